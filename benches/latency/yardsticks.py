"""The yardsticks from outside: what others' tools take for the same step.

POP's step compiled by numba, and linear model-predictive controllers on osqp and on daqp, in
``benches/yardsticks``. They need numba, daqp, osqp and scipy; what is not at hand is left out, with
its reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from benches.latency.calls import (
    DAQP_SOLVE,
    DAQP_STEP,
    DAQP_UPDATE,
    MPC_SOLVE,
    MPC_STEP,
    MPC_UPDATE,
    NUMBA_STEP,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from benches.latency.timing import Drive, Driver

_NO_EXTRA = "not installed: pip install numba daqp osqp scipy"


class _Yardstick(NamedTuple):
    """A function of a module, what it needs, the rows it gives, and how many calls are enough."""

    module: str
    prepare: str
    needs: tuple[str, ...]
    rows: tuple[str, ...]
    calls: int


_YARDSTICKS = (
    _Yardstick("numba_pop", "prepare", ("numba",), (NUMBA_STEP,), 200_000),
    _Yardstick("osqp_mpc", "prepare", ("osqp", "scipy"), (MPC_STEP, MPC_UPDATE, MPC_SOLVE), 10_000),
    _Yardstick("mpc", "daqp", ("daqp", "scipy"), (DAQP_STEP, DAQP_UPDATE, DAQP_SOLVE), 10_000),
)

ROWS = tuple(row for yardstick in _YARDSTICKS for row in yardstick.rows)
"""Names in the report, whether at hand or not."""


@dataclass(frozen=True)
class Yardsticks:
    """Makers of drivers, calls that are enough, and why other yardsticks are `absent`, by name."""

    makers: Mapping[str, Callable[[], Driver]] = field(default_factory=dict)
    calls: Mapping[str, int] = field(default_factory=dict)
    absent: Mapping[str, str] = field(default_factory=lambda: dict.fromkeys(ROWS, "not asked for"))


def at_hand(drive: Drive) -> Yardsticks:
    """Prepare the yardsticks for a drive, and say which are absent."""
    makers: dict[str, Callable[[], Driver]] = {}
    calls: dict[str, int] = {}
    absent: dict[str, str] = {}
    for yardstick in _YARDSTICKS:
        if any(find_spec(module) is None for module in yardstick.needs):
            absent |= dict.fromkeys(yardstick.rows, _NO_EXTRA)
        else:
            # It is run once, as numba compiles it.
            module = import_module(f"benches.yardsticks.{yardstick.module}")
            makers[yardstick.rows[0]] = getattr(module, yardstick.prepare)(drive)
            calls[yardstick.rows[0]] = yardstick.calls
    return Yardsticks(makers, calls, absent)
