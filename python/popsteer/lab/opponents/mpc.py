"""A model-predictive controller whose quadratic problem is condensed, on daqp.

The dense problem of 20 commands suits daqp, an active-set solver: D. Arnström, A. Bemporad,
D. Axehill, *A Dual Active-Set Solver for Embedded Quadratic Programming*, 2022. It needs the extra
``mpc``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from popsteer._core import Path, Vehicle
from popsteer.errors import PopsteerError
from popsteer.extras import require
from popsteer.lab.opponents import lqr
from popsteer.lab.opponents.lqr import cost_to_go, model, weights
from popsteer.lab.opponents.observer import Opponent, Seen

_STAGES, _STAGE = 20, 0.05  # how many, and how long [s]
# The problem's matrices are kept while speed and gain move less than these shares.
_SPEED, _GAIN = 0.005, 0.02


@dataclass(frozen=True)
class Weights(lqr.Weights):
    """Weights of the cost e² (3 / L)² + heading ψ² + change Δδ², per stage.

    Parameters
    ----------
    heading : float, default 10.0
        Cost of the heading error squared, beside that of (3 e / L)²; L is the wheelbase.
    change : float, default 0.1
        Cost of the change of the angle squared, per stage of 50 ms; more: calmer wheels.
    """

    heading: float = 10.0
    change: float = 0.1


class Mpc(Opponent):
    """Least cost over 20 stages of 50 ms within the limits of the angle and of its rate.

    With x = (e, ψ, a, δ) and u the change of δ as in `lqr.model`, r the angle of the path's
    curvature at each stage and D what it takes off::

        x[k+1] = A x[k] + B u[k] - D r[k]         X = S x[0] + T u - V r
        cost  = Σ |x[k] - ref[k]|²_Q + |u[k]|²_R + |x[N] - ref[N]|²_P
        H = Tᵀ Q T + R,  f = Tᵀ Q (S x[0] - V r - ref)

    with the regulator's P for the time beyond the horizon.
    """

    Params = Weights

    def __init__(self, path: Path, vehicle: Vehicle, params: Weights) -> None:
        require("controller mpc", "mpc", "daqp")
        self._q, self._r = weights(vehicle.wheelbase, params.heading, params.change)
        super().__init__(path, vehicle, params)

    def reset(self) -> None:
        """Forget the steps taken so far."""
        super().reset()
        self._key = (math.inf, 0.0)
        self._solver: Any = None
        self.said: dict[str, Any] = {}
        """What daqp says of the last problem, such as its own `solve_time` [s]."""

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Answer a pose [m, m, rad] and a speed [m/s] with the angle of the wheels [rad]."""
        self.update(x, y, yaw, speed, dt)
        return self.solve()

    def solve(self) -> float:
        """Solve it: the command [rad]. Raises PopsteerError where daqp finds no solution."""
        x, _, flag, self.said = self._solver.solve()
        if flag < 1:
            raise PopsteerError(f"daqp found no solution: {flag}")
        return self.observer.commanded(self._before + float(x[0]), self._seen)

    def update(self, x: float, y: float, yaw: float, speed: float, dt: float) -> None:
        """Take what `step` does, and set the problem up."""
        self._seen = seen = self.observer.see(x, y, yaw, speed, dt)
        ends = seen.speed * _STAGE * np.arange(_STAGES + 1, dtype=np.float64)
        bends = self.observer.curvature(seen, ends)
        reference = np.arctan(seen.length * bends)
        rate = 1.0 + float(np.mean((seen.length * bends) ** 2))
        car, side = self.vehicle, -1.0 if self.observer.reverse else 1.0
        moved = abs(seen.speed - self._key[0]) > _SPEED * self._key[0]
        hessian = None
        if moved or abs(rate - self._key[1]) > _GAIN * rate:
            self._key = (seen.speed, rate)
            hessian = self._condense(seen, rate)
        offset = self.observer.eye.estimate.steer_offset
        self._before = before = side * (self.observer.steer + offset)
        wanted = np.zeros((_STAGES, 4))
        wanted[:, 1] = -seen.slope * bends
        wanted[:, 2] = wanted[:, 3] = reference
        # Its model is that of small angles: from farther off it approaches as from there.
        far = 0.5 * car.wheelbase
        error = min(max(seen.error, -far), far)
        start = np.array([error, seen.heading, seen.wheel, before])
        off = self._start @ start - self._drift @ reference - wanted.ravel()
        # Bounds of the changes, then of the angles that they come to.
        fastest = math.inf if car.max_steer_rate is None else car.max_steer_rate
        change = np.full(_STAGES, min(fastest * _STAGE, 2.0 * car.max_steer))
        change[0] = min(fastest * seen.dt, 2.0 * car.max_steer)
        most = car.max_steer
        if car.max_lateral_acceleration is not None:
            most = min(most, math.atan(car.max_lateral_acceleration * seen.length / seen.speed**2))
        back = np.cumsum(change)  # from beyond the limits, no sooner than this
        high = np.concatenate((change, np.maximum(most - before, -back)))
        low = np.concatenate((-change, np.minimum(-most - before, back)))
        if self._solver is None:
            import daqp

            self._solver = daqp.Model()
            sums = np.tril(np.ones((_STAGES, _STAGES)))
            self._solver.setup(hessian, self._pull @ off, sums, high, low)
        else:
            self._solver.update(H=hessian, f=self._pull @ off, bupper=high, blower=low)

    def _condense(self, seen: Seen, rate: float) -> NDArray[np.float64]:
        """Compute S, V, Tᵀ Q for a speed and a gain; give H."""
        a, b = model(seen.speed, seen.length, self.vehicle.steer_lag, rate, _STAGE)
        turn = _STAGE * seen.speed * rate / seen.length
        loss = np.array([0.5 * _STAGE * seen.speed * turn, turn, 0.0, 0.0])
        size = 4 * _STAGES
        powers = [np.eye(4)]
        for _ in range(_STAGES):
            powers.append(a @ powers[-1])
        self._start = np.vstack(powers[1:])
        column, lost = (np.vstack(powers[:-1]) @ each for each in (b[:, 0], loss))
        moved, self._drift = np.zeros((size, _STAGES)), np.zeros((size, _STAGES))
        for k in range(_STAGES):  # what a stage does is seen from there on
            rest = size - 4 * k
            moved[4 * k :, k], self._drift[4 * k :, k] = column[:rest], lost[:rest]
        self._pull = np.empty((_STAGES, size))
        last = cost_to_go(a, b, self._q, self._r)
        for k in range(_STAGES):
            rows = slice(4 * k, 4 * k + 4)
            self._pull[:, rows] = moved[rows].T @ (last if k == _STAGES - 1 else self._q)
        hessian: NDArray[np.float64] = self._pull @ moved + self._r[0, 0] * np.eye(_STAGES)
        return 0.5 * (hessian + hessian.T)
