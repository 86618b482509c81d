"""The calls that the benchmark times, each under its name in the report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from benches.latency.timing import Drive, Driver
from popsteer import reference
from popsteer._core import _EmptyCall

if TYPE_CHECKING:
    from collections.abc import Callable


POP_STEP = "pop_step_ns"
POP_COMMAND = "pop_command_ns"
PAPER_STEP = "pop_paper_step_ns"
PREVIEW_POP_STEP = "preview_pop_step_ns"
REAL_CAR_STEP = "preview_pop_car_step_ns"
ASIDE_STEP = "preview_pop_aside_step_ns"
REFERENCE_STEP = "reference_step_ns"
PAPER_REFERENCE_STEP = "reference_paper_step_ns"
SLOW_STEPS = frozenset({REFERENCE_STEP, PAPER_REFERENCE_STEP})
"""Those in plain Python, which get fewer calls."""
EMPTY_CALL = "empty_call_ns"
NUMBA_STEP = "numba_step_ns"
MPC_STEP = "mpc_step_ns"
MPC_UPDATE = "mpc_update_ns"
MPC_SOLVE = "mpc_solve_ns"
DAQP_STEP = "daqp_step_ns"
DAQP_UPDATE = "daqp_update_ns"
DAQP_SOLVE = "daqp_solve_ns"

PAPER_NS = 3.239e6
"""Mean latency of POP in the paper, on its laptop [ns]."""

LABELS = {
    POP_STEP: "POP, angle",
    POP_COMMAND: "POP, command",
    PAPER_STEP: "POP, paper's",
    PREVIEW_POP_STEP: "preview POP",
    REAL_CAR_STEP: "- of a real car",
    ASIDE_STEP: "- of it, aside",
    "pid_step_ns": "PID",
    "pure_pursuit_step_ns": "pure pursuit",
    "stanley_step_ns": "Stanley",
    EMPTY_CALL: "empty call",
    REFERENCE_STEP: "POP in Python",
    PAPER_REFERENCE_STEP: "paper, Python",
    NUMBA_STEP: "POP in numba",
    MPC_STEP: "MPC on osqp",
    MPC_UPDATE: "- its update",
    MPC_SOLVE: "- its solve",
    DAQP_STEP: "MPC on daqp",
    DAQP_UPDATE: "- its update",
    DAQP_SOLVE: "- its solve",
}
"""What a person reads for each name."""


def lineup(drive: Drive) -> dict[str, Callable[[], Driver]]:
    """Give a maker of drivers for each call that is timed, by its name in the report.

    Each driver made has a state of its own. The drive gives the path, and the vehicle that the
    controllers are given.

    Notes
    -----
    ``pop_step_ns`` and the other controllers are ``steer``, the angle alone; ``pop_command_ns`` is
    ``step``, which measures the errors besides; ``pop_paper_step_ns`` is POP with the paper's
    search. ``preview_pop_car_step_ns`` is that of a car with a dead time and a lag of 0.15 s whose
    wheels turn by 0.4 rad/s at most, ``preview_pop_aside_step_ns`` of the same half a metre from
    its path, where these limits bind. ``empty_call_ns`` is a method with the signature of ``steer``
    that returns at once: what the border between Python and Rust costs by itself.
    """
    path, car = drive.path, drive.vehicle
    paper = popsteer.PopParams(exact_lookahead=False)
    real = car.replace(steer_lag=0.15, dead_time=0.15, max_steer_rate=0.4)
    plain = reference.Path(zip(path.x.tolist(), path.y.tolist(), strict=True), closed=path.closed)
    plain_car = reference.Vehicle(**car.as_dict())
    plain_pop = reference.Pop(plain_car)
    plain_paper = reference.Pop(plain_car, reference.PopParams(exact_lookahead=False))

    def driver(make: Callable[[], Any], method: str = "steer") -> Callable[[], Driver]:
        def made() -> Driver:
            law = make()
            return Driver(getattr(law, method), law.reset)

        return made

    return {
        POP_STEP: driver(lambda: popsteer.Pop(path, car)),
        POP_COMMAND: driver(lambda: popsteer.Pop(path, car), "step"),
        PAPER_STEP: driver(lambda: popsteer.Pop(path, car, paper)),
        PREVIEW_POP_STEP: driver(lambda: popsteer.PreviewPop(path, car)),
        REAL_CAR_STEP: driver(lambda: popsteer.PreviewPop(path, real)),
        ASIDE_STEP: driver(lambda: popsteer.PreviewPop(_aside(path), real)),
        "pid_step_ns": driver(lambda: popsteer.Pid(path, car)),
        "pure_pursuit_step_ns": driver(lambda: popsteer.PurePursuit(path, car)),
        "stanley_step_ns": driver(lambda: popsteer.Stanley(path, car)),
        EMPTY_CALL: driver(_EmptyCall),
        REFERENCE_STEP: driver(lambda: reference.Tracker(plain_pop, plain)),
        PAPER_REFERENCE_STEP: driver(lambda: reference.Tracker(plain_paper, plain)),
    }


def _aside(path: popsteer.Path) -> popsteer.Path:
    """Give a path half a metre to the left."""
    ahead = np.gradient(np.column_stack((path.x, path.y)), axis=0)
    left = np.column_stack((-ahead[:, 1], ahead[:, 0])) / np.hypot(*ahead.T)[:, None]
    return popsteer.Path(np.column_stack((path.x, path.y)) + 0.5 * left, closed=path.closed)
