"""New paths, what binds and is said, estimates that do no harm, and the table of cases."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import popsteer
from studies.cases import case_lines
from studies.layout import table
from tests.trust.car import TOLD, Car, alternating, bends, drive, flips, jitter, out_and_back

LAWS = (popsteer.PreviewPop, popsteer.Stanley, popsteer.PurePursuit, popsteer.Pid)


def test_path_out_and_back_sent_again_is_driven_as_without() -> None:
    for law in LAWS:
        once, again = flips(None, law), flips(10, law)
        assert once[0] == again[0] == 1, (law, once, again)
        assert abs(once[1] - again[1]) < 0.5, (law, once, again)


def test_speed_tracker_keeps_its_direction_through_new_paths() -> None:
    paths = [out_and_back(0.5), out_and_back(0.4)]
    tracker = popsteer.SpeedTracker(paths[0], TOLD)
    x, speed, reverses = 2.0, 0.0, []
    for k in range(1200):
        if k and k % 10 == 0:
            tracker.set_path(paths[k // 10 % 2])
        command = tracker.step(x + 1.35, 0.0, 0.0, speed, 0.05)
        reverses.append(command.reverse)
        ahead = -1.0 if command.reverse else 1.0
        forward = max(0.0, ahead * speed + 0.05 * command.acceleration)
        speed = ahead * forward
        x += 0.05 * speed
    assert int(np.sum(np.diff(reverses) != 0)) == 1
    assert reverses[-1]


def test_laps_of_an_open_path_do_not_jump() -> None:
    # Three laps of one circle as an open path, sent again every half second from another place on.
    angle = np.linspace(0.0, 6.0 * math.pi, 900)
    course = 20.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    steering = popsteer.PreviewPop(popsteer.Path(course), TOLD)
    car, remaining = Car(), []
    for k in range(600):
        if k and k % 10 == 0:
            steering.set_path(popsteer.Path(course[k % 3 :]))
        command = steering.step(*car.pose(), 0.05)
        remaining.append(command.distance_to_stop)
        car.command(command.steer)
        car.advance(0.05, 6.0)
    assert np.max(np.abs(np.diff(remaining))) < 2.0


def test_dead_end_of_a_gap_finds_the_place_it_can_have_reached() -> None:
    # Held inputs for 1.5 s while the car brakes from 15 to 3 m/s.
    def gap(k: int, _: object) -> float:
        return 1.5 if k == 100 else 0.05

    def speed(time: float) -> float:
        return 15.0 - 8.0 * min(max(time - 5.0, 0.0), 1.5)

    course = np.column_stack((np.arange(0.0, 300.0), np.zeros(300)))
    for law in (popsteer.Stanley, popsteer.Pid):
        drove = drive(law, course=course, speed=speed, periods=gap, seconds=10.0)
        assert drove.first_fault() == math.inf
        assert max(abs(steer) for _, steer in drove.steers) < 0.05


def test_status_names_the_limit_that_binds() -> None:
    status = popsteer.Status
    path = popsteer.Path(np.column_stack((np.arange(0.0, 100.0), np.zeros(100))))
    free = {"max_steer_rate": None, "max_lateral_acceleration": None}
    cars = {
        status.RATE_LIMIT: TOLD.replace(max_steer_rate=0.05, max_lateral_acceleration=None),
        status.LATERAL_LIMIT: TOLD.replace(**{**free, "max_lateral_acceleration": 0.2}),
        status.STEER_LIMIT: TOLD.replace(**{**free, "max_steer": 0.01}),
    }
    for limit, car in cars.items():
        command = popsteer.Stanley(path, car).step(20.0, 3.0, 0.0, 8.0, 0.05)
        assert limit in command.status, (limit, command.status)
        assert status.SATURATED in command.status


def test_page_table_of_cases_is_what_is_driven() -> None:
    lines = case_lines()
    assert table("loop.md", "cases") == lines
    assert not [row for row in lines if "**" in row]


ESTIMATING = (
    popsteer.PreviewPop,
    popsteer.Pop,
    popsteer.Stanley,
    popsteer.PurePursuit,
    popsteer.Pid,
)


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
        assert means["all"] < 1.1 * means["no slip"], (name, means)
        assert means["all"] < 1.1 * means["none"], (name, means)


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
