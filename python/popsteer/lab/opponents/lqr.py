"""A linear-quadratic regulator with the curvature fed forward."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from popsteer.lab.opponents.observer import Opponent, Seen
from popsteer.parameters import Parameters

Matrix = NDArray[np.float64]


def model(speed: float, length: float, lag: float, rate: float, dt: float) -> tuple[Matrix, Matrix]:
    """Give A, B of x[k+1] = A x[k] + B u[k], x = (e, ψ, a, u before), per control period `dt` [s].

    e' = v ψ, ψ' = v gain a / G, a' = (δ - a) / τ for small errors beside a path of the curvature
    that a and δ are measured from, `rate` being the gain 1 + (G κ)²; u is the change of δ [rad], so
    that the last state is δ. Within the period the angle of the wheels has its mean over it.
    """
    kept = math.exp(-dt / lag) if lag > 0.0 else 0.0
    mean = (1.0 - kept) * lag / dt if lag > 0.0 else 0.0
    turn = dt * speed * rate / length
    wheels = np.array([0.0, 0.0, mean, 1.0 - mean])  # mean angle, of a and of the command
    a = np.eye(4)
    a[0, 1] = dt * speed
    a[0] += 0.5 * dt * speed * turn * wheels
    a[1] += turn * wheels
    a[2] = 0.0, 0.0, kept, 1.0 - kept
    b = a[:, 3].copy()
    return a, b[:, None]


def weights(wheelbase: float, heading: float, change: float) -> tuple[Matrix, Matrix]:
    """Give Q over (e, ψ, a, δ) and R over the change: e in wheelbases over 3, as `mpc` has it."""
    return np.diag([(3.0 / wheelbase) ** 2, heading, 0.0, 0.0]), np.array([[change]])


def cost_to_go(a: Matrix, b: Matrix, q: Matrix, r: Matrix) -> Matrix:
    """Give P of the least cost xᵀ P x over all time: P = Q + Aᵀ P A - Aᵀ P B (R + Bᵀ P B)⁻¹ Bᵀ P A.

    By doubling, each pass over twice the time of the last: E. Chu, H.-Y. Fan, W.-W. Lin, C.-S.
    Wang, *Structure-preserving algorithms for periodic discrete-time algebraic Riccati equations*,
    2004.
    """
    g, p = b @ np.linalg.solve(r, b.T), q
    for _ in range(50):
        both = np.linalg.solve(np.eye(len(a)) + g @ p, np.hstack((a, g)))
        past, with_g = np.split(both, 2, axis=1)
        more = a.T @ p @ past
        g, p, a = g + a @ with_g @ a.T, p + more, a @ past
        if np.abs(more).max() <= 1e-12 * np.abs(p).max():
            break
    return p


@dataclass(frozen=True)
class Weights(Parameters):
    """Weights of the cost e² (3 / L)² + heading ψ² + change Δδ², per control period."""

    RANGES: ClassVar = {"heading": (0.0, 1e3), "change": (0.01, 1e4)}

    heading: float = 30.0
    change: float = 10.0


class Lqr(Opponent):
    """Angle atan(G κ) - K (e, ψ, a - atan(G κ), ...), K by the Riccati equation for each speed.

    R. Rajamani, *Vehicle Dynamics and Control*, 2nd ed. 2012, section 3; κ is the curvature where
    the wheels will have turned, ahead by the lag. K is kept while the speed moves less than 2 %.
    """

    Params = Weights
    params: Weights

    def reset(self) -> None:
        """Forget the steps taken so far."""
        super().reset()
        self._key, self._gain = (math.inf, 0.0), np.zeros(4)

    def wheels(self, seen: Seen) -> float:
        """Give the angle of the wheels [rad]."""
        length = self.vehicle.wheelbase
        if abs(seen.speed - self._key[0]) > 0.02 * self._key[0] or self._key[1] != seen.dt:
            self._key = (seen.speed, seen.dt)
            a, b = model(seen.speed, seen.length, self.vehicle.steer_lag, 1.0, seen.dt)
            q, r = weights(length, self.params.heading, self.params.change)
            p = cost_to_go(a, b, q, r)
            self._gain = np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a)[0]
        here = 0.5 * seen.speed * seen.dt
        ahead = here + seen.speed * self.vehicle.steer_lag
        now, then = (self.observer.bend(seen, at) for at in (here, ahead))
        feed = math.atan(seen.length * then)
        before = self.observer.steer + self.observer.eye.estimate.steer_offset
        before = -before if self.observer.reverse else before
        # From farther off the path is approached as from a wheelbase.
        error = min(max(seen.error, -length), length)
        state = (error, seen.heading + seen.slope * now, seen.wheel, before)
        reference = (0.0, 0.0, math.atan(seen.length * now), feed)
        return before - float(self._gain @ (np.array(state) - reference))
