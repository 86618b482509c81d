"""Imported first by each file of tests: skips it where there is no rclpy, else makes all ready."""

from __future__ import annotations

import pytest

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')

from tests.adapters.ros import interfaces

if WHY := interfaces.prepare():
    pytest.skip(WHY, allow_module_level=True)
