"""The calls that the benchmark times, each under its name in the report."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import popsteer
from popsteer import reference

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from popsteer.bench.states import Drive

__all__ = [
    "EMPTY_CALL",
    "LABELS",
    "MPC_SOLVE",
    "MPC_STEP",
    "MPC_UPDATE",
    "NUMBA_STEP",
    "PAPER_NS",
    "POP_COMMAND",
    "POP_STEP",
    "PREVIEW_POP_STEP",
    "REFERENCE_STEP",
    "Driver",
    "lineup",
]

POP_STEP = "pop_step_ns"
POP_COMMAND = "pop_command_ns"
PREVIEW_POP_STEP = "preview_pop_step_ns"
REFERENCE_STEP = "reference_step_ns"
EMPTY_CALL = "empty_call_ns"
NUMBA_STEP = "numba_step_ns"
MPC_STEP = "mpc_step_ns"
MPC_UPDATE = "mpc_update_ns"
MPC_SOLVE = "mpc_solve_ns"

PAPER_NS = 3.239e6
"""Mean latency of POP in the paper, on its laptop [ns]."""

LABELS = {
    POP_STEP: "POP, angle",
    POP_COMMAND: "POP, command",
    PREVIEW_POP_STEP: "preview POP",
    "pid_step_ns": "PID",
    "pure_pursuit_step_ns": "pure pursuit",
    "stanley_step_ns": "Stanley",
    EMPTY_CALL: "empty call",
    REFERENCE_STEP: "POP in Python",
    NUMBA_STEP: "POP in numba",
    MPC_STEP: "MPC on osqp",
    MPC_UPDATE: "- its update",
    MPC_SOLVE: "- its solve",
}
"""What a person reads for each name."""


class Driver(NamedTuple):
    """A controller as the benchmark drives it.

    Attributes
    ----------
    call : callable
        The control step, of (x, y, yaw, speed, dt).
    reset : callable
        Forgets the steps taken so far; of nothing.
    stages : dict, optional
        What `call` does in two parts, in order, each under its name in the report: the first takes
        the arguments, the second none. They are timed apart.
    """

    call: Callable[[float, float, float, float, float], object]
    reset: Callable[[], None]
    stages: Mapping[str, Callable[..., object]] | None = None


def lineup(drive: Drive) -> dict[str, Callable[[], Driver]]:
    """Give a maker of drivers for each call that is timed.

    Parameters
    ----------
    drive : Drive
        Gives the path and the reference points of the laws.

    Returns
    -------
    dict
        Name in the report to maker. Each driver made has a state of its own.

    Notes
    -----
    ``pop_step_ns`` and the other laws are ``steer``, the angle alone; ``pop_command_ns`` is
    ``step``, which measures the errors besides. ``empty_call_ns`` is a method of `popsteer.Pop`
    with the signature of ``steer`` that returns at once: what the border between Python and Rust
    costs by itself.
    """
    path, front, rear = drive.path, drive.front_offset, drive.rear_offset
    pop_params = popsteer.PopParams(reference_offset=front)
    preview_pop_params = popsteer.PreviewPopParams(reference_offset=rear)
    pid_params = popsteer.PidParams(reference_offset=front)
    pure_pursuit_params = popsteer.PurePursuitParams(reference_offset=rear)
    stanley_params = popsteer.StanleyParams(reference_offset=front)
    reference_path = reference.Path(
        zip(path.x.tolist(), path.y.tolist(), strict=True), closed=path.closed
    )
    reference_params = reference.PopParams(reference_offset=front)

    def pop() -> Driver:
        law = popsteer.Pop(path, pop_params)
        return Driver(law.steer, law.reset)

    def pop_command() -> Driver:
        law = popsteer.Pop(path, pop_params)
        return Driver(law.step, law.reset)

    def preview_pop() -> Driver:
        law = popsteer.PreviewPop(path, preview_pop_params)
        return Driver(law.steer, law.reset)

    def pid() -> Driver:
        law = popsteer.Pid(path, pid_params)
        return Driver(law.steer, law.reset)

    def pure_pursuit() -> Driver:
        law = popsteer.PurePursuit(path, pure_pursuit_params)
        return Driver(law.steer, law.reset)

    def stanley() -> Driver:
        law = popsteer.Stanley(path, stanley_params)
        return Driver(law.steer, law.reset)

    def empty_call() -> Driver:
        law = popsteer.Pop(path, pop_params)
        return Driver(law._empty_call, law.reset)  # noqa: SLF001 - it is there for this

    def reference_pop() -> Driver:
        law = reference.Pop(reference_path, reference_params)
        return Driver(law.steer, law.reset)

    return {
        POP_STEP: pop,
        POP_COMMAND: pop_command,
        PREVIEW_POP_STEP: preview_pop,
        "pid_step_ns": pid,
        "pure_pursuit_step_ns": pure_pursuit,
        "stanley_step_ns": stanley,
        EMPTY_CALL: empty_call,
        REFERENCE_STEP: reference_pop,
    }
