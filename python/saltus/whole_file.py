"""Files that are never seen half written, whoever else writes into the folder."""

import contextlib
import os
import secrets
import socket


@contextlib.contextmanager
def whole_file(path):
    """The name of an empty file beside `path`, of this user alone: what stands there at the end becomes `path` in one step.

    With an error or an interruption `path` is as it was. OSError names `path`. What a killed process leaves is hidden, and
    ends with its machine's name, its number and .part: the next run into the folder on that machine clears it.
    """
    folder, name = os.path.split(os.path.abspath(path))
    host = socket.gethostname()[:16].replace(".", "-") or "host"  # as framework/saltus/core/temporary_file.cpp has it
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
