"""The message types of the node: their definitions, and their bytes as ROS 2 has them (CDR)."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from popsteer import logs
from popsteer.extras import require

ODOMETRY = "nav_msgs/msg/Odometry"
"""Pose and speed of the vehicle."""
PATH = "nav_msgs/msg/Path"
"""A path without speeds."""
TRAJECTORY = "autoware_planning_msgs/msg/Trajectory"
"""A path with speeds."""
ACKERMANN = "ackermann_msgs/msg/AckermannDriveStamped"
"""Angle and speed to drive with."""
CONTROL = "autoware_control_msgs/msg/Control"
"""Angle, speed and acceleration to drive with."""
TWIST = "geometry_msgs/msg/Twist"
"""Speed and yaw rate to drive with."""
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
"""The same with a stamp."""
CONTROL_MODE = "autoware_vehicle_msgs/msg/ControlModeReport"
"""Whether the vehicle obeys (1) or a person drives."""
OPERATION_MODE = "autoware_adapi_v1_msgs/msg/OperationModeState"
"""Whether Autoware drives (mode 2, control enabled), or who else."""
STEERING_REPORT = "autoware_vehicle_msgs/msg/SteeringReport"
"""The angle of the wheels, as it is measured."""
SPEED_LIMIT = "nav2_msgs/msg/SpeedLimit"
"""How fast it may be driven: in m/s, or in percent of what is driven at most; 0: no limit."""
EMPTY = "std_msgs/msg/Empty"
"""A message that says nothing but that it came."""
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
"""Diagnostics."""
CLOCK = "rosgraph_msgs/msg/Clock"
"""The time of a simulation."""
TYPES = (
    *(ODOMETRY, PATH, TRAJECTORY, ACKERMANN, CONTROL, CONTROL_MODE, OPERATION_MODE),
    *(SPEED_LIMIT, STEERING_REPORT, EMPTY, DIAGNOSTICS, CLOCK),
)
"""Every type that the node receives or sends."""

# Those that neither rosbags nor `popsteer.logs` brings.
DEFINITIONS = {
    "autoware_planning_msgs/msg/TrajectoryPoint": """\
builtin_interfaces/Duration time_from_start
geometry_msgs/Pose pose
float32 longitudinal_velocity_mps
float32 lateral_velocity_mps
float32 acceleration_mps2
float32 heading_rate_rps
float32 front_wheel_angle_rad
float32 rear_wheel_angle_rad
""",
    CONTROL_MODE: "builtin_interfaces/Time stamp\nuint8 mode\n",
    OPERATION_MODE: """\
uint8 UNKNOWN=0
uint8 STOP=1
uint8 AUTONOMOUS=2
uint8 LOCAL=3
uint8 REMOTE=4
builtin_interfaces/Time stamp
uint8 mode
bool is_autoware_control_enabled
bool is_in_transition
bool is_stop_mode_available
bool is_autonomous_mode_available
bool is_local_mode_available
bool is_remote_mode_available
""",
    SPEED_LIMIT: "std_msgs/Header header\nbool percentage\nfloat64 speed_limit\n",
    TRAJECTORY: "std_msgs/Header header\nautoware_planning_msgs/TrajectoryPoint[] points\n",
}


_SERVICE = {
    "std_srvs/srv/Trigger_Request": "uint8 structure_needs_at_least_one_member\n",
    "std_srvs/srv/Trigger_Response": "bool success\nstring message\n",
}


@lru_cache(maxsize=1)
def store() -> Any:  # noqa: ANN401 - rosbags is an extra
    """Give the types of ROS 2 and those of steering; needs the extra ``ros2``."""
    require("ROS 2", "ros2", "rosbags")
    from rosbags.typesys import get_types_from_msg

    found = logs.messages.typestore()
    for name, text in DEFINITIONS.items():
        found.register(get_types_from_msg(text, name))
    for name, text in _SERVICE.items():
        (definition,) = get_types_from_msg(text, "std_srvs/msg/Trigger").values()
        found.register({name: definition})
    return found


@lru_cache
def hash_of(name: str) -> str:
    """Give the hash of a type by which ROS 2 compares definitions, from Iron on."""
    return str(store().hash_rihs01(name))


def make(name: str, /, **fields: Any) -> Any:  # noqa: ANN401
    """Make a message; fields that are left out are zero, empty or made so.

    Parameters
    ----------
    name : str
        Its type, such as ``nav_msgs/msg/Path``.
    **fields : object
        Its fields; a ``dict`` of fields makes one that is a message itself.

    Returns
    -------
    object
        A message of rosbags' class.

    Raises
    ------
    PopsteerError
        The extra ``ros2`` is not installed.

    Examples
    --------
    >>> make("geometry_msgs/msg/Point", x=2.0).x
    2.0
    """
    types = store()
    values = {}
    for field, (kind, detail) in types.get_msgdef(name).fields:
        given = fields[field] if field in fields else _zero(kind, detail)
        values[field] = make(detail, **given) if isinstance(given, dict) else given
    return types.types[name](**values)


def encode(message: Any) -> bytes:  # noqa: ANN401
    """Give the bytes of a message.

    Parameters
    ----------
    message : object
        The message.

    Returns
    -------
    bytes
        Little-endian CDR, with its header.

    Examples
    --------
    >>> encode(make("builtin_interfaces/msg/Time", sec=1)).hex(" ", 4)
    '00010000 01000000 00000000'
    """
    return bytes(store().serialize_cdr(message, message.__msgtype__))


def decode(name: str, data: bytes) -> Any:  # noqa: ANN401
    """Give the message that bytes are.

    Parameters
    ----------
    name : str
        Its type.
    data : bytes
        CDR, with its header.

    Returns
    -------
    object
        A message of rosbags' class.

    Raises
    ------
    Exception
        The bytes are no such message: whatever rosbags stumbles over.

    Examples
    --------
    >>> decode("builtin_interfaces/msg/Time", bytes.fromhex("000100000100000002000000")).nanosec
    2
    """
    return store().deserialize_cdr(data, name)


def _zero(kind: Any, detail: Any) -> Any:  # noqa: ANN401
    """Give what an empty message has in a field."""
    import numpy as np

    if kind.name == "NAME":
        return make(detail)
    if kind.name == "BASE":
        empty = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}
        return empty.get(detail[0], 0)
    (inner, of), count = detail
    if inner.name != "BASE" or of[0] == "string":
        return [_zero(inner, of) for _ in range(count)] if kind.name == "ARRAY" else []
    name = {"byte": "uint8", "char": "uint8"}.get(of[0], of[0])
    return np.zeros(count if kind.name == "ARRAY" else 0, dtype=name)
