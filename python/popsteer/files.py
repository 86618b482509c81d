"""Output files written whole or not at all.

The bytes go to a temporary file in the same folder, which then takes the name of the target in one
step. Whoever reads the target sees the old file or the new one, and a failure leaves the old one.
What a killed process leaves of temporary files goes with the next write to the same folder.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

with suppress(ImportError):  # not on Windows, where nothing is locked and so nothing swept
    import fcntl

_LOCKS = "fcntl" in globals()

__all__ = [
    "check_files",
    "check_folder",
    "write_bytes_atomic",
    "write_files_atomic",
    "write_text_atomic",
]

_PREFIX = ".popsteer-"
_SUFFIX = ".tmp"


def check_files(paths: Iterable[str | os.PathLike[str]]) -> None:
    """Refuse files that cannot be written, before the work whose results they are to hold.

    A file is made and removed again in each of their folders: permissions alone do not tell, as a
    disk may be read-only or full, and root may not write everywhere.

    Parameters
    ----------
    paths : iterable of str or os.PathLike
        The files; folders that are missing are not made.

    Raises
    ------
    OSError
        One of them cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     check_files([Path(folder) / "new" / "note.txt"])
    ...     list(Path(folder).iterdir())
    []
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
    """Refuse a folder that cannot be written to, before the work whose results it is to hold.

    Parameters
    ----------
    folder : str or os.PathLike
        The folder; where it is missing it is not made.
    names : iterable of str, optional
        What is to be written there; below the folder, and checked as `check_files` does.

    Raises
    ------
    OSError
        It is no folder and cannot become one, or one of the files cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.NamedTemporaryFile() as file:
    ...     check_folder(file.name)
    Traceback (most recent call last):
    NotADirectoryError: ...
    """
    with _naming(folder):
        _try_out(Path(os.path.realpath(folder)))
    check_files(Path(folder) / name for name in names)


def write_text_atomic(path: str | os.PathLike[str], text: str) -> None:
    r"""Write text as UTF-8, whole or not at all; line ends stay as they are.

    Parameters
    ----------
    path : str or os.PathLike
        The file to write; folders that are missing are made.
    text : str
        Its whole content.

    Raises
    ------
    OSError
        The file cannot be written; what stood there before still does.
    UnicodeEncodeError
        The text cannot be encoded; nothing was touched.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_text_atomic(Path(folder) / "new" / "note.txt", "e = 0.1 m\n")
    ...     (Path(folder) / "new" / "note.txt").read_text(encoding="utf-8")
    'e = 0.1 m\n'
    """
    write_bytes_atomic(path, text.encode("utf-8"))


def write_bytes_atomic(path: str | os.PathLike[str], data: bytes) -> None:
    r"""Write bytes, whole or not at all.

    A symbolic link is followed, and a target that is no regular file, such as ``/dev/stdout``, is
    written to directly: replacing it would put a file in its place.

    Parameters
    ----------
    path : str or os.PathLike
        The file to write; folders that are missing are made.
    data : bytes
        Its whole content.

    Raises
    ------
    OSError
        The file cannot be written; what stood there before still does.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_bytes_atomic(Path(folder) / "data.bin", b"\x00\x01")
    ...     (Path(folder) / "data.bin").read_bytes()
    b'\x00\x01'
    """
    write_files_atomic({Path(path): data})


def write_files_atomic(files: Mapping[Path, bytes]) -> None:
    """Write several files; none takes its name before the bytes of all are on the disk.

    Parameters
    ----------
    files : mapping of pathlib.Path to bytes
        The content of each file, treated as `write_bytes_atomic` does.

    Raises
    ------
    OSError
        One of them cannot be written; what stood there before still does, for all of them.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_files_atomic({Path(folder) / "a": b"1", Path(folder) / "b": b"2"})
    ...     sorted(file.name for file in Path(folder).iterdir())
    ['a', 'b']
    """
    targets = {}
    for path in files:
        with _naming(path):
            targets[path] = _target(path)
    for folder in {target.parent for target in targets.values() if target is not None}:
        _sweep(folder)
    with ExitStack() as stack:
        staged = []
        for path, target in targets.items():
            if target is None:
                continue
            with _naming(path):
                target.parent.mkdir(parents=True, exist_ok=True)
                temporary, descriptor = stack.enter_context(_temporary(target.parent))
                # Closing a copy writes all out, or fails, while the file is still its temporary.
                with os.fdopen(os.dup(descriptor), "wb") as stream:
                    stream.write(files[path])
                staged.append((path, temporary, target))
        for path, temporary, target in staged:
            with _naming(path):
                temporary.replace(target)
    for path, target in targets.items():
        if target is None:
            with _naming(path):
                path.write_bytes(files[path])


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


def _try_out(folder: Path) -> None:
    """Make and remove a file in a folder, or in the nearest one above it that is there."""
    try:
        mode = folder.stat().st_mode
    except FileNotFoundError:
        _try_out(folder.parent)
        return
    if not stat.S_ISDIR(mode):
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
    _sweep(folder)
    with _temporary(folder):
        pass


@contextmanager
def _temporary(folder: Path) -> Iterator[tuple[Path, int]]:
    """Make a file; it goes on leaving, unless it has got another name."""
    path, descriptor = _make_locked(folder)
    try:
        yield path, descriptor
    finally:
        with suppress(OSError):
            path.unlink()
        os.close(descriptor)


def _make_locked(folder: Path) -> tuple[Path, int]:
    """Make a file under a name that is not in use, and lock it against `_sweep`."""
    while True:
        path = folder / f"{_PREFIX}{secrets.token_hex(8)}{_SUFFIX}"
        # The permissions are those of the umask, unlike tempfile's 0600.
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        try:
            if _lock(descriptor) and os.fstat(descriptor).st_nlink:
                return path, descriptor
        except OSError:
            return path, descriptor  # no locks on this disk, so that nobody sweeps here either
        os.close(descriptor)  # swept in the moment before it was locked


def _sweep(folder: Path) -> None:
    """Remove the temporary files that killed processes have left in a folder.

    Who writes one holds a lock on it, and the kernel lifts the lock when the process ends, however
    it ends. The id of the process would tell less: it is used again by others, and means nothing
    in another container or on another host.
    """
    if not _LOCKS:
        return
    with suppress(OSError):
        for path in folder.glob(f"{_PREFIX}*{_SUFFIX}"):
            with suppress(OSError):  # somebody else's, or swept by another meanwhile
                # Neither to follow a link nor to wait at a pipe that has such a name.
                descriptor = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
                try:
                    if stat.S_ISREG(os.fstat(descriptor).st_mode) and _lock(descriptor):
                        path.unlink()
                finally:
                    os.close(descriptor)


def _lock(descriptor: int) -> bool:
    """Lock a file for oneself; false where another has it."""
    if not _LOCKS:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
