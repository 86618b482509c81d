"""A car's loop, as good as in 0.1.0 or better: rates, quantised commands, backlash, noise, jumps."""

from __future__ import annotations

import pytest

from tests.closed_loop.cars_loop import (
    CONTROLLERS,
    JUMP,
    ROWS,
    Loop,
    drive,
    lines,
    overshoot,
    recorded,
    staircase,
)
from tests.closed_loop.page import table

each_controller = pytest.mark.parametrize("name", CONTROLLERS)
