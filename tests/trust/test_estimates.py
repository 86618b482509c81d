"""Estimates that do no harm: unequal periods, gaps, noise, and a dead time that nobody told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import popsteer
from tests.trust.car import TOLD, Car, alternating, bends, drive, jitter

LAWS = (popsteer.PreviewPop, popsteer.Pop, popsteer.Stanley, popsteer.PurePursuit, popsteer.Pid)


@pytest.mark.parametrize("true", [0.15, 0.1])
def test_dead_time_is_learnt_in_unequal_periods_as_in_equal_ones(true: float) -> None:
    told = TOLD.replace(dead_time=0.15 if true == 0.15 else 0.2)
    equal = drive(car=Car(dead_time=true), told=told, periods=jitter(0.0, 0.025))
    for periods in (
        alternating(0.02, 0.03),
        alternating(0.04, 0.06),
        jitter(0.02),
        jitter(0.05),
        jitter(0.5),
    ):
        found = drive(car=Car(dead_time=true), told=told, periods=periods)
        apart = found.estimate.dead_time - equal.estimate.dead_time
        assert abs(apart) < 0.01
        assert abs(found.estimate.dead_time - true) < 0.01
        assert found.mean() < 1.2 * equal.mean() + 0.0005


def test_estimates_through_noise_cost_no_more_than_a_tenth() -> None:
    course = bends(length=520.0)
    noisy: dict[str, dict[str, Any]] = {
        "yaw, loss, jitter": {"noise": (0.0, 0.01, 0.0), "loss": 0.2, "periods": jitter(0.3)},
        "waypoints and poses": {
            "noise": (0.05, 0.01, 0.0),
            "waypoint_noise": 0.01,
            "fresh": True,
        },
    }
    for name, kind in noisy.items():
        means = {
            adapt: np.mean(
                [
                    drive(course=course, seconds=50.0, seed=seed, **options, **kind).mean()
                    for seed in range(4)
                ]
            )
            for adapt, options in (
                ("all", {}),
                ("no slip", {"adapt": popsteer.AdaptParams(slip_time=0.0)}),
                ("none", {"adapt": None}),
            )
        }
        assert means["all"] < 1.2 * means["no slip"], (name, means)
        assert means["all"] < 1.15 * means["none"], (name, means)


def test_dead_time_that_nobody_told_is_found() -> None:
    for told, true, most in ((0.0, 0.15, 0.01), (0.05, 0.25, 0.02)):
        found = drive(told=TOLD.replace(dead_time=told), car=Car(dead_time=true))
        assert found.mean() < most
        assert abs(found.estimate.dead_time - true) < 0.01


def test_gain_is_not_learnt_from_noise_within_a_period() -> None:
    # A bend of 20 m, a dead time shorter than a period: noise alone once made a gain of 2.5.
    angle = np.linspace(0.0, 1.9 * np.pi, 240)
    course = 20.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    told = TOLD.replace(dead_time=0.01)
    found = drive(told=told, car=Car(dead_time=0.01), course=course, noise=(0.0, 0.01, 0.0))
    assert 0.8 < found.estimate.gain < 1.25
    assert found.mean() < 0.06
