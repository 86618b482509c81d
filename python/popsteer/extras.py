"""What needs an extra, what of it is missing, and how the wheel is installed with it."""

from __future__ import annotations

import sys
from importlib.util import find_spec

from popsteer.errors import PopsteerError

MODULES = {
    "lab": ("filelock", "matplotlib", "optuna", "plotly", "rich", "rosbags", "scipy", "typer"),
    "ros2": ("cyclonedds", "rich", "rosbags", "typer"),
    "carla": ("carla",),
    "gym": ("gymnasium",),
    "plants": ("mujoco", "vehiclemodels"),
    "mpc": ("daqp",),
    "dask": ("distributed",),
    "parquet": ("pyarrow",),
    "geo": ("pyproj",),
}
"""What each extra brings, by the names that Python imports it under."""


class MissingExtra(PopsteerError, ModuleNotFoundError):  # noqa: N818 - as ModuleNotFoundError is
    """Packages of an extra are not installed: `what` needs them, `extras` bring them.

    Examples
    --------
    >>> raise MissingExtra("sweep", "dask", "lab")
    Traceback (most recent call last):
    popsteer.extras.MissingExtra: sweep needs the extras "dask", "lab" (not installed: \
    distributed, scipy): pip install "popsteer-VERSION-PLATFORM.whl[dask,lab]"
    """

    def __init__(self, what: str, *extras: str) -> None:
        named = ", ".join(f'"{each}"' for each in extras)
        plural = "s" if len(extras) > 1 else ""
        absent = sorted({each for extra in extras for each in MODULES[extra] if missing(each)})
        lack = f" (not installed: {', '.join(absent)})" if absent else ""
        line = f'pip install "popsteer-VERSION-PLATFORM.whl[{",".join(extras)}]"'
        super().__init__(f"{what} needs the extra{plural} {named}{lack}: {line}")
        self.what = what
        self.extras = extras


def missing(*modules: str) -> bool:
    """Whether one of some modules is not installed; none is imported to see."""
    return not all(map(_is_found, modules))


def _is_found(module: str) -> bool:
    if module in sys.modules:
        return sys.modules[module] is not None
    try:
        return find_spec(module) is not None
    except ImportError:
        return False


def require(what: str, extra: str, *modules: str) -> None:
    """Raise MissingExtra unless the extra's `modules`, all by default, are installed."""
    if missing(*(modules or MODULES[extra])):
        raise MissingExtra(what, extra)
