"""What dead time does to the laws, and what it costs to predict through it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer import laws, presets
from popsteer._core import Actuator
from popsteer.errors import ConfigError
from popsteer.ranges import check_in_range
from popsteer.sim import Metrics, actuator, fitted, run
from popsteer.sim.geometry import LEARNING_TIME

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from popsteer._core import Path
    from popsteer.sim.run import Pose

__all__ = ["DEAD_TIME", "DEAD_TIME_LAWS", "DEAD_TIME_PLANT", "DeadTimeRow", "dead_times"]

DEAD_TIME_LAWS = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")
"""The laws that are driven: all but bang-bang, which holds no line."""
DEAD_TIME_PLANT = "carla-identified"
"""What moves: the plant identified from the run of the paper's authors."""
DEAD_TIME = 0.2
"""Dead time between command and wheels [s]: four control periods of the paper."""


@dataclass(frozen=True, eq=False)
class DeadTimeRow:
    """What dead time did to a law, and what prediction made of it."""

    law: str
    """Name of the law."""
    dead_time: float
    """Dead time between command and wheels [s]."""
    prompt: Metrics
    """Without dead time."""
    late: Metrics
    """With it, and nothing done about it."""
    predicted: Metrics
    """With it, predicted through."""
    short: Metrics
    """... the model's wheelbase 15 % too short."""
    long: Metrics
    """... the model's wheelbase 15 % too long."""
    early: Metrics
    """... its dead time taken to be 50 ms less."""
    later: Metrics
    """... its dead time taken to be 50 ms more."""

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


def dead_times(
    path: Path,
    names: Iterable[str] = DEAD_TIME_LAWS,
    *,
    start: Pose | None = None,
    preset: str = presets.REPRODUCTION,
    dead_time: float = DEAD_TIME,
    learning_time: float = LEARNING_TIME,
    progress: Callable[[str, float], object] | None = None,
) -> list[DeadTimeRow]:
    """Drive laws with and without dead time, and with a prediction through it, right and wrong.

    Parameters
    ----------
    path : Path
        What is followed.
    names : iterable of str
        The laws, of `popsteer.laws.names`.
    start : tuple of float, optional
        Pose of the front axle at the start [m, m, rad]; as `popsteer.sim.run` has it by default.
    preset : str, default "reproduction"
        Where the parameters of the laws come from.
    dead_time : float, default 0.2
        Dead time between command and wheels [s], 0.05 to 9.
    learning_time : float, default 10.0
        Time over which the actuator learns how wrong its model is [s]; 0 never.
    progress : callable, optional
        Called now and then with what is being done and the share of all that is done, 0 to 1.

    Returns
    -------
    list of DeadTimeRow
        A row for each law.

    Raises
    ------
    ConfigError
        There is no law, a law or the preset is not known, or a number is out of its range.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(201)])
    >>> row = dead_times(path, ["stanley"])[0]
    >>> row.ratio(row.predicted) < row.ratio(row.late)
    True
    """
    chosen = list(names)
    if not chosen:
        raise ConfigError("laws", chosen, "at least one")
    check_in_range("dead_time", dead_time, 0.05, 9.0)
    real = Actuator(dead_time=dead_time)
    known = actuator(DEAD_TIME_PLANT, dead_time).replace(learning_time=learning_time)
    models: dict[str, tuple[Actuator | None, Actuator | None]] = {
        "prompt": (None, None),
        "late": (real, None),
        "predicted": (real, known),
        "short": (real, known.replace(wheelbase=0.85 * known.wheelbase)),
        "long": (real, known.replace(wheelbase=1.15 * known.wheelbase)),
        "early": (real, known.replace(dead_time=dead_time - 0.05)),
        "later": (real, known.replace(dead_time=dead_time + 0.05)),
    }
    params = {name: fitted(presets.get(name, preset), DEAD_TIME_PLANT) for name in chosen}
    rows = []
    for index, name in enumerate(chosen):
        found = {}
        for step, (model, (steering, predicting)) in enumerate(models.items()):
            if progress is not None:
                progress(f"{name}: {model}", (index + step / len(models)) / len(chosen))
            controller = laws.get(name).controller
            law = controller(path, params[name], actuator=predicting)  # type: ignore[arg-type]
            found[model] = run(law, DEAD_TIME_PLANT, start=start, steering=steering).metrics
        rows.append(DeadTimeRow(law=name, dead_time=dead_time, **found))
    if progress is not None:
        progress("done", 1.0)
    return rows
