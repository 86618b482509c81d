"""A point of the vehicle, followed along the path: forwards, backwards, and where it turns round.

A vehicle that backs up is, for a kinematic bicycle exactly, one that drives forward with its
heading turned by half a circle, its axles mirrored about the rear axle and its steering negated. So
the controllers are written for driving forward only: `Follow.locate` hands them the mirrored
vehicle where the path is driven backwards, and they negate what they answer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import PI, cos, sin, sqrt
from popsteer.reference.path.index import STEP_BUDGET
from popsteer.reference.path.locate import locate
from popsteer.reference.path.relocalise import relocalise_within

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.index import Found
    from popsteer.reference.path.projection import ClosestPoint
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Follow", "Located"]


@dataclass(frozen=True)
class Located:
    """Where the followed point is, with the vehicle as one that drives forward.

    Attributes
    ----------
    position : tuple of float
        The followed point [m].
    closest : ClosestPoint
        Its closest point on the path.
    vehicle : VehicleState
        The vehicle, mirrored where the path is driven backwards, so that it drives forward.
    heading : tuple of float
        The unit vector along the mirrored vehicle's heading.
    dt : float
        Control period [s].
    reverse : bool
        Whether the path is driven backwards here.
    past_end : bool
        Whether the point is past the last waypoint of an open path.
    direction_changed : bool
        Whether the direction of driving differs from that of the last step.
    off_path : bool
        Whether the vehicle was lost, or is.
    """

    position: Point
    closest: ClosestPoint
    vehicle: VehicleState
    heading: Point
    dt: float
    reverse: bool
    past_end: bool
    direction_changed: bool = False
    off_path: bool = False

    def mirror(self, steer: float) -> float:
        """Convert an angle or a curvature of the mirrored vehicle to the real one, and back.

        The sign changes where the path is driven backwards.
        """
        return -steer if self.reverse else steer


@dataclass(frozen=True)
class Follow:
    """Which point of the vehicle is followed, and how.

    Attributes
    ----------
    base : float
        How far ahead of the pose's point the vehicle is mirrored where it drives backwards [m]:
        the rear axle, or the point that does not slip.
    reference_offset : float
        How far ahead of `base` the followed point lies, in the direction of driving [m].
    rear_axle : float
        How far ahead of the pose's point the rear axle lies, in the vehicle's own frame [m]: 0 for
        a pose of the rear axle, negative for one farther forward, whichever way it drives.
    search_distance : float
        How far along the path from its last place the point is looked for [m], beside what the
        vehicle travels in a step.
    lost_distance : float
        Farther than this from its place on the path the vehicle is lost, and looked for on the
        whole of it [m].
    arrival_distance : float
        The rear axle has come to where the vehicle turns round when it is this near [m].
    opposite_distance : float
        How much farther off the path counts where it leads the opposite way [m].
    """

    base: float
    reference_offset: float
    rear_axle: float
    search_distance: float
    lost_distance: float
    arrival_distance: float
    opposite_distance: float

    @classmethod
    def of(cls, vehicle: Vehicle, base: float, ahead: float) -> Follow:
        """Say how the point of `vehicle` is followed that lies `ahead` [m] of `base`.

        Itself so far ahead of the pose's point [m]. It is looked for two wheelbases along the path
        either way, and never lost.
        """
        wheelbase = vehicle.wheelbase
        return cls(
            base=base,
            reference_offset=ahead,
            rear_axle=vehicle.rear_axle,
            search_distance=2.0 * wheelbase,
            lost_distance=inf,
            arrival_distance=0.05 * wheelbase,
            # 10 m at the paper's wheelbase, to the last bit.
            opposite_distance=wheelbase * 10.0 / 3.0,
        )

    def locate(
        self, path: PathView, waypoint: int | None, vehicle: VehicleState, dt: float
    ) -> Located:
        """Find the point of a checked vehicle that was last at `waypoint`.

        On the whole path where that is None. A search of the whole path that runs out of
        `STEP_BUDGET` gives the best place it has found. A first step goes on from there; a vehicle
        that is lost only where it is no longer lost there, else from its last place.
        """
        if waypoint is None:
            start = self._find_anew(path, vehicle).segment
        else:
            start = path.segment_at(waypoint)
        at = self._locate_from(path, start, vehicle, dt)
        following = self._next_section(path, at, vehicle)
        if following is not None:
            at = self._locate_from(path, following, vehicle, dt)
        squared_lost = self.lost_distance * self.lost_distance
        if at.closest.squared_distance > squared_lost:
            found = self._find_anew(path, vehicle)
            anew = self._locate_from(path, found.segment, vehicle, dt)
            is_found = found.is_exact or anew.closest.squared_distance <= squared_lost
            if is_found and anew.closest.squared_distance < at.closest.squared_distance:
                at = anew
            at = replace(at, off_path=True)
        changed = waypoint is not None and at.reverse != path.is_reverse(start)
        return replace(at, direction_changed=changed)

    def _locate_from(
        self, path: PathView, segment: int, vehicle: VehicleState, dt: float
    ) -> Located:
        """Find the point near a segment, in the direction in which that is driven."""
        reverse = path.is_reverse(segment)
        if reverse:
            vehicle = replace(vehicle, yaw=vehicle.yaw + PI, speed=-vehicle.speed)
        heading = (cos(vehicle.yaw), sin(vehicle.yaw))
        base = -self.base if reverse else self.base
        ahead = self.reference_offset + base
        position = (vehicle.x + ahead * heading[0], vehicle.y + ahead * heading[1])
        reach = self.search_distance + abs(vehicle.speed) * dt
        closest = locate(path, segment, position, heading, reach, self.opposite_distance)
        return Located(
            position=position,
            closest=closest,
            vehicle=vehicle,
            heading=heading,
            dt=dt,
            reverse=reverse,
            past_end=closest.fraction > 1.0 and path.next_segment(closest.segment) is None,
        )

    def _next_section(self, path: PathView, at: Located, vehicle: VehicleState) -> int | None:
        """Return the segment to go on with where the vehicle turns round, once it is there.

        That is one event for all that follow the vehicle, wherever their own point and that of
        the pose are: the closest point of each only has to be near enough to tell which end is
        meant.
        """
        closest = at.closest
        # How far the followed point lies behind the rear axle, in the direction of driving.
        behind = at.mirror(self.rear_axle - self.base) - self.reference_offset
        near = (behind if behind > 0.0 else 0.0) + 4.0 * self.arrival_distance
        last = closest.segment
        rest = (1.0 - closest.fraction) * path.segment_length(last)
        for _ in range(path.segments):
            following = path.following(last)
            if following is None:
                return self._segment_after_cusp(path, last, vehicle)
            rest += path.segment_length(following)
            if rest > near:
                break
            last = following
        return None

    def _segment_after_cusp(self, path: PathView, last: int, vehicle: VehicleState) -> int | None:
        """Return the segment after `last`, where the vehicle turns round, once it is there."""
        after = path.next_segment(last)
        if after is None:
            return None
        start, end = path.segment(last)
        along = (end[0] - start[0], end[1] - start[1])
        rear_axle = vehicle.point_ahead(self.rear_axle)
        to = (end[0] - rear_axle[0], end[1] - rear_axle[1])
        length = sqrt(along[0] * along[0] + along[1] * along[1])
        remaining = (to[0] * along[0] + to[1] * along[1]) / length
        return after if remaining <= self.arrival_distance else None

    def _find_anew(self, path: PathView, vehicle: VehicleState) -> Found:
        """Find the vehicle on the whole path, by the place of its `base`."""
        base = vehicle.ahead(self.base)
        position = (base.x, base.y)
        return relocalise_within(path, position, vehicle.yaw, self.opposite_distance, STEP_BUDGET)
