"""A linear time-varying model-predictive controller on osqp: 20 steps of 50 ms.

The model is the kinematic bicycle with understeer and a lag, in coordinates of the path and
linearised along it. With v the speed, L the wheelbase, K the understeer, τ the lag, d how far the
reference point lies ahead of the point whose pose is given, κ_k the path's mean curvature over
stage k, h the length of a stage, δ the command and a the angle that the yaw rate r answers to::

    G = L + K v²            δ_ref = atan(G κ)
    r ≈ v (κ + (1 + (G κ)²) (a - δ_ref) / G)
    a[k+1] = α a[k] + (1 - α) δ[k]         α = exp(-h / τ);  its mean over the stage:
    ā[k] = β a[k] + (1 - β) δ[k]           β = (1 - α) τ / h
    e[k+1] = e[k] + h v ψ[k] + h² v / 2 (r̄[k] - v κ) + h d r̄[k]
    ψ[k+1] = ψ[k] + h (r̄[k] - v κ - v κ² e[k])

The cost weighs e², (ψ + d κ)², whose zero is the heading that keeps the reference point on a bend,
and the squares of δ - δ_ref and of the changes of δ; the last stage's errors count more, for the
time beyond the horizon. |δ| and the changes of δ keep their limits.

What can be done once is done once: the sparsity, the cost's matrix and the symbolic factorisation.
Each step writes the new entries into osqp (`Mpc.update`), then starts from the last solution, moved
on by one stage, and solves (`Mpc.solve`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import osqp
from scipy import sparse

from popsteer.baselines.mpc_params import MpcParams
from popsteer.errors import InputError, PopsteerError
from popsteer.status import Status

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer import Path

__all__ = ["Mpc", "MpcCommand"]

# Below, the vehicle hardly answers to its wheels, and the problem would be about nothing.
_LEAST_SPEED = 1.0
# Farther from the path the linear model says nothing; from there on it is approached as from here.
_MOST_ERROR, _MOST_HEADING = 3.0, 1.0
# Of a stage: variables δ[k], e[k+1], ψ[k+1], a[k+1]; rows the equations of e, ψ, a, the limit of δ,
# the limit of its change.
_VARIABLES, _ROWS = 4, 5
# Row and column within the stage, and whether the column is of the stage before, which the first
# stage has not: what it knows of the time before is in the bounds.
_KINDS = (
    (0, 1, 0), (0, 1, 1), (0, 2, 1), (0, 3, 1), (0, 0, 0),
    (1, 2, 0), (1, 1, 1), (1, 2, 1), (1, 3, 1), (1, 0, 0),
    (2, 3, 0), (2, 3, 1), (2, 0, 0),
    (3, 0, 0),
    (4, 0, 0), (4, 0, 1),
)  # fmt: skip
_OWN = [_KINDS.index(kind) for kind in ((0, 1, 0), (1, 2, 0), (2, 3, 0), (4, 0, 1))]


class MpcCommand(NamedTuple):
    """What a step of the controller comes to."""

    steer: float
    """Angle of the front wheels [rad]."""
    status: Status
    """``SATURATED`` where the angle is at its limit."""


class Mpc:
    """The controller, for `popsteer.sim.run` a law of one's own.

    Parameters
    ----------
    path : Path
        What to follow.
    params : MpcParams, optional
        Vehicle, weights and limits.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    >>> Mpc(path).step(0.0, 0.5, 0.0, 8.0, 0.05).steer < 0.0
    True
    """

    name = "mpc"

    def __init__(self, path: Path, params: MpcParams | None = None) -> None:
        self.path = path
        self.params = MpcParams() if params is None else params
        self.reference_offset = self.params.reference_offset
        self._s, self._heading = _headings(path)
        stages = self.params.stages
        self._ends = np.arange(stages + 1) * self.params.stage_time
        self._entries = np.ones((stages, len(_KINDS)))
        self._entries[:, _OWN] = -1.0
        self._q = np.zeros((stages, _VARIABLES))
        self._low, self._high = np.zeros((stages, _ROWS)), np.zeros((stages, _ROWS))
        change = self.params.max_steer_rate * self.params.stage_time
        self._low[:, 3], self._high[:, 3] = -self.params.max_steer, self.params.max_steer
        self._low[:, 4], self._high[:, 4] = -change, change
        self.reset()
        self._set_up()

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self._segment: int | None = None
        self._answered = 0.0
        self._change = 0.0
        self.previous_steer = 0.0
        stages = self.params.stages
        self._x, self._y = np.zeros((stages, _VARIABLES)), np.zeros((stages, _ROWS))

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> MpcCommand:
        """Answer a pose and a speed.

        Parameters
        ----------
        x, y, yaw : float
            Pose of the vehicle [m, m, rad].
        speed : float
            Speed [m/s].
        dt : float
            Time since the last step, and until the next [s].

        Returns
        -------
        MpcCommand
            The angle.

        Raises
        ------
        InputError
            A number is not finite, or `dt` is not positive.
        PopsteerError
            osqp found no solution.
        """
        steer = self.steer(x, y, yaw, speed, dt)
        limit = abs(steer) >= self.params.max_steer
        return MpcCommand(steer, Status.SATURATED if limit else Status.OK)

    def steer(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Answer as `step` does, with the angle alone.

        Parameters
        ----------
        x, y, yaw, speed, dt : float
            As `step`.

        Returns
        -------
        float
            The angle [rad].

        Raises
        ------
        InputError, PopsteerError
            As `step`.
        """
        self.update(x, y, yaw, speed, dt)
        return self.solve()

    def update(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> None:
        """Find the vehicle on the path, linearise ahead of it, hand the numbers to osqp.

        Parameters
        ----------
        x, y, yaw, speed, dt : float
            As `step`.

        Raises
        ------
        InputError
            As `step`.
        """
        for field, value in (("x", x), ("y", y), ("yaw", yaw), ("speed", speed)):
            if not math.isfinite(value):
                raise InputError(field, value, "finite")
        if not 0.0 < dt < math.inf:
            raise InputError("dt", dt, "positive and finite")
        params = self.params
        x += self.reference_offset * math.cos(yaw)
        y += self.reference_offset * math.sin(yaw)
        path, last = self.path, self._segment
        start = path.relocalise(x, y, yaw) if last is None else last
        reach = 2.0 * params.wheelbase + abs(speed) * dt
        foot = path.locate(x, y, yaw, start, reach)
        self._segment = foot.segment
        speed = max(speed, _LEAST_SPEED)
        heading = self._headings_ahead(foot.arc_length, speed)
        # What the command of the last step has come to at the wheels by now.
        kept = math.exp(-dt / params.lag) if params.lag > 0.0 else 0.0
        self._answered = kept * self._answered + (1.0 - kept) * self.previous_steer
        self._change = params.max_steer_rate * dt
        self._fill(
            np.diff(heading) / (speed * params.stage_time),
            speed,
            _within(foot.cross_track_error, _MOST_ERROR),
            _within(math.remainder(yaw - float(heading[0]), math.tau), _MOST_HEADING),
        )
        bounds = {"l": self._low.ravel(), "u": self._high.ravel()}
        self._osqp.update(q=self._q.ravel(), Ax=self._data(), **bounds)

    def solve(self) -> float:
        """Solve from the last solution, moved on by one stage.

        Returns
        -------
        float
            The angle [rad].

        Raises
        ------
        PopsteerError
            osqp found no solution.
        """
        self._osqp.warm_start(_moved_on(self._x), _moved_on(self._y))
        result = self._osqp.solve(raise_error=False)
        if result.x is None or not np.isfinite(result.x).all():
            raise PopsteerError(f"osqp found no solution: {result.info.status}")
        stages = self.params.stages
        self._x = result.x.reshape(stages, _VARIABLES)
        self._y = result.y.reshape(stages, _ROWS)
        # The solver keeps limits to its tolerance; the wheels keep them.
        change = _within(float(self._x[0, 0]) - self.previous_steer, self._change)
        self.previous_steer = _within(self.previous_steer + change, self.params.max_steer)
        return self.previous_steer

    def _set_up(self) -> None:
        """Give osqp the structure; it scales for the numbers that it is set up with."""
        pattern = _pattern(self.params.stages)
        self._order = pattern.data.astype(int) - 1
        self._fill(np.full(self.params.stages, 0.01), 10.0, 0.0, 0.0)
        matrix = sparse.csc_matrix(
            (self._data(), pattern.indices, pattern.indptr), shape=pattern.shape
        )
        self._osqp: Any = osqp.OSQP()
        self._osqp.setup(
            _cost(self.params),
            self._q.ravel(),
            matrix,
            self._low.ravel(),
            self._high.ravel(),
            verbose=False,
            eps_abs=self.params.tolerance,
            eps_rel=self.params.tolerance,
        )

    def _headings_ahead(self, arc: float, speed: float) -> NDArray[np.float64]:
        """Give the path's heading at the ends of the stages [rad], the turns of a lap included."""
        ahead = arc + speed * self._ends
        if not self.path.closed:
            return np.asarray(np.interp(ahead, self._s, self._heading), dtype=np.float64)
        laps = np.floor(ahead / self.path.length)
        turn = self._heading[-1] - self._heading[0]
        heading = np.interp(ahead - laps * self.path.length, self._s, self._heading)
        return np.asarray(heading + laps * turn, dtype=np.float64)

    def _fill(
        self, curvature: NDArray[np.float64], speed: float, cross_track: float, heading: float
    ) -> None:
        """Write what has changed into the entries of A, the bounds and q."""
        p, entries, low, high, q = self.params, self._entries, self._low, self._high, self._q
        h, d, v = p.stage_time, self.reference_offset, speed
        base = p.wheelbase + p.understeer * v * v
        slope = base * curvature
        reference = np.arctan(slope)
        gain = v * (1.0 + slope * slope) / base  # of r on a
        kept = math.exp(-h / p.lag) if p.lag > 0.0 else 0.0
        mean = (1.0 - kept) * p.lag / h
        turned = h * gain
        moved = turned * (0.5 * h * v + d)
        bend = h * v * curvature * curvature
        # In the order of _KINDS.
        entries[:, 2] = h * v
        entries[:, 3], entries[:, 4] = mean * moved, (1.0 - mean) * moved
        entries[:, 6] = -bend
        entries[:, 8], entries[:, 9] = mean * turned, (1.0 - mean) * turned
        entries[:, 11], entries[:, 12] = kept, 1.0 - kept
        # What does not depend on the variables: r̄ = v κ - gain δ_ref + gain ā.
        low[:, 0] = moved * reference - h * d * v * curvature
        low[:, 1] = turned * reference
        low[:, 2] = 0.0
        answered = self._answered
        low[0, 0] -= cross_track + h * v * heading + mean * moved[0] * answered
        low[0, 1] -= heading - bend[0] * cross_track + mean * turned[0] * answered
        low[0, 2] -= kept * answered
        high[:, :3] = low[:, :3]
        low[0, 4] = self.previous_steer - self._change
        high[0, 4] = self.previous_steer + self._change
        q[:, 0] = -p.steer_weight * reference
        q[0, 0] -= p.change_weight * self.previous_steer
        weight = np.full(len(q), p.heading_weight)
        weight[-1] *= p.last_weight
        q[:, 2] = weight * d * curvature

    def _data(self) -> NDArray[np.float64]:
        """Give A's entries in the order of its columns."""
        data: NDArray[np.float64] = self._entries.ravel()[self._order]
        return data


def _pattern(stages: int) -> sparse.csc_matrix:
    """Give A with 1, 2, ... for its entries, in the order of stages and `_KINDS`."""
    entries = [
        (len(_KINDS) * k + kind + 1, _ROWS * k + row, _VARIABLES * (k - before) + column)
        for k in range(stages)
        for kind, (row, column, before) in enumerate(_KINDS)
        if k >= before
    ]
    data, rows, columns = zip(*entries, strict=True)
    shape = (_ROWS * stages, _VARIABLES * stages)
    return sparse.csc_matrix((np.array(data, float), (rows, columns)), shape)


def _cost(params: MpcParams) -> sparse.csc_matrix:
    """Give P, its upper half."""
    stages = params.stages
    diagonal = np.zeros((stages, _VARIABLES))
    diagonal[:, 1:3] = params.cross_track_weight, params.heading_weight
    diagonal[-1, 1:3] *= params.last_weight
    diagonal[:, 0] = params.steer_weight + 2.0 * params.change_weight
    diagonal[-1, 0] -= params.change_weight  # nothing changes after the last stage
    beside = np.zeros((stages, _VARIABLES))
    beside[:-1, 0] = -params.change_weight
    above = beside.ravel()[: _VARIABLES * (stages - 1)]
    return sparse.diags([diagonal.ravel(), above], [0, _VARIABLES], format="csc")


def _moved_on(stages: NDArray[np.float64]) -> NDArray[np.float64]:
    """Drop the first stage, repeat the last."""
    return np.concatenate((stages[1:], stages[-1:])).ravel()


def _within(value: float, bound: float) -> float:
    return min(max(value, -bound), bound)


def _headings(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give arc lengths, and the path's heading at each [rad], continuous: that of its neighbours.

    A closed path ends with its first waypoint once more, a turn later.
    """
    xy = np.column_stack((path.x, path.y))
    if path.closed:
        xy = np.vstack((xy[-1:], xy, xy[:2]))
    along = np.diff(xy, axis=0)
    yaw = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    between = 0.5 * (yaw[1:] + yaw[:-1])
    if path.closed:
        return np.append(path.s, path.length), between
    return np.array(path.s), np.concatenate((yaw[:1], between, yaw[-1:]))
