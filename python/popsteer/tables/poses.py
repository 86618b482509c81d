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
_OF_CAMERA = [1.0, -1.0]  # x is its z, y its -x
_SAID_OF_CAMERA = " of a camera: x is its z, y its -x"
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
        return _matrices(values)
    for size, orders in _ORDERS.items():
        x = count - size - size // 2 - 1  # x, y and z are before four, x and y before two
        turned = values[:, count - size :]
        if x not in (0, 1) or not _is_unit(turned):
            continue
        if x == 1 and not (shown.is_time(values[:, 0]) or shown.is_count(values[:, 0])):
            continue
        xy = values[:, x : x + 2]
        yaws = [yaw_of(dict(zip(order.split(), turned.T, strict=True))) for order in orders]
        note = f"columns {count - size + 1} to {count} are a quaternion"
        if size == 4:
            position = values[:, x : x + 3]
            cameras = (_of_camera(order.split(), turned, position) for order in orders)
            if (camera := next(filter(None, cameras), None)) is not None:
                return camera._replace(note=note + camera.note)
            reach = np.ptp(position, axis=0)
            if reach[2] > 0.5 * max(reach[:2]):
                ways = (",".join(["-"] * x + [*each, *"-" * 4]) for each in ("xy-", "x-y"))
                raise PathError(
                    f"{name}: {note}, whose z moves as much as x and y do:"
                    f" --columns {', or of a camera, whose y points down, --columns '.join(ways)}"
                )
        ahead = [yaw for yaw in yaws if _is_ahead(xy, yaw)]
        if ahead or size == 4:  # two may be another unit vector
            return Poses(xy, (ahead or yaws)[0], f"x, y (columns {x + 1}, {x + 2})", note)
    return None


def _is_unit(vectors: Floats) -> bool:
    """Whether rows are unit vectors, and not always the same."""
    off = np.abs(np.linalg.norm(vectors, axis=1) - 1.0)
    return bool(off.max() < _UNIT) and bool(np.ptp(vectors, axis=0).max() > 0.0)


def _of_camera(order: list[str], turned: Floats, position: Floats) -> Poses | None:
    """Read poses of a camera, whose y points down and whose z points where it moves."""
    x, y, z, w = (turned[:, order.index(f"q{axis}")] for axis in "xyzw")
    upright = 1.0 - 2.0 * (x * x + z * z)
    xy = position[:, [2, 0]] * _OF_CAMERA
    yaw = np.arctan2(-2.0 * (x * z + w * y), 1.0 - 2.0 * (x * x + y * y))
    flat = np.ptp(position[:, 1]) < np.ptp(position[:, 2])
    if not flat or np.quantile(upright, 0.01) < _UPRIGHT or not _is_ahead(xy, yaw):
        return None
    return Poses(xy, yaw, "x, y", _SAID_OF_CAMERA)


def _matrices(values: Floats) -> Poses | None:
    parts = values[:, -12:].reshape(-1, 3, 4)
    turned, position = parts[:, :, :3], parts[:, :, 3]
    off = np.abs(turned @ np.swapaxes(turned, 1, 2) - np.eye(3))
    if off.max() > 10.0 * _UNIT or np.ptp(turned) == 0.0:
        return None
    # A camera's y points down and its z ahead, a vehicle's z up and its x ahead.
    camera = np.ptp(position[:, 1]) < np.ptp(position[:, 2])
    if np.quantile(turned[:, 1, 1] if camera else turned[:, 2, 2], 0.01) < _UPRIGHT:
        return None
    axes, signs = ([2, 0], _OF_CAMERA) if camera else ([0, 1], [1.0, 1.0])
    xy, ahead = (each[:, axes] * signs for each in (position, turned[:, :, axes[0]]))
    yaw = np.arctan2(ahead[:, 1], ahead[:, 0])
    if not _is_ahead(xy, yaw):
        return None
    said = _SAID_OF_CAMERA if camera else ""
    return Poses(xy, yaw, "x, y", f"the last 12 columns are a pose's matrix of 3 x 4{said}")


def _is_ahead(xy: Floats, yaw: Floats) -> bool:
    """Whether a yaw is the direction of motion, mostly ahead."""
    found = shown.heading(shown.ways(xy), yaw, ("rad",), both_ways=True)
    return found is not None and not found.frame and float(found.backwards.mean()) < 0.5
