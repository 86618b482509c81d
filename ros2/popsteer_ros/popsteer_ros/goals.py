"""Goals of FollowPath with the poses of their path as an array: no Python object for each pose.

rclpy makes objects of a request by a function of its class, `_CONVERT_TO_PY`. Here a function takes
its place that copies the poses' numbers, and lets rclpy's make the rest. With 10,000 poses, a goal
costs 1 ms in place of 160, in which nothing would be commanded.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message

from popsteer.adapters.ros2.paths import numbers_of

_POSES = 48  # bytes of a goal's id (16), and the header of its path (8, and 24 of the frame's name)
_POSE = 11  # numbers of 8 bytes in a pose with its header, the last seven of which are the pose's


class _Sequence(ctypes.Structure):
    """A sequence of messages, as ROS's C structures have it."""

    _fields_ = (
        ("data", ctypes.c_void_p),
        ("size", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
    )


def poses_of(path: Any) -> np.ndarray[Any, Any]:
    """Give the poses of a path, shape (N, 7): place and orientation."""
    if isinstance(path.poses, np.ndarray):
        return path.poses
    return numbers_of(path.poses)


def light(action: Any) -> Any:
    """Give the same action with such requests; itself where this ROS has its requests otherwise."""
    request = _request(action.Impl.SendGoalService.Request)
    found = type("Light", (action,), {})
    service = type("SendGoalService", (), {"Request": request})
    service.Response = action.Impl.SendGoalService.Response
    found.Impl = type("Impl", (action.Impl,), {"SendGoalService": service})
    return found if _is_right(action, request) else action


def _request(plain: Any) -> Any:
    plain.__class__.__import_type_support__()
    capsule = ctypes.pythonapi.PyCapsule_GetPointer
    capsule.restype, capsule.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
    made = ctypes.pythonapi.PyCapsule_New
    made.restype = ctypes.py_object
    made.argtypes = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p
    convert = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p)
    rest = convert(capsule(plain.__class__._CONVERT_TO_PY, None))  # noqa: SLF001 - rclpy's own

    @convert
    def light_request(address: int) -> Any:
        poses = _Sequence.from_address(address + _POSES)
        count = poses.size
        numbers = np.empty((count, _POSE))
        if count:
            ctypes.memmove(numbers.ctypes.data, poses.data, numbers.nbytes)
        poses.size = 0
        try:
            found = rest(address)
        finally:
            poses.size = count
        found.goal.path._poses = numbers[:, -7:]  # noqa: SLF001 - its setter takes messages
        return found

    made_of = {"_CONVERT_TO_PY": made(light_request, None, None), "kept": light_request}
    kind = type("Light", (plain.__class__,), made_of)
    return kind(plain.__name__, (plain,), {"__slots__": ()})


def _is_right(action: Any, request: Any) -> bool:
    """Say whether requests are laid out as is thought here, by one that is known."""
    fields = [
        next(iter(each.get_fields_and_field_types().values()))
        for each in (action.Impl.SendGoalService.Request, action.Goal)
    ]
    if fields != ["unique_identifier_msgs/UUID", "nav_msgs/Path"] or ctypes.sizeof(_Sequence) != 24:
        return False
    if [*PoseStamped.get_fields_and_field_types()] != ["header", "pose"]:
        return False
    plain = action.Impl.SendGoalService.Request()
    plain.goal.path = Path(poses=[PoseStamped(), PoseStamped()])
    plain.goal.controller_id = plain.goal.path.header.frame_id = "known"
    for k, each in enumerate(plain.goal.path.poses):
        each.header.frame_id = k * "name"
        each.pose.position.x, each.pose.orientation.z = 3.0 + k, 0.5 * k
    found = deserialize_message(serialize_message(plain), request).goal
    same = np.array_equal(poses_of(found.path), poses_of(plain.goal.path))
    return same and (found.controller_id, found.path.header.frame_id) == ("known", "known")
