"""A log from whatever file it is in."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from popsteer.logs.bag import read_bag
from popsteer.logs.csv_log import read_csv
from popsteer.logs.log import Log, LogError

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping


_BAGS = (".mcap", ".db3", ".bag")


def read(
    file: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    topics: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    progress: Callable[[float], object] | None = None,
) -> Log:
    """Read a log: a folder, ``.mcap``, ``.db3`` or ``.bag`` as a bag, all else as CSV.

    Parameters
    ----------
    file : str or os.PathLike
        The file or folder.
    columns : mapping of str to str, optional
        Names of columns, for CSV.
    topics : mapping of str to str, optional
        Names of topics, for bags.
    units : mapping of str to str, optional
        Units, by column.
    progress : callable, optional
        Called now and then with the share done, 0 to 1.

    Returns
    -------
    Log
        The log.

    Raises
    ------
    LogError
        The file cannot be read, or lacks a column or a topic.
    PopsteerError
        It is a bag, and the extra ``lab`` is not installed.
    """
    path = Path(file)
    if path.is_dir() or path.suffix.lower() in _BAGS:
        if columns:
            raise LogError(f"{path}: columns are of CSV files; a bag has topics")
        return read_bag(path, topics=topics, units=units, progress=progress)
    if topics:
        raise LogError(f"{path}: topics are of bags; a CSV file has columns")
    return read_csv(path, columns=columns, units=units)
