"""Several files into one folder: all or none."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from popsteer.files import write_files_atomic

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

__all__ = ["write"]


def write(content: Mapping[str, bytes], folder: str | os.PathLike[str]) -> list[Path]:
    """Write files into a folder, all or none.

    Parameters
    ----------
    content : mapping of str to bytes
        The content of each file by its name in the folder, as an experiment gives it.
    folder : str or os.PathLike
        The folder; it is made where it is missing.

    Returns
    -------
    list of pathlib.Path
        The files, in the order of writing.

    Raises
    ------
    OSError
        A file cannot be written; then none is.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [file.name for file in write({"note.txt": b"e = 0"}, folder)]
    ['note.txt']
    """
    written = {Path(folder) / name: data for name, data in content.items()}
    write_files_atomic(written)
    return list(written)
