"""Output files written whole or not at all.

The bytes go to a temporary file in the same folder, which then takes the name of the target in one
step. Whoever reads the target sees the old file or the new one, and a failure leaves the old one.
"""

from __future__ import annotations

import os
import secrets
import stat
from pathlib import Path

__all__ = ["write_bytes_atomic", "write_text_atomic"]


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
    named = Path(path)
    try:
        regular = stat.S_ISREG(named.stat().st_mode)
    except FileNotFoundError:
        regular = True
    if not regular:
        try:
            named.write_bytes(data)  # a device or pipe takes it; a folder raises IsADirectoryError
        except OSError as error:  # that of a full device has no name
            raise OSError(error.errno, error.strerror, os.fspath(path)) from error
        return
    # Path.resolve would raise a RuntimeError at a loop of links; stat has refused that above.
    target = Path(os.path.realpath(named))
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(f".popsteer-{secrets.token_hex(8)}.tmp")
    try:
        # Mode "x" makes the file with the permissions of the umask, unlike tempfile's 0600.
        with temporary.open("xb") as stream:
            stream.write(data)
        temporary.replace(target)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        # The reason is the same, the name is the one the caller knows.
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
