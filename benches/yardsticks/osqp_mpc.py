"""A linear model-predictive controller on osqp: 20 steps of 50 ms, in path coordinates.

The kinematic bicycle about its rear axle, linearised along the path stage by stage (so it varies
with time, as curvature does), with e_y the cross-track error, e_ψ the heading error, κ the path's
curvature, and δ_ref = atan(L κ) the angle that follows it::

    e_y[k+1] = e_y[k] + v Δt e_ψ[k]
    e_ψ[k+1] = e_ψ[k] - v Δt κ_k² e_y[k] + v Δt / (L cos² δ_ref,k) (δ[k] - δ_ref,k)

Least squares of both errors, of δ - δ_ref and of the changes of δ, within |δ| ≤ δ_max and a rate
limit as wide as POP's neighbourhood. What can be done once is done once: the sparsity, the cost's
matrix and the symbolic factorisation. Each step writes the new entries into osqp (`update`), then
starts from the last solution, moved on by one stage, and solves (`solve`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import osqp
from scipy import sparse

from popsteer import PopParams
from popsteer.bench.laws import MPC_SOLVE, MPC_UPDATE, Driver

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer import Path
    from popsteer.bench.states import Drive

STAGES = 20
ERROR_WEIGHTS = 1.0, 1.0
"""Of cross-track error [1/m²] and heading error."""
STEER_WEIGHT, CHANGE_WEIGHT = 0.1, 1.0
"""Of δ - δ_ref, and of the change from stage to stage."""


def prepare(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of drivers for a drive."""

    def make() -> Driver:
        mpc = Mpc(drive.path, drive.rear_offset)
        return Driver(mpc.step, mpc.reset, {MPC_UPDATE: mpc.update, MPC_SOLVE: mpc.solve})

    return make


class Mpc:
    """The controller. Variables of stage k: δ[k], e_y[k+1], e_ψ[k+1].

    Rows of stage k: both equations above, the limit of δ[k], the limit of its change.
    """

    def __init__(self, path: Path, reference_offset: float) -> None:
        params = PopParams()
        self.path, self.reference_offset = path, reference_offset
        self.wheelbase, self.max_steer = params.wheelbase, params.max_steer
        self.max_change = params.steer_span
        self._s, self._curvature = _curvature(path)
        self._stages = np.arange(STAGES)
        pattern = _pattern()
        self._order = pattern.data.astype(int) - 1
        self._entries = np.ones((STAGES, 10))
        self._entries[:, (1, 4, 9)] = -1.0
        self._q = np.zeros((STAGES, 3))
        self._low, self._high = np.zeros((STAGES, 4)), np.zeros((STAGES, 4))
        self._low[:, 2], self._high[:, 2] = -self.max_steer, self.max_steer
        self._low[:, 3], self._high[:, 3] = -self.max_change, self.max_change
        self._osqp = osqp.OSQP()
        self.reset()
        self._fill(np.zeros(STAGES), 0.5, 0.0, 0.0)  # osqp scales for what it is set up with
        matrix = sparse.csc_matrix(
            (self._data(), pattern.indices, pattern.indptr), shape=pattern.shape
        )
        bounds = self._low.ravel(), self._high.ravel()
        self._osqp.setup(_cost(), self._q.ravel(), matrix, *bounds, verbose=False)

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self._nearest: int | None = None
        self.previous_steer = 0.0
        self._x, self._y = np.zeros((STAGES, 3)), np.zeros((STAGES, 4))

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        """Update, then solve: the angle [rad]."""
        self.update(x, y, yaw, speed, dt)
        return self.solve()

    def update(self, x: float, y: float, yaw: float, speed: float, dt: float) -> None:
        """Find the vehicle on the path, linearise ahead of it, hand the matrices to osqp."""
        x += self.reference_offset * math.cos(yaw)
        y += self.reference_offset * math.sin(yaw)
        path, last = self.path, self._nearest
        nearest = (
            path.nearest_waypoint(x, y)
            if last is None
            else path.locate(x, y, yaw, last, 2.0 * self.wheelbase).segment
        )
        self._nearest = nearest
        foot = path.project(x, y, nearest)
        travel = max(speed, 0.0) * dt
        ahead = foot.arc_length + travel * self._stages
        if path.closed:
            ahead %= path.length
        curvature = np.interp(ahead, self._s, self._curvature)
        heading_error = math.remainder(yaw - foot.path_yaw, math.tau)
        self._fill(curvature, travel, foot.cross_track_error, heading_error)
        bounds = {"l": self._low.ravel(), "u": self._high.ravel()}
        self._osqp.update(q=self._q.ravel(), Ax=self._data(), **bounds)

    def solve(self) -> float:
        """Solve from the last solution, moved on by one stage: the angle [rad]."""
        self._osqp.warm_start(_moved_on(self._x), _moved_on(self._y))
        result = self._osqp.solve(raise_error=True)
        self._x, self._y = result.x.reshape(STAGES, 3), result.y.reshape(STAGES, 4)
        # The solver keeps limits to its tolerance; the wheels keep them.
        low = max(self.previous_steer - self.max_change, -self.max_steer)
        high = min(self.previous_steer + self.max_change, self.max_steer)
        self.previous_steer = min(max(float(self._x[0, 0]), low), high)
        return self.previous_steer

    def _fill(
        self, curvature: NDArray[np.float64], travel: float, cross_track: float, heading: float
    ) -> None:
        """Write what has changed into the entries of A, the bounds and q."""
        slope = self.wheelbase * curvature
        reference = np.arctan(slope)
        gain = travel / self.wheelbase * (1.0 + slope * slope)  # 1 / cos² of an arctan
        bend = travel * curvature * curvature
        self._entries[:, 2] = -travel
        self._entries[:, 5] = bend
        self._entries[:, 6] = -gain
        low, high, q = self._low, self._high, self._q
        low[0, 0] = high[0, 0] = cross_track + travel * heading
        low[:, 1] = -gain * reference
        low[0, 1] += heading - bend[0] * cross_track
        high[:, 1] = low[:, 1]
        low[0, 3] = self.previous_steer - self.max_change
        high[0, 3] = self.previous_steer + self.max_change
        q[:, 0] = -STEER_WEIGHT * reference
        q[0, 0] -= CHANGE_WEIGHT * self.previous_steer

    def _data(self) -> NDArray[np.float64]:
        """Give A's entries in the order of its columns."""
        data: NDArray[np.float64] = self._entries.ravel()[self._order]
        return data


def _pattern() -> sparse.csc_matrix:
    """Give A with 1, 2, ... for its entries: 1 + 10 k for the first of stage k."""
    # Row and column within the stage, and whether the column is of the stage before, which the
    # first stage has not: what it knows of the time before is in the bounds.
    kinds = (
        (0, 1, 0), (0, 1, 1), (0, 2, 1),             # e_y[k+1], e_y[k], e_ψ[k]
        (1, 2, 0), (1, 2, 1), (1, 1, 1), (1, 0, 0),  # e_ψ[k+1], e_ψ[k], e_y[k], δ[k]
        (2, 0, 0),                                   # δ[k]
        (3, 0, 0), (3, 0, 1),                        # δ[k], δ[k-1]
    )  # fmt: skip
    entries = [
        (10 * k + kind + 1, 4 * k + row, 3 * (k - before) + column)
        for k in range(STAGES)
        for kind, (row, column, before) in enumerate(kinds)
        if k >= before
    ]
    data, rows, columns = zip(*entries, strict=True)
    return sparse.csc_matrix((np.array(data, float), (rows, columns)), (4 * STAGES, 3 * STAGES))


def _cost() -> sparse.csc_matrix:
    """Give P, its upper half."""
    diagonal = np.empty((STAGES, 3))
    diagonal[:, 1:] = ERROR_WEIGHTS
    diagonal[:, 0] = STEER_WEIGHT + 2.0 * CHANGE_WEIGHT
    diagonal[-1, 0] -= CHANGE_WEIGHT  # nothing changes after the last stage
    beside = np.zeros((STAGES, 3))
    beside[:-1, 0] = -CHANGE_WEIGHT
    above = beside.ravel()[: 3 * STAGES - 3]
    return sparse.diags([diagonal.ravel(), above], [0, 3], format="csc")


def _moved_on(stages: NDArray[np.float64]) -> NDArray[np.float64]:
    """Drop the first stage, repeat the last."""
    return np.concatenate((stages[1:], stages[-1:])).ravel()


def _curvature(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give arc lengths, and the curvature at each [1/m]: turn over the mean of two segments."""
    xy = np.column_stack((path.x, path.y))
    if path.closed:
        xy = np.vstack((xy[-1:], xy, xy[:1], xy[1:2]))
    along = np.diff(xy, axis=0)
    length = np.hypot(along[:, 0], along[:, 1])
    yaw = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    curvature = np.diff(yaw) / (0.5 * (length[1:] + length[:-1]))
    if path.closed:
        return np.append(path.s, path.length), curvature
    return np.array(path.s), np.pad(curvature, 1, mode="edge")
