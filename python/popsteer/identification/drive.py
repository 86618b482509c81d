"""What a log says, made ready for the fit: one clock, equal cells, and no outliers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from popsteer.identification.arrays import middles, parted, stretches
from popsteer.identification.rounding import grain_of, rounding_of, unrounded

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from popsteer.logs import Log

    Array = NDArray[np.float64]

CELL = 0.025
"""Longest cell of the simulation [s]. Lag, dead time and rate are exact for a command that stays
the same within it; shorter ones cost time alone."""
PAUSE = 5.0
"""What a gap is replaced by [s]: the simulated wheels settle meanwhile, and the car stands."""
SETTLING = 1.0
"""Time after a start or a gap that does not count [s]: nobody knows what was commanded before."""
TURN = 1.0
"""Time over which turns are compared [s]: a bend is more than noise, and no drift."""
OUTLIER = 6.0
"""A sample this many standard deviations from its neighbours' median is an outlier. Noise alone
makes one of 500 million."""
MOST_OUTLIERS = 0.05
"""A larger share of them is no noise: the signal is another than it is taken for."""
RESOLVED = {"yaw": 2e-4, "speed": 1e-3, "position": 1e-3}
"""What the best sensors resolve [rad, share of the usual speed, m of a full-size car]: less noise
than this, or than the digits that were written, is a simulation's, and no knowledge of a car."""

FULL_SIZE = 2.0
"""Wheelbase [m] below which bounds of lengths and speeds scale with the wheelbase."""
REST = 0.1
REST_TIME = 1.0
"""A full-size car slower than `REST` [m/s] for as long as this [s] stands."""
SEEN = 4.0
"""Nor is a speed seen that is below this many standard deviations of its noise."""
SMOOTHING = 0.3
"""Standard deviation of what the acceleration is smoothed by [s]: noise of 0.02 m/s leaves 0.03
m/s² at 20 Hz."""
HARDEST = 12.0
"""Bound of the acceleration [m/s²]: beyond it the speed jumps across a pause."""


@dataclass(frozen=True, eq=False)
class PreparedLog:
    """A log on a clock without gaps.

    `commands` begin at `times`. `edges` bound the cells of the simulation, `speed` is that of
    each, 0 in the pauses that stand for gaps. `unbroken` are the samples between these.
    """

    t: Array
    x: Array
    y: Array
    yaw: Array
    sample_speed: Array
    edges: Array
    times: Array
    commands: Array
    speed: Array
    acceleration: Array
    usual_speed: float
    unbroken: list[slice]
    outliers: dict[str, int]
    """How many samples of each column stand out from their neighbours."""
    usual_step: float
    speed_noise: float
    """Standard deviation of the noise of the measured speeds [m/s], as are the following."""
    least_noise: dict[str, float]
    """Below it no noise of ``yaw`` [rad], ``steer`` [rad] and ``position`` [m] is believed."""
    recorded: Array
    """The commands as they are recorded [rad], and the step of their digits; 0 without digits."""
    steer_step: float

    moving: NDArray[np.bool_]
    """Whether a sample is of a moving car: at rest nothing is learnt, not even the noise."""
    size: float
    """As `size_of` gives it for the vehicle that was given."""
    play: float = 0.0
    """The play of the steering [rad], where it is known to have some."""

    @property
    def cell(self) -> float:
        """Length of a cell [s]."""
        return float(self.edges[1] - self.edges[0])

    def drift(self, error: Array, length: float) -> Array:
        """Give how far the noise s of speeds and commands lets the heading drift a sample.

        s dt yaw'/v by a speed, s dt v/L by a command; `error` is what is left of the heading [rad].
        """
        speed = np.maximum(np.abs(self.sample_speed[1:]), 0.3 * self.size)
        by_speed = np.diff(self.yaw - error) / speed * self.speed_noise
        by_command = self.least_noise["steer"] * np.diff(self.t) * speed / length
        found: Array = np.hypot(by_speed, by_command)
        return found

    def explained(self, yaw: Array) -> tuple[float, float]:
        """Give the share of the measured turns that a simulated heading explains, and their slope.

        The turns are those of `TURN`, less their means.
        """
        parts = self.parts()
        longest = max(part.stop - part.start for part in parts)
        every = max(1, min(round(TURN / self.usual_step), longest - 1))
        given, measured = (
            np.concatenate([np.diff(each[part][::every]) for part in parts])
            for each in (yaw, self.yaw)
        )
        given, measured = given - given.mean(), measured - measured.mean()
        slope = float(given @ measured) / max(float(given @ given), 1e-12)
        return slope**2 * float(given @ given) / max(float(measured @ measured), 1e-12), slope

    def parts(self) -> list[slice]:
        """Give the samples of each unbroken part that count: moving, and after `SETTLING`."""
        found = []
        for whole in self.unbroken:
            begins = self.t[whole.start]
            if self.play:  # until they are pushed to both sides, the wheels lie anywhere in it
                since = self.times >= begins
                asked = self.commands[since]
                pushed = np.maximum.accumulate(asked) - np.minimum.accumulate(asked) > self.play
                begins = np.append(self.times[since][pushed], self.t[-1])[0]
            first = int(np.searchsorted(self.t[whole], begins + SETTLING) + whole.start)
            found += [
                slice(first + part.start, first + part.stop)
                for part in stretches(self.moving[first : whole.stop])
                if part.stop - part.start >= 3
            ]
        return found


def size_of(wheelbase: float) -> float:
    """Give the share of `FULL_SIZE` that a wheelbase [m] is, at most 1."""
    return min(wheelbase / FULL_SIZE, 1.0)


def prepare(log: Log, size: float = 1.0, whole: Log | None = None) -> PreparedLog:
    """Lay a log out for the fit: on a clock in which each gap lasts `PAUSE`.

    The speed between its rows is that of `whole`, which may have more of them.
    """
    unbroken = parted(log.gaps, len(log))
    columns = {"x": log.x, "y": log.y, "yaw": np.unwrap(log.yaw), "speed": log.speed}
    slowest = max(REST * size, SEEN * noise_of(log.speed))
    moving = _moving(log.t, np.abs(log.speed) > slowest, unbroken)
    clean, outliers = {}, {}
    for name, values in columns.items():
        kept, found, grain = values.copy(), 0, grain_of(values)
        if name == "speed":  # a corner of its ramps is none: 6 m/s² in a row
            grain = max(grain, float(np.median(np.diff(log.t))) * 6.0 / OUTLIER)
        for part in unbroken:
            kept[part], count = _without_outliers(log.t[part], values[part], moving[part], grain)
            found += count
        clean[name] = kept if found <= MOST_OUTLIERS * len(values) else values
        outliers[name] = found
    t = log.t - log.t[0]
    for start in log.gaps:
        t[start:] -= t[start] - t[start - 1] - PAUSE
    if log.commands is None:
        # A command holds until the next one; through a gap the one that follows it does.
        times, commands = t, log.steer.copy()
        for start in log.gaps:
            commands[start - 1] = log.steer[start]
    else:
        given, commands = log.commands
        times = _on_clock(given, log.t, t)
    grain = grain_of(commands)  # of a long log the rows have means
    speeds = (t, clean["speed"])
    if whole is not None and len(whole) > len(log):
        own = _without_outliers(whole.t, whole.speed, np.ones(len(whole), np.bool_))[0]
        speeds = (_on_clock(whole.t, log.t, t), own)
    edges, speed, through = _cells(t, log.gaps, speeds)
    acceleration = _acceleration(through, float(edges[1] - edges[0]))
    usual = _usual_speed(t, clean["yaw"], clean["speed"])
    return PreparedLog(
        t=t,
        x=clean["x"],
        y=clean["y"],
        yaw=clean["yaw"],
        sample_speed=clean["speed"],
        edges=edges,
        times=times,
        commands=unrounded(times, commands, grain),
        speed=speed,
        acceleration=acceleration,
        usual_speed=usual,
        unbroken=unbroken,
        outliers=outliers,
        usual_step=float(np.median(np.diff(log.t))),
        speed_noise=max(
            noise_of(clean["speed"][moving]), rounding_of(log.speed), RESOLVED["speed"] * usual
        ),
        least_noise={
            "yaw": max(rounding_of(log.yaw), RESOLVED["yaw"]),
            "steer": grain / np.sqrt(12.0),
            "position": max(rounding_of(log.x), rounding_of(log.y), RESOLVED["position"] * size),
        },
        recorded=commands,
        steer_step=grain,
        moving=moving,
        size=size,
    )


def _moving(t: Array, moving: NDArray[np.bool_], unbroken: list[slice]) -> NDArray[np.bool_]:
    """Say where the car moves; a rest is as long as `REST_TIME` at least."""
    for part in unbroken:
        for rest in stretches(~moving[part]):
            if t[part][rest.stop - 1] - t[part][rest.start] < REST_TIME:
                moving[part][rest] = True
    return moving


def noise_of(values: Array) -> float:
    """Give the standard deviation of the noise of a smooth signal's samples."""
    second = np.abs(np.diff(values, 2))
    return float(1.4826 * np.median(second) / np.sqrt(6.0)) if second.size else 0.0


def _on_clock(times: Array, log: Array, clock: Array) -> Array:
    """Bring times onto the clock without gaps; before and after the log it goes on."""
    after = np.clip(np.searchsorted(log, times), 1, len(log) - 1)
    # In a gap the last ones keep their distance to its end: what the wheels did just before.
    mapped = np.maximum(clock[after] - (log[after] - times), clock[after - 1])
    mapped += np.minimum(times - log[0], 0.0)
    # The earlier ones fall together: the least step keeps their order.
    risen: Array = np.maximum.accumulate(mapped) + 1e-9 * np.arange(len(mapped))
    return risen


def _cells(
    t: Array, gaps: Sequence[int], speeds: tuple[Array, Array]
) -> tuple[Array, Array, Array]:
    """Give equal cells, and the speed of each: 0 in a gap, and steady through it.

    The fall to 0 and the rise from it are no accelerations of the car.
    """
    period = float(np.median(np.diff(t)))
    cell = period / np.ceil(period / CELL) if period > CELL else CELL
    edges = t[0] + cell * np.arange(int(np.ceil((t[-1] - t[0]) / cell)) + 2)
    middle = middles(edges)
    through = np.interp(middle, *speeds)
    driven = through.copy()
    for start in gaps:
        driven[(middle > t[start - 1]) & (middle < t[start])] = 0.0
    return edges, driven, through


def _acceleration(speed: Array, cell: float) -> Array:
    """Give the acceleration along the car, smoothed [m/s²]."""
    from scipy.ndimage import gaussian_filter1d

    smooth: Array = gaussian_filter1d(speed, SMOOTHING / cell, order=1, mode="nearest") / cell
    return np.clip(smooth, -HARDEST, HARDEST)


def _usual_speed(t: Array, yaw: Array, speed: Array) -> float:
    """Give the speed at which the car turns: the mean, weighted by the square of the yaw rate."""
    every = min(max(1, round(0.5 / float(np.median(np.diff(t))))), len(t) - 1)
    turned = np.diff(yaw[::every]) / np.diff(t[::every])
    weight = turned**2 + 1e-12
    middle = np.abs(middles(speed[::every]))
    return max(float(np.sum(weight * middle) / np.sum(weight)), 1e-3)


def _without_outliers(
    t: Array, values: Array, moving: NDArray[np.bool_], grain: float = 0.0
) -> tuple[Array, int]:
    """Replace what stands out from both neighbours' line by that line; how many did.

    Hampel's filter on second differences, by their median size while the car moves.
    """
    if len(values) < 9:
        return values, 0
    scale = moving if moving.sum() >= 9 else np.ones_like(moving)
    share = (t[2:-2] - t[:-4]) / (t[4:] - t[:-4])
    around = values[:-4] + share * (values[4:] - values[:-4])
    sides = np.sort(np.stack((values[:-4], values[1:-3], values[3:-1], values[4:])), axis=0)
    near, apart = 0.5 * (sides[1] + sides[2]), sides[2] - sides[1]
    # The line through the neighbours is pulled by an outlier among them, their median is not.
    from_line, from_median = values[2:-2] - around, values[2:-2] - near
    off = np.where(np.abs(from_line) < np.abs(from_median), from_line, from_median)
    spread = 1.4826 * float(np.median(np.abs(off[scale[2:-2]])))
    step = float(np.median(np.abs(np.diff(values)[scale[1:]])))
    most = np.maximum(OUTLIER * max(spread, step, grain, 1e-9), apart)  # a fast turn is none
    found = 2 + np.flatnonzero(np.abs(off) > most)
    if not found.size:
        return values, 0
    kept = np.delete(np.arange(len(values)), found)
    return np.interp(t, t[kept], values[kept]), int(found.size)
