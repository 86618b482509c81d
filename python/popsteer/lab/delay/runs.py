"""What dead time does to the controllers, and what it costs to predict through it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from popsteer import controllers, presets, sim
from popsteer.errors import ConfigError
from popsteer.ranges import check_in_range
from popsteer.sim import CarlaIdentified, KinematicBicycle, Metrics

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from typing import Any

    from popsteer._core import AdaptParams, Path, Settings
    from popsteer.controllers import Params
    from popsteer.sim.closed_loop import Pose
    from popsteer.sim.geometry import StartAt

__all__ = ["DEAD_TIME", "DEAD_TIME_CONTROLLERS", "DEAD_TIME_PLANT", "DeadTimeRow", "run"]

DEAD_TIME_CONTROLLERS = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")
"""The controllers that are driven."""
DEAD_TIME_PLANT = CarlaIdentified()
"""What moves: the plant identified from the run of the paper's authors."""
DEAD_TIME = 0.2
"""Dead time between command and wheels [s]: four control periods of the paper."""


@dataclass(frozen=True, eq=False)
class DeadTimeRow:
    """What dead time did to a controller, and what prediction made of it."""

    law: str
    """Name of the controller."""
    dead_time: float
    """Dead time between command and wheels [s]."""
    prompt: Metrics
    """Without dead time."""
    late: Metrics
    """With it, and the controller given none: it does not predict."""
    predicted: Metrics
    """With it, and the controller given it: it predicts through it."""
    short: Metrics
    """... and given a turning wheelbase 15 % too short."""
    long: Metrics
    """... 15 % too long."""
    early: Metrics
    """... and given a dead time 50 ms too short."""
    later: Metrics
    """... 50 ms too long."""

    def ratio(self, found: Metrics) -> float:
        """Give the error of a run over that without dead time.

        Parameters
        ----------
        found : Metrics
            One of the row's runs.

        Returns
        -------
        float
            Ratio of the mean absolute cross-track errors; infinite where the run did not finish.
        """
        if not found.finished:
            return float("inf")
        return found.mean_abs_cross_track_error / self.prompt.mean_abs_cross_track_error


def run(  # noqa: PLR0913 - as `popsteer.sim.run`
    path: Path,
    names: Iterable[str] | Mapping[str, Params] = DEAD_TIME_CONTROLLERS,
    *,
    plant: CarlaIdentified | KinematicBicycle = DEAD_TIME_PLANT,
    start: Pose | None = None,
    start_at: StartAt = "pose",
    speed: float | None = None,
    constant_speed: float | None = None,
    settings: Settings | None = None,
    preset: str = presets.REPRODUCTION,
    dead_time: float = DEAD_TIME,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
    progress: Callable[[str, float], object] | None = None,
) -> list[DeadTimeRow]:
    """Drive with and without dead time, and with a prediction through it, right and wrong.

    Parameters
    ----------
    path : Path
        What is followed.
    names : iterable of str, or mapping of str to parameters
        The controllers, of `popsteer.controllers.names`. A mapping gives each its tuning, and
        `preset` is then not used.
    plant : CarlaIdentified or KinematicBicycle, default DEAD_TIME_PLANT
        What moves; its own dead time is replaced.
    start : tuple of float, optional
        Pose at the start [m, m, rad]; as `popsteer.sim.run` has it by default.
    start_at : {"pose", "rear", "front"}, default "pose"
        Whose pose `start` is: the vehicle's point's, or that of an axle.
    speed, constant_speed : float, optional
        Speed at the start, and speed to be kept throughout [m/s]; as `popsteer.sim.run` has them.
    settings : Settings, optional
        Control period, limits and the like.
    preset : str, default "reproduction"
        Where the tuning of the controllers comes from.
    dead_time : float, default 0.2
        Dead time between command and wheels [s], 0.05 to 9.
    adapt : AdaptParams or None, optional
        How the controllers adapt; None: not at all. Left out: as each does by default.
    progress : callable, optional
        Called now and then with what is being done and the share of all that is done, 0 to 1.

    Returns
    -------
    list of DeadTimeRow
        A row for each controller.

    Raises
    ------
    ConfigError
        There is no controller, one or the preset is not known, or a number is out of its range.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(201)])
    >>> row = run(path, ["stanley"])[0]
    >>> row.ratio(row.predicted) < row.ratio(row.late)
    True
    """
    # The registries pair each controller with its parameters; the type checker cannot see that.
    params: dict[str, Any] = (
        dict(names)
        if isinstance(names, Mapping)
        else {name: presets.get(name, preset) for name in names}
    )
    if not params:
        raise ConfigError("controllers", [], "at least one")
    check_in_range("dead_time", dead_time, 0.05, 9.0)
    prompt = plant.vehicle.replace(dead_time=0.0)
    real = prompt.replace(dead_time=dead_time)
    turning = real.turning_length(0.0)
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
    for index, name in enumerate(params):
        found = {}
        for step, (model, (vehicle, believed)) in enumerate(models.items()):
            if progress is not None:
                progress(f"{name}: {model}", (index + step / len(models)) / len(params))
            make = controllers.get(name).controller
            driver = make(path, believed, params[name], adapt=adapt)
            done = sim.run(
                driver,
                plant.replace(vehicle=vehicle),
                start=start,
                start_at=start_at,
                speed=speed,
                constant_speed=constant_speed,
                settings=settings,
            )
            found[model] = done.metrics
        rows.append(DeadTimeRow(law=name, dead_time=dead_time, **found))
    if progress is not None:
        progress("done", 1.0)
    return rows
