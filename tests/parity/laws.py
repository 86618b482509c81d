"""The laws by name, with what their parameters may be."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from hypothesis import strategies as st

from tests.parity.strategies import usually

Range = tuple[float, float]


@dataclass(frozen=True)
class Law:
    """A class of popsteer with parameters: the range of each number, and where it usually is."""

    name: str
    ranges: dict[str, tuple[Range, Range]]
    counts: dict[str, tuple[int, int]] = field(default_factory=dict)
    flags: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    searches: bool = False
    reads_belief: bool = False

    @property
    def params_name(self) -> str:
        return f"{self.name}Params"

    @property
    def state_name(self) -> str:
        return f"{self.name}State"

    def params(self) -> st.SearchStrategy[dict[str, Any]]:
        """Some of the parameters, the others by default."""
        drawn: dict[str, st.SearchStrategy[Any]] = {
            name: usually(usual, *whole) for name, (whole, usual) in self.ranges.items()
        }
        for name in self.optional:
            drawn[name] = st.none() | drawn[name]
        for name in self.flags:
            drawn[name] = st.booleans()
        if "buffer_length" in self.counts:
            drawn["buffer_length"] = st.integers(1, 12) | st.integers(1, 500)
        if "candidate_count" in self.counts:
            drawn["candidate_count"] = st.integers(1, 50).map(lambda half: 2 * half + 1)
        return st.fixed_dictionaries({}, optional=drawn)


_FOLLOW: dict[str, tuple[Range, Range]] = {
    "search_distance": ((0.0, 1e6), (0.0, 20.0)),
    "lost_distance": ((1e-3, 1e9), (5.0, 60.0)),
}
_SEARCH: dict[str, tuple[Range, Range]] = {
    "lookahead_gain": ((0.0, 1e3), (0.0, 1.0)),
    "min_lookahead": ((0.0, 1e4), (0.0, 12.0)),
    "lookahead_tolerance": ((1e-9, 1e3), (0.005, 0.5)),
    "window_ahead": ((1e-3, 1e6), (5.0, 40.0)),
    "grid_spacing": ((1e-6, 1e3), (0.01, 1.0)),
}
_SEARCHED = ("min_lookahead", "lookahead_tolerance", "window_ahead", "grid_spacing")
_GAIN: tuple[Range, Range] = ((0.0, 1e6), (0.0, 2.0))

POP = Law(
    "Pop",
    {**_SEARCH, "steer_span": ((1e-6, math.pi), (0.01, 0.5)), **_FOLLOW},
    counts={"candidate_count": (3, 100_001)},
    flags=("exact_lookahead",),
    optional=(*_SEARCHED, *_FOLLOW),
    searches=True,
)
PREVIEW_POP = Law(
    "PreviewPop",
    {
        "steer_span_rate": ((1e-3, 1e6), (0.1, 3.0)),
        "horizon": ((0.05, 100.0), (0.3, 3.0)),
        "heading_cost": ((0.0, 1e3), (0.0, 10.0)),
        "steer_rate_cost": ((1e-5, 1e3), (0.05, 2.0)),
        "approach_angle": ((1e-3, 0.5 * math.pi), (0.05, 1.0)),
        "min_speed": ((1e-3, 1e4), (1.0, 10.0)),
        "smoothing_length": ((0.0, 1e3), (0.0, 10.0)),
        **_FOLLOW,
    },
    optional=(
        *("steer_span_rate", "heading_cost", "steer_rate_cost", "min_speed", "smoothing_length"),
        *_FOLLOW,
    ),
    reads_belief=True,
)
PID = Law(
    "Pid",
    {
        "kp": _GAIN,
        "ki": _GAIN,
        "kd": _GAIN,
        "smoothing_length": ((0.0, 1e4), (0.0, 10.0)),
        **_FOLLOW,
    },
    counts={"buffer_length": (1, 500)},
    flags=("integral_with_dt",),
    optional=("kp", "ki", "kd", "smoothing_length", *_FOLLOW),
)
PURE_PURSUIT = Law(
    "PurePursuit",
    {**_SEARCH, **_FOLLOW},
    flags=("alpha_by_arccos", "exact_lookahead"),
    optional=(*_SEARCHED, *_FOLLOW),
    searches=True,
)
STANLEY = Law(
    "Stanley",
    {
        "cross_track_gain": _GAIN,
        "speed_gain": _GAIN,
        "softening": ((1e-9, 1e6), (1e-5, 1.0)),
        "smoothing_length": ((0.0, 1e4), (0.0, 10.0)),
        **_FOLLOW,
    },
    flags=("heading_behind",),
    optional=("softening", "smoothing_length", *_FOLLOW),
)
COUPLED = Law(
    "CoupledLongitudinal",
    {
        "cutoff": ((0.0, 1.0), (0.3, 0.7)),
        "steer_limit": ((1e-3, 1.57), (0.3, 1.3)),
        "speed_limit": ((1e-3, 1e4), (5.0, 70.0)),
    },
)
SPEED_PID = Law("SpeedPid", {"kp": _GAIN, "ki": _GAIN, "kd": _GAIN})

SPEED_TRACKER = Law(
    "SpeedTracker",
    {
        "kp": ((0.0, 1e3), (0.0, 4.0)),
        "ki": ((0.0, 1e3), (0.0, 1.0)),
        "max_jerk": ((1e-3, 1e6), (1.0, 50.0)),
        "reserve": ((0.0, 1e3), (0.0, 1.0)),
        "drive_delay": ((0.0, 10.0), (0.0, 0.5)),
    },
)

LATERAL = (POP, PREVIEW_POP, PID, PURE_PURSUIT, STANLEY)
ALL = (*LATERAL, COUPLED, SPEED_PID, SPEED_TRACKER)
