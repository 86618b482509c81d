"""Path-tracking steering laws for self-driving cars and car-like robots.

The POP controller (proximally optimal predictive) and the laws it is measured against, computed
in Rust. SI units and radians; x forward, y left, yaw counter-clockwise; positive steering turns
left. A law is given the pose of the rear axle and finds its own reference point.

>>> import popsteer
>>> path = popsteer.Path([(float(x), 0.0) for x in range(100)])
>>> pop = popsteer.Pop(path)
>>> command = pop.step(0.0, 0.5, 0.0, 5.0, 0.05)
>>> command.steer < 0.0  # left of the path: steer right
True

"The paper" in these pages is C. Samak, T. Samak, S. Kandhasamy, *Proximally Optimal Predictive
Control Algorithm for Path Tracking of Self-Driving Cars*.

Modules: `popsteer.sim` (plants and the closed loop), `popsteer.tracks`, `popsteer.laws` and
`popsteer.presets` (the laws and their parameter sets by name), `popsteer.study` (comparisons),
`popsteer.report` (tables, figures, files), `popsteer.bench`, and `popsteer.reference` (the same
laws in plain Python, to read and to compare with).
"""

from popsteer._core import (
    Actuator,
    BangBang,
    BangBangParams,
    BangBangState,
    Batch,
    Command,
    CommandBatch,
    CoupledLongitudinal,
    CoupledLongitudinalParams,
    Lookahead,
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
from popsteer.status import Status

__all__ = [
    "Actuator",
    "BangBang",
    "BangBangParams",
    "BangBangState",
    "Batch",
    "Command",
    "CommandBatch",
    "ConfigError",
    "CoupledLongitudinal",
    "CoupledLongitudinalParams",
    "InputError",
    "Lookahead",
    "Path",
    "PathError",
    "Pid",
    "PidParams",
    "PidState",
    "Pop",
    "PopParams",
    "PopState",
    "PopsteerError",
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
    "__version__",
    "build_profile",
    "get_distance",
    "get_predicted_location",
    "kinematic_bicycle",
    "saturate",
    "state_transition",
    "wrap",
]
