"""The files of a comparison: all computed before the first is written."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from popsteer.errors import ConfigError
from popsteer.files import write_bytes_atomic
from popsteer.report.metrics_json import metrics_json
from popsteer.report.runs_csv import run_csv

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping

    from popsteer.study import Comparison

__all__ = ["files", "write"]


def files(
    comparison: Comparison, progress: Callable[[str, float], object] | None = None
) -> dict[str, bytes]:
    """Compute the files of a comparison.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    progress : callable, optional
        Called with what is being done and the share of it that is done, 0 to 1.

    Returns
    -------
    dict
        The content of each file by its name: ``runs/LAW.csv`` for each law, ``results`` and
        ``overview`` as ``.png`` and ``.svg``, each for a light and, as ``-dark``, for a dark
        background, and ``metrics.json``.

    Raises
    ------
    ConfigError
        The runs kept no records.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.study import compare
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> content = files(compare(path, ["pop"]))
    >>> sorted(content)[:3]
    ['metrics.json', 'overview-dark.png', 'overview-dark.svg']
    """
    from popsteer.report.figures import FIGURES, THEMES, render

    if not comparison.first.settings.keep_records:
        raise ConfigError("keep_records", value=False, requirement="true where files are wanted")
    content = {
        f"runs/{re.sub(r'[^A-Za-z0-9._-]+', '-', name)}.csv": run_csv(run).encode()
        for name, run in comparison.runs.items()
    }
    wanted = [(figure, theme) for figure in FIGURES for theme in THEMES]
    for done, (figure, theme) in enumerate(wanted):
        if progress is not None:
            progress("figures", done / len(wanted))
        suffix = "" if theme == "light" else f"-{theme}"
        for kind, data in render(comparison, figure, theme).items():
            content[f"{figure}{suffix}.{kind}"] = data
    if progress is not None:
        progress("figures", 1.0)
    # The last to be written: whoever finds it finds the others too.
    content["metrics.json"] = metrics_json(comparison).encode()
    return content


def write(content: Mapping[str, bytes], folder: str | os.PathLike[str]) -> list[Path]:
    """Write files into a folder, each whole or not at all.

    Parameters
    ----------
    content : mapping of str to bytes
        The content of each file by its name in the folder, as `files` gives it.
    folder : str or os.PathLike
        The folder; it is made where it is missing.

    Returns
    -------
    list of pathlib.Path
        The files, in the order of writing.

    Raises
    ------
    OSError
        A file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [file.name for file in write({"note.txt": b"e = 0"}, folder)]
    ['note.txt']
    """
    written = []
    for name, data in content.items():
        file = Path(folder) / name
        write_bytes_atomic(file, data)
        written.append(file)
    return written
