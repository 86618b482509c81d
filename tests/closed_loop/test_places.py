"""The place of a vehicle on its path, and its time, where they could be lost: each kind by numbers.

`studies.places` draws vehicles of 0.16 to 12 m, paths, controllers and delays; more of them by
``python -m studies.places 1000``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import Status
from popsteer.tracks.cusps import parallel_parking
from studies import places

each_law = pytest.mark.parametrize("name", places.LAWS)
each_size = pytest.mark.parametrize("wheelbase", [0.16, 0.9, 2.7, 12.0])


@pytest.mark.parametrize(("kind", "count"), [("laps", 15), ("cusps", 25), ("corrections", 60)])
def test_place_in_drives_that_could_lose_it_is_kept(kind: str, count: int) -> None:
    # Known: one of the drawn PIDs, whose derivative is filtered, limit-cycles and leaves its path.
    known = ["Pid, 2.50 m, sent every 2"] if kind == "laps" else []
    assert [said.partition(":")[0] for said in places.wrong(kind, count)] == known


def test_clock_that_repeats_or_leaps_is_one_event() -> None:
    # A leap ahead that could be a gap, of up to 1,000 s, is taken for one: PID integrates over it.
    found = places.wrong("clocks", 40)
    assert [said for said in found if not (said.startswith("Pid") and "leaps by +" in said)] == []


def _out_and_back(length: float, spacing: float) -> popsteer.Path:
    out = np.arange(0.0, length + 0.5 * spacing, spacing)
    x = np.concatenate((out, out[-2::-1]))
    flags = np.arange(len(x)) >= len(out) - 1
    return popsteer.Path(np.column_stack((x, np.zeros(len(x)))), reverse=flags)


@each_law
@each_size
@pytest.mark.parametrize("jump", [-3.0, -0.3, 0.05, 0.3, 3.0])
def test_correction_on_the_way_back_changes_neither_direction_nor_stop(
    name: str, wheelbase: float, jump: float
) -> None:
    end, speed = 20.0 * wheelbase, wheelbase
    path = _out_and_back(end, 0.2 * wheelbase)
    controller = getattr(popsteer, name)(path, popsteer.Vehicle(wheelbase=wheelbase))
    x, v, on_the_way_back = 0.9 * end, speed, 0
    while on_the_way_back < 160:
        off = jump * wheelbase if on_the_way_back > 120 else 0.0
        command = controller.step(x + off, 0.0, 0.0, v, 0.05)
        if command.reverse:
            v = -speed
        assert command.reverse or v > 0.0
        on_the_way_back += v < 0.0
        x += v * 0.05
    assert command.distance_to_stop == pytest.approx(x - v * 0.05 + off, abs=0.1 * wheelbase)


@each_law
@each_size
def test_first_step_is_in_the_first_of_the_laps_that_overlap(name: str, wheelbase: float) -> None:
    radius = 8.0 * wheelbase
    for seed in range(4):
        draw = np.random.default_rng(seed)
        turn = np.arange(0.0, draw.uniform(1.05, 2.5) * math.tau, 0.2 * wheelbase / radius)
        noise = 0.03 * min(1.0, wheelbase / 2.7)
        xy = radius * np.column_stack((np.sin(turn), 1.0 - np.cos(turn)))
        path = popsteer.Path(xy + draw.normal(0.0, noise, xy.shape))
        pose = (*draw.normal(0.0, 3.0 * noise, 2), draw.normal(0.0, 0.02), 0.0)
        car = popsteer.Vehicle(wheelbase=wheelbase)
        made: Any
        for made in (getattr(popsteer, name)(path, car), popsteer.SpeedTracker(path, car)):
            command = made.step(*pose, 0.05)
            assert command.distance_to_stop == pytest.approx(path.length, abs=wheelbase)


def test_first_step_far_beside_a_path_is_at_its_closest_point() -> None:
    path = popsteer.Path([(float(k), 0.0) for k in range(2000)])  # one that has an index
    short = popsteer.Path([(float(k), 0.0) for k in range(400)])
    for made, aside in ((path, 20.0), (path, 200.0), (short, 20.0), (short, 200.0)):
        controller = popsteer.PreviewPop(made, popsteer.Vehicle(wheelbase=2.7))
        command = controller.step(300.0, aside, 0.0, 5.0, 0.05)
        assert command.cross_track_error == pytest.approx(aside)


@each_law
def test_laps_sent_again_with_noise_stay_the_same_lap(name: str) -> None:
    for seed, wheelbase in enumerate((0.16, 0.9, 2.7, 12.0)):
        draw = np.random.default_rng(seed)
        radius, noise = 6.0 * wheelbase, 0.05 * min(1.0, wheelbase / 2.7)
        turn = np.arange(0.0, 3.0 * math.tau, 0.2 * wheelbase / radius)
        xy = radius * np.column_stack((np.sin(turn), 1.0 - np.cos(turn)))
        car = popsteer.Vehicle(wheelbase=wheelbase)
        controller = getattr(popsteer, name)(popsteer.Path(xy), car)
        for k in range(60):  # into the second lap
            angle = 0.16 * k
            pose = (radius * math.sin(angle), radius * (1.0 - math.cos(angle)), angle)
            before = controller.step(*pose, wheelbase, 0.16 * radius / wheelbase)
        for _ in range(5):
            path = popsteer.Path(xy + draw.normal(0.0, noise, xy.shape))
            controller.set_path(path)
            after = controller.step(*pose, wheelbase, 1e-3)
        share = after.distance_to_stop / path.length
        assert share == pytest.approx(before.distance_to_stop / (3.0 * math.tau * radius), abs=0.01)


@each_size
@pytest.mark.parametrize("moved", [-40.0, 3.0, 40.0])
def test_relocalise_with_an_aged_pose_gives_the_errors_of_the_pose(
    wheelbase: float, moved: float
) -> None:
    speed = 6.0 * wheelbase
    path = popsteer.Path([(0.4 * wheelbase * k, 0.0) for k in range(600)])
    controller = popsteer.Stanley(path, popsteer.Vehicle(wheelbase=wheelbase))
    x, aside, age = 100.0 * wheelbase, 0.02 * wheelbase, 0.5
    for _ in range(40):
        controller.step(x - age * speed, aside, 0.0, speed, 0.05, pose_age=age)
        x += 0.05 * speed
    x += moved * wheelbase
    controller.relocalise(x - age * speed, aside, 0.0)
    for _ in range(3):
        command = controller.step(x - age * speed, aside, 0.0, speed, 0.05, pose_age=age)
        assert command.cross_track_error == pytest.approx(aside, abs=0.02 * wheelbase)
        assert command.status == Status.OK
        x += 0.05 * speed


@pytest.mark.parametrize("late", [0.05, 0.15, 0.3])
def test_dead_time_that_is_learnt_keeps_the_place(late: float) -> None:
    # Parallel parking crosses its own line; the estimate switches on in mid-drive.
    track = parallel_parking()
    path = popsteer.Path(track.xy, speed=track.speed)
    car = popsteer.Vehicle(wheelbase=2.7, max_steer=0.6)
    tuning = popsteer.PreviewPopParams(min_speed=1.0, smoothing_length=0.5)
    controller, tracker = popsteer.PreviewPop(path, car, tuning), popsteer.SpeedTracker(path, car)
    plant = places.Car(car, late, 6.0)
    for _ in range(900):
        pose = (plant.x, plant.y, plant.yaw, plant.speed, 0.05)
        command, pace = controller.step(*pose), tracker.step(*pose)
        assert abs(command.cross_track_error) < 0.15
        assert Status.DEVIATING not in command.status
        gear = -1.0 if pace.reverse else 1.0
        wanted = 0.0 if pace.standing else plant.speed + gear * 0.05 * pace.acceleration
        plant.advance(command.steer, wanted)
    assert math.dist((plant.x, plant.y), track.xy[-1]) < 0.1
