"""Output files written whole or not at all.

The bytes go to a temporary folder beside the target, from where they take its name in one step.
Whoever reads the target sees the old file or the new one, and a failure leaves the old one.
"""

from __future__ import annotations

import errno
import os
import select
import stat
import time
from contextlib import ExitStack, contextmanager
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

_PATIENCE = 30.0  # s without a byte in a pipe
_MOST_PIPED = 1 << 30
_MOST_LOOKED_AT = 10_000  # files of a folder, for one that may be meant


def check_files(paths: Iterable[str | os.PathLike[str]]) -> None:
    """Refuse files that cannot be written, before the work whose results they are to hold.

    A file is made in each folder and removed: permissions do not tell of a full disk. OSError.
    """
    tried = set()
    for path in paths:
        with _naming(path):
            target = _target(Path(path))
            if target is None:
                if not os.access(path, os.W_OK):
                    raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            elif target.parent not in tried:
                _try_out(target.parent)
                tried.add(target.parent)


def check_folder(folder: str | os.PathLike[str], names: Iterable[str] = ()) -> None:
    """Refuse a folder, and files of some names in it, as `check_files`; none is made."""
    with _naming(folder):
        _try_out(Path(os.path.realpath(folder)))
    check_files(Path(folder) / name for name in names)


def alike(path: str | os.PathLike[str], ending: str = "") -> str | None:
    """Give the file of its folder that a name which is none may mean; None where none is like it.

    `ending` is that of the files which may be meant.
    """
    import difflib

    meant = Path(path)
    try:
        with os.scandir(meant.parent) as each:
            there = [it.name for it in islice(each, _MOST_LOOKED_AT) if it.name.endswith(ending)]
    except (OSError, ValueError):
        return None
    whole = f"{meant.name}{ending}"
    found = [whole] if whole in there else difflib.get_close_matches(meant.name, there, 1, 0.75)
    return str(meant.with_name(found[0])) if found else None


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """Read a file or a pipe to its end; OSError, also for a device without one.

    A pipe into which nothing is written for half a minute is an error, too, and one without an end.
    """
    # Without O_NONBLOCK a pipe is not even opened before somebody writes into it.
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    with _naming(path), os.fdopen(_opened(path, flags), "rb") as stream:
        mode = os.fstat(stream.fileno()).st_mode
        if stat.S_ISBLK(mode) or (stat.S_ISCHR(mode) and not stream.isatty()):
            raise OSError(errno.EINVAL, "is a device, not a file")
        if stat.S_ISREG(mode) or os.name == "nt":
            return stream.read()
        os.set_blocking(stream.fileno(), True)
        return stream.read() if stream.isatty() else _piped(stream.fileno())


def _opened(path: str | os.PathLike[str], flags: int) -> int:
    try:
        return os.open(path, flags)
    except FileNotFoundError as error:
        if (meant := alike(path)) is None:
            raise
        why = f"{error.strerror}, did you mean {meant}?"
        raise FileNotFoundError(error.errno, why) from error


def write_text_atomic(path: str | os.PathLike[str], text: str) -> None:
    """Write text as UTF-8, as `write_bytes_atomic`; line ends stay as they are."""
    write_bytes_atomic(path, text.encode("utf-8"))


def write_bytes_atomic(path: str | os.PathLike[str], data: bytes) -> None:
    """Write bytes, whole or not at all; folders that are missing are made.

    A symbolic link is followed, and a target that is no regular file, such as ``/dev/stdout``, is
    written to directly: replacing it would put a file in its place. Raises OSError where the file
    cannot be written; what stood there before still does.
    """
    write_files_atomic({Path(path): data})


def write_files_atomic(files: Mapping[Path, bytes]) -> None:
    """Write several files; none takes its name before the bytes of all are on the disk."""
    targets = {}
    for path in files:
        with _naming(path):
            targets[path] = _target(path)
    with ExitStack() as stack:
        staged = []
        for path, target in targets.items():
            if target is None:
                continue
            with _naming(path):
                target.parent.mkdir(parents=True, exist_ok=True)
                # A folder, as a file of `tempfile` would not have the permissions of the umask.
                folder = TemporaryDirectory(
                    dir=target.parent, prefix=".popsteer-", ignore_cleanup_errors=True
                )
                temporary = Path(stack.enter_context(folder)) / target.name
                temporary.write_bytes(files[path])
                staged.append((path, temporary, target))
        for path, temporary, target in staged:
            with _naming(path):
                temporary.replace(target)
    for path, target in targets.items():
        if target is None:
            with _naming(path):
                _pour(path, files[path])


@contextmanager
def _naming(path: str | os.PathLike[str]) -> Iterator[None]:
    """Give errors the name that the caller knows, rather than a temporary one or none."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error


def _target(named: Path) -> Path | None:
    """Follow links to the file that is to be replaced; None for a device or pipe."""
    try:
        mode = named.stat().st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    # Path.resolve would raise a RuntimeError at a loop of links; stat has refused that above.
    return Path(os.path.realpath(named)) if stat.S_ISREG(mode) else None


def _pour(path: Path, data: bytes) -> None:
    """Write into a device or a pipe; OSError where nobody opens that pipe to read it."""
    # With O_NONBLOCK opening a pipe does not wait for a reader, and fails without one.
    flags = os.O_WRONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    until = time.monotonic() + _PATIENCE
    while True:
        try:
            descriptor = os.open(path, flags)
            break
        except OSError as error:
            if error.errno != errno.ENXIO:
                raise
        if time.monotonic() > until:
            raise OSError(errno.ETIMEDOUT, f"nobody reads it for {_PATIENCE:g} s")
        time.sleep(0.05)
    if os.name != "nt":
        os.set_blocking(descriptor, True)
    with os.fdopen(descriptor, "wb") as stream:
        stream.write(data)


def _piped(descriptor: int) -> bytes:
    """Read what others write, to its end."""
    data = bytearray()
    while select.select([descriptor], [], [], _PATIENCE)[0]:
        part = os.read(descriptor, 1 << 20)
        data += part
        if not part:
            return bytes(data)
        if len(data) > _MOST_PIPED:
            raise OSError(errno.EFBIG, f"writes more than {_MOST_PIPED:,} bytes")
    raise OSError(errno.ETIMEDOUT, f"nothing is written into it for {_PATIENCE:g} s")


def _try_out(folder: Path) -> None:
    """Make and remove a file in a folder, or in the nearest one above it that is there."""
    try:
        mode = folder.stat().st_mode
    except FileNotFoundError:
        _try_out(folder.parent)
        return
    if not stat.S_ISDIR(mode):
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
    with TemporaryFile(dir=folder, prefix=".popsteer-"):
        pass
