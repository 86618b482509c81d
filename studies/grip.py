"""Wheels' loads on circuits with hairpins, by the lateral acceleration asked.

Six closed splines with hairpins of 7 to 12 m, planned with 4 m/s² of braking, driven by preview
POP: a table of docs/planning.md.
The controller is told the vehicle's own limit, but in the first rows, whose limit is 4 m/s².

    python -m studies.pages grip
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from popsteer import Path, PreviewPop, SpeedTracker, Status, plants, sim
from popsteer.sim.closed_loop import START_OFFSET
from studies.layout import line
from tests.trust.car import circuit

PLANTS = ("commonroad-mb-1", "commonroad-mb-2", "commonroad-mb-3", "mujoco-car")
CIRCUITS = 6
RESERVE = 0.9
"""Share of the vehicle's lateral acceleration that a plan uses."""
LIMITS: dict[str, Any] = {"max_speed": 30.0, "max_acceleration": 2.5, "max_deceleration": 4.0}
SAYING = Status.TOO_FAST | Status.LATERAL_LIMIT
SETTLED = 100
"""Steps after which the start beside the path is over."""
RECENT = 60
"""Steps before a wheel lifts in which a status counts as said ahead."""


class Watched:
    """A plant whose wheels' loads and lateral acceleration are watched."""

    def __init__(self, name: str) -> None:
        self.plant: Any = plants.get(name)
        self.name, self.vehicle = name, self.plant.vehicle
        self.reverses, self.params = self.plant.reverses, self.plant.params
        self.reset = self.plant.reset
        self.least: list[float] = []
        """The least load of a wheel, as a share of the mean at rest."""
        self.lateral: list[float] = []

    def advance(self, *command: Any) -> plants.PlantState:
        state: plants.PlantState = self.plant.advance(*command)
        loads = self._deflections()
        self.least.append(min(loads) / (sum(loads) / len(loads)))
        self.lateral.append(abs(state.speed * state.yaw_rate))
        return state

    def _deflections(self) -> list[float]:
        """How far tyres or springs are pressed in, which is in proportion to their loads."""
        if self.name == "mujoco-car":
            model, data = self.plant._model, self.plant._data  # noqa: SLF001
            springs = [f"spring {a} {b}" for a in ("front", "rear") for b in ("left", "right")]
            places = [model.joint(each).qposadr[0] for each in springs]
            return [float(data.qpos[at]) - float(model.qpos_spring[at]) for at in places]
        x, p = self.plant._x, self.plant._p  # noqa: SLF001
        loads = []
        for roll, height, track in ((x[13], x[16], p.T_f), (x[18], x[21], p.T_r)):
            middle = height + p.R_w * (np.cos(roll) - 1.0)
            lean = 0.5 * track * np.sin(roll)
            loads += [float(middle - lean), float(middle + lean)]
        return loads


class Driven(NamedTuple):
    """What a circuit came to."""

    finished: bool
    lateral: float
    """Largest lateral acceleration [m/s²]."""
    least: float
    """Least load of a wheel, as a share of the mean."""
    said: int
    """Steps that are `too-fast`."""
    ahead: float | None
    """How long before a wheel lifted a status said so first [s]; 0 if none did. None: none did."""


def drive(name: str, seed: int, asked: float | None = None, told: float | None = None) -> Driven:
    """Drive a circuit planned at `asked` [m/s²], or with the reserve of the limit `told`."""
    plant = Watched(name)
    car = plant.vehicle.replace(**LIMITS)
    if told is not None:
        car = car.replace(max_lateral_acceleration=told)
    pace = car if asked is None else car.replace(max_lateral_acceleration=asked / RESERVE)
    path = Path(circuit(seed, 1.0), closed=True)
    start = sim.default_start(path, -START_OFFSET, car)
    pedals = SpeedTracker(path, pace)
    run = sim.run(PreviewPop(path, car), plant, start=start, speed=4.0, longitudinal=pedals)
    time, steps = run.records["time"], len(run.records["time"])
    statuses = [Status(int(each)) for each in run.records["status"]]
    ahead = None
    # A run that ends on the way from the start counts whole.
    first = SETTLED if len(plant.least) > SETTLED else 0
    if "leaves the road" in run.ending or min(plant.least[first:]) <= 0.0:
        lifted = next(
            (k for k, load in enumerate(plant.least) if k >= first and load <= 0.0), steps - 1
        )
        said = [k for k in range(max(0, lifted - RECENT), lifted + 1) if statuses[k] & SAYING]
        ahead = float(time[lifted] - time[said[0]]) if said else 0.0
    return Driven(
        run.metrics.finished,
        max(plant.lateral[first:]),
        min(plant.least[first:]),
        sum(bool(each & Status.TOO_FAST) for each in statuses[first:]),
        ahead,
    )


def grip_lines() -> list[str]:
    """Word a row for each plant and acceleration asked."""
    lines = []
    for name in PLANTS:
        own = plants.get(name).vehicle.max_lateral_acceleration or 0.0
        for title, asked, told in (
            ("3.6, told 4", None, 4.0),
            (f"{RESERVE * own:.1f}, its own limit {own:.1f}", None, None),
            ("8", 8.0, None),
            ("10", 10.0, None),
        ):
            runs = [drive(name, seed, asked, told) for seed in range(CIRCUITS)]
            lifts = [run.ahead for run in runs if run.ahead is not None]
            ahead = ", ".join(f"{each:.1f}" for each in sorted(lifts)) or "–"
            lines.append(
                line(
                    name,
                    title,
                    f"{sum(run.finished for run in runs)} of {CIRCUITS}",
                    f"{max(run.lateral for run in runs):.2f}",
                    f"{100.0 * max(0.0, min(run.least for run in runs)):.0f} %",
                    str(sum(run.said for run in runs)),
                    ahead,
                )
            )
    return lines
