"""What several controllers did on one plant and one path."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from popsteer._core import Path, Vehicle
    from popsteer.sim import Run


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs of several controllers on one plant and one path.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab.compare import run
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> comparison = run(path, ["stanley", "pop"])
    >>> comparison.plant, list(comparison.runs)
    ('carla-identified', ['stanley', 'pop'])
    """

    runs: Mapping[str, Run]
    """The runs by name of the controller, in the order to show them; at least one."""
    tuning: Mapping[str, str]
    """Where the tuning of each controller comes from, by its name: a preset, a file, changes."""
    plant: str
    """What the plant is called."""
    track: str = ""
    """What the path is called; ``dataclasses.replace`` gives it a name."""
    joined: bool = False
    """Whether the settling time is that in which the vehicle drives `JOINED` wheelbases."""
    begins: str = ""
    """Where the runs start and how fast they drive, in one line."""
    constant_speed: float | None = None
    """Speed kept throughout [m/s]; None where another controller worked the pedals."""
    step_times: Mapping[str, float] = field(default_factory=dict)
    """What a step of each controller takes [s], where that was measured: see `time_steps`."""
    latencies: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """What each of the timed steps took, as the clock read it [ns]; by controller."""

    @property
    def first(self) -> Run:
        """Any of the runs, for what they have in common: the first."""
        return next(iter(self.runs.values()))

    @property
    def points(self) -> dict[str, str]:
        """The point at which the errors of each controller are measured, by its name."""
        return {name: _point(run.tracked_point, self.believed) for name, run in self.runs.items()}

    @property
    def vehicle(self) -> Vehicle:
        """What the plant is: the same for all runs."""
        return self.first.plant_vehicle

    @property
    def believed(self) -> Vehicle:
        """What the controllers were given of the vehicle: the same for all."""
        return self.first.vehicle or self.vehicle

    @property
    def path(self) -> Path:
        """What was followed: the same for all runs."""
        return self.first.path

    @property
    def dt(self) -> float:
        """Control period [s]."""
        return self.first.dt


def _point(at: float | None, vehicle: Vehicle) -> str:
    """Name a point `at` [m] ahead of the pose's, None for the front axle."""
    at = vehicle.front_axle if at is None else at
    no_slip = vehicle.rear_axle if vehicle.no_slip_point is None else vehicle.no_slip_point
    known = ((vehicle.front_axle, "front"), (vehicle.rear_axle, "rear"), (no_slip, "no-slip"))
    return next((name for ahead, name in known if at == ahead), f"{at:.3g} m ahead")
