"""A law of the user's own in the closed loop."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

from popsteer._core import CoupledLongitudinal, SpeedPid
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer._core import Simulation

__all__ = ["OwnCommand", "OwnLaw", "Step", "drive"]

_STEPS_PER_LOOK = 256  # between two calls of `progress`, as in the closed loop of the core
_STATUS_CODES = {
    Status.OK: 0,
    Status.LOOKAHEAD_LOST: 1,
    Status.SATURATED: 2,
    Status.END_OF_PATH: 3,
    Status.OFF_PATH: 4,
    Status.INPUT_HELD: 5,
    Status.INPUT_LOST: 6,
}


class OwnCommand(Protocol):
    """What a law of your own may return: an angle, and more if it likes.

    `target` (a point [m]) and `status` go into the records where they are given, as `Command` has
    them.
    """

    @property
    def steer(self) -> float:
        """Angle of the front wheels [rad]."""
        ...


class OwnLaw(Protocol):
    """What `run` asks of a law of your own.

    It may carry `path` (what it follows), `reference_offset` (where its errors are measured, ahead
    of the point whose pose it is given [m]; the plant's front axle by default) and `name`.
    """

    def step(
        self, x: float, y: float, yaw: float, speed: float, dt: float, /
    ) -> OwnCommand | float:
        """Answer the pose [m, m, rad] and the speed [m/s] with the angle of the wheels [rad]."""
        ...


class Step:
    """What one answer of a law holds for the records."""

    __slots__ = ("status", "steer", "target")

    def __init__(self, answer: OwnCommand | float) -> None:
        if isinstance(answer, (int, float)):
            self.steer = float(answer)
        else:
            try:
                self.steer = float(answer.steer)
            except (AttributeError, TypeError):
                kind = type(answer).__name__
                message = f"a law's step must return an angle or have .steer, got {kind}"
                raise TypeError(message) from None
        target: tuple[float, float] | None = getattr(answer, "target", None)
        self.target = (math.nan, math.nan) if target is None else (target[0], target[1])
        self.status = _STATUS_CODES[Status(getattr(answer, "status", Status.OK))]


def drive(
    simulation: Simulation,
    law: OwnLaw,
    longitudinal: CoupledLongitudinal | SpeedPid | None = None,
    progress: Callable[[float], object] | None = None,
) -> list[Step]:
    """Let a law drive until the run is over: `Simulation.drive`, step by step.

    Parameters
    ----------
    simulation : Simulation
        The vehicle.
    law : OwnLaw
        The law, in the state that it is in.
    longitudinal : CoupledLongitudinal or SpeedPid, optional
        The pedals, from a fresh state; by default the paper's law.
    progress : callable, optional
        Called now and then with the share of the path done, 0 to 1.

    Returns
    -------
    list of Step
        What the law answered at each step.

    Raises
    ------
    InputError
        The law's angle is not finite or beyond its bound.
    TypeError
        The law's answer is neither a number nor has an angle.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.sim import Simulation
    >>> class Straight:
    ...     def step(self, x, y, yaw, speed, dt):
    ...         return 0.0
    >>> path = popsteer.Path([(0.0, 0.0), (50.0, 0.0)])
    >>> simulation = Simulation(path, start=(0.0, 0.5, 0.0))
    >>> steps = drive(simulation, Straight())
    >>> simulation.is_finished
    True
    """
    # A copy starts from a fresh state and leaves the caller's alone, as the core's loop does.
    speed_pid = SpeedPid(longitudinal.params) if isinstance(longitudinal, SpeedPid) else None
    coupled = (
        longitudinal if isinstance(longitudinal, CoupledLongitudinal) else CoupledLongitudinal()
    )
    dt = simulation.settings.dt
    steps: list[Step] = []
    while not simulation.is_over:
        x, y, yaw, speed = simulation.vehicle
        step = Step(law.step(x, y, yaw, speed, dt))
        if speed_pid is None:
            throttle, brake = coupled.step(speed, step.steer)
        else:
            wanted = simulation.reference_speed
            throttle, brake = speed_pid.step(speed, speed if wanted is None else wanted, dt)
        simulation.step(step.steer, throttle, brake)
        steps.append(step)
        if progress is not None and len(steps) % _STEPS_PER_LOOK == 0:
            progress(simulation.progress)
    return steps
