"""What preview POP keeps of a bend: nothing, but for what its model is wrong about.

In a steady bend of curvature κ the prediction with the right model foresees no error and asks for
no move. Where the vehicle turns by l = L + K v² and the model by l', the law tells its wheels c =
κ l / l' in the model's curvature, and rests where the error asks for what is missing, with its
gains g of `popsteer.study.linear_preview`::

    g_e e = (g_a + g_c) (κ - c)      e = (g_a + g_c) / g_e · (1 - l / l') / R
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from popsteer._core import PopParams, PreviewPopParams
from popsteer.ranges import check_in_range
from popsteer.study.carrot import carrot_offset
from popsteer.study.linear_preview import preview_gains
from popsteer.study.stability import margins

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.study.vehicle import Vehicle

__all__ = ["Choice", "choice", "preview_offset"]


class Choice(NamedTuple):
    """What comes of a parameter that trades margin for accuracy, at each of its values."""

    values: tuple[float, ...]
    """The values."""
    dead_times: tuple[float, ...]
    """Dead time that may be added [s]; NaN where the loop is unstable without."""
    offsets: tuple[float, ...]
    """Offset in the bend, to the inside [m]."""


def preview_offset(
    params: PreviewPopParams, vehicle: Vehicle, radius: float, speed: float, dt: float = 0.05
) -> float:
    """Offset that preview POP keeps in a steady bend.

    Parameters
    ----------
    params : PreviewPopParams
        Parameters of the law.
    vehicle : Vehicle
        The vehicle.
    radius : float
        Radius R of the bend [m]; it should be wide against the wheelbase.
    speed : float
        Speed v [m/s], positive.
    dt : float, default 0.05
        Control period [s].

    Returns
    -------
    float
        How far inside the bend its reference point runs [m]; negative outside. 0 where it learns
        how the vehicle turns.

    Raises
    ------
    ConfigError
        A number is out of its range.

    Examples
    --------
    >>> from popsteer import PreviewPopParams
    >>> from popsteer.study import Vehicle
    >>> preview_offset(PreviewPopParams(wheelbase=3.0), Vehicle(wheelbase=3.0), 50.0, 15.0)
    0.0
    >>> 0.0 < preview_offset(PreviewPopParams(wheelbase=3.3), Vehicle(), 50.0, 15.0) < 0.1
    True
    """
    check_in_range("radius", radius, 1e-3, 1e6)
    check_in_range("speed", speed, 1e-3, 1e3)
    check_in_range("dt", dt, 1e-3, 1.0)
    if params.turn_learning_time > 0.0 and speed >= params.min_speed:
        return 0.0
    gains = preview_gains(params, speed, dt)
    turns = vehicle.wheelbase + vehicle.understeer * speed * speed
    modelled = params.wheelbase + params.understeer * speed * speed
    return (gains.driven + gains.told) / gains.error * (1.0 - turns / modelled) / radius


def choice(
    params: PopParams | PreviewPopParams,
    vehicle: Vehicle,
    values: Sequence[float],
    *,
    radius: float = 50.0,
    speed: float = 15.0,
    dt: float = 0.05,
) -> Choice:
    """Turn the parameter of a law that trades margin for accuracy.

    Parameters
    ----------
    params : PopParams or PreviewPopParams
        Parameters of the law, with its reference point.
    vehicle : Vehicle
        The vehicle.
    values : sequence of float
        Of POP lookahead distances [m], of preview POP values of `steer_rate_cost` [m s/rad].
    radius : float, default 50.0
        Radius of the bend [m].
    speed : float, default 15.0
        Speed [m/s].
    dt : float, default 0.05
        Control period [s].

    Returns
    -------
    Choice
        The margins and offsets.

    Raises
    ------
    ConfigError
        A number is out of its range.

    Examples
    --------
    >>> from popsteer.study import Vehicle
    >>> found = choice(PopParams(reference_offset=3.0), Vehicle(), (2.0, 9.0))
    >>> found.dead_times[0] < found.dead_times[1], found.offsets[0] < found.offsets[1]
    (True, True)
    """
    dead_times, offsets = [], []
    for value in values:
        if isinstance(params, PopParams):
            rope = params.replace(lookahead_gain=0.0, min_lookahead=value)
            found = margins(rope, vehicle, speed, dt)
            offset = carrot_offset(value, radius, vehicle, speed)
        else:
            costs = params.replace(steer_rate_cost=value)
            found = margins(costs, vehicle, speed, dt)
            offset = preview_offset(costs, vehicle, radius, speed, dt)
        dead_times.append(found.dead_time)
        offsets.append(offset)
    return Choice(tuple(values), tuple(dead_times), tuple(offsets))
