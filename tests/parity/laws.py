"""The laws by name, with what their parameters may be."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

from hypothesis import strategies as st

from popsteer import reference
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


# Where a number usually is; one that is not named: from half of its default to twice that.
_USUAL: dict[str, Range] = {
    "search_distance": (0.0, 20.0),
    "lost_distance": (5.0, 60.0),
    "lookahead_gain": (0.0, 1.0),
    "min_lookahead": (0.0, 12.0),
    "lookahead_tolerance": (0.005, 0.5),
    "window_ahead": (5.0, 40.0),
    "grid_spacing": (0.01, 1.0),
    "steer_span": (0.01, 0.5),
    "steer_span_rate": (0.1, 3.0),
    "horizon": (0.3, 3.0),
    "heading_cost": (0.0, 10.0),
    "steer_rate_cost": (0.05, 2.0),
    "approach_angle": (0.05, 1.0),
    "min_speed": (1.0, 10.0),
    "smoothing_length": (0.0, 10.0),
    **dict.fromkeys(("kp", "ki", "kd", "cross_track_gain", "speed_gain"), (0.0, 2.0)),
    "softening": (1e-5, 1.0),
    "cutoff": (0.3, 0.7),
    "steer_limit": (0.3, 1.3),
    "speed_limit": (5.0, 70.0),
}


def _law(name: str, *, searches: bool = False, reads_belief: bool = False) -> Law:
    """A law with the parameters that its reference declares."""
    params = getattr(reference, f"{name}Params")()
    declared = {each.name: each for each in dataclasses.fields(params)}
    resolved = params.resolved(reference.Vehicle()) if hasattr(params, "resolved") else params
    counts = {key: at for key, at in declared.items() if type(at.default) is int}
    flags = tuple(key for key, at in declared.items() if type(at.default) is bool)
    ranges = {}
    for key in declared.keys() - counts - set(flags):
        low, high = declared[key].metadata["range"]
        default = getattr(resolved, key)
        usual = max(low, 0.5 * default), min(high, 2.0 * default)
        ranges[key] = (low, high), _USUAL.get(key, usual)
    return Law(
        name,
        {key: ranges[key] for key in declared if key in ranges},
        {key: at.metadata["range"] for key, at in counts.items()},
        flags,
        tuple(key for key, at in declared.items() if at.default is None),
        searches=searches,
        reads_belief=reads_belief,
    )


POP = _law("Pop", searches=True)
PREVIEW_POP = _law("PreviewPop", reads_belief=True)
PID = _law("Pid")
PURE_PURSUIT = _law("PurePursuit", searches=True)
STANLEY = _law("Stanley")
COUPLED = _law("CoupledLongitudinal")
SPEED_PID = _law("SpeedPid")
# It has no reference.
SPEED_TRACKER = Law(
    "SpeedTracker",
    {
        "kp": ((0.0, 1e3), (0.0, 4.0)),
        "disturbance_time": ((1e-3, 1e3), (0.1, 5.0)),
        "max_jerk": ((1e-3, 1e6), (1.0, 50.0)),
        "reserve": ((0.0, 1e3), (0.0, 1.0)),
        "drive_delay": ((0.0, 10.0), (0.0, 0.5)),
    },
)

LATERAL = (POP, PREVIEW_POP, PID, PURE_PURSUIT, STANLEY)
ALL = (*LATERAL, COUPLED, SPEED_PID, SPEED_TRACKER)
