"""The fastest speeds along a path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer._core import (
    Path,
    Vehicle,
    _path_curvature,
    _path_cusps,
    _plan_speeds,
    _speed_defaults,
)
from popsteer.errors import ConfigError, PathError, in_range
from popsteer.planning.limits import SpeedLimits, table_of
from popsteer.planning.profile import LIMITS, SpeedProfile, spacing_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

_LEAST = 1e-3
"""The least speed limit that is no stop [m/s]."""


def speed_profile(
    path: Path,
    limits: SpeedLimits | None = None,
    vehicle: Vehicle | None = None,
    *,
    speed_limits: ArrayLike | None = None,
    curvature: ArrayLike | None = None,
) -> SpeedProfile:
    """Find the fastest speeds along a path that vehicle and limits allow.

    At a waypoint with the curvature κ, the speed v keeps the top speed and the speed limit there,
    and v² κ keeps the lateral acceleration. The angle of the wheels is that of the vehicle's chain,
    tan(wheel) = κ (turning_wheelbase + understeer v²); it keeps `max_steer`, and over each segment
    `max_steer_rate`. Between waypoints the acceleration is constant; it keeps the limits of driving
    and braking and the friction ellipse at both ends of the segment.

    An open path begins at `start_speed` and ends at `end_speed` or slower. Where the path changes
    between forwards and backwards the vehicle stops. A closed path has the same speeds in each lap.

    Parameters
    ----------
    path : Path
        What is to be driven; its own speeds tell only where it is driven backwards.
    limits : SpeedLimits, optional
        The limits; the vehicle's by default.
    vehicle : Vehicle, optional
        What drives, ``Vehicle()`` by default.
    speed_limits : float or array_like, optional
        Speed limits along the path, one for each waypoint or one for all [m/s]; the vehicle stops
        at a waypoint where it is 0.
    curvature : (N,) array_like, optional
        Curvature at each waypoint [1/m] where it is known, as that of a spline; by default it is
        taken from the smoothed waypoints, which flattens sharp bends (see `planning.curvature`).

    Returns
    -------
    SpeedProfile
        The path with the speeds, what limits them where, and the time that it takes.

    Raises
    ------
    ConfigError
        Limits contradict each other; names the one that cannot hold.
    PathError
        A section of the path has no waypoint between its ends: no room to start and stop; or a
        speed limit is out of its range, or a curvature is not finite: names the waypoint.

    Notes
    -----
    The speeds come from a pass
    forward and one backward, as in Heilmeier et al., *Minimum curvature trajectory planning and
    control for an autonomous race car*, Vehicle System Dynamics 58, 2020.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    >>> profile = speed_profile(path, SpeedLimits(max_acceleration=2.0, max_deceleration=2.0))
    >>> profile.speed[[0, 1, 50, 100]].round(2).tolist()
    [0.0, 2.0, 14.14, 0.0]
    >>> round(profile.time, 2)
    14.14
    """
    vehicle = Vehicle() if vehicle is None else vehicle
    limits = (SpeedLimits() if limits is None else limits).resolved(vehicle)
    if curvature is None:
        numbers: Any = limits
        bends = sharp = _path_curvature(path, numbers.smoothing_length)
        if vehicle.steers_at_rest:
            sharp = _path_curvature(path, _speed_defaults["sharp"] * vehicle.wheelbase)
    else:
        bends = sharp = _given(curvature)
        if len(bends) != len(path):
            raise PathError(f"curvature must have shape ({len(path)},), got {bends.shape}")
    spacing = spacing_of(path)
    cusps = _path_cusps(path)
    bounds = _bounds(speed_limits, len(path))
    if bounds is not None and (bounds == 0.0).any():
        cusps = cusps | (bounds == 0.0)
        bounds = np.maximum(bounds, _LEAST)
    ends = (None, None) if path.closed else (limits.start_speed, limits.end_speed)
    speed, by = _plan(
        (bends, sharp), spacing, limits, vehicle, path.closed, cusps, (bounds, path.grade), ends
    )
    if not path.closed and speed[0] < limits.start_speed - 1e-9:
        allowed = f"at most {speed[0]:.3f}, which is what the limit {LIMITS[by[0]]!r} allows there"
        raise ConfigError("start_speed", limits.start_speed, allowed)
    _check_sections(speed, spacing)
    if limits.max_jerk is not None:
        from popsteer.planning.jerk import within_jerk

        speed, by = within_jerk(path, speed, by, bends, limits, vehicle)
    return SpeedProfile.of(path, speed, bends, by, limits, vehicle)


def speeds_along(
    curvature: ArrayLike,
    spacing: ArrayLike,
    limits: SpeedLimits | None = None,
    vehicle: Vehicle | None = None,
    *,
    closed: bool = False,
    start_speed: float | None = None,
    end_speed: float | None = None,
) -> Floats:
    """Find the fastest speeds where the curvature is known.

    Parameters
    ----------
    curvature : (N,) array_like
        Curvature at each waypoint [1/m].
    spacing : float or array_like
        Length of each segment [m], (N - 1,) of an open path, (N,) of a closed one; or one for all.
    limits : SpeedLimits, optional
        The limits; those of the speeds at the ends, of the jerk and the smoothing are not used
        here.
    vehicle : Vehicle, optional
        What drives, ``Vehicle()`` by default.
    closed : bool, default False
        Whether the last waypoint leads back to the first.
    start_speed, end_speed : float, optional
        Largest speeds at the ends of an open path [m/s]; no limit by default.

    Returns
    -------
    (N,) ndarray
        Speed at each waypoint [m/s].

    Raises
    ------
    ConfigError
        A limit is out of its range.
    PathError
        The lengths of the arrays do not match, or a number is not finite.

    Examples
    --------
    >>> limits = SpeedLimits(max_lateral_acceleration=4.0)
    >>> speeds_along([0.04] * 4, 1.0, limits, closed=True).tolist()
    [10.0, 10.0, 10.0, 10.0]
    """
    vehicle = Vehicle() if vehicle is None else vehicle
    limits = (SpeedLimits() if limits is None else limits).resolved(vehicle)
    bends = _given(curvature)
    count = bends.size if closed else bends.size - 1
    lengths = np.asarray(spacing, dtype=np.float64)
    lengths = np.full(count, lengths) if lengths.ndim == 0 else np.ascontiguousarray(lengths)
    if lengths.shape != (count,):
        raise PathError(f"spacing must have shape ({count},), got {lengths.shape}")
    if (broken := np.flatnonzero(~(np.isfinite(lengths) & (lengths > 0.0)))).size:
        raise PathError(f"spacing after waypoint {broken[0]} must be above 0", int(broken[0]))
    ends = (start_speed, end_speed)
    return _plan((bends, bends), lengths, limits, vehicle, closed, None, (None, None), ends)[0]


def _given(curvature: ArrayLike) -> Floats:
    bends = np.ascontiguousarray(curvature, dtype=np.float64)
    if bends.ndim != 1 or bends.size < 2:
        raise PathError(f"curvature must have shape (N,) with N >= 2, got {bends.shape}")
    if (broken := np.flatnonzero(~np.isfinite(bends))).size:
        raise PathError(f"curvature of waypoint {broken[0]} is not finite", int(broken[0]))
    return bends


def curvature(path: Path, smoothing_length: float | None = None) -> Floats:
    """Take the curvature of a path from its waypoints, which may be noisy.

    The waypoints are smoothed first by penalised least squares: those q are taken that minimise
    Σ w |q - p|² + length⁶ ∫ |q'''|² ds, Whittaker's graduation with a penalty on the change of the
    curvature. A wave of length 2π L is kept up to the factor 1 / (1 + (length / L)⁶), so a bend of
    twice the smoothing length as radius is flattened by 2 %. Noise of 2 cm every metre leaves
    0.0008 /m at a length of 2 m.

    Parameters
    ----------
    path : Path
        The path. Where it changes its direction, the curvature is that of what begins there.
    smoothing_length : float, optional
        The length [m]; 2 m by default.

    Returns
    -------
    (N,) ndarray
        Curvature at each waypoint [1/m], positive to the left.

    Raises
    ------
    ConfigError
        The length is not in [0.001, 1000].

    References
    ----------
    E. T. Whittaker, *On a New Method of Graduation*, Proceedings of the Edinburgh Mathematical
    Society 41, 1923; P. H. C. Eilers, *A Perfect Smoother*, Analytical Chemistry 75, 2003.

    Examples
    --------
    >>> import math, popsteer
    >>> angles = [0.1 * k for k in range(20)]
    >>> bend = popsteer.Path([(20 * math.sin(a), 20 - 20 * math.cos(a)) for a in angles])
    >>> bool(abs(curvature(bend)[10] - 0.05) < 1e-4)
    True
    """
    return _path_curvature(path, 2.0 if smoothing_length is None else smoothing_length)


def _plan(
    bends: tuple[Floats, Floats],
    spacing: Floats,
    limits: Any,  # noqa: ANN401 - a SpeedLimits with all of them filled in
    vehicle: Vehicle,
    closed: bool,  # noqa: FBT001 - all are by place
    cusps: NDArray[np.bool_] | None,
    along: tuple[Floats | None, Floats | None],
    ends: tuple[float | None, float | None],
) -> tuple[Floats, NDArray[np.uint8]]:
    return _plan_speeds(
        bends[0],
        spacing,
        sharp=bends[1],
        closed=closed,
        cusps=cusps,
        speed_limits=along[0],
        grade=along[1],
        start_speed=ends[0],
        end_speed=ends[1],
        max_speed=limits.max_speed,
        max_lateral_acceleration=limits.max_lateral_acceleration,
        acceleration=table_of(limits.max_acceleration),
        deceleration=table_of(limits.max_deceleration),
        longitudinal_grip=limits.longitudinal_grip,
        exponent=limits.exponent,
        vehicle=vehicle,
    )


def _bounds(speed_limits: ArrayLike | None, count: int) -> Floats | None:
    """Settle the speed limits along the path."""
    if speed_limits is None:
        return None
    bounds = np.asarray(speed_limits, dtype=np.float64)
    if bounds.ndim == 0:
        bounds = np.full(count, bounds)
    if bounds.shape != (count,):
        raise PathError.length_mismatch("speed_limits", bounds.size, count)
    wrong = np.flatnonzero(~((bounds == 0.0) | (bounds >= _LEAST) & (bounds <= 1e4)))
    if wrong.size:
        index = int(wrong[0])
        value = float(bounds[index])
        raise PathError.out_of_range("speed_limits", index, value, in_range(_LEAST, 1e4))
    return np.ascontiguousarray(bounds)


def _check_sections(speed: Floats, spacing: Floats) -> None:
    """Refuse a segment between two stops, along which a vehicle would stand for ever."""
    after = np.roll(speed, -1)[: spacing.size]
    standing = np.flatnonzero((speed[: spacing.size] <= 0.0) & (after <= 0.0))
    if standing.size:
        first = int(standing[0])
        raise PathError(
            f"between the stops at waypoints {first} and {(first + 1) % speed.size} there must be"
            " a waypoint: the path is too short to start and stop",
            first,
        )
