from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer.errors import ConfigError
from popsteer.tracks import edges
from popsteer.tracks.cusps import CREEP, MANOEUVRING, SLOWING
from tests.helpers import looped

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.tracks.edges import Waypoints

MAKERS = [getattr(edges, name) for name in edges.__all__ if name.islower()]
PARKING = [edges.three_point_turn, edges.parallel_parking]
SPACED = [edges.figure8, edges.out_and_back, edges.spiral, edges.touching, edges.dense_straight]


def _gaps(edge: Waypoints) -> NDArray[np.float64]:
    xy = np.concatenate((edge.xy, edge.xy[:1])) if edge.closed else edge.xy
    return np.asarray(np.hypot(*np.diff(xy, axis=0).T))


def _legs(edge: Waypoints) -> list[NDArray[np.float64]]:
    """Waypoints of each leg, its cusps at both ends."""
    cusps = np.flatnonzero(np.diff(np.sign(edge.speed))) + 1
    ends = [0, *cusps.tolist(), len(edge.xy) - 1]
    return [edge.xy[a : b + 1] for a, b in itertools.pairwise(ends)]


def test_edges_are_all_here() -> None:
    assert len(MAKERS) == 9


@looped("make", MAKERS)
def test_edge_makes_a_path_of_finite_waypoints(make: Callable[[], Waypoints]) -> None:
    edge = make()
    path = popsteer.Path(edge.xy, speed=edge.speed, closed=edge.closed)
    assert np.isfinite(edge.xy).all()
    assert np.isfinite(edge.speed).all()
    assert (edge.speed != 0.0).all()
    assert path.length == pytest.approx(_gaps(edge).sum())


@looped("make", SPACED)
@looped("spacing", [0.01, 0.1, 1.0, 10.0])
def test_edge_has_the_spacing_asked_for(make: Callable[..., Waypoints], spacing: float) -> None:
    gaps = _gaps(make(spacing=spacing))
    assert np.median(gaps) == pytest.approx(spacing, rel=0.09)
    assert gaps.max() <= 1.09 * spacing


@looped("make", [edges.out_and_back, edges.spiral, edges.touching])
def test_edge_at_a_hundred_metres_keeps_points_of_the_line(make: Callable[..., Waypoints]) -> None:
    long = {"turns": 40.0} if make is edges.spiral else {"length": 400.0}
    coarse, fine = make(spacing=100.0, **long), make(spacing=0.1, **long)
    assert 4 <= len(coarse.xy) < 80
    distances = np.hypot(*(coarse.xy[:, None] - fine.xy[None]).transpose(2, 0, 1))
    assert distances.min(axis=1).max() < 0.06


def test_figure8_crosses_itself_at_a_right_angle_in_the_origin() -> None:
    eight = edges.figure8(size=40.0, spacing=0.01)
    near = np.flatnonzero(np.hypot(*eight.xy.T) < 0.006)
    first, second = near[0], near[-1]
    assert second - first > len(eight.xy) // 3
    ways = eight.xy[[first + 1, second + 1]] - eight.xy[[first, second]]
    assert abs(ways[0] @ ways[1]) < 1e-3 * 0.01**2


def test_out_and_back_lies_half_a_metre_apart() -> None:
    edge = edges.out_and_back(offset=0.5, length=60.0, spacing=0.1)
    turned = edge.xy[:, 0] > 60.0
    assert np.allclose(np.hypot(*(edge.xy[turned] - [60.0, 0.25]).T), 0.25)
    assert np.allclose(np.unique(edge.xy[~turned, 1].round(9)), [0.0, 0.5])


def test_spiral_turns_lie_one_pitch_apart() -> None:
    edge = edges.spiral(pitch=0.8, inner_radius=6.0, turns=3.0, spacing=0.01)
    radius = np.hypot(*edge.xy.T)
    angle = np.unwrap(np.arctan2(edge.xy[:, 1], edge.xy[:, 0]))
    assert np.allclose(radius, 6.0 + 0.8 * angle / (2 * np.pi))
    assert angle[-1] == pytest.approx(6 * np.pi)


def test_touching_meets_itself_in_place_and_heading() -> None:
    edge = edges.touching(radius=12.0, length=40.0, spacing=0.01)
    near = np.flatnonzero(np.hypot(*(edge.xy - [40.0, 0.0]).T) < 0.02)
    first, second = near[0], near[-1]
    assert (second - first) * 0.01 == pytest.approx(2 * np.pi * 12.0, abs=0.05)
    ways = edge.xy[[first, second]] - edge.xy[[first - 1, second - 1]]
    assert np.allclose(ways[0] / 0.01, ways[1] / 0.01, atol=1e-2)


def test_polygon_has_equal_sides_and_turns_once() -> None:
    edge = edges.polygon(12, 100.0)
    assert edge.closed
    assert np.allclose(_gaps(edge), 100.0)
    assert len(edge.xy) == 12


def test_near_duplicates_come_in_pairs() -> None:
    gaps = _gaps(edges.near_duplicates(gap=1e-6))
    assert np.allclose(gaps[::2], 1e-6, rtol=1e-6)
    assert gaps[1::2].min() > 0.9


@looped("make", PARKING)
def test_parking_has_two_cusps_and_a_reverse_leg_between(make: Callable[[], Waypoints]) -> None:
    edge = make()
    signs = np.sign(edge.speed)
    assert signs[np.flatnonzero(np.diff(signs))].tolist() == [1.0, -1.0]
    assert signs[-1] == 1.0
    for before, after in itertools.pairwise(_legs(edge)):
        arrival, departure = before[-1] - before[-2], after[1] - after[0]
        cosine = arrival @ departure / np.hypot(*arrival) / np.hypot(*departure)
        assert cosine == pytest.approx(-1.0, abs=1e-3)


@looped("make", PARKING)
def test_parking_suits_a_car_of_three_metres_wheelbase(make: Callable[[], Waypoints]) -> None:
    for leg in _legs(make()):
        steps = np.diff(leg, axis=0)
        gaps = np.hypot(*steps.T)
        assert 0.095 < gaps.min() <= gaps.max() < 0.105
        turned = np.arctan2(
            steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0],
            (steps[:-1] * steps[1:]).sum(axis=1),
        )
        curvature = np.abs(turned) / gaps[1:]
        assert curvature.max() <= 1 / 6.0 * 1.001
        assert np.arctan(3.0 * curvature.max()) < 0.6


@looped("make", PARKING)
def test_parking_ends_on_a_straight_of_three_metres(make: Callable[[], Waypoints]) -> None:
    last = _legs(make())[-1]
    along = np.cumsum(np.hypot(*np.diff(last[::-1], axis=0).T))
    straight = last[::-1][1:][along <= 3.0 + 1e-9]
    direction = (last[-1] - last[-2]) / np.hypot(*(last[-1] - last[-2]))
    away = straight - last[-1]
    assert np.abs(away[:, 0] * direction[1] - away[:, 1] * direction[0]).max() < 1e-9
    assert np.hypot(*away[-1]) > 2.9


@looped("make", PARKING)
def test_parking_speed_falls_to_a_creep_at_cusps_and_ends(make: Callable[[], Waypoints]) -> None:
    edge = make()
    speed = np.abs(edge.speed)
    cusps = (np.flatnonzero(np.diff(np.sign(edge.speed))) + 1).tolist()
    assert np.allclose(speed[[0, *cusps, -1]], CREEP)
    assert speed.max() <= MANOEUVRING
    gaps = _gaps(edge)
    assert (np.abs(np.diff(speed**2)) / (2 * gaps)).max() <= SLOWING * 1.01


def test_three_point_turn_turns_round() -> None:
    edge = edges.three_point_turn()
    assert np.allclose((edge.xy[-1] - edge.xy[-2]) / 0.1, [-1.0, 0.0], atol=0.02)


def test_parallel_parking_ends_along_the_lane_in_the_slot() -> None:
    edge = edges.parallel_parking(offset=2.5)
    assert edge.xy[-1, 1] == pytest.approx(-2.5)
    assert edge.xy[-1, 1] == pytest.approx(edge.xy[-20, 1])
    assert 0.0 < edge.xy[-1, 0] < 10.0


@looped(
    ("make", "wrong", "message"),
    [
        (edges.figure8, {"spacing": 100.0}, "spacing must be in"),
        (edges.figure8, {"size": 0.0}, "size must be in"),
        (edges.out_and_back, {"offset": 0.0}, "offset must be in"),
        (edges.out_and_back, {"spacing": 1e-3}, "spacing must be in"),
        (edges.spiral, {"pitch": float("nan")}, "pitch must be in"),
        (edges.spiral, {"turns": 0.0}, "turns must be in"),
        (edges.touching, {"radius": -1.0}, "radius must be in"),
        (edges.polygon, {"sides": 2}, "sides must be in"),
        (edges.dense_straight, {"length": 0.0}, "length must be in"),
        (edges.near_duplicates, {"gap": 1e-9}, "gap must be in"),
        (edges.three_point_turn, {"arc_deg": 90.0}, "arc_deg must be in"),
        (edges.parallel_parking, {"offset": 13.0}, "offset must be in"),
    ],
)
def test_edge_of_bad_dimension_is_refused_by_name(
    make: Callable[..., Waypoints], wrong: dict[str, float], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        make(**wrong)
