"""A straight, joined from beside it by a bicycle in plain Python; and the offline optimum."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import osqp
from scipy import sparse

import popsteer
from studies.chain import Chain

if TYPE_CHECKING:
    from collections.abc import Iterator

    Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

DT = 0.05
TIME = 20.0
SETTLED = 15.0
MANOEUVRE = 6.0
LINE = popsteer.Path([(float(x), 0.0) for x in range(-50, 1600)])


@dataclass(frozen=True)
class Straight:
    """A vehicle beside a straight; speed and offset are of one of 2.7 m, and scale with it."""

    rate: float
    speed: float
    offset: float
    heading_deg: float = 0.0
    wheelbase: float = 2.7
    dead_time: float = 0.0
    lag: float = 0.15

    @property
    def scale(self) -> float:
        """How many times as long as one of 2.7 m it is."""
        return self.wheelbase / 2.7

    def car(self) -> popsteer.Vehicle:
        """Give the vehicle."""
        return popsteer.Vehicle(
            wheelbase=self.wheelbase,
            steer_lag=self.lag,
            dead_time=self.dead_time,
            max_steer=0.6,
            max_steer_rate=self.rate,
        )

    def chain(self) -> Chain:
        """Give the vehicle on its place."""
        pose = 0.0, self.offset * self.scale, math.radians(self.heading_deg)
        return Chain(self.car(), pose, self.speed * self.scale, DT)


class Joined(NamedTuple):
    """How a straight was joined; lengths are those of a vehicle of 2.7 m."""

    overshoot: float
    """Farthest to the other side [m]."""
    within: float
    """Time until within 0.1 m for good [s]; infinite for never."""
    late: float
    """Largest error after 15 s [m]."""


def join(case: Straight, *, inside: bool = True) -> Joined:
    """Drive; `inside` False plans without limits and cuts the angle afterwards, as 0.1.0 did."""
    car, chain = case.car(), case.chain()
    if inside:
        controller = popsteer.PreviewPop(LINE, car)
    else:
        free = car.replace(max_steer_rate=None, max_lateral_acceleration=None)
        params = popsteer.PreviewPopParams(steer_span_rate=1e3)
        controller = popsteer.PreviewPop(LINE, free, params)
    widest = largest_angle(case)
    errors, last = [], 0.0
    for _ in range(round(TIME / DT)):
        errors.append(chain.y / case.scale)
        steer = controller.steer(*chain.pose, chain.speed, DT)
        if not inside:
            steer = max(-widest, min(steer, widest))
            steer = max(last - case.rate * DT, min(steer, last + case.rate * DT))
            state = controller.state
            law = state.law.replace(previous_steer=steer)
            controller.state = state.replace(steer=steer, law=law)
        last = steer
        chain.advance(steer)
    far = [k for k, error in enumerate(errors) if abs(error) > 0.1]
    within = (far[-1] + 1) * DT if far else 0.0
    return Joined(
        overshoot=max(0.0, -min(errors)),
        within=within if within < TIME else math.inf,
        late=max(abs(error) for error in errors[round(SETTLED / DT) :]),
    )


def largest_angle(case: Straight) -> float:
    """Give the largest angle of the wheels within the lateral acceleration [rad]."""
    car, speed = case.car(), case.speed * case.scale
    assert car.max_lateral_acceleration is not None
    return min(car.max_steer, math.atan(car.max_lateral_acceleration * car.wheelbase / speed**2))


def best_overshoot(case: Straight) -> float:
    """Give the overshoot of the offline optimum under the same limits, lag and dead time [m].

    The optimum is that of preview POP's cost over the whole manoeuvre, as one quadratic program in
    the commanded curvature; its commands are driven.
    """
    chain, car = case.chain(), case.car()
    late = round(case.dead_time / DT)
    length = car.wheelbase
    # The state when the first command arrives: the wheels stand straight until then.
    error = chain.y + late * DT * chain.speed * math.sin(chain.yaw)
    curvature = math.tan(largest_angle(case)) / length
    moves = _Manoeuvre.of(case).solve(
        (error, chain.yaw, 0.0, 0.0), case.rate * DT / length, curvature
    )
    lowest = chain.y
    for commanded in np.cumsum(moves):
        chain.advance(math.atan(commanded * length))
        lowest = min(lowest, chain.y)
    return max(0.0, -lowest / case.scale)


class _Manoeuvre:
    """The quadratic program of a whole manoeuvre: states x' = A x + B c, moves of c."""

    @classmethod
    @functools.cache
    def _at(cls, speed: float, lag: float, wheelbase: float) -> _Manoeuvre:
        return cls(speed, lag, wheelbase)

    @classmethod
    def of(cls, case: Straight) -> _Manoeuvre:
        """Give the one of a case."""
        return cls._at(case.speed * case.scale, case.lag, case.wheelbase)

    def __init__(self, speed: float, lag: float, wheelbase: float) -> None:
        step, kept = speed * DT, math.exp(-DT / lag)
        way, taken = speed * lag, 1.0 - kept
        by_driven = way * taken
        by_commanded = step - by_driven
        # Of cross-track error, heading error, curvature driven and commanded, after the move.
        self.transition = np.array(
            [
                [1.0, step, way * by_commanded, 0.5 * step * step - way * by_commanded],
                [0.0, 1.0, by_driven, by_commanded],
                [0.0, 0.0, kept, taken],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
        self.weights = np.array([1.0, wheelbase**2, 0.0, 0.0])
        self.move_cost = (wheelbase / 12.0 * wheelbase / DT) ** 2

    @functools.cached_property
    def answers(self) -> tuple[Array, Array]:
        """What a unit of each state, and of each move, makes of the errors at all steps."""
        count = round(MANOEUVRE / DT)
        powers = [np.eye(4)]
        for _ in range(count):
            powers.append(self.transition @ powers[-1])
        free = np.array(powers[1:])
        moved = np.array([self.transition @ power[:, 3] for power in powers[:-1]])
        forced = np.zeros((count, 4, count))
        for k in range(count):
            forced[k:, :, k] = moved[: count - k]
        return free, forced

    def solve(self, start: tuple[float, ...], move: float, most: float) -> Array:
        """Give the best moves [1/m]."""
        free, forced = self.answers
        count = forced.shape[2]
        root = np.sqrt(self.weights)[None, :, None]
        rows = (root * forced).reshape(-1, count)
        constant = (root[..., 0] * (free @ np.array(start))).reshape(-1)
        # In units of the largest move, so that the solver's tolerances mean something.
        hessian = move**2 * (rows.T @ rows + self.move_cost * np.eye(count))
        slope = move * (rows.T @ constant)
        scale = float(np.abs(hessian).max())
        solver = osqp.OSQP()
        limits = np.vstack([np.eye(count), np.tril(np.ones((count, count)))])
        ends = np.concatenate([np.ones(count), np.full(count, most / move)])
        solver.setup(
            sparse.csc_matrix(np.triu(hessian / scale)),
            slope / scale,
            sparse.csc_matrix(limits),
            -ends,
            ends,
            verbose=False,
            eps_abs=1e-5,
            eps_rel=1e-5,
            max_iter=20000,
        )
        moves = np.clip(solver.solve(raise_error=False).x, -1.0, 1.0) * move
        return np.diff(np.clip(np.cumsum(moves), -most, most), prepend=0.0)


def sweep() -> Iterator[Straight]:
    """Give the cases of the sweep."""
    yield from itertools.starmap(
        Straight,
        itertools.product(
            (0.2, 0.4, 0.7, 1.0),
            (3.0, 8.0, 15.0, 25.0),
            (0.5, 1.0, 3.0),
            (-20.0, -10.0, 0.0, 10.0, 20.0),
            (0.33, 2.7, 6.0),
            (0.0, 0.2),
            (0.05, 0.15, 0.3),
        ),
    )


def allowed(case: Straight) -> float:
    """Give the overshoot that is allowed: a tenth of the offset, or 5 cm beyond the least [m]."""
    return max(0.1 * case.offset, 0.05 + best_overshoot(case))


def check(case: Straight) -> tuple[Straight, Joined, float]:
    """Drive a case of the sweep."""
    return case, join(case), allowed(case)
