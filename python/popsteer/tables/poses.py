"""Poses without names, known by their orientation: quaternions, and KITTI's matrices of 3 x 4.

A unit quaternion and a rotation matrix prove what they are, and with that which columns are the
position before them: TUM's trajectories are ``t x y z qx qy qz qw``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.errors import PathError
from popsteer.tables import shown

if TYPE_CHECKING:
    from collections.abc import Mapping

    from popsteer.tables.shown import Floats

_UNIT = 2e-3  # how far rounding leaves a length from 1
_UPRIGHT = 0.8  # cosine of the steepest tilt of a vehicle
# Of a camera and of a vehicle: which axes are x and y, their signs, and which is upright.
_FRAMES: tuple[tuple[list[int], list[float], int, str], ...] = (
    ([2, 0], [1.0, -1.0], 1, " of a camera: x is its z, y its -x"),
    ([0, 1], [1.0, 1.0], 2, ""),
)
# ROS and TUM have w last, EuRoC has it first.
_ORDERS = {4: ("qx qy qz qw", "qw qx qy qz"), 2: ("qz qw", "qw qz")}


class Poses(NamedTuple):
    """Positions in the ground's plane, and what the orientation would be as a yaw there."""

    xy: Floats
    yaw: Floats
    read: str
    note: str


def yaw_of(columns: Mapping[str, Floats]) -> Floats:
    """Give the yaw of a quaternion's columns [rad]; x and y are 0 where they are missing."""
    z, w = columns["qz"], columns["qw"]
    x, y = columns.get("qx", 0.0 * z), columns.get("qy", 0.0 * z)
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def poses(name: str, values: Floats) -> Poses | None:
    """Find poses in columns without names; None where nothing proves them.

    Raises PathError where a quaternion does, but not which plane is the ground's.
    """
    count = values.shape[1]
    if len(values) < 5 or count < 4:
        return None
    if count in (12, 13):
        parts = values[:, -12:].reshape(-1, 3, 4)
        note = "the last 12 columns are a pose's matrix of 3 x 4"
        return _grounded(parts[:, :, :3], parts[:, :, 3], "x, y", note)
    for size, orders in _ORDERS.items():
        x = count - size - size // 2 - 1  # x, y and z are before four, x and y before two
        turned = values[:, count - size :]
        if x not in (0, 1) or not _is_unit(turned):
            continue
        if x == 1 and not (shown.is_time(values[:, 0]) or shown.is_count(values[:, 0])):
            continue
        position = np.pad(values[:, x : count - size], ((0, 0), (0, 2 - size // 2)))
        said = f"x, y (columns {x + 1}, {x + 2})", f"columns {count - size + 1} to {count} are"
        each = [dict(zip(order.split(), turned.T, strict=True)) for order in orders]
        found = (_grounded(_matrix(q), position, said[0], f"{said[1]} a quaternion") for q in each)
        if (proved := next(filter(None, found), None)) is not None or size == 2:
            return proved  # two may be another unit vector
        reach = np.ptp(position, axis=0)
        if reach[2] > 0.5 * max(reach[:2]):
            ways = (",".join(["-"] * x + [*plane, *"-" * 4]) for plane in ("xy-", "x-y"))
            raise PathError(
                f"{name}: {said[1]} a quaternion, whose z moves as much as x and y do: --columns"
                f" {', or of a camera, whose y points down, --columns '.join(ways)}"
            )
        return Poses(position[:, :2], yaw_of(each[0]), said[0], f"{said[1]} a quaternion")
    return None


def _is_unit(vectors: Floats) -> bool:
    """Whether rows are unit vectors, and not always the same."""
    off = np.abs(np.linalg.norm(vectors, axis=1) - 1.0)
    return bool(off.max() < _UNIT) and bool(np.ptp(vectors, axis=0).max() > 0.0)


def _matrix(columns: Mapping[str, Floats]) -> Floats:
    """Give the rotation matrices of quaternions, shape (N, 3, 3)."""
    z, w = columns["qz"], columns["qw"]
    x, y = columns.get("qx", 0.0 * z), columns.get("qy", 0.0 * z)
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (w * z + x * y), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.moveaxis(np.array(rows), 2, 0)


def _grounded(turned: Floats, position: Floats, read: str, note: str) -> Poses | None:
    """Find the ground's plane of poses: they are rotations, upright, and look where they move.

    A camera's y points down and its z ahead, a vehicle's z up and its x ahead.
    """
    off = np.abs(turned @ np.swapaxes(turned, 1, 2) - np.eye(3))
    if off.max() > 10.0 * _UNIT or np.ptp(turned) == 0.0:
        return None
    for axes, signs, up, said in _FRAMES[int(np.ptp(position[:, 1]) >= np.ptp(position[:, 2])) :]:
        xy, ahead = (each[:, axes] * signs for each in (position, turned[:, :, axes[0]]))
        yaw = np.arctan2(ahead[:, 1], ahead[:, 0])
        found = shown.heading(shown.ways(xy), yaw, ("rad",), both_ways=True)
        is_ahead = found is not None and not found.frame and found.backwards.mean() < 0.5
        if is_ahead and np.quantile(turned[:, up, up], 0.01) >= _UPRIGHT:
            return Poses(xy, yaw, read, note + said)
    return None
