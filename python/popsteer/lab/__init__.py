"""The laboratory: what people look at, one experiment a folder.

Each experiment has what it runs (``run``), its table and its figures in its folder:

``compare``
    Several controllers on one plant and one path, or on each of several.
``suite``
    A suite of scenarios under conditions, with a version.
``stability``
    How far the steering loops are from instability.
``plan``
    What limits the speeds along a path.
``identify``
    A vehicle from the log of a drive.
``replay``
    Controllers that watch the log of a drive.
``tune``
    Parameters of a controller, tuned for a vehicle.
``sweep``
    Thousands of runs that differ: how often a controller succeeds, and where it fails.
``report``
    One self-contained page to look at for what an experiment came to.

``baselines`` and ``opponents`` are controllers from elsewhere to compare with, ``common`` is what
the experiments share: names, layout, colours. Running needs numpy alone; tables and figures
need the extra ``lab``.

Examples
--------
>>> import popsteer
>>> from popsteer import lab
>>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
>>> comparison = lab.compare.run(path, ["stanley", "pop"], "kinematic-bicycle")
>>> comparison.runs["pop"].metrics.finished
True
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from popsteer.lab import (
        baselines,
        common,
        compare,
        identify,
        plan,
        replay,
        report,
        stability,
        suite,
        sweep,
        tune,
    )

__all__ = [
    "baselines",
    "common",
    "compare",
    "identify",
    "plan",
    "replay",
    "report",
    "stability",
    "suite",
    "sweep",
    "tune",
]


# Hidden from type checkers, which would take any name for one of the laboratory's.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        if name in __all__:
            return import_module(f"{__name__}.{name}")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
