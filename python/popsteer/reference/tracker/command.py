"""The command of one step, with its errors and status."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.status import Status

__all__ = ["Command"]


@dataclass(frozen=True)
class Command:
    """The command of one step, with its errors and status.

    Attributes
    ----------
    steer : float
        Angle to command [rad], positive to the left.
    cross_track_error : float
        Offset of the tracked point of the measured vehicle from the path [m], positive left of it.
    heading_error : float
        Yaw of the measured vehicle less direction of the path [rad], in [-π, π].
    predicted_cross_track_error : float
        Cross-track error of the vehicle as it will be when the command reaches the wheels [m];
        that of the measured one without a dead time.
    predicted_heading_error : float
        Heading error of that vehicle [rad].
    target : tuple of float
        The point aimed at: the lookahead point, or the projection onto the path, (x, y) [m].
    reverse : bool
        Whether the path is driven backwards here.
    reference_speed : float or None
        The path's speed beside the rear axle [m/s], negative where it is driven backwards; None
        where the path has no speeds.
    distance_to_stop : float
        Distance that the rear axle has to go along the path to the next cusp, or to the end [m];
        negative past the end, inf on a closed path without cusps.
    status : Status
        How the step went.

    Examples
    --------
    >>> from popsteer.reference import Path, Stanley
    >>> command = Stanley(Path([(0.0, 0.0), (9.0, 0.0)])).step(1.0, 0.5, 0.0, 5.0, 0.05)
    >>> command.cross_track_error, command.heading_error, command.target, str(command.status)
    (0.5, 0.0, (4.0, 0.0), 'ok')
    """

    steer: float
    cross_track_error: float
    heading_error: float
    predicted_cross_track_error: float
    predicted_heading_error: float
    target: Point
    reverse: bool
    reference_speed: float | None
    distance_to_stop: float
    status: Status
