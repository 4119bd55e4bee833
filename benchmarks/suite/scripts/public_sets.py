"""Public sets of problems: where they are, their licence, and `bench fetch`, which copies one into the user's cache.

A set is a list of files of a public repository at one commit. `digest` is the SHA-256 of the lines "BLOB PATH" of these
files, sorted by path, where BLOB is git's name of the contents (SHA-1). It verifies the list; BLOB verifies each file.
"""

import fnmatch
import hashlib
import json
import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from dataclasses import dataclass

from cache import cache_folder

LISTING = "listing.json"
TRIES_OF_A_FILE = 3
SERVERS = {"listing": "https://api.github.com/repos/{repository}/git/trees/{commit}?recursive=1",
           "file": "https://raw.githubusercontent.com/{repository}/{commit}/{path}"}
SERVERS_VARIABLE = "SALTUS_BENCH_SERVER"  # replaces both addresses: ADDRESS/listing.json and ADDRESS/PATH


@dataclass(frozen=True)
class PublicSet:
    about: str
    repository: str
    commit: str
    patterns: tuple
    licence: str
    files: int
    megabytes: float
    digest: str
    largest: int = 1 << 40  # bytes; larger files are not part of the set
    others: str = ""  # a set with the same problems, which is not counted twice
    kind: str = "quadratic programs"


SETS = {
    "mpc": PublicSet(
        "quadratic programs of model predictive control, mpc_qpbenchmark",
        "qpsolvers/mpc_qpbenchmark", "1548e6b364074fcb708bc400189bfe76bf00442a", ("data/*.npz",), "Apache-2.0", 64, 18,
        "093c5e854d349fb5c337a5c3644081ba4be2b0c6fdd2a7fc5a07f10bd1d62156"),
    "maros-meszaros": PublicSet(
        "convex quadratic programs of Maros and Meszaros",
        "qpsolvers/maros_meszaros_qpbenchmark", "0cae37f473c2fd0a762e537a61bd4db5b31ff00c", ("data/*.mat",),
        "Apache-2.0 (the repository; the problems are by their authors)", 138, 18,
        "a2ed7fe03d3455c88c323fc2c88d15ef9de02e1138c4d6910697433d23f4a290"),
    "maros-meszaros-qps": PublicSet(
        "the same programs as QPS files, with the table of their published optima",
        "YimingYAN/QP-Test-Problems", "871cc300154cfb438acc20f52b2c585db3f11e31",
        ("QPS_Files/*.QPS", "QPS_Files/00README.QP"), "none stated in the repository", 139, 150, "e44f75587f92286e59931bf6518ca381d8a788c29f2b1fd1216f717c2b64220c",
        others="maros-meszaros"),
    "nosbench": PublicSet(
        "programs with complementarity constraints from nonsmooth optimal control, files below 4 MiB",
        "nosnoc/nosbench", "8f44ce444eb641a0efae4c3c778cf1f37e02b907", ("problems/casadi/*.json",),
        "none stated in the repository", 392, 540, "4dde2a9fcef38705f02576f49fd80793ecc556906f25ea3736e32c3462e367db",
        largest=4 << 20, kind="complementarity programs"),
}


class FetchError(Exception):
    """A set that cannot be fetched; the message is one sentence."""


class NoNetwork(FetchError):
    """No server can be reached."""


class TimeIsUp(FetchError):
    """The time limit; the same command continues."""


def folder_of(name):
    """The folder of a fetched set; it may not exist."""
    return os.path.join(cache_folder("problems"), name)


def files_of(name):
    """File of each fetched problem, by its name."""
    folder = folder_of(name)
    found = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
    return {os.path.splitext(file)[0]: os.path.join(folder, file) for file in found
            if file != LISTING and any(fnmatch.fnmatch(file, os.path.basename(p)) for p in SETS[name].patterns if "*" in p)}


def blob_name(contents):
    """Git's name of a file's contents."""
    return hashlib.sha1(b"blob %d\0" % len(contents) + contents, usedforsecurity=False).hexdigest()


def digest_of(listing):
    return hashlib.sha256("".join(f"{blob} {path}\n" for path, blob in sorted(listing)).encode()).hexdigest()


def is_wanted(wanted, path, size):
    return any(fnmatch.fnmatch(path, p) for p in wanted.patterns) and size < wanted.largest


class Server:
    """The public repository, file by file."""

    def __init__(self, wanted, ends):
        self.wanted, self.ends = wanted, ends
        own = os.environ.get(SERVERS_VARIABLE)
        self.addresses = {"listing": own + "/listing.json", "file": own + "/{path}"} if own else SERVERS

    def listing(self):
        tree = json.loads(self._read("listing"))
        return [(e["path"], e["sha"]) for e in tree["tree"]
                if e["type"] == "blob" and is_wanted(self.wanted, e["path"], e.get("size", 0))]

    def contents(self, path, _):
        return self._read("file", path=urllib.request.quote(path))

    def _read(self, what, **more):
        address = self.addresses[what].format(repository=self.wanted.repository, commit=self.wanted.commit, **more)
        left = self.ends - time.monotonic()
        if left <= 0:
            raise TimeIsUp("")
        try:
            # The limit of one answer is also that of each of its packets.
            with urllib.request.urlopen(address, timeout=min(30.0, max(1.0, left))) as answer:
                parts = []
                while part := answer.read(1 << 16):
                    parts.append(part)
                    if time.monotonic() > self.ends:
                        raise TimeIsUp("")
                return b"".join(parts)
        except urllib.error.HTTPError as error:
            raise FetchError(f"{address} answers {error.code} {error.reason}; try again later, or give the files with "
                             "--from FOLDER") from None
        except (urllib.error.URLError, socket.timeout, ConnectionError) as error:
            host = address.split("/")[2]
            raise NoNetwork(f"no network: {host} cannot be reached ({getattr(error, 'reason', error)}); copy the files of "
                            f"github.com/{self.wanted.repository} to this machine and give --from FOLDER") from None


class GitFolder:
    """A local copy of the repository that contains the commit, with or without a work tree."""

    def __init__(self, wanted, folder):
        self.wanted, self.folder = wanted, folder

    def listing(self):
        lines = self._git("ls-tree", "-r", "-l", "-z", "--full-tree", self.wanted.commit).decode().split("\0")
        found = []
        for line in filter(None, lines):
            (_, kind, blob, size), path = line.split("\t")[0].split(), line.split("\t")[1]
            # A copy without large files does not know their size.
            if kind == "blob" and is_wanted(self.wanted, path, int(size) if size.isdigit() else 1 << 30):
                found.append((path, blob))
        return found

    def contents(self, _, blob):
        try:
            return self._git("cat-file", "blob", blob)
        except subprocess.CalledProcessError:
            return None

    def _git(self, *words):
        return subprocess.run(["git", "-C", self.folder, *words], check=True, capture_output=True,
                              env={**os.environ, "GIT_NO_LAZY_FETCH": "1"}).stdout

    def has_commit(self):
        try:
            self._git("cat-file", "-e", self.wanted.commit + "^{commit}")
            return True
        except (OSError, subprocess.CalledProcessError):
            return False


class PlainFolder:
    """Files in a folder and its subfolders, found by their names. Without git they are verified only as a whole."""

    def __init__(self, wanted, folder):
        self.files = {}
        for place, _, names in sorted(os.walk(folder)):
            for name in sorted(names):
                path = os.path.join(place, name)
                for pattern in wanted.patterns:
                    if fnmatch.fnmatch(name, os.path.basename(pattern)) and os.path.getsize(path) < wanted.largest:
                        self.files.setdefault(os.path.join(os.path.dirname(pattern), name), path)

    def listing(self):
        return [(path, blob_name(self.contents(path, None))) for path in self.files]

    def contents(self, path, _):
        with open(self.files[path], "rb") as file:
            return file.read()


def fetch(name, source, seconds, out):
    """Copies a set into the cache, from the network or from a local folder. Files that are already there stay."""
    wanted, ends = SETS[name], time.monotonic() + seconds
    print(f"{name}: {wanted.about}\n  github.com/{wanted.repository} at {wanted.commit[:12]}; {wanted.files} files, about "
          f"{wanted.megabytes:g} MB; licence: {wanted.licence}", file=out, flush=True)
    if source is None:
        place = Server(wanted, ends)
    else:
        if not os.path.isdir(source):
            raise FetchError(f"'{source}' is not a folder; give the folder with the files of {wanted.repository}")
        place = GitFolder(wanted, source)
        if not place.has_commit():
            place = PlainFolder(wanted, source)
    try:
        return _copy(name, wanted, place, ends, out)
    except TimeIsUp:
        raise TimeIsUp(f"{name} is incomplete after {seconds:g} s; the same command continues, --limit SECONDS gives "
                       "more time") from None


def _copy(name, wanted, place, ends, out):
    listing = sorted(place.listing())
    if not listing:
        raise FetchError(f"there are no files {' or '.join(map(os.path.basename, wanted.patterns))} in it; give the folder "
                         f"with the files of {wanted.repository}")
    is_verified = digest_of(listing) == wanted.digest
    if isinstance(place, Server) and not is_verified:
        raise FetchError(f"the list of files of {wanted.repository} does not match its checksum; nothing was changed")
    folder = folder_of(name)
    os.makedirs(folder, exist_ok=True)
    absent, copied = [], 0
    for path, blob in listing:
        target = os.path.join(folder, os.path.basename(path))
        if os.path.exists(target):
            with open(target, "rb") as file:
                if blob_name(file.read()) == blob:
                    continue
        if time.monotonic() > ends:
            raise TimeIsUp("")
        contents = _verified(place, path, blob)
        if contents is None:
            absent.append(os.path.basename(path))
            continue
        with open(target + ".part", "wb") as file:
            file.write(contents)
        os.replace(target + ".part", target)
        copied += 1
        if copied % 50 == 0:
            print(f"  {copied} files copied", file=sys.stderr, flush=True)
    with open(os.path.join(folder, LISTING), "w", encoding="utf-8") as file:
        json.dump({"commit": wanted.commit, "verified": is_verified, "files": [
            [os.path.basename(p), b] for p, b in listing if os.path.basename(p) not in absent]}, file)
    there = len(listing) - len(absent)
    verdict = "verified" if is_verified else (f"not verified: they differ from the {wanted.files} files of the commit")
    print(f"  {there} of {wanted.files} files in {folder}, {copied} of them new; {verdict}", file=out)
    if absent:
        print(f"  missing in the folder: {', '.join(absent[:5])}{', ...' if len(absent) > 5 else ''} ({len(absent)})", file=out)
    return there


def _verified(place, path, blob):
    """The contents of a file, or None if the folder does not have them."""
    for _ in range(TRIES_OF_A_FILE):
        contents = place.contents(path, blob)
        if contents is None or blob_name(contents) == blob:
            return contents
    raise FetchError(f"'{path}' does not match its checksum; files before it are kept, and the same command tries again")
