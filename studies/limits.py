"""Preview POP behind wheels that turn slowly: the tables and the map of docs/preview_pop.md.

    python -m studies.limits    # draws the map: overshoot over speed and rate

"Clipped" plans without limits and cuts the angle afterwards. The plant of all but the slalom is a
bicycle in plain Python, no part of popsteer.
"""

from __future__ import annotations

import functools
import itertools
import math
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import osqp
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from scipy import sparse

import popsteer
from popsteer import sim, tracks
from popsteer.lab.common.varied import varied
from popsteer.lab.opponents.mpc import Mpc, Weights
from popsteer.reference.laws.preview_pop.cost_to_go import transition
from popsteer.sim.geometry import object_of
from studies.chain import Chain
from studies.layout import line, write_figures

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from popsteer.lab.common.theme import Theme

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
    """Drive; `inside` False plans without limits and cuts the angle afterwards."""
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
    """Overshoot [m] of preview POP's cost minimised offline in one quadratic program, driven."""
    chain, car = case.chain(), case.car()
    late = round(case.dead_time / DT)
    length = car.wheelbase
    # The state when the first command arrives: the wheels stand straight until then.
    error = chain.y + late * DT * chain.speed * math.sin(chain.yaw)
    curvature = math.tan(largest_angle(case)) / length
    manoeuvre = _Manoeuvre(chain.speed, case.lag, car.wheelbase)
    moves = manoeuvre.solve((error, chain.yaw, 0.0, 0.0), case.rate * DT / length, curvature)
    lowest = chain.y
    for commanded in np.cumsum(moves):
        chain.advance(math.atan(commanded * length))
        lowest = min(lowest, chain.y)
    return max(0.0, -lowest / case.scale)


@functools.cache
class _Manoeuvre:
    """The quadratic program of a whole manoeuvre: states x' = A x + B c, moves of c."""

    def __init__(self, speed: float, lag: float, wheelbase: float) -> None:
        # Of cross-track error, heading error, curvature driven and commanded, after the move.
        whole = transition(speed * DT, speed * lag, math.exp(-DT / lag), offset=0.0)
        self.transition = whole[:4, :4].copy()
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
    cases = itertools.product(
        (0.2, 0.4, 0.7, 1.0),
        (3.0, 8.0, 15.0, 25.0),
        (0.5, 1.0, 3.0),
        (-20.0, -10.0, 0.0, 10.0, 20.0),
        (0.33, 2.7, 6.0),
        (0.0, 0.2),
        (0.05, 0.15, 0.3),
    )
    return itertools.starmap(Straight, cases)


def allowed(case: Straight) -> float:
    """Give the overshoot that is allowed: a tenth of the offset, or 5 cm beyond the least [m]."""
    return max(0.1 * case.offset, 0.05 + best_overshoot(case))


def check(case: Straight) -> tuple[Straight, Joined, float]:
    """Drive a case of the sweep."""
    return case, join(case), allowed(case)


RATES, SPEEDS = np.linspace(0.15, 1.0, 18), np.linspace(3.0, 25.0, 23)
"""Of the map [rad/s, m/s]."""


class Slalom(NamedTuple):
    """A plant on the slalom, from 2.44 m beside it at constant speed."""

    plant: str
    rate: float
    speed: float

    def make(self) -> Any:
        """Give the plant."""
        rate = {"carla-identified": "max_steer_rate", "mujoco-car": "steer_rate"}.get(self.plant)
        plant = varied(object_of(self.plant), LINE, {rate: self.rate} if rate else {}).plant
        assert plant.vehicle.max_steer_rate == self.rate
        return plant

    def drive(self, controller: str) -> sim.Metrics:
        """Drive it by "preview-pop" or by "mpc"."""
        path = popsteer.Path(tracks.get("slalom").xy)
        plant = self.make()
        law: Any = popsteer.PreviewPop(path)
        if controller == "mpc":
            law = Mpc(path, plant.vehicle, Weights())
        start = sim.default_start(path, -sim.closed_loop.START_OFFSET, plant.vehicle)
        run = sim.run(law, plant, path=path, start=start, constant_speed=self.speed)
        return run.metrics


SLALOMS = (
    *(Slalom("commonroad-mb-2", 0.4, speed) for speed in (9.0, 9.5, 10.0, 10.3, 11.0)),
    Slalom("carla-identified", 0.4, 8.0),
    Slalom("carla-identified", 0.2, 8.0),
    Slalom("mujoco-car", 0.2, 8.0),
    Slalom("mujoco-car", 0.15, 8.0),
)
STRAIGHTS = tuple(
    Straight(rate, speed, offset)
    for rate in (0.2, 0.4, 0.8)
    for speed in (3.0, 8.0, 20.0)
    for offset in (1.0, 3.0)
)


def slalom_lines() -> list[str]:
    """Set out mean errors after settling [m], and the rates of the wheels."""
    lines = []
    for case in SLALOMS:
        found = [case.drive(name) for name in ("preview-pop", "mpc")]
        errors = [f"{run.settled_mean_abs_cross_track_error:.3f}" for run in found]
        rates = [f"{math.degrees(run.rms_steer_rate):.1f}" for run in found]
        lines.append(line(case.plant, f"{case.rate:g}", f"{case.speed:g}", *errors, *rates))
    return lines


def straight_lines() -> list[str]:
    """Set out overshoot [m], and time until within 0.1 m [s], clipped and within."""

    def cell(found: Joined) -> str:
        within = "never" if math.isinf(found.within) else f"{found.within:.1f}"
        return f"{found.overshoot:.2f}, {within}"

    lines = []
    for near, far in zip(STRAIGHTS[::2], STRAIGHTS[1::2], strict=True):
        cells = [join(case, inside=inside) for case in (near, far) for inside in (False, True)]
        lines.append(line(f"{near.rate:g}", f"{near.speed:g}", *map(cell, cells)))
    return lines


def sweep_lines() -> list[str]:
    """Give what the sweep of the straight came to, by wheelbase and speed."""
    lines = []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(check, sweep(), chunksize=16))
    for wheelbase, fast in itertools.product((0.33, 2.7, 6.0), (False, True)):
        runs = [
            each
            for each in found
            if each[0].wheelbase == wheelbase and (each[0].speed > 20.0) is fast
        ]
        scale = wheelbase / 2.7
        speeds = f"{25 * scale:.1f}" if fast else f"{3 * scale:.1f} to {15 * scale:.1f}"
        over = [joined.overshoot - most for _, joined, most in runs if joined.overshoot > most]
        counts = (
            *(len(runs), len(over), sum(each > 0.1 for each in over)),
            sum(joined.late > 0.02 for _, joined, _ in runs),
        )
        lines.append(line(f"{wheelbase:g}", speeds, *map(str, counts)))
    return lines


def map_figure(overshoots: Sequence[Array], theme: Theme) -> Figure:
    """Draw overshoot over speed and rate, clipped and within."""
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    titles = "plan without limits, cut afterwards", "limits inside the prediction"
    for axis, title, over in zip(axes, titles, overshoots, strict=True):
        mesh = axis.pcolormesh(
            SPEEDS, RATES, np.maximum(over, 1e-3), norm=LogNorm(1e-3, 3.0), cmap="viridis"
        )
        axis.set(title=title, xlabel="speed [m/s]")
        axis.grid(visible=False)
    axes[0].set_ylabel("rate of the wheels [rad/s]")
    bar = figure.colorbar(mesh, ax=axes, label="overshoot from 1 m beside [m]")
    bar.outline.set_edgecolor(theme.faint)
    return figure


def draw_map() -> None:
    """Compute the map and draw it."""
    overshoots = [
        np.array(
            [
                [join(Straight(rate, speed, 1.0), inside=inside).overshoot for speed in SPEEDS]
                for rate in RATES
            ]
        )
        for inside in (False, True)
    ]
    write_figures({"limits-map": functools.partial(map_figure, overshoots)})


if __name__ == "__main__":
    draw_map()
