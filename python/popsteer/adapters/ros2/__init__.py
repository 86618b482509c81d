"""ROS 2 without a ROS installation: a node that steers, recordings, and what converts.

``popsteer ros2`` runs the node from the command line, ``popsteer record`` records its topics; see
docs/ros2.md. It needs the extra ``ros2``.

Units and signs are those of popsteer. Headings, times and the acceleration of an ``AckermannDrive``
are converted in `popsteer.adapters.ros2.conversions`.

Examples
--------
>>> from popsteer.adapters.ros2 import measured_of, odometry_message
>>> measured_of(odometry_message(1.0, 2.0, 0.5, 3.0, 0, "map")).yaw
0.5
"""

from popsteer.adapters.ros2.conversions import (
    Measured,
    MessageError,
    ackermann_message,
    control_message,
    measured_of,
    odometry_message,
    path_message,
    yaw_of,
)
from popsteer.adapters.ros2.dds import Participant, Reader, Writer
from popsteer.adapters.ros2.intake import Intake
from popsteer.adapters.ros2.messages import decode, encode, make
from popsteer.adapters.ros2.node import Node, Options
from popsteer.adapters.ros2.pacing import spin
from popsteer.adapters.ros2.paths import path_of
from popsteer.adapters.ros2.recording import Recording, record_run
from popsteer.adapters.ros2.topics import Topics

__all__ = [
    "Intake",
    "Measured",
    "MessageError",
    "Node",
    "Options",
    "Participant",
    "Reader",
    "Recording",
    "Topics",
    "Writer",
    "ackermann_message",
    "control_message",
    "decode",
    "encode",
    "make",
    "measured_of",
    "odometry_message",
    "path_message",
    "path_of",
    "record_run",
    "spin",
    "yaw_of",
]
