"""rclpy is up for each test, and down after it."""

from __future__ import annotations

import gc
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(autouse=True)
def ros() -> Iterator[None]:
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    # The test runner keeps its own handlers of signals.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    yield
    # The services of a lifecycle node are there as long as it is in memory, and it is in a circle.
    gc.collect()
    rclpy.try_shutdown()
