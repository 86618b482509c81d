"""Path-tracking steering for self-driving cars and car-like robots.

The POP controller (proximally optimal predictive) and the controllers it is measured against,
computed in Rust. SI units and radians; x forward, y left, yaw counter-clockwise; positive steering
turns left. All that is true of the car is told once, in a `Vehicle`. A pose is that of the
vehicle's point, wherever it is measured; each controller finds the point it tracks from there.

>>> import popsteer
>>> path = popsteer.Path([(float(x), 0.0) for x in range(100)])
>>> car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, dead_time=0.15)
>>> controller = popsteer.PreviewPop(path, car)
>>> command = controller.step(0.0, 0.5, 0.0, 5.0, 0.05)
>>> command.steer < 0.0  # left of the path: steer right
True

"The paper" in these pages is C. Samak, T. Samak, S. Kandhasamy, *Proximally Optimal Predictive
Control Algorithm for Path Tracking of Self-Driving Cars*.

Modules: `popsteer.vehicles` (vehicles by name), `popsteer.sim` (plants and the closed loop),
`popsteer.tracks`, `popsteer.laws` and `popsteer.presets` (the controllers and their parameter sets
by name), `popsteer.logs` and `popsteer.identification` (a vehicle from the log of a drive),
`popsteer.study` (comparisons), `popsteer.report` (tables, figures, files), `popsteer.bench`, and
`popsteer.reference` (the same controllers in plain Python, to read and to compare with).
"""

from typing import TYPE_CHECKING, Any

from popsteer import vehicles
from popsteer._core import (
    AdaptParams,
    BangBang,
    BangBangParams,
    BangBangState,
    Batch,
    Command,
    CommandBatch,
    CoupledLongitudinal,
    CoupledLongitudinalParams,
    Estimate,
    Lookahead,
    MonitorParams,
    Path,
    Pid,
    PidParams,
    PidState,
    Pop,
    PopParams,
    PopState,
    PreviewPop,
    PreviewPopParams,
    PreviewPopState,
    Projection,
    PurePursuit,
    PurePursuitParams,
    PurePursuitState,
    SpeedPid,
    SpeedPidParams,
    SpeedPidState,
    Stanley,
    StanleyParams,
    StanleyState,
    Vehicle,
    __version__,
    build_profile,
    get_distance,
    get_predicted_location,
    kinematic_bicycle,
    saturate,
    state_transition,
    wrap,
)
from popsteer.errors import ConfigError, InputError, PathError, PopsteerError
from popsteer.prediction import Prediction
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer.identification import identify

__all__ = [
    "AdaptParams",
    "BangBang",
    "BangBangParams",
    "BangBangState",
    "Batch",
    "Command",
    "CommandBatch",
    "ConfigError",
    "CoupledLongitudinal",
    "CoupledLongitudinalParams",
    "Estimate",
    "InputError",
    "Lookahead",
    "MonitorParams",
    "Path",
    "PathError",
    "Pid",
    "PidParams",
    "PidState",
    "Pop",
    "PopParams",
    "PopState",
    "PopsteerError",
    "Prediction",
    "PreviewPop",
    "PreviewPopParams",
    "PreviewPopState",
    "Projection",
    "PurePursuit",
    "PurePursuitParams",
    "PurePursuitState",
    "SpeedPid",
    "SpeedPidParams",
    "SpeedPidState",
    "Stanley",
    "StanleyParams",
    "StanleyState",
    "Status",
    "Vehicle",
    "__version__",
    "build_profile",
    "get_distance",
    "get_predicted_location",
    "identify",
    "kinematic_bicycle",
    "saturate",
    "state_transition",
    "vehicles",
    "wrap",
]


def __getattr__(name: str) -> Any:  # noqa: ANN401 - what an attribute is depends on its name
    # Loaded where it is used: what drives a car needs none of it.
    if name == "identify":
        from popsteer.identification import identify

        return identify
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
