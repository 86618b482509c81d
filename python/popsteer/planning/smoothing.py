"""From recorded waypoints to a path with a continuous curvature."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer._core import Path
from popsteer.errors import PathError
from popsteer.extras import require
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

# Waypoints are averaged over this many tolerances before their offset counts. Shorter: noise is
# taken for the line; longer: bends of that length may be cut.
_WINDOW = 40.0
# What of the tolerance the spline may use, and what is for the noise that the mean still has, taken
# for so many standard deviations. The rest is for what lies between the waypoints.
_SHARE = 0.3
_AVERAGED = 0.2
_AVERAGED_END = 0.6
_MANY = 3.5
# The parabola that leads on at an end is through so many tolerances. Shorter: noise counts; longer:
# a bend that begins there is cut.
_END = 56.0
# What the parabola may leave beyond the noise, in tolerances, and how much shorter it is made else.
_BENT, _SHORTER = 0.1, 0.8
# How far on a waypoint has to lead, in tolerances, for it to count.
_ON = 0.5
_LEAST = 6
_HALVINGS = 24


def smooth(
    path: Path | ArrayLike,
    tolerance: float,
    *,
    closed: bool = False,
    spacing: float | None = None,
) -> Path:
    """Make a path with a continuous curvature of recorded waypoints.

    Waypoints that run back are left out: the measured position of a standing vehicle wanders. The
    others are fitted by a cubic smoothing spline for x and for y over the distance along them,
    which bridges gaps. It is the smoothest one, with the least ∫ |q''|² ds, that stays within the
    tolerance of the waypoints' means over 40 tolerances of path length, so noise does not count.

    Parameters
    ----------
    path : Path or array_like
        The waypoints in the order in which they were driven, or an (N, 2) array of them [m]; those
        of a `Path` tell where it is driven backwards, and each section is smoothed by itself.
    tolerance : float
        How far the path may be from the recorded line [m].
    closed : bool, default False
        Whether the last waypoint of an array leads back to the first.
    spacing : float, optional
        Distance of the new waypoints [m]; by default that of the old ones, but at least two
        tolerances.

    Returns
    -------
    Path
        The new waypoints, without speeds.

    Raises
    ------
    ConfigError
        The tolerance is not in [0.001, 10], or the spacing not in [0.01, 100].
    PathError
        Fewer than six waypoints are left of a section, or they run back farther than noise does.
    PopsteerError
        The extra ``lab`` is not installed.

    Notes
    -----
    The spline is `scipy.interpolate.make_smoothing_spline` (P. Craven and G. Wahba, *Smoothing
    noisy data with spline functions*, Numerische Mathematik 31, 1979); the weight of its roughness
    is found by bisection.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> recorded = np.column_stack((np.arange(0.0, 40.0, 0.2), np.zeros(200)))
    >>> recorded += rng.normal(0.0, 0.05, recorded.shape)
    >>> path = smooth(recorded, 0.1)
    >>> bool(abs(path.y).max() < 0.1)
    True
    """
    check_in_range("tolerance", tolerance, 1e-3, 10.0)
    if spacing is not None:
        check_in_range("spacing", spacing, 0.01, 100.0)
    require("smoothing", "lab", "scipy")
    if not isinstance(path, Path):
        xy = np.asarray(path, dtype=np.float64)
        if xy.ndim != 2 or xy.shape[1] != 2 or not np.isfinite(xy).all():
            raise PathError(f"waypoints must be finite and of shape (N, 2), got {xy.shape}")
        return Path(_smoothed(xy, tolerance, spacing, closed=closed), closed=closed)
    xy = np.column_stack((path.x, path.y))
    reverse = path.reverse
    if reverse is None:
        made = _smoothed(xy, tolerance, spacing, closed=path.closed)
        return Path(made, closed=path.closed)
    if path.closed:
        raise PathError("a closed path that is driven in both directions is not smoothed")
    pieces: list[Floats] = []
    backwards: list[bool] = []
    ends = [0, *(np.flatnonzero(reverse[1:-1] != reverse[:-2]) + 1).tolist(), len(xy) - 1]
    for first, last in pairwise(ends):
        piece = _smoothed(xy[first : last + 1], tolerance, spacing, closed=False, first=first)
        if pieces:
            piece = piece[1:]  # one cusp for both sections
            backwards[-1] = bool(reverse[first])
        pieces.append(piece)
        backwards += [bool(reverse[first])] * len(piece)
    return Path(np.concatenate(pieces), reverse=backwards)


def _smoothed(
    xy: Floats, tolerance: float, spacing: float | None, *, closed: bool, first: int = 0
) -> Floats:
    """Give the new waypoints of one section."""
    kept = xy[_forward(xy, tolerance, first)]
    if closed:
        # The recording may run on beyond its start.
        kept = _one_lap(kept)
    if len(kept) < _LEAST:
        raise PathError(
            f"from waypoint {first} on {len(kept)} waypoints are left, fewer than {_LEAST}", first
        )
    if closed:
        lap = len(kept)
        kept = np.concatenate((kept, kept, kept))
    along = _distance(kept, tolerance)
    line = _smoothest(along, kept, tolerance)
    begin, end = (along[lap], along[2 * lap]) if closed else (along[0], along[-1])
    if spacing is None:
        spacing = max(float(np.median(np.diff(along))), 2.0 * tolerance)
    fine = np.linspace(begin, end, max(round((end - begin) / spacing) * 8, 32) + 1)
    steps = np.diff(line(fine), axis=0)
    arc = np.append(0.0, np.cumsum(np.sqrt((steps * steps).sum(axis=1))))
    count = max(round(float(arc[-1]) / spacing), 3)
    stations = np.linspace(0.0, arc[-1], count + 1)
    made: Floats = line(np.interp(stations, arc, fine))
    return made[:-1] if closed else made


def _forward(xy: Floats, tolerance: float, first: int) -> list[int]:
    """Choose the waypoints that lead on: those past the ones before, in the direction of these."""
    reach = 10.0 * tolerance
    kept = [0]
    farthest = 0.0
    for index in range(1, len(xy)):
        last = xy[kept[-1]]
        back = len(kept) - 1
        while back > 0 and _length(last - xy[kept[back]]) < reach:
            back -= 1
        heading = last - xy[kept[back]]
        step = xy[index] - last
        size = _length(step)
        if size <= 1e-3 * tolerance:
            continue
        if _length(heading) < 0.5 * reach:
            # At the start there is no direction yet; it is that to what lies a reach ahead.
            ahead = index
            while ahead + 1 < len(xy) and _length(xy[ahead] - xy[0]) < reach:
                ahead += 1
            heading = xy[ahead] - xy[0]
        scale = _length(heading)
        progress = float(step @ heading) / scale if scale > 0.0 else size
        if progress > _ON * tolerance:
            kept.append(index)
            farthest = 0.0
        else:
            farthest = max(farthest, -progress)
            if farthest > 2.0 * reach:
                raise PathError(
                    f"waypoints {first + kept[-1]} to {first + index} run back by"
                    f" {farthest:.2f} m: negative speeds mark what is driven backwards",
                    first + index,
                )
    return kept


def _one_lap(xy: Floats) -> Floats:
    """Leave out what is recorded beyond the start of a lap."""
    begin, heading = xy[0], xy[min(len(xy) - 1, 5)] - xy[0]
    half = len(xy) // 2
    beyond = ((xy[half:] - begin) @ heading > 0.0) & (
        np.sqrt(((xy[half:] - begin) ** 2).sum(axis=1)) < 5.0 * _length(heading)
    )
    return xy[: half + int(np.argmax(beyond))] if beyond.any() else xy


def _distance(xy: Floats, tolerance: float) -> Floats:
    """Measure the distance along the waypoints without that of their noise."""
    half = max(round(5.0 * tolerance / max(_median_step(xy), 1e-9)), 1)
    half = min(half, len(xy) - 1)
    # Reflected at the ends, where a mean of half a window would shorten the line.
    before, after = 2.0 * xy[0] - xy[half:0:-1], 2.0 * xy[-1] - xy[-2 : -half - 2 : -1]
    padded = np.concatenate((before, xy, after))
    sums = np.cumsum(np.concatenate((np.zeros((1, 2)), padded)), axis=0)
    window = 2 * half + 1
    means = (sums[window:] - sums[:-window]) / window
    ahead = np.diff(means, axis=0)
    ahead /= np.maximum(np.sqrt((ahead * ahead).sum(axis=1)), 1e-12)[:, None]
    steps = (np.diff(xy, axis=0) * ahead).sum(axis=1)
    return np.append(0.0, np.cumsum(np.maximum(steps, 0.1 * tolerance)))


def _smoothest(along: Floats, xy: Floats, tolerance: float) -> Any:  # noqa: ANN401 - of scipy
    """Find the smoothest spline within the tolerance."""
    from scipy.interpolate import make_smoothing_spline

    noise = _MANY * _noise(xy)
    # The smoothest spline is straight at its ends, where the driven line need not be.
    before, xy_before = _led_on(along[::-1], xy[::-1], tolerance)
    after, xy_after = _led_on(along, xy, tolerance)
    along = np.concatenate((before[::-1], along, after))
    xy = np.concatenate((xy_before[::-1], xy, xy_after))
    # Shorter windows at the ends, where the line could turn away within a long one.
    to_end = np.minimum(along - along[0], along[-1] - along)
    half = np.clip(to_end, 0.1 * _WINDOW * tolerance, 0.5 * _WINDOW * tolerance)
    low = np.searchsorted(along, along - half)
    high = np.searchsorted(along, along + half, side="right")
    counts = high - low
    at_end = half < 0.5 * _WINDOW * tolerance
    rest = np.where(at_end, _AVERAGED_END, _AVERAGED) * tolerance
    most_offset = _SHARE * tolerance + np.minimum(noise / np.sqrt(counts), rest)
    # From weights that smooth next to nothing to those that leave a straight line. That line is
    # taken off first, which changes no spline: the largest weights would lose its digits.
    least, most = 4.0 * np.log10(0.1 * tolerance), 5.0 * np.log10(along[-1])
    trend = np.polynomial.polynomial.polyfit(along, xy, 1)
    xy = xy - np.polynomial.polynomial.polyval(along, trend).T
    best = make_smoothing_spline(along, xy, lam=10.0**least)
    for _ in range(_HALVINGS):
        middle = 0.5 * (least + most)
        found = make_smoothing_spline(along, xy, lam=10.0**middle)
        sums = np.cumsum(np.concatenate((np.zeros((1, 2)), xy - found(along))), axis=0)
        mean = (sums[high] - sums[low]) / counts[:, None]
        if (np.sqrt((mean * mean).sum(axis=1)) <= most_offset).all():
            best, least = found, middle
        else:
            most = middle
    return lambda place: best(place) + np.polynomial.polynomial.polyval(place, trend).T


def _led_on(along: Floats, xy: Floats, tolerance: float) -> tuple[Floats, Floats]:
    """Lead a line on beyond its last waypoint: places along it, and waypoints there.

    By a parabola through the last `_END` tolerances, or fewer where it fits them badly.
    """
    size, left = _END * tolerance, np.inf
    most = np.hypot(_BENT * tolerance, np.sqrt(2.0) * _noise(xy))
    while left > most:
        back = (along[-1] - along) / size
        last = np.abs(back) <= 1.0
        last[-_LEAST:] = True
        bend = np.polynomial.polynomial.polyfit(back[last], xy[last], 2)
        off = xy[last] - np.polynomial.polynomial.polyval(back[last], bend).T
        left = np.sqrt((off * off).sum() / len(off)) if len(off) > 2 * _LEAST else 0.0
        size *= _SHORTER
    size /= _SHORTER
    step = (along[-1] - along[last][0]) / (np.count_nonzero(last) - 1)
    length = min(_WINDOW * tolerance, size)
    beyond = step * np.arange(1, max(round(length / abs(step)), 2) + 1)
    led: Floats = np.polynomial.polynomial.polyval(-beyond / size, bend).T
    return along[-1] + beyond, led


def _noise(xy: Floats) -> float:
    """Estimate the noise of the waypoints in one direction [m], from their third differences."""
    third = np.diff(xy, n=3, axis=0)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0))


def _median_step(xy: Floats) -> float:
    return float(np.median(np.sqrt((np.diff(xy, axis=0) ** 2).sum(axis=1))))


def _length(vector: Floats) -> float:
    return float(np.sqrt(vector @ vector))
