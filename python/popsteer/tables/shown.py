"""What a column without a name shows itself to be, against the waypoints beside it.

Each function is a test of one hypothesis: it compares the column with what the waypoints say, and
gives the evidence or None. What could be two things is none.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer.tables.quantities import UNITS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_AGREE = 0.8  # share of the waypoints at which a column agrees: recordings have their standstills
_FASTEST = 12.0  # m/s² to the side: a speed in km/h means more
_HEADING = 0.15  # rad between a heading and the chord of its neighbours, which noise turns
_FITS = 0.05  # relative difference of a rate or a ratio
_LEAST = 5  # waypoints, before anything is shown
_RATES = np.array([1, 2, 4, 5, 10, 15, 20, 25, 30, 40, 50, 60, 100, 200])  # Hz, of recorders
_TOP_SPEED = 100.0  # m/s
_NEAR = 0.35  # rad that a recorded heading may lag behind a lap, and still be one
SPEEDS = ("km/h", "mph", "kn", "cm/s", "mm/s")  # units of speeds that motion tells apart
TURN = 0.3  # rad that the path has to turn before a constant offset is told from a heading


class Along(NamedTuple):
    """The waypoints as evidence: where they move, by how much, and in which direction."""

    moves: NDArray[np.int64]
    """Waypoints that do not repeat the one before."""
    s: Floats
    """Arc length at those [m]."""
    heading: Floats
    """Direction of the chord of their neighbours [rad], unwrapped."""
    points: Floats
    """Their positions [m], shape (N, 2)."""

    @property
    def turn(self) -> float:
        """How far the direction reaches [rad]."""
        return float(np.ptp(self.heading)) if len(self.heading) else 0.0


def along(xy: Floats, reach: float = 0.0) -> Along:
    """Measure waypoints, without those that stand: less than `reach` [m] from the last that counts.

    By default a third of the usual step: noise at rest has no direction.
    """
    steps = np.hypot(*np.diff(xy, axis=0).T)
    if reach <= 0.0 and (steps > 0.0).any():
        reach = float(np.median(steps[steps > 0.0])) / 3.0
    x, y = xy[0].tolist()
    moves = [0]
    for k, (here_x, here_y) in enumerate(xy.tolist()):
        if abs(here_x - x) + abs(here_y - y) >= reach and math.hypot(here_x - x, here_y - y) > 0.0:
            x, y = here_x, here_y
            moves.append(k)
    there = xy[moves]
    s = np.concatenate(([0.0], np.cumsum(steps)))[moves]
    if len(there) < 2:
        return Along(np.array(moves), s, np.zeros(len(there)), there)
    ends = np.vstack((2.0 * there[0] - there[1], there, 2.0 * there[-1] - there[-2]))
    chord = ends[2:] - ends[:-2]
    return Along(np.array(moves), s, np.unwrap(np.arctan2(chord[:, 1], chord[:, 0])), there)


_FRAMES = (
    ("", 1.0, 0.0),
    ("from north, clockwise", -1.0, np.pi / 2),
    ("from y, counter-clockwise", 1.0, np.pi / 2),
    ("clockwise", -1.0, 0.0),
)


class Heading(NamedTuple):
    """A column as a heading: its unit and frame in words, and as popsteer has it [rad]."""

    unit: str
    frame: str
    yaw: Floats
    backwards: NDArray[np.bool_]
    """Where the vehicle looks against the waypoints."""

    def __str__(self) -> str:
        return ", ".join(filter(None, (self.unit, self.frame)))


def ways(xy: Floats) -> Iterator[Along]:
    """Measure waypoints three times: noise hides the direction over a step, not over a part."""
    reach = float(np.hypot(*np.ptp(xy, axis=0)))
    return (along(xy, share * reach) for share in (0.0, 0.01, 0.03))


def heading(
    measured: Iterable[Along],
    values: Floats,
    units: tuple[str, ...] = ("rad", "deg"),
    *,
    both_ways: bool = False,
    most: float = _HEADING,
) -> Heading | None:
    """Find the unit and the frame in which a column is the direction of waypoints, within `most`.

    `measured` are these, as by `ways`.
    With `both_ways` it may also look against the waypoints, where they are driven backwards.
    """
    found = (_heading(way, values, units, both_ways=both_ways, most=most) for way in measured)
    return next((each for each in found if each is not None), None)


def is_velocity(xy: Floats, vx: Floats, vy: Floats, yaw: Floats | None = None) -> bool:
    """Whether two columns are the velocity in the waypoints' plane, rather than the vehicle's own.

    It points where the waypoints go, and would not if it were measured from a `yaw` [rad]. Along x
    both would, and to and fro there it is the vehicle's own, which may be driven backwards.
    """
    for way in ways(xy):
        pointed = np.arctan2(vy, vx)[way.moves]
        frames = (0.0 * pointed, *(() if yaw is None else (yaw[way.moves],)))
        off = [np.quantile(np.abs(_wrapped(pointed + k - way.heading)), _AGREE) for k in frames]
        if off[0] <= _HEADING and len(way.moves) >= _LEAST:
            to_and_fro = float(np.quantile(np.abs(np.sin(way.heading)), _AGREE)) <= _HEADING
            to_and_fro &= bool((vx > 0.0).any() and (vx < 0.0).any())
            return not (to_and_fro or any(each <= _HEADING for each in off[1:]))
    return False


def is_followed(xy: Floats, values: Floats, *, degrees: bool) -> bool:
    """Whether a column that is near the direction of waypoints turns as they do.

    Where one coordinate is far larger than the other, any small number is near it.
    """
    way = along(xy)
    yaw = np.unwrap((np.pi / 180.0 if degrees else 1.0) * values[way.moves])
    return abs(_correlation(way.heading, yaw)) > _AGREE


def is_near_heading(measured: Sequence[Along], values: Floats) -> bool:
    """Whether a column is a heading, although farther from the waypoints' than one to drive by."""
    return measured[0].turn >= np.pi and heading(measured, values, most=_NEAR) is not None


def _heading(
    way: Along, values: Floats, units: tuple[str, ...], *, both_ways: bool, most: float
) -> Heading | None:
    if len(way.moves) < (2 if both_ways else _LEAST):
        return None
    if not both_ways and (way.turn < TURN or np.ptp(values) == 0.0):
        return None  # beside a straight line any constant may be near its direction
    found = []
    for unit in units:
        if unit == "deg" and way.turn < TURN and np.max(np.abs(values)) <= 2.0 * np.pi:
            continue  # few degrees agree with any straight line along x
        scale = np.pi / 180.0 if unit == "deg" else 1.0
        for frame, sign, offset in _FRAMES:
            yaw = sign * scale * values + offset
            off = np.abs(_wrapped(yaw[way.moves] - way.heading))
            against = off > np.pi / 2
            off = np.where(against, np.pi - off, off) if both_ways else off
            error = float(np.quantile(off, _AGREE))
            share = float(against.mean()) if both_ways else 0.0
            found.append((error + 0.1 * share, error, Heading(unit, frame, yaw, against)))
    found.sort(key=lambda each: each[0])
    best, error, chosen = found[0]
    rivals = (
        score
        for score, _, other in found[1:]
        if np.quantile(np.abs(_wrapped(other.yaw - chosen.yaw)), _AGREE) > _HEADING
    )
    if chosen.frame and chosen.backwards.mean() > _AGREE:
        return None  # in a frame of its own, and against the waypoints: it shows nothing
    if error > most or (way.turn >= TURN and next(rivals, np.inf) < 2.0 * best and best > 0.02):
        return None
    backwards = np.zeros(len(values), dtype=np.bool_)
    if both_ways:
        steps = np.diff(way.points, axis=0)
        ahead = np.arctan2(steps[:, 1], steps[:, 0])
        off = np.abs(_wrapped(chosen.yaw[way.moves[:-1]] - ahead))
        if _is_reversing(off):
            latest = np.searchsorted(way.moves[:-1], np.arange(len(values)), "right") - 1
            backwards = (off > np.pi / 2)[latest]
    return chosen._replace(backwards=backwards)


def to_yaw(turned: Heading) -> tuple[float, float]:
    """Give factor and offset [rad] that turn a column into popsteer's yaw."""
    sign, offset = next((sign, offset) for name, sign, offset in _FRAMES if name == turned.frame)
    return sign * (np.pi / 180.0 if turned.unit == "deg" else 1.0), offset


def _is_reversing(off: Floats) -> bool:
    """Whether a heading looks clearly against the waypoints, and for some of them in a row."""
    against = off > np.pi / 2
    ends = np.flatnonzero(np.diff(against)) + 1
    runs = np.diff(np.concatenate(([0], ends, [len(off)])))
    clear = np.minimum(off, np.pi - off) < 3.0 * _HEADING
    return bool(against.any() and runs.min() >= _LEAST and clear[against].mean() > _AGREE)


def _wrapped(angle: Floats) -> Floats:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def is_arc(way: Along, values: Floats) -> bool:
    """Whether a column is the arc length along the waypoints."""
    here, gone = values[way.moves] - values[0], way.s
    return _agrees(np.diff(here), np.diff(gone)) and abs(here[-1] - gone[-1]) <= _FITS * gone[-1]


def is_count(values: Floats) -> bool:
    """Whether a column counts the rows."""
    return len(values) >= _LEAST and bool(np.all(np.diff(values) == 1.0)) and values[0] in (0, 1)


def is_time(values: Floats) -> bool:
    """Whether a column rises with every row as a clock does: evenly, or from the epoch on."""
    steps = np.diff(values)
    if len(steps) < _LEAST - 1 or not np.all(steps >= 0.0) or values[0] == values[-1]:
        return False
    return bool(values[0] > 1e8 or np.quantile(steps, 0.9) <= 3.0 * np.median(steps) > 0.0)


def is_rate(way: Along, values: Floats, time: Floats) -> bool:
    """Whether a column is the speed at which the waypoints are passed at some times."""
    here = np.abs(values[way.moves])
    steps = np.diff(time[way.moves])
    if not np.all(steps > 0.0):
        return False
    rate, mean = np.diff(way.s) / steps, 0.5 * (here[1:] + here[:-1])
    # A constant is soon near another, so that it has to be the same.
    within = 0.02 if np.ptp(mean) > 0.1 * np.max(mean) else 0.005
    return _agrees(rate, mean) and bool(abs(np.median(mean) / np.median(rate) - 1.0) < within)


def ratio(t: Floats, x: Floats, y: Floats, speed: Floats) -> float | None:
    """Give how many times as far speed says as positions move; None where nothing shows it.

    It is the median over stretches that are straight, of the longest before they bend: noise hides
    the motion over short ones.
    """
    fast = np.abs(speed)
    said = np.concatenate(([0.0], np.cumsum(0.5 * (fast[1:] + fast[:-1]) * np.diff(t))))
    found, half = None, 1
    while 10 * half < len(t):
        ends = np.arange(0, len(t) - 2 * half, 2 * half)
        first, second = (
            np.hypot(*(each[ends + k * half] - each[ends + (k - 1) * half] for each in (x, y)))
            for k in (1, 2)
        )
        whole = np.hypot(x[ends + 2 * half] - x[ends], y[ends + 2 * half] - y[ends])
        gone = said[ends + 2 * half] - said[ends]
        moving = (whole > 0.0) & (gone > 0.3 * np.median(gone))
        straight = moving & (whole >= 0.97 * (first + second))
        if moving.sum() >= 5 and straight.sum() >= 0.8 * moving.sum():
            arcs = (4.0 * (first + second) - whole) / 3.0  # of chords, by extrapolation
            found = float(np.median(gone[straight] / arcs[straight]))
        elif found is not None:
            break
        half *= 2
    return found


def unit_of_speed(size: float, within: float = 0.04) -> str | None:
    """Say in what unit a speed is that says so many times as far as positions move, but m/s."""
    metres = ((unit, size * UNITS["speed"][unit]) for unit in SPEEDS)
    return next((unit for unit, each in metres if abs(each - 1.0) < within), None)


def is_recorded_speed(way: Along, values: Floats) -> bool:
    """Whether waypoints lie as far apart as a recorder with an even period leaves them.

    The distances vary by a tenth at least, and are proportional to the column; by a period that
    recorders have, 1 Hz to 200 Hz, which in other units of speed is none.
    """
    here, steps = values[way.moves], np.diff(way.s)
    mean = 0.5 * (here[1:] + here[:-1])
    if len(steps) < 20 or np.std(steps) < 0.1 * np.mean(steps) or not (mean > 0.0).all():
        return False
    rate = float(np.median(mean / steps))
    return (
        bool(np.abs(_RATES / rate - 1.0).min() < 0.015)
        and float(here.max()) < _TOP_SPEED
        and _agrees(steps * rate, mean)
    )


def is_planned_speed(way: Along, values: Floats) -> bool:
    """Whether a column is slow where the waypoints bend, as a speed has to be.

    Its ranks correlate with those of the curvature by -0.5 or less (28 public racelines: -0.53 to
    -0.94; 57 track widths and heights: -0.42 to 0.37), and the lateral acceleration that it means
    keeps to a limit: its 99 % quantile is at most 1.7 times the one of 90 % (1.03 to 1.61; of 1467
    smooth random columns 8 pass both); or by -0.4, with 1.1 times (none). Where a tenth is at the
    top to the bit, as at a top speed, and it is half as fast elsewhere, 1.2 times is enough. A
    throttle is low in bends, too, so a speed has to exceed 1.5; it has to be drivable (12 m/s²; in
    km/h it would seem 13 times as much), and not to rise or fall all the way, as a time does.
    """
    here = values[way.moves]
    slow, fast = (float(each) for each in np.quantile(here, (0.01, 1.0)))
    if len(here) < 30 or here.min() < 0.0 or fast < max(1.5, 1.3 * slow) or way.turn < 1.0:
        return False
    most, usual, ranks = _in_bends(way, here)
    rises = np.sign(np.diff(here))
    keeps = ranks <= -0.4 and most <= (1.7 if ranks <= -0.5 else 1.1) * usual
    at_top = float(np.mean(here == fast)) >= 0.1 and fast >= 2.0 * slow and most <= 1.2 * usual
    return (keeps or at_top) and most <= _FASTEST and bool(np.ptp(rises) == 2.0)


def _in_bends(way: Along, here: Floats) -> tuple[float, float, float]:
    """Give lateral accelerations that a speed would mean, and how its ranks follow the bends.

    The 99 % and the 90 % quantile [m/s²], and the correlation of the ranks of speed and curvature.
    """
    window = max(way.s[-1] / 60.0, 3.0 * float(np.median(np.diff(way.s))))
    middle = 0.5 * (way.s[1:] + way.s[:-1])
    steps = np.diff(way.points, axis=0)
    turned = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    ahead, behind = (np.interp(way.s + k * window, middle, turned) for k in (0.5, -0.5))
    bend = np.abs(ahead - behind) / window
    most, usual = (float(each) for each in np.quantile(here * here * bend, (0.99, 0.9)))
    first, second = (np.argsort(np.argsort(each, kind="stable")) for each in (here, bend))
    return most, usual, _correlation(first.astype(np.float64), second.astype(np.float64))


def are_widths(way: Along, first: Floats, second: Floats, *, alone: bool) -> bool:
    """Whether two columns are how far either side of a road is.

    Both are the same, and are no whole numbers where they never change. Or they are `alone` those
    of a line in the middle: beside a lap, alike within a tenth in their medians (public ones: 0.06
    and less), and neither is slow in bends as a speed of a lap is (ranks of -0.42 and more; lateral
    accelerations whose 99 % quantile is 1.6 times that of 90 % and more).
    """
    if np.array_equal(first, second):
        return bool(np.ptp(first) > 0.0 or first[0] % 1.0 != 0.0)
    if not alone or len(way.s) < 30 or way.turn < np.pi or min(first.min(), second.min()) <= 0.0:
        return False
    gap = float(np.hypot(*(way.points[-1] - way.points[0])))
    one, other = float(np.median(first)), float(np.median(second))
    varied = min(np.std(first) / one, np.std(second) / other) > 0.03
    if gap > 3.0 * float(np.median(np.diff(way.s))) or not 0.9 < one / other < 1.1 or not varied:
        return False
    bends = (_in_bends(way, each[way.moves]) for each in (first, second))
    return all(most > 1.5 * usual and ranks > -0.45 for most, usual, ranks in bends)


def is_curvature(way: Along, values: Floats) -> bool:
    """Whether a column is the curvature of the waypoints, who turn by half a radian at least."""
    if len(way.s) < _LEAST or way.turn < 0.5:
        return False
    here = values[way.moves]
    turned = np.concatenate(([0.0], np.cumsum(0.5 * (here[1:] + here[:-1]) * np.diff(way.s))))
    return bool(np.max(np.abs(turned - way.heading + way.heading[0])) <= 0.1 * way.turn + _HEADING)


def is_acceleration(way: Along, values: Floats, speed: Floats) -> bool:
    """Whether a column is the acceleration that another has as a speed: a = d(v²/2)/ds."""
    here, fast = values[way.moves], speed[way.moves]
    if len(here) < _LEAST or np.ptp(fast) < 0.1 * np.max(np.abs(fast)):
        return False
    gained = np.diff(0.5 * fast * fast) / np.diff(way.s)
    mean = 0.5 * (here[1:] + here[:-1])
    if np.ptp(mean) == 0.0 or np.ptp(gained) == 0.0:
        return False
    alike = _correlation(gained, mean) > 0.9
    return alike and bool(0.7 < np.std(mean) / np.std(gained) < 1.4)


def is_direction(way: Along, first: Floats, second: Floats) -> bool:
    """Whether two columns are a unit vector along the waypoints, or to their side."""
    off = _wrapped(np.arctan2(second, first)[way.moves] - way.heading)
    turned = np.abs(_wrapped(2.0 * off))  # 0 along and against, pi to either side
    return bool(np.all(np.abs(first * first + second * second - 1.0) < 0.01)) and bool(
        min(np.quantile(turned, _AGREE), np.quantile(np.pi - turned, _AGREE)) < 4.0 * _HEADING
    )


def is_curve(xy: Floats, *, closed: bool) -> bool:
    """Whether coarse waypoints lie on a smooth curve, by leave-one-out cross-validation.

    Where they turn by 11 degrees and more, the cubic through two neighbours on either side has to
    predict a waypoint three times as well as their chord (public and made-up hairpins: 0.1 to 0.35
    of its error; corners 0.67, noise from 0.8 on). Fewer than nine a circle are corners.
    """
    there = along(xy).points
    if closed:
        there = np.vstack((there[-2:], there, there[:2]))
    steps = np.diff(there, axis=0)
    lengths = np.hypot(*steps.T)
    turns = np.abs(_wrapped(np.diff(np.arctan2(steps[:, 1], steps[:, 0]))))[1:-1]
    if len(turns) < _LEAST or turns.max() > 0.75 or np.count_nonzero(turns > 0.2) < _LEAST - 1:
        return False
    s = np.concatenate(([0.0], np.cumsum(lengths)))
    here = np.arange(2, len(there) - 2)

    def off(*beside: int) -> float:
        """Lagrange's polynomial through neighbours: how far it is off, over all coarse ones."""
        predicted = np.zeros((len(here), 2))
        for j in beside:
            others = [k for k in beside if k != j]
            weights = [(s[here] - s[here + k]) / (s[here + j] - s[here + k]) for k in others]
            predicted += np.prod(weights, axis=0)[:, None] * there[here + j]
        return float(np.sum((there[here] - predicted)[turns > 0.2] ** 2))

    return off(-2, -1, 1, 2) <= 0.35**2 * off(-1, 1)


def is_degrees(first: Floats, second: Floats) -> bool:
    """Whether two columns are latitude and longitude: a road of a few hundredths of a degree.

    So is a robot that stands near the origin; but no road is where both are below 5.
    """
    both = np.column_stack((first, second))
    reach, far = np.ptp(both, axis=0).max(), np.abs(both).max()
    steps = np.hypot(*np.diff(both, axis=0).T)
    usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    return bool(0.0 < usual < 1e-3 and reach < 1.0 and reach < 0.02 * far and 5.0 < far <= 360.0)


def _agrees(one: Floats, other: Floats) -> bool:
    """Whether two series are alike, sum and most of their values."""
    if len(one) < _LEAST - 1 or not len(other):
        return False
    scale = float(np.median(np.abs(other)))
    off = np.abs(one - other) <= _FITS * np.maximum(np.abs(other), scale)
    return scale > 0.0 and bool(off.mean() >= _AGREE)


def _correlation(one: Floats, other: Floats) -> float:
    """Pearson's coefficient; NaN where one of them is constant."""
    one, other = one - one.mean(), other - other.mean()
    return float(one @ other / np.sqrt((one @ one) * (other @ other)))
