"""What can be set about the plants: pedals, and what else the car in MuJoCo has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from popsteer.parameters import Parameters


@dataclass(frozen=True)
class PedalParams(Parameters):
    """What the pedals and the air do: a = drive·throttle - braking·brake - drag·v.

    The numbers are those of the vehicle identified from the paper's run, so that the paper's
    longitudinal controller drives these plants at speeds like that one's.

    Parameters
    ----------
    drive : float, default 6.0
        Acceleration at full throttle [m/s^2].
    drag : float, default 0.28
        Drag linear in speed [1/s].
    braking : float, default 9.0
        Deceleration at full brake [m/s^2].

    Raises
    ------
    ConfigError
        A number is not in its range.

    Examples
    --------
    >>> PedalParams(drag=0.0).acceleration(0.5, 0.0, 10.0)
    3.0
    """

    RANGES: ClassVar = dict.fromkeys(("drive", "drag", "braking"), (0.0, 1e3))

    drive: float = 6.0
    drag: float = 0.28
    braking: float = 9.0

    def acceleration(self, throttle: float, brake: float, speed: float) -> float:
        """Give the acceleration [m/s^2] by the pedals, 0 to 1, and by the air at a speed [m/s]."""
        return self.drive * throttle - self.braking * brake - self.drag * speed


@dataclass(frozen=True)
class MujocoCarParams(PedalParams):
    """What can be set about the car; the rest is in its model file.

    Parameters
    ----------
    drive : float, default 6.0
        Acceleration that the torque of all wheels gives at full throttle [m/s^2].
    drag : float, default 0.28
        Drag linear in speed [1/s]; it pulls at the body.
    braking : float, default 9.0
        Deceleration that the torque of all wheels gives at full brake [m/s^2].
    friction : float, default 1.0
        Coulomb friction of tyre and road.
    steer_rate : float, default 0.6
        Fastest turn of the front wheels [rad/s].

    Raises
    ------
    ConfigError
        A number is not in its range.

    Examples
    --------
    >>> MujocoCarParams(friction=0.3).drive
    6.0
    """

    RANGES: ClassVar = {
        **PedalParams.RANGES,
        "friction": (0.0, 10.0),
        "steer_rate": (1e-3, 100.0),
    }

    friction: float = 1.0
    steer_rate: float = 0.6
