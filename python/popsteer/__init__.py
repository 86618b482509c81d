"""Path-tracking steering for self-driving cars and car-like robots.

The POP controller (proximally optimal predictive) and the controllers it is measured against,
computed in Rust. SI units and radians; x forward, y left, yaw counter-clockwise; positive steering
turns left. All parameters of the car are in one `Vehicle`. A pose is that of the
vehicle's point, wherever it is measured; each controller finds the point it tracks from there.

"The paper" in these pages is C. Samak, T. Samak, S. Kandhasamy, *Proximally Optimal Predictive
Control Algorithm for Path Tracking of Self-Driving Cars*.

For a vehicle: `popsteer.vehicles` (vehicles by name), `popsteer.controllers` and `popsteer.presets`
(the controllers and their parameter sets by name), `popsteer.sim` (plants and the closed loop),
`popsteer.plants`, `popsteer.tracks` and `popsteer.planning`. For a log of it: `popsteer.logs` and
`popsteer.identification`. To read beside the paper: `popsteer.paper` (its functions)
and `popsteer.reference` (the same controllers in plain Python). To look at: `popsteer.lab`
(comparisons, margins, benchmarks, their tables and figures).

Examples
--------
>>> import popsteer
>>> path = popsteer.Path([(float(x), 0.0) for x in range(100)])
>>> car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, dead_time=0.15)
>>> controller = popsteer.PreviewPop(path, car)
>>> command = controller.step(0.0, 0.5, 0.0, 5.0, 0.05)
>>> command.steer < 0.0  # left of the path: steer right
True
>>> popsteer.sim.run(controller, popsteer.sim.KinematicBicycle(car)).metrics.finished
True
"""

from popsteer import interrupt as interrupt  # isort: skip - before all that takes time

from importlib import import_module
from typing import TYPE_CHECKING

from popsteer import _core, vehicles
from popsteer._core import (
    AdaptParams,
    Batch,
    Command,
    CommandBatch,
    CoupledLongitudinal,
    CoupledLongitudinalParams,
    Drive,
    Driver,
    DriverParams,
    Estimate,
    Lookahead,
    MonitorParams,
    Path,
    Pid,
    PidParams,
    Pop,
    PopParams,
    PreviewPop,
    PreviewPopParams,
    Projection,
    PurePursuit,
    PurePursuitParams,
    SpeedCommand,
    SpeedPid,
    SpeedPidParams,
    SpeedTracker,
    SpeedTrackerParams,
    Stanley,
    StanleyParams,
    Vehicle,
    __version__,
    build_profile,
)
from popsteer.errors import ConfigError, InputError, PathError, PopsteerError
from popsteer.params_file import add_load_and_save, spell_out
from popsteer.prediction import Prediction
from popsteer.state import State
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer import adapters as adapters
    from popsteer import controllers as controllers
    from popsteer import identification as identification
    from popsteer import lab as lab
    from popsteer import logs as logs
    from popsteer import paper as paper
    from popsteer import planning as planning
    from popsteer import plants as plants
    from popsteer import presets as presets
    from popsteer import reference as reference
    from popsteer import sim as sim
    from popsteer import tracks as tracks
    from popsteer.identification import identify

__all__ = [
    "AdaptParams",
    "Batch",
    "Command",
    "CommandBatch",
    "ConfigError",
    "CoupledLongitudinal",
    "CoupledLongitudinalParams",
    "Drive",
    "Driver",
    "DriverParams",
    "Estimate",
    "InputError",
    "Lookahead",
    "MonitorParams",
    "Path",
    "PathError",
    "Pid",
    "PidParams",
    "Pop",
    "PopParams",
    "PopsteerError",
    "Prediction",
    "PreviewPop",
    "PreviewPopParams",
    "Projection",
    "PurePursuit",
    "PurePursuitParams",
    "SpeedCommand",
    "SpeedPid",
    "SpeedPidParams",
    "SpeedTracker",
    "SpeedTrackerParams",
    "Stanley",
    "StanleyParams",
    "State",
    "Status",
    "Vehicle",
    "__version__",
    "build_profile",
    "identify",
    "paper",
    "planning",
    "vehicles",
]

spell_out(*(kind for kind in vars(_core).values() if hasattr(kind, "replace") and callable(kind)))
add_load_and_save(PidParams, PopParams, PreviewPopParams, PurePursuitParams, StanleyParams)


# Loaded where they are used: what drives a car needs none of them.
_LAZY = (
    *("adapters", "controllers", "identification", "lab", "logs", "paper"),
    *("planning", "plants", "presets", "reference", "sim", "tracks"),
)

# Hidden from type checkers, which would take any name for one of popsteer.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        if name == "identify":
            return import_module("popsteer.identification").identify
        if name in _LAZY:
            return import_module(f"popsteer.{name}")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_LAZY})
