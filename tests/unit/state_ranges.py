"""A state with all that may be absent, and the range of each of its numbers."""

from __future__ import annotations

import math
from typing import Any

from popsteer import State

# Of the default vehicle, with all that may be absent: where, from, to, and the field that the error
# names where that is not the place.
DEVIATION = State(cross_track_error=0.5, yaw=0.1, along=(1.0, 0.0))
POSE = State(x=0.0, y=0.0, yaw=0.0, speed=1.0)
WHOLE: dict[str, Any] = {
    "place": State(segment=0, point=(0.0, 1.0), lost=False),
    "handover": State(offset=0.1, remaining=0.5),
    "past": State(angles=((0.0, 0.1), (0.1, 0.1)), wheel=0.0, since=0.0),
    "answer": State(
        measured=DEVIATION,
        predicted=DEVIATION,
        target=(1.0, 2.0),
        reverse=True,
        ahead=State(reference_speed=1.0, distance_to_stop=3.0),
        vehicle=POSE,
    ),
    "monitor": State(
        wheel=0.1,
        yaw=0.2,
        turned=State(over=0.01, under=0.0),
        rates=(0.2, 0.3),
        later=0.1,
        known=((1.1, 0.1), (0.01, 0.02)),
        yaw_rate=0.2,
        noise=State(variance=1e-6, last=0.01, count=9.0),
        gain=State(
            level=0.0,
            variance=1e-6,
            cross=(0.0,),
            mean=(1.0,),
            covariance=(0.01,),
            noise=State(variance=1e-6, last=0.0, count=9.0),
        ),
        course=State(turn=0.1, aside=0.2, commanded=0.3),
        heading=False,
        alarm=0.5,
        within=True,
    ),
}
WHOLE["gate"] = State(
    **dict.fromkeys(("believed", "measured"), POSE),
    **dict.fromkeys(("since", "stale", "agreed", "gone", "age"), 0.0),
    doubted=False,
    jump=((0.0, 0.0), 0.0),
    drift=(0.0, 0.0),
    **dict.fromkeys(("ahead", "aside"), State(over=0.01, under=0.0)),
    **dict.fromkeys(("position", "heading"), State(variance=1e-4, last=0.01, count=9.0)),
    pace=State(variance=1e-4, last=(0.01, 0.02), count=9.0, period=0.05),
)
QUARTER = 0.5 * math.pi
RANGES: list[tuple[str, float, float, str]] = [
    ("steer", -1.22, 1.22, ""),
    ("handover.offset", -2.59, 2.59, ""),
    ("handover.remaining", 0.0, 1.0, ""),
    ("held_time", 0.0, 1e3, ""),
    ("period", 0.0, 1e3, ""),
    *((f"place.point.{axis}", -4e9, 4e9, "place.point") for axis in (0, 1)),
    *(
        (f"estimator.last_measured.{name}", -most, most, "last_measured")
        for name, most in (("x", 2e9), ("y", 2e9), ("yaw", 1e6), ("speed", 1e4))
    ),
    *(
        (f"estimator.unseen.{name}", least, 1e30, "unseen")
        for name, least in (("wheels.turn", -1e30), ("time", 0.0), ("first", -1e30))
    ),
    *(
        (f"estimator.{name}.{field}", least, most, name)
        for name in ("turning", "sliding", "driving")
        for field, least, most in (
            *((each, -1e40, 1e40) for each in ("level", "cross.1", "mean.0")),
            *((variance, 0.0, 1e40) for variance in ("variance", "covariance.0")),
            *(
                ("noise.variance", 0.0, 1e100),
                ("noise.last", -1e49, 1e49),
                ("noise.count", 1.0, 1e100),
            ),
        )
    ),
    # A covariance of two is no more than the root of their variances' product.
    *(
        (f"estimator.{name}.covariance.1", -most, most, name)
        for name, one, other in (
            *(("turning", 0.1, 0.012), ("sliding", 0.02, 0.1), ("driving", 0.1, 0.1)),
        )
        for most in (1.001 * math.sqrt(one**2 * other**2) + 1e-6,)
    ),
    ("estimator.wheel_rate", -1e40, 1e40, "wheel_rate"),
    ("estimator.gain_deviation", 0.0, 1e40, "gain_deviation"),
    *(
        (f"estimator.estimate.{name}", low, high, name)
        for name, low, high in (
            ("gain", 0.4, 2.5),
            ("steer_offset", -0.15, 0.15),
            ("slip", -0.15, 0.15),
            ("slip_length", -3.0, 3.0),
            ("acceleration", -60.0, 60.0),
            ("speed_scale", 0.6, 1.6),
        )
    ),
    *(
        (f"answer.{vehicle}.{name}", -most, most, "answer")
        for vehicle in ("measured", "predicted")
        for name, most in (
            *(("cross_track_error", 4e9), ("yaw", 2e6)),
            *(("along.0", 4e9), ("along.1", 4e9)),
        )
    ),
    *((f"answer.target.{axis}", -4e9, 4e9, "answer") for axis in (0, 1)),
    ("answer.ahead.reference_speed", -2e4, 2e4, "answer"),
    *(
        (f"answer.vehicle.{name}", -most, most, "answer")
        for name, most in (("x", 1e9), ("y", 1e9), ("yaw", 1e6), ("speed", 1e4))
    ),
    *((f"gate.{name}.x", -1e20, 1e20, "gate") for name in ("believed", "measured")),
    *((f"gate.{name}", -1e20, 1e20, "gate") for name in ("gone", "jump.0.0", "jump.1", "drift.0")),
    *((f"gate.{name}", 0.0, 1e20, "gate") for name in ("since", "stale", "agreed", "age")),
    *(
        (f"{name}.{side}", 0.0, 1e100, name.split(".")[0])
        for name in ("gate.ahead", "gate.aside", "monitor.turned")
        for side in ("over", "under")
    ),
    *(
        (f"{name}.{field}", least, most, name.split(".")[0])
        for name in ("gate.position", "gate.heading", "monitor.noise")
        for field, least, most in (
            *(("variance", 0.0, 1e100), ("last", -1e49, 1e49), ("count", 1.0, 1e100)),
        )
    ),
    *(
        (f"gate.pace.{field}", least, most, "gate")
        for field, least, most in (
            *((name, 0.0, 1e100) for name in ("variance", "count", "period")),
            *((f"last.{place}", -1e49, 1e49) for place in (0, 1)),
        )
    ),
    ("past.wheel", -QUARTER, QUARTER, ""),
    ("past.since", 0.0, 1e6, ""),
    ("past.angles.1.0", -QUARTER, QUARTER, "past.angles"),
    ("past.angles.1.1", 0.0, 1e6, "past.angles"),
    *(
        (f"monitor.{name}", low, high, "monitor")
        for name, low, high in (
            *(("wheel", -QUARTER, QUARTER), ("yaw", -1e6, 1e6)),
            *(("rates.0", -1e100, 1e100), ("rates.1", -1e100, 1e100)),
            *(("later", 0.0, 1e100), ("yaw_rate", -1e100, 1e100)),
            *(("known.0.0", 0.0, 2.5), ("known.0.1", 0.0, 1e100)),
            *(("known.1.0", -1.0, 1.0), ("known.1.1", 0.0, 1e100)),
            *((f"course.{sum_}", -1e100, 1e100) for sum_ in ("turn", "aside", "commanded")),
            ("alarm", 0.0, 2.0),
        )
    ),
]
# Not of preview POP, whose commands in flight would have to be as long.
LONGER = [("estimator.estimate.longer_dead_time", -0.1, 0.25, "longer_dead_time")]
OWN_RANGES: dict[str, list[tuple[str, float, float, str]]] = {
    "Pop": [*LONGER, ("law.previous_steer", -1.22, 1.22, "")],
    "PreviewPop": [
        ("law.previous_steer", -1.22, 1.22, ""),
        ("in_flight.wheel", -QUARTER, QUARTER, ""),
    ],
    "Pid": [
        *LONGER,
        ("law.previous_error", -1e16, 1e16, ""),
        ("law.previous_position.0", -4e9, 4e9, "law.previous_position"),
        ("law.buffer.sum", -1e16, 1e16, ""),
        ("law.buffer.terms.1", -1e16, 1e16, "law.buffer.terms"),
    ],
    "PurePursuit": [*LONGER, ("law.previous_alpha", -math.pi, math.pi, "")],
}
