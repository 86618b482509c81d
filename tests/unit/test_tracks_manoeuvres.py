from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import sim, tracks
from popsteer.errors import ConfigError
from popsteer.tracks.manoeuvres import double_lane_change, obstacle_avoidance, step_steer
from tests.helpers import looped

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.tracks import Track


def _curvature(track: Track) -> NDArray[np.float64]:
    """Curvature of the circle through each waypoint and its two neighbours."""
    before, after = track.xy[1:-1] - track.xy[:-2], track.xy[2:] - track.xy[1:-1]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    sides = [np.hypot(*part.T) for part in (before, after, before + after)]
    return np.asarray(2.0 * cross / (sides[0] * sides[1] * sides[2]))


@pytest.mark.parametrize("name", ["step-steer", "double-lane-change", "obstacle-avoidance"])
@pytest.mark.parametrize("law", [popsteer.Pop, popsteer.Stanley])
def test_manoeuvre_is_driven_to_its_end_by_the_laws(
    name: str, law: type[popsteer.Pop | popsteer.Stanley]
) -> None:
    track = tracks.get(name)
    metrics = sim.run(law(popsteer.Path(track.xy, speed=track.speed))).metrics
    assert metrics.finished
    assert metrics.settled_mean_abs_cross_track_error < 1.0


def test_step_steer_is_a_straight_a_linear_rise_and_a_constant() -> None:
    curvature = _curvature(step_steer(run_up=80.0, transition=20.0, radius=40.0, arc=120.0))
    # Entry k belongs to waypoint k + 1.
    assert np.abs(curvature[:79]).max() < 5e-6
    assert np.allclose(curvature[80:98], np.arange(1, 19) / 20.0 / 40.0, atol=1e-5)
    assert np.allclose(curvature[101:], 1.0 / 40.0, atol=1e-5)


def test_step_steer_of_negative_radius_is_its_mirror_image() -> None:
    left, right = step_steer(radius=40.0), step_steer(radius=-40.0)
    assert np.array_equal(left.xy * [1.0, -1.0], right.xy)
    assert np.array_equal(left.speed, right.speed)


@looped(
    ("make", "first", "second", "back", "third"),
    [
        # Beginnings and ends of the lanes, from the first on.
        (double_lane_change, (0, 15), (45, 70), (70, 95), (95, 125)),
        (obstacle_avoidance, (0, 12), (25.5, 36.5), (36.5, 49), (49, 61)),
    ],
)
def test_lane_change_is_straight_in_its_lanes_and_moves_only_between(
    make: Callable[..., Track],
    first: tuple[float, float],
    second: tuple[float, float],
    back: tuple[float, float],
    third: tuple[float, float],
) -> None:
    track = make(run_up=50.0, return_offset=0.25)
    offset = 3.5 if make is double_lane_change else 3.515
    x, y = track.xy[:, 0] - 50.0, track.xy[:, 1]

    def lane(part: tuple[float, float]) -> NDArray[np.float64]:
        return y[(x >= part[0]) & (x <= part[1])]

    assert np.ptp(lane(first)) == 0.0
    assert np.array_equal(np.unique(lane(second)), [offset])
    assert np.array_equal(np.unique(lane(third)), [0.25])
    assert (np.diff(lane((first[1], second[0]))) >= 0.0).all()
    assert (np.diff(lane(back)) <= 0.0).all()


def test_lane_change_curvature_follows_the_polynomial() -> None:
    # The greatest second derivative of the polynomial is 10 / √3 of h / X².
    track = double_lane_change(sections=(15.0, 60.0, 25.0, 60.0, 15.0, 15.0), offset=1.0)
    assert np.abs(_curvature(track)).max() == pytest.approx(10 / 3**0.5 / 60.0**2, rel=0.01)


def test_lane_change_is_driven_at_one_speed_that_its_sharpest_bend_allows() -> None:
    track = obstacle_avoidance(run_up=60.0)
    inside = (track.xy[:, 0] >= 60.0) & (track.xy[:, 0] <= 121.0)
    assert np.ptp(track.speed[inside]) == 0.0
    lateral = np.abs(_curvature(track)).max() * track.speed[inside][0] ** 2
    assert 0.95 * 4.0 < lateral <= 4.0


def test_obstacle_avoidance_offset_is_half_of_both_lanes_and_the_gap() -> None:
    for width, gap in ((1.6, 1.0), (2.1, 0.5)):
        lanes = 1.1 * width + 0.25, width + 1.0
        top = obstacle_avoidance(car_width=width, gap=gap).xy[:, 1].max()
        assert top == pytest.approx(0.5 * sum(lanes) + gap, abs=1e-6)


@looped("name", ["double-lane-change", "obstacle-avoidance"])
def test_lane_change_claims_no_conformance(name: str) -> None:
    track = tracks.get(name)
    assert "in the style of ISO 3888-" in track.title
    assert "No conformance with the standard is claimed" in track.description


@looped(
    ("make", "wrong", "message"),
    [
        (step_steer, {"radius": 0.0}, "radius must be in"),
        (step_steer, {"run_up": float("nan")}, "run_up must be in"),
        (step_steer, {"arc": -1.0}, "arc must be in"),
        (double_lane_change, {"sections": (1.0, 2.0)}, "sections must be 6 lengths"),
        (double_lane_change, {"sections": (15, 30, 25, 0, 15, 15)}, "sections must be in"),
        (double_lane_change, {"offset": float("inf")}, "offset must be in"),
        (obstacle_avoidance, {"car_width": 0.0}, "car_width must be in"),
        (obstacle_avoidance, {"gap": -1.0}, "gap must be in"),
        (obstacle_avoidance, {"run_out": 0.0}, "run_out must be in"),
    ],
)
def test_manoeuvre_of_bad_dimension_is_refused_by_name(
    make: Callable[..., Track], wrong: dict[str, object], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        make(**wrong)
