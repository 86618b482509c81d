"""A log from whatever file it is in."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from popsteer.logs.bag import read_bag
from popsteer.logs.csv_log import paths, read_csv
from popsteer.logs.log import Log, LogError

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping, Sequence

    from popsteer.tables.columns import Columns


_BAGS = (".mcap", ".db3", ".bag")


def read(
    file: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Columns | None = None,
    topics: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    origin: tuple[float, float] | None = None,
    progress: Callable[[float], object] | None = None,
) -> Log:
    """Read a log: a folder, ``.mcap``, ``.db3`` or ``.bag`` as a bag, all else as a table.

    Parameters
    ----------
    file : str, os.PathLike or sequence of them
        The file or folder; or several tables with one clock.
    columns : str, sequence of str or mapping of str to str, optional
        What the columns of a table are: ``"t,x,y,yaw,speed,steer"`` in their order, ``-`` for what
        is left out; or by their names, ``{"steer": "delta"}`` or ``"steer=delta"``. By default
        their names say so (docs/files.md).
    topics : mapping of str to str, optional
        The topics of a bag for ``odometry`` and ``steer``, where there are several of their types;
        for ``pose`` and ``speed``, where odometry has not both.
    units : mapping of str to str, optional
        What a column, or a topic's number, is measured in; see `popsteer.logs.units.factor`.
    origin : tuple of float, optional
        Latitude and longitude [deg] of x = y = 0, for tables that have these.
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
    files = paths(file)
    bags = [each for each in map(Path, files) if each.is_dir() or each.suffix.lower() in _BAGS]
    if not bags:
        if topics:
            raise LogError(f"{files[0]}: topics are of bags; a table has columns")
        return read_csv(files, columns=columns, units=units, origin=origin)
    if len(files) > 1:
        raise LogError(f"{bags[0]}: a bag is read alone; it may have several topics")
    if columns or origin:
        raise LogError(f"{bags[0]}: columns and an origin are of tables; a bag has topics")
    return read_bag(bags[0], topics=topics, units=units, progress=progress)
