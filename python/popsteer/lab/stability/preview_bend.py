"""The offset of preview POP in a bend: none, except by the errors of its model.

In a steady bend of curvature κ the prediction with the right model foresees no error and asks for
no move. Where the vehicle turns by l = L + K v² and the model by l', the controller commands
c = κ l / l' in the model's curvature, and rests where the error asks for what is missing, with its
gains g of `popsteer.lab.stability.linear`::

    g_e e = (g_a + g_c) (κ - c)      e = (g_a + g_c) / g_e · (1 - l / l') / R
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from popsteer._core import AdaptParams, PopParams, PreviewPopParams
from popsteer.lab.stability.carrot import carrot_offset
from popsteer.lab.stability.linear import preview_gains
from popsteer.lab.stability.runs import margins
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer._core import Vehicle


class Choice(NamedTuple):
    """Margin and accuracy at each value of a parameter that trades one for the other."""

    values: tuple[float, ...]
    """The values."""
    dead_times: tuple[float, ...]
    """Dead time that may be added [s]; NaN where the loop is unstable without."""
    offsets: tuple[float, ...]
    """Offset in the bend, to the inside [m]."""


def preview_offset(
    params: PreviewPopParams,
    vehicle: Vehicle,
    radius: float,
    speed: float,
    dt: float = 0.05,
    *,
    believed: Vehicle | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
) -> float:
    """Offset that preview POP keeps in a steady bend.

    Parameters
    ----------
    params : PreviewPopParams
        Tuning of the controller.
    vehicle : Vehicle
        The vehicle as it is.
    radius : float
        Radius R of the bend [m]; it should be wide against the wheelbase.
    speed : float
        Speed v [m/s], positive.
    dt : float, default 0.05
        Control period [s].
    believed : Vehicle, optional
        The vehicle that the controller is given; `vehicle` by default.
    adapt : AdaptParams or None, optional
        How the controller adapts; None: not at all. Left out: as it does by default.

    Returns
    -------
    float
        How far inside the bend its tracked point runs [m]; negative outside. 0 where it estimates
        how the vehicle turns.

    Raises
    ------
    ConfigError
        A number is out of its range.

    Examples
    --------
    >>> from popsteer import PreviewPopParams, Vehicle
    >>> preview_offset(PreviewPopParams(), Vehicle(), 50.0, 15.0, adapt=None)
    0.0
    >>> longer = Vehicle(turning_wheelbase=3.3)
    >>> offset = preview_offset(
    ...     PreviewPopParams(), Vehicle(), 50.0, 15.0, believed=longer, adapt=None
    ... )
    >>> 0.0 < offset < 0.1
    True
    """
    check_in_range("radius", radius, 1e-3, 1e6)
    check_in_range("speed", speed, 1e-3, 1e3)
    check_in_range("dt", dt, 1e-3, 1.0)
    adapt = AdaptParams() if adapt == "auto" else adapt
    if adapt is not None and adapt.turn_time > 0.0:
        return 0.0
    believed = vehicle if believed is None else believed
    gains = preview_gains(params, believed, speed, dt)
    turns, modelled = vehicle.turning_length(speed), believed.turning_length(speed)
    return (gains.driven + gains.commanded) / gains.error * (1.0 - turns / modelled) / radius


def choice(
    params: PopParams | PreviewPopParams,
    vehicle: Vehicle,
    values: Sequence[float],
    *,
    radius: float = 50.0,
    speed: float = 15.0,
    dt: float = 0.05,
    believed: Vehicle | None = None,
    adapt: AdaptParams | Literal["auto"] | None = "auto",
) -> Choice:
    """Vary the parameter of a controller that trades margin for accuracy.

    `values` are lookahead distances [m] for POP, values of `steer_rate_cost` [m s/rad] for preview
    POP. `radius` is that of the bend [m], and the other arguments are those of `preview_offset`.
    Raises ConfigError where a number is out of its range.
    """
    dead_times, offsets = [], []
    for value in values:
        changed: PopParams | PreviewPopParams
        if isinstance(params, PopParams):
            changed = params.replace(lookahead_gain=0.0, min_lookahead=value)
            offset = carrot_offset(value, radius, vehicle, speed)
        else:
            changed = params.replace(steer_rate_cost=value)
            offset = preview_offset(
                changed, vehicle, radius, speed, dt, believed=believed, adapt=adapt
            )
        found = margins(changed, vehicle, speed, dt, believed=believed, adapt=adapt)
        dead_times.append(found.dead_time)
        offsets.append(offset)
    return Choice(tuple(values), tuple(dead_times), tuple(offsets))
