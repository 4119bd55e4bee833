"""Atomic writing of files, also with several writers in one folder."""

import contextlib
import os
import secrets
import socket


@contextlib.contextmanager
def whole_file(path):
    """Yields the name of an empty file next to `path`, private to this user, whose content replaces `path` in one step.

    After an error or an interruption `path` is unchanged. OSError names `path`. The file of a killed process is hidden and
    ends with the name of its machine, its number and .part. The next run into the folder on that machine removes it.
    """
    folder, name = os.path.split(os.path.abspath(path))
    host = socket.gethostname()[:16].replace(".", "-") or "host"  # same rule as framework/saltus/core/temporary_file.cpp
    partial = os.path.join(folder, f".{name[:40]}.{secrets.token_hex(4)}.{host}.{os.getpid()}.part")
    try:
        try:
            os.close(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))
            yield partial
            os.chmod(partial, 0o666 & ~_umask())
            os.replace(partial, path)
        finally:
            with contextlib.suppress(OSError):
                os.remove(partial)
    except OSError as error:
        raise OSError(error.errno, os.strerror(error.errno), path) if error.errno else error from None


def _umask():
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def write_text(path, text):
    with whole_file(path) as partial, open(partial, "w", encoding="utf-8") as file:
        file.write(text)
