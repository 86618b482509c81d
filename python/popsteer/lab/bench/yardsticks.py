"""The yardsticks from outside: what others' tools take for the same step.

POP's step compiled by numba, and linear model-predictive controllers on osqp and on daqp. They are
files of the checkout's ``benches/yardsticks``, no part of the package, and need numba, daqp, osqp
and scipy; what is not at hand is left out, with its reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from popsteer import own
from popsteer.errors import PopsteerError
from popsteer.lab.bench.calls import (
    DAQP_SOLVE,
    DAQP_STEP,
    DAQP_UPDATE,
    MPC_SOLVE,
    MPC_STEP,
    MPC_UPDATE,
    NUMBA_STEP,
)

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping

    from popsteer.lab.common.timing import Drive, Driver

# Of the working directory, if that is the checkout.
_FOLDER = Path("benches", "yardsticks")
_NO_EXTRA = "not installed: pip install numba daqp osqp scipy"
_NO_FOLDER = "not at hand: run in a checkout, or name its benches/yardsticks with --yardsticks"


class _Yardstick(NamedTuple):
    """A function of a file, what it needs, the rows it gives, and how many calls are enough."""

    file: str
    prepare: str
    needs: tuple[str, ...]
    rows: tuple[str, ...]
    calls: int


_YARDSTICKS = (
    _Yardstick("numba_pop.py", "prepare", ("numba",), (NUMBA_STEP,), 200_000),
    _Yardstick(
        "osqp_mpc.py", "prepare", ("osqp", "scipy"), (MPC_STEP, MPC_UPDATE, MPC_SOLVE), 10_000
    ),
    _Yardstick("mpc.py", "daqp", ("daqp", "scipy"), (DAQP_STEP, DAQP_UPDATE, DAQP_SOLVE), 10_000),
)

ROWS = tuple(row for yardstick in _YARDSTICKS for row in yardstick.rows)
"""Names in the report, whether at hand or not."""


@dataclass(frozen=True)
class Yardsticks:
    """Makers of drivers, calls that are enough, and why other yardsticks are `absent`, by name."""

    makers: Mapping[str, Callable[[], Driver]] = field(default_factory=dict)
    calls: Mapping[str, int] = field(default_factory=dict)
    absent: Mapping[str, str] = field(default_factory=lambda: dict.fromkeys(ROWS, "not asked for"))


def at_hand(drive: Drive, folder: str | os.PathLike[str] | None = None) -> Yardsticks:
    """Prepare the yardsticks in `folder`, by default ``benches/yardsticks``, and what is absent."""
    makers: dict[str, Callable[[], Driver]] = {}
    calls: dict[str, int] = {}
    absent: dict[str, str] = {}
    for yardstick in _YARDSTICKS:
        file = Path(_FOLDER if folder is None else folder) / yardstick.file
        if not file.is_file():
            if folder is not None:
                raise PopsteerError(f"{file}: there is no such file")
            absent |= dict.fromkeys(yardstick.rows, _NO_FOLDER)
        elif any(find_spec(module) is None for module in yardstick.needs):
            absent |= dict.fromkeys(yardstick.rows, _NO_EXTRA)
        else:
            # The file is run once, as numba compiles it.
            prepare = own.load("controller", f"{file.resolve()}:{yardstick.prepare}")
            makers[yardstick.rows[0]] = prepare(drive)
            calls[yardstick.rows[0]] = yardstick.calls
    return Yardsticks(makers, calls, absent)
