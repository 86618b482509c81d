"""Imported first: lets the tests run in a ROS installation, or on rclpy's wheels in `make test`.

Of what has no wheel the messages are built of their texts, and tf2_ros has a stand-in.
"""

from __future__ import annotations

import os
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


def _prepare() -> str:
    """Make all importable that the tests need; says why that cannot be."""
    if find_spec("rclpy") is None:
        return 'no rclpy: neither is ROS sourced nor has the group "ros" wheels for this Python'
    if find_spec("cyclonedds") is None or find_spec("rosbags") is None:
        return 'the extra "ros2" is not installed'
    with warnings.catch_warnings():  # of a parser that the messages are loaded by
        warnings.simplefilter("ignore")
        import rosidl_generator_py  # noqa: F401
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if find_spec("nav2_msgs") is not None:
        return ""
    from tests.adapters.ros import interfaces
    from tests.adapters.ros2_domain import domain

    if why := interfaces.missing():
        return why
    interfaces.installed()
    os.environ["ROS_DOMAIN_ID"] = str(domain())
    package, stand_ins = ROOT / "ros2" / "popsteer_ros", ROOT / "tests/adapters/ros/stand_ins"
    sys.path.append(str(stand_ins))
    # For the processes that tests start.
    paths = [str(package), os.environ["PYTHONPATH"], str(stand_ins)]
    os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    return ""


if WHY := _prepare():
    pytest.skip(WHY, allow_module_level=True)
