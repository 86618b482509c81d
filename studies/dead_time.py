"""What dead time does to the controllers, and what prediction makes of it: docs/edges.md."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from popsteer import controllers, presets, sim
from popsteer.sim import CarlaIdentified, KinematicBicycle, Metrics
from studies.layout import AUTHORS_START, course, line

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer import AdaptParams, Path
    from popsteer.sim import Pose

NAMES = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")
RUNS = ("late", "predicted", "short", "long", "early", "later")


@dataclass(frozen=True, eq=False)
class DeadTimeRow:
    """What each of the models of `run` did to a controller, by its name."""

    law: str
    prompt: Metrics
    late: Metrics
    predicted: Metrics
    short: Metrics
    long: Metrics
    early: Metrics
    later: Metrics

    def ratio(self, found: Metrics) -> float:
        """Give the mean error of one of the row's runs over that without dead time.

        Infinite where the run did not finish.
        """
        if not found.finished:
            return math.inf
        return found.mean_abs_cross_track_error / self.prompt.mean_abs_cross_track_error


def run(
    path: Path,
    names: Iterable[str] = NAMES,
    *,
    plant: CarlaIdentified | KinematicBicycle | None = None,
    start: Pose | None = None,
    start_at: Literal["pose", "front"] = "pose",
    preset: str = presets.REPRODUCTION,
    dead_time: float = 0.2,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
) -> list[DeadTimeRow]:
    """Drive with and without dead time [s], and with a prediction through it, right and wrong.

    The plant's own dead time is replaced; the default is the one identified from the authors' run.
    """
    plant = CarlaIdentified() if plant is None else plant
    prompt = plant.vehicle.replace(dead_time=0.0)
    real = prompt.replace(dead_time=dead_time)
    turning = real.turning_length(0.0)
    # The vehicle, and what the controller is given: no dead time, none given, and right or wrong.
    models = {
        "prompt": (prompt, prompt),
        "late": (real, prompt),
        "predicted": (real, real),
        "short": (real, real.replace(turning_wheelbase=0.85 * turning)),
        "long": (real, real.replace(turning_wheelbase=1.15 * turning)),
        "early": (real, real.replace(dead_time=dead_time - 0.05)),
        "later": (real, real.replace(dead_time=dead_time + 0.05)),
    }
    rows = []
    for name in names:
        make = controllers.get(name).controller
        # The registries pair each controller with its parameters; the type checker cannot see it.
        params: Any = presets.get(name, preset)
        found: dict[str, Any] = {
            model: sim.run(
                make(path, believed, params, adapt=adapt),
                plant.replace(vehicle=vehicle),
                start=start,
                start_at=start_at,
            ).metrics
            for model, (vehicle, believed) in models.items()
        }
        rows.append(DeadTimeRow(law=name, **found))
    return rows


def dead_time_rows(name: str) -> list[DeadTimeRow]:
    """Drive a shipped track, or that of the paper's authors."""
    path, start = course(name)
    if start is None:
        return run(path)
    return run(path, start=AUTHORS_START, start_at="front")


def dead_time_lines(rows: Iterable[DeadTimeRow]) -> list[str]:
    """Mean errors [m]; in brackets over that without dead time."""
    return [
        line(
            controllers.get(row.law).title,
            f"{row.prompt.mean_abs_cross_track_error:.3f}",
            *(_cell(row, getattr(row, each)) for each in RUNS),
        )
        for row in rows
    ]


def _cell(row: DeadTimeRow, found: Metrics) -> str:
    if not found.finished:
        return "off the road"
    return f"{found.mean_abs_cross_track_error:.3f} ({row.ratio(found):.2f})"
