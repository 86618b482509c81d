"""A linear time-varying model-predictive controller on osqp: 20 stages of 50 ms.

The commands in flight are rolled through as the controllers of popsteer do it, so that the problem
begins where the next command reaches the wheels; backwards the vehicle is mirrored about its rear
axle. The model is the vehicle's chain in coordinates of the path, linearised along it, for a
vehicle that drives forward. With v the speed, L the wheelbase that it turns by, K the understeer, τ
the lag, d how far the tracked point lies ahead of the no-slip point, κ_k the path's mean curvature
over stage k, h the length of a stage, δ the command and a the angle of the wheels, both without the
steering offset δ_0::

    G = L + K v²            δ_ref = atan(G κ) - δ_0
    r ≈ v (κ + (1 + (G κ)²) (a - δ_ref) / G)
    a[k+1] = α a[k] + (1 - α) δ[k]         α = exp(-h / τ);  its mean over the stage:
    ā[k] = β a[k] + (1 - β) δ[k]           β = (1 - α) τ / h
    e[k+1] = e[k] + h v ψ[k] + h² v / 2 (r̄[k] - v κ) + h d r̄[k]
    ψ[k+1] = ψ[k] + h (r̄[k] - v κ - v κ² e[k])

The cost weighs e², (ψ + d κ)², whose zero is the heading that keeps the tracked point on a bend,
and the squares of δ - δ_ref and of the changes of δ; the last stage's errors count more, for the
time beyond the horizon. The angle keeps `max_steer` and `max_lateral_acceleration`, its changes
keep `max_steer_rate`: from the last command within the control period, then within each stage.

What can be done once is done once: the sparsity, the cost's matrix and the symbolic factorisation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
import osqp
from scipy import sparse

from benches.latency.calls import MPC_SOLVE, MPC_UPDATE
from benches.latency.timing import Drive, Driver
from popsteer._core import Vehicle, _InFlight
from popsteer.errors import PopsteerError
from popsteer.lab.opponents.observer import Ahead
from popsteer.parameters import Parameters
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer import Path


@dataclass(frozen=True)
class MpcParams(Parameters):
    """Weights and horizon of `Mpc`: its tuning; what is true of the car is its vehicle's.

    Parameters
    ----------
    cross_track_weight : float, optional
        Weight of the squared cross-track error [1/m²]; by default (3 / wheelbase)².
    heading_weight : float, default 10.0
        Weight of the squared heading error.
    steer_weight : float, default 0.0
        Weight of the squared difference between the angle and that of the path's curvature.
    change_weight : float, default 10.0
        Weight of the squared change of the angle from stage to stage.
    last_weight : float, default 10.0
        Factor on the weights of the errors of the last stage.
    stages : int, default 20
        Stages of the horizon.
    stage_time : float, default 0.05
        Length of a stage [s].
    tolerance : float, default 1e-4
        osqp's eps_abs and eps_rel.

    Raises
    ------
    ConfigError
        A number is not in its range.
    """

    RANGES: ClassVar = {
        "cross_track_weight": (1e-9, 1e9),
        "heading_weight": (0.0, 1e9),
        "steer_weight": (0.0, 1e9),
        "change_weight": (1e-9, 1e9),
        "last_weight": (1.0, 1e9),
        "stages": (2, 1000),
        "stage_time": (1e-3, 1.0),
        "tolerance": (1e-9, 1e-1),
    }

    cross_track_weight: float | None = None
    heading_weight: float = 10.0
    steer_weight: float = 0.0
    change_weight: float = 10.0
    last_weight: float = 10.0
    stages: int = 20
    stage_time: float = 0.05
    tolerance: float = 1e-4

    def resolved(self, vehicle: Vehicle) -> MpcParams:
        """Fill in what scales with the vehicle that is steered."""
        if self.cross_track_weight is not None:
            return self
        return self.replace(cross_track_weight=(3.0 / vehicle.wheelbase) ** 2)


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


class Instant(NamedTuple):
    """What a problem is about: a vehicle that drives forward, beside its path; SI units, radians.

    The curvature is the path's mean over each stage, `ahead` how far the tracked point, whose
    errors these are, lies ahead of the no-slip point; `wheel` is without the steering offset, and
    `dt` is the time since the command `previous`.
    """

    curvature: NDArray[np.float64]
    speed: float
    ahead: float
    cross_track: float
    heading: float
    wheel: float
    offset: float
    previous: float
    dt: float


class Problem:
    """The problem, set up once and solved again and again; its parameters are `resolved`."""

    def __init__(self, vehicle: Vehicle, params: MpcParams) -> None:
        self._vehicle, self._params = vehicle, params
        stages = params.stages
        self._entries = np.ones((stages, len(_KINDS)))
        self._entries[:, _OWN] = -1.0
        self._q = np.zeros((stages, _VARIABLES))
        self._low, self._high = np.zeros((stages, _ROWS)), np.zeros((stages, _ROWS))
        # Between two angles within the largest, no change is larger than this.
        self._rate = vehicle.max_steer_rate
        self._most_change = 2.0 * vehicle.max_steer
        change = self._change(params.stage_time)
        self._low[:, 4], self._high[:, 4] = -change, change
        self._changes_before = change * np.arange(stages)
        self.reset()
        self._set_up()

    def reset(self) -> None:
        """Forget the last solution."""
        stages = self._params.stages
        self._x, self._y = np.zeros((stages, _VARIABLES)), np.zeros((stages, _ROWS))

    @property
    def reach(self) -> tuple[float, float]:
        """Smallest and largest angle that the next command can have, but for its rate [rad]."""
        return float(self._low[0, 3]), float(self._high[0, 3])

    def update(self, now: Instant) -> None:
        """Hand the numbers of an instant to osqp."""
        self._fill(now)
        bounds = {"l": self._low.ravel(), "u": self._high.ravel()}
        self._osqp.update(q=self._q.ravel(), Ax=self._data(), **bounds)

    def solve(self) -> float:
        """Solve from the last solution, moved on by one stage, for the next command [rad].

        Raises PopsteerError where osqp found no solution.
        """
        self._osqp.warm_start(_moved_on(self._x), _moved_on(self._y))
        result = self._osqp.solve(raise_error=False)
        if result.x is None or not np.isfinite(result.x).all():
            raise PopsteerError(f"osqp found no solution: {result.info.status}")
        stages = self._params.stages
        self._x = result.x.reshape(stages, _VARIABLES)
        self._y = result.y.reshape(stages, _ROWS)
        # The solver keeps limits to its tolerance; the wheels keep them.
        angle = within(float(self._x[0, 0]), self._low[0, 4], self._high[0, 4])
        return within(angle, *self.reach)

    def _change(self, time: float) -> float:
        most = self._most_change
        return most if self._rate is None else min(self._rate * time, most)

    def _set_up(self) -> None:
        """Give osqp the structure; it scales for the numbers that it is set up with."""
        pattern = _pattern(self._params.stages)
        self._order = pattern.data.astype(int) - 1
        length, stage_time = self._vehicle.wheelbase, self._params.stage_time
        curvature = np.full(self._params.stages, 0.03 / length)
        self._fill(Instant(curvature, 3.0 * length, length, 0.0, 0.0, 0.0, 0.0, 0.0, stage_time))
        matrix = sparse.csc_matrix(
            (self._data(), pattern.indices, pattern.indptr), shape=pattern.shape
        )
        self._osqp: Any = osqp.OSQP()
        self._osqp.setup(
            _cost(self._params),
            self._q.ravel(),
            matrix,
            self._low.ravel(),
            self._high.ravel(),
            verbose=False,
            eps_abs=self._params.tolerance,
            eps_rel=self._params.tolerance,
        )

    def _fill(self, now: Instant) -> None:
        """Write what has changed into the entries of A, the bounds and q."""
        p, entries, low, high, q = self._params, self._entries, self._low, self._high, self._q
        h, d, v, lag = p.stage_time, now.ahead, now.speed, self._vehicle.steer_lag
        base = self._vehicle.turning_length(v)
        slope = base * now.curvature
        reference = np.arctan(slope) - now.offset
        gain = v * (1.0 + slope * slope) / base  # of r on a
        kept = math.exp(-h / lag) if lag > 0.0 else 0.0
        mean = (1.0 - kept) * lag / h
        turned = h * gain
        moved = turned * (0.5 * h * v + d)
        bend = h * v * now.curvature * now.curvature
        # In the order of _KINDS.
        entries[:, 2] = h * v
        entries[:, 3], entries[:, 4] = mean * moved, (1.0 - mean) * moved
        entries[:, 6] = -bend
        entries[:, 8], entries[:, 9] = mean * turned, (1.0 - mean) * turned
        entries[:, 11], entries[:, 12] = kept, 1.0 - kept
        # What does not depend on the variables: r̄ = v κ - gain δ_ref + gain ā.
        low[:, 0] = moved * reference - h * d * v * now.curvature
        low[:, 1] = turned * reference
        low[:, 2] = 0.0
        low[0, 0] -= now.cross_track + h * v * now.heading + mean * moved[0] * now.wheel
        low[0, 1] -= now.heading - bend[0] * now.cross_track + mean * turned[0] * now.wheel
        low[0, 2] -= kept * now.wheel
        high[:, :3] = low[:, :3]
        self._bound(now, base)
        q[:, 0] = -p.steer_weight * reference
        q[0, 0] -= p.change_weight * now.previous
        weight = np.full(len(q), p.heading_weight)
        weight[-1] *= p.last_weight
        q[:, 2] = weight * d * now.curvature

    def _bound(self, now: Instant, base: float) -> None:
        widest = most = self._vehicle.max_steer
        if self._vehicle.max_lateral_acceleration is not None:
            acceleration = self._vehicle.max_lateral_acceleration
            widest = min(most, math.atan(acceleration * base / (now.speed * now.speed)))
        change = self._change(now.dt)
        self._low[0, 4], self._high[0, 4] = now.previous - change, now.previous + change
        # Where the last command is beyond the limits, they are those that it can come back to.
        back = change + self._changes_before
        lowest = within(-widest - now.offset, -most, most)
        highest = within(widest - now.offset, -most, most)
        self._low[:, 3] = np.minimum(lowest, now.previous + back)
        self._high[:, 3] = np.maximum(highest, now.previous - back)

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
    return np.concatenate((stages[1:], stages[-1:])).ravel()


def within(value: float, low: float, high: float) -> float:
    """Bound a value."""
    return float(min(max(value, low), high))


# Below this speed, in wheelbases a second, the vehicle hardly answers to its wheels: the problem is
# set up for this speed instead.
_LEAST_SPEED = 1.0 / 3.0
# Farther from the path, in wheelbases, the linear model says nothing; from there on it is
# approached as from here.
_MOST_ERROR, _MOST_HEADING = 1.0, 1.0


class MpcCommand(NamedTuple):
    """The result of a step of the controller."""

    steer: float
    """Angle of the front wheels [rad]."""
    status: Status
    """``SATURATED`` where the angle is at its limit."""
    reverse: bool
    """Whether the path is driven backwards."""


class Mpc:
    """The controller, for `popsteer.sim.run` one of one's own.

    Its tracked point is the front axle, backwards the point a wheelbase behind the rear axle. The
    vehicle, ``Vehicle()`` by default and in `popsteer.sim.run` the plant's, says where the point
    lies whose pose `step` is given. The defaults of the parameters scale with it.
    """

    name = "mpc"

    def __init__(
        self, path: Path, vehicle: Vehicle | None = None, params: MpcParams | None = None
    ) -> None:
        self.path = path
        self.vehicle_given = vehicle is not None
        self.vehicle = vehicle = Vehicle() if vehicle is None else vehicle
        self.params = MpcParams() if params is None else params
        self.tracked_point = vehicle.front_axle
        resolved = self.params.resolved(vehicle)
        point = vehicle.no_slip_point
        self._no_slip = vehicle.rear_axle if point is None else point
        self._ahead = Ahead(path, vehicle)
        self._ends = resolved.stage_time * np.arange(resolved.stages + 1, dtype=np.float64)
        self._problem = Problem(vehicle, resolved)
        self.reset()

    def with_vehicle(self, vehicle: Vehicle) -> Mpc:
        """Give a fresh controller of another vehicle, on the same path."""
        return Mpc(self.path, vehicle, self.params)

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self.previous_steer = 0.0
        self._segment: int | None = None
        self._reverse = False
        self._in_flight = _InFlight(self.vehicle)
        self._problem.reset()

    def step(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        /,
        *,
        reverse: bool | None = None,
    ) -> MpcCommand:
        """Answer a pose [m, m, rad] and a speed [m/s], negative while rolling backwards.

        `dt` is the time since the last step, and until the next [s]. `reverse` says whether the
        path is driven backwards where the rear axle is; left out, the direction stays, and no cusp
        is passed. Raises InputError where a number is not finite or beyond its bound, and
        PopsteerError where osqp finds no solution.
        """
        steer = self.steer(x, y, yaw, speed, dt, reverse=reverse)
        lowest, highest = self._problem.reach
        limited = not lowest < self._mirror(steer) < highest
        return MpcCommand(steer, Status.SATURATED if limited else Status.OK, self._reverse)

    def steer(self, *pose: float, reverse: bool | None = None) -> float:
        """Answer as `step` does, with the angle alone [rad]."""
        self.update(*pose, reverse=reverse)
        return self.solve()

    def update(self, *pose: float, reverse: bool | None = None) -> None:
        """Find the vehicle on the path, linearise ahead of it, hand the numbers to osqp."""
        x, y, yaw, speed, dt = pose
        # The no-slip point when the next command reaches the wheels.
        then = self._in_flight.advance(self.previous_steer, dt, x, y, yaw, speed)
        segment = self._find(x, y, yaw, reverse=reverse)
        x, y, yaw, speed, wheel = then

        # Backwards, mirrored to a vehicle that drives forward.
        length, slip = self.vehicle.wheelbase, self._no_slip - self.vehicle.rear_axle
        ahead = length - slip
        if self._reverse:
            yaw, ahead = math.remainder(yaw + math.pi, math.tau), length + slip
        x, y = x + ahead * math.cos(yaw), y + ahead * math.sin(yaw)
        reach = 2.0 * length + abs(speed) * dt
        projection = self.path.locate(x, y, yaw, segment, reach)
        self._segment = projection.segment
        speed = max(self._mirror(speed), _LEAST_SPEED * length)
        heading = self._ahead.headings(
            projection.segment, projection.arc_length, speed * self._ends
        )
        error = math.remainder(yaw - float(heading[0]), math.tau)
        offset, far = self.vehicle.steer_offset, _MOST_ERROR * length
        self._problem.update(
            Instant(
                curvature=np.diff(heading) / (speed * self.params.stage_time),
                speed=speed,
                ahead=ahead,
                cross_track=within(self._ahead.cross_track(projection), -far, far),
                heading=within(error, -_MOST_HEADING, _MOST_HEADING),
                wheel=self._mirror(wheel - offset),
                offset=self._mirror(offset),
                previous=self._mirror(self.previous_steer),
                dt=dt,
            )
        )

    def solve(self) -> float:
        """Solve for the angle [rad] from the last solution; PopsteerError if osqp finds none."""
        self.previous_steer = self._mirror(self._problem.solve())
        return self.previous_steer

    def _find(self, x: float, y: float, yaw: float, *, reverse: bool | None) -> int:
        """Give the segment at which to search for the vehicle, and set the direction."""
        segment = self._segment
        if segment is None:
            rear = self.vehicle.rear_axle
            x, y = x + rear * math.cos(yaw), y + rear * math.sin(yaw)
            segment = self.path.relocalise(x, y, yaw)
        if reverse is not None:
            segment = self._ahead.turning(segment, reverse=reverse)
        backwards = self._ahead.reverse(segment)
        if backwards is not self._reverse:
            # The last solution is of the vehicle that was not mirrored, or was.
            self._problem.reset()
            self._reverse = backwards
        return segment

    def _mirror(self, value: float) -> float:
        """Give an angle or a speed of the vehicle as that of the mirrored one, and back."""
        return -value if self._reverse else value


def prepare(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of its drivers."""

    def make() -> Driver:
        mpc = Mpc(drive.path, drive.vehicle)
        return Driver(mpc.steer, mpc.reset, {MPC_UPDATE: mpc.update, MPC_SOLVE: mpc.solve})

    return make
