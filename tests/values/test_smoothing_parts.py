"""The steps of smoothing a recording, and laps of it, against answers known by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from popsteer import PathError, planning

pytest.importorskip("scipy")

from popsteer.planning import smoothing


def _line(x: list[float]) -> np.ndarray:
    return np.column_stack((x, np.zeros(len(x))))


def test_waypoints_that_lead_on_are_kept() -> None:
    # By half a tolerance at least, past the last one that was kept.
    x = [0.0, 0.1, 0.14, 0.16, 0.16, 0.1, 0.3, 0.34, 0.36, 5.0, 4.0, 5.04, 5.06]
    assert smoothing._forward(_line(x), 0.1, 0) == [0, 1, 3, 6, 8, 9, 12]
    for back, refused in ((1.99, False), (2.01, True)):
        line = _line([*np.arange(0.0, 6.0, 0.5).tolist(), 5.5 - back, 6.0])
        if refused:
            with pytest.raises(
                PathError, match=r"waypoints 107 to 108 run back by 2\.01 m"
            ) as told:
                smoothing._forward(line, 0.1, 96)
            assert told.value.index == 108
        else:
            assert smoothing._forward(line, 0.1, 96) == [*range(12), 13]


def test_distance_along_is_that_without_the_noise() -> None:
    x = 0.2 * np.arange(120)
    noisy = np.column_stack((x, 0.05 * (-1.0) ** np.arange(120)))
    assert math.hypot(0.2, 0.1) * 119 > 26.0
    assert smoothing._distance(noisy, 0.6)[-1] == pytest.approx(23.8, abs=0.25)
    exact = smoothing._distance(np.column_stack((x, 2.0 * x)), 0.1)
    assert exact == pytest.approx(x * math.sqrt(5.0))
    # Two points are a line, and one that stands still leads on by a tenth of the tolerance.
    assert smoothing._distance(_line([0.0, 3.0]), 0.1).tolist() == [0.0, 3.0]
    still = smoothing._distance(_line([0.0, 1.0, 1.0, 2.0]), 0.1)
    assert still == pytest.approx([0.0, 1.0, 1.01, 2.01])


def test_noise_and_steps_of_a_recording_are_medians() -> None:
    random = np.random.default_rng(0)
    noisy = np.cumsum(np.full((4000, 2), 0.2), axis=0) + random.normal(0.0, 0.03, (4000, 2))
    assert smoothing._noise(noisy) == pytest.approx(0.03, rel=0.05)
    assert smoothing._median_step(_line([0.0, 1.0, 4.0, 4.5])) == 1.0


def test_lap_that_runs_on_beyond_its_start_is_one_lap() -> None:
    turn = np.linspace(0.0, 2.3 * np.pi, 116)
    places = 10.0 * np.column_stack((np.cos(turn), np.sin(turn)))
    first = smoothing._one_lap(places)
    assert len(first) == 101
    assert smoothing._one_lap(places[:95]) is not None
    assert len(smoothing._one_lap(places[:95])) == 95
    for overrun in (places, places[:100]):
        path = planning.smooth(overrun, 0.05, closed=True)
        assert path.closed
        assert np.hypot(path.x, path.y) == pytest.approx(10.0, abs=0.02)
        assert path.length == pytest.approx(20.0 * np.pi, rel=2e-3)
        steps = np.diff(np.append(path.s, path.length))
        assert steps == pytest.approx(steps.mean(), rel=0.01)
        # Waypoints as far apart as they were recorded, from the same place on.
        assert steps.mean() == pytest.approx(0.628, rel=0.02)
        assert (path.x[0], path.y[0]) == pytest.approx((10.0, 0.0), abs=0.05)
    asked = planning.smooth(places, 0.05, closed=True, spacing=2.0)
    assert len(asked) == 31


def test_clean_bend_keeps_its_radius_and_noise_is_smoothed_within_its_tolerance() -> None:
    turn = np.linspace(0.0, 0.75 * np.pi, 120)
    clean = 12.0 * np.column_stack((np.cos(turn), np.sin(turn)))
    random = np.random.default_rng(1)
    for noise, tolerance in ((0.0, 0.1), (0.02, 0.1)):
        made = planning.smooth(clean + random.normal(0.0, noise, clean.shape), tolerance)
        off = np.hypot(made.x, made.y) - 12.0
        assert np.abs(off).max() < tolerance
        assert np.sqrt(np.mean(off**2)) < 0.35 * tolerance
        # It is smooth: its curvature is that of the circle within a third, away from the ends.
        x, y = np.gradient(np.stack((made.x, made.y)), made.s, axis=1)
        bend = np.gradient(np.unwrap(np.arctan2(y, x)), made.s)
        inner = slice(len(made) // 5, -len(made) // 5)
        assert bend[inner] == pytest.approx(1.0 / 12.0, abs=0.35 / 12.0)
        # As smooth as the tolerance allows: more of it is used than a tenth; a clean bend is kept.
        used = np.abs(off).max() / tolerance
        assert used > 0.1 if noise else used < 0.02
