"""Tracks a point of the vehicle along the path: forwards, backwards, and through cusps.

A vehicle that drives backwards equals one that drives forward with its heading turned by 180°, its
axles mirrored about the rear axle and its steering angle negated; for the kinematic bicycle
exactly. Controllers are therefore written for driving forward only. Where the path is driven
backwards, `Follow.locate` gives them the mirrored vehicle, and `Located.mirror` converts their
angle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.geometry import get_distance
from popsteer.reference.math import PI, cos, sin, sqrt
from popsteer.reference.path.locate import locate
from popsteer.reference.path.relocalise import first_as_good, relocalise

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.projection import ClosestPoint
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.state import VehicleState

_AS_GOOD = 0.075
"""How much farther a place may be, and still be as good as the nearest, in opposite distances."""


@dataclass(frozen=True)
class Located:
    """The tracked point on the path, and the vehicle as one that drives forward."""

    position: Point  # the tracked point [m]
    closest: ClosestPoint  # of the path, to it
    vehicle: VehicleState  # mirrored where the path is driven backwards
    heading: Point  # unit vector along the mirrored vehicle's heading
    dt: float  # control period [s]
    reverse: bool  # whether the path is driven backwards here
    past_end: bool  # whether the point is past the last waypoint of an open path
    direction_changed: bool = False  # whether `reverse` differs from that of the last step
    off_path: bool = False  # whether the vehicle was lost in this step

    def mirror(self, steer: float) -> float:
        """Convert an angle or a curvature of the mirrored vehicle to the real one, and back.

        The sign changes where the path is driven backwards.
        """
        return -steer if self.reverse else steer


@dataclass(frozen=True)
class Follow:
    """Which point of the vehicle is tracked, and how it is searched for on the path."""

    base: float  # rear axle or no-slip point, about which it is mirrored, ahead of the pose's [m]
    reference_offset: float  # tracked point, ahead of `base` in the direction of driving [m]
    rear_axle: float  # ahead of the pose's point in the vehicle's frame [m]
    # Arc to search on each side of the last projection, besides the distance travelled [m].
    search_distance: float
    lost_distance: float  # from the path, beyond which it is searched for on the whole path [m]
    arrival_distance: float  # to a cusp, at which the rear axle counts as arrived [m]
    opposite_distance: float  # cost of a path that leads opposite to the heading [m]

    @classmethod
    def of(cls, vehicle: Vehicle, base: float, ahead: float) -> Follow:
        """Track the point `ahead` [m] of `base`, which lies so far [m] ahead of the pose's point.

        The search covers two wheelbases of path on each side, and the vehicle is never lost.
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
        self,
        path: PathView,
        waypoint: int | None,
        vehicle: VehicleState,
        dt: float,
        travelled: float,
    ) -> Located:
        """Project the tracked point of a checked vehicle near segment `waypoint`.

        From there it can have `travelled` so far [m] in the period `dt` [s]. On the whole path if
        that is None, or if the vehicle is lost.
        """
        if waypoint is None:
            start = self._first_segment(path, vehicle)
        else:
            start = path.segment_at(waypoint)
        at = self._locate_from(path, start, vehicle, dt, travelled)
        following = None if path.reverse is None else self._next_section(path, at, vehicle)
        if following is not None:
            at = self._locate_from(path, following, vehicle, dt, travelled)
        squared_lost = self.lost_distance * self.lost_distance
        if at.closest.squared_distance > squared_lost:
            found = self._find_anew(path, vehicle)
            anew = self._locate_from(path, found, vehicle, dt, travelled)
            if anew.closest.squared_distance < at.closest.squared_distance:
                at = anew
            at = replace(at, off_path=True)
        changed = waypoint is not None and at.reverse != path.is_reverse(start)
        return replace(at, direction_changed=changed)

    def offset(
        self, path: PathView, at: Located, vehicle: VehicleState, travelled: float
    ) -> Located:
        """Project the same vehicle elsewhere, as an offset from where it is, on the same leg."""
        along = at.closest.along
        moved = (vehicle.x - at.vehicle.x) * along[0] + (vehicle.y - at.vehicle.y) * along[1]
        length = sqrt(along[0] * along[0] + along[1] * along[1])
        arc = at.closest.arc_length(path) + moved / length
        segment = _on_leg(path, at.closest.segment, arc)
        found = self._locate_from(path, segment, vehicle, at.dt, travelled)
        return replace(found, direction_changed=at.direction_changed, off_path=at.off_path)

    def _first_segment(self, path: PathView, vehicle: VehicleState) -> int:
        """Find the segment of a vehicle that was on no path before.

        Where an open path passes it more than once, the first of the places that are as good within
        noise.
        """
        found = self._find_anew(path, vehicle)
        if path.closed:
            return found
        base, noise = vehicle.ahead(self.base), _AS_GOOD * self.opposite_distance
        if self._is_before_lap(path, found, (base.x, base.y), vehicle.yaw):
            return 0
        return first_as_good(path, (base.x, base.y), vehicle.yaw, self.opposite_distance, noise)

    def _is_before_lap(self, path: PathView, found: int, position: Point, yaw: float) -> bool:
        """Tell whether a vehicle beside the end of an open lap stands before its start."""
        reach = self.search_distance
        first, following = path.segment(0)
        last = path.waypoint(len(path) - 1)
        along = (following[0] - first[0], following[1] - first[1])
        forward = along[0] * cos(yaw) + along[1] * sin(yaw) > 0.0
        is_lap = path.length > 4.0 * reach and get_distance(first, last) <= 0.5 * reach
        is_near = get_distance(first, position) <= reach
        at_end = path.s[found] >= path.length - 2.0 * reach
        return is_lap and at_end and is_near and forward and not path.is_reverse(0)

    def _locate_from(
        self, path: PathView, segment: int, vehicle: VehicleState, dt: float, travelled: float
    ) -> Located:
        """Find the point near a segment, in the direction in which that is driven."""
        reverse = path.is_reverse(segment)
        if reverse:
            vehicle = replace(vehicle, yaw=vehicle.yaw + PI, speed=-vehicle.speed)
        heading = (cos(vehicle.yaw), sin(vehicle.yaw))
        base = -self.base if reverse else self.base
        ahead = self.reference_offset + base
        position = (vehicle.x + ahead * heading[0], vehicle.y + ahead * heading[1])
        reach = self.search_distance + travelled
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
        """Return the first segment behind a cusp, once the rear axle has arrived at the cusp.

        The rear axle decides for every tracked point and every point of the pose, so that all
        change direction in one step. The projection only tells which cusp is next.
        """
        closest = at.closest
        # Distance of the tracked point behind the rear axle, in the direction of driving.
        behind = at.mirror(self.rear_axle - self.base) - self.reference_offset
        _, last = path.section(closest.segment)
        seam = path.length if last < closest.segment else 0.0
        rest = path.segment_end(last) + seam - closest.arc_length(path)
        after = path.next_segment(last)
        if after is None or rest > max(behind, 0.0) + 4.0 * self.arrival_distance:
            return None
        start, end = path.segment(last)
        along = (end[0] - start[0], end[1] - start[1])
        rear_axle = vehicle.point_ahead(self.rear_axle)
        to = (end[0] - rear_axle[0], end[1] - rear_axle[1])
        length = sqrt(along[0] * along[0] + along[1] * along[1])
        remaining = (to[0] * along[0] + to[1] * along[1]) / length
        return after if remaining <= self.arrival_distance else None

    def _find_anew(self, path: PathView, vehicle: VehicleState) -> int:
        """Search the whole path for the vehicle's `base`."""
        base = vehicle.ahead(self.base)
        return relocalise(path, (base.x, base.y), vehicle.yaw, self.opposite_distance)


def _on_leg(path: PathView, start: int, arc: float) -> int:
    """Return the segment at `arc` [m] of the leg that segment `start` is on."""
    beyond = path.closed and not 0.0 <= arc < path.length
    around = path.length if arc < 0.0 else -path.length
    segment = path.segment_by_arc(arc + around if beyond else arc)
    if path.reverse is None or (path.closed and all(path.reverse)):
        return segment
    if path.section(start) == path.section(segment):
        return segment
    first, last = path.section(start)
    return last if arc > path.s[start] else first
