"""Where episodes begin, backwards too, and what comes after each of their ends."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import sim, tracks
from tests.values.tables import BACKWARDS, SELF

gymnasium = pytest.importorskip("gymnasium", reason='the extra "gym" is not installed')

from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402

from popsteer.adapters.gymnasium import TrackEnv, TrackVectorEnv  # noqa: E402

XY = [(0.5 * k, 0.0) for k in range(41)]
# Some finish, some are off the path at once, some run out of time.
ENDS: dict[str, dict[str, Any]] = {
    "finished": {"track": popsteer.Path(XY[:17], speed=[3.0] * 17), "random_start": True},
    "off the path": {"track": "straight", "start_offset": (0.0, 1.5), "off_path_distance": 1.0},
    "time limit": {"track": "slalom", "time_limit": 0.4},
}


def test_vector_goes_on_after_each_end_as_single_environments_do() -> None:
    for name, options in ENDS.items():
        for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP):
            many = TrackVectorEnv(4, autoreset_mode=mode, **options)
            single = SyncVectorEnv([partial(TrackEnv, **options)] * 4, autoreset_mode=mode)
            for envs in (many, single):
                envs.reset(seed=5)
            ends, begun = 0, 0
            for _ in range(60):
                actions = np.full((4, 1), 0.02, dtype=np.float32)
                answer, expected = many.step(actions), single.step(actions)
                for one, other in zip(answer[:4], expected[:4], strict=True):
                    np.testing.assert_array_equal(one, other, err_msg=f"{name}, {mode}")
                for key in ("time", "x", "progress", "cross_track_error"):
                    np.testing.assert_array_equal(answer[4][key], expected[4][key])
                ends += int((answer[2] | answer[3]).sum())
                begun += int((answer[4]["time"] == 0.0).sum())
            assert ends > 8, name
            # Each end but those of the last step is followed by a begin.
            assert ends - 4 <= begun <= ends, (name, mode)


def test_vector_begun_by_hand_in_part_goes_on_with_the_rest() -> None:
    actions = np.full((4, 1), 0.02, dtype=np.float32)
    for name, options in ENDS.items():
        many, single = (
            TrackVectorEnv(4, **options),
            SyncVectorEnv([partial(TrackEnv, **options)] * 4),
        )
        for envs in (many, single):
            envs.reset(seed=5)
        over = many.step(actions)[2]
        single.step(actions)
        while not over.any():
            _, _, ended, truncated, _ = many.step(actions)
            single.step(actions)
            over = ended | truncated
        # All but one that is over, which begins by itself in the next step.
        begin: dict[str, Any] = {"options": {"reset_mask": np.arange(4) != int(np.argmax(over))}}
        np.testing.assert_array_equal(many.reset(**begin)[0], single.reset(**begin)[0], name)
        for _ in range(3):
            answer, expected = many.step(actions), single.step(actions)
            for one, other in zip(answer[:4], expected[:4], strict=True):
                np.testing.assert_array_equal(one, other, name)


def test_vehicles_that_are_not_begun_keep_what_they_draw_from() -> None:
    actions = np.full((3, 1), 0.02, dtype=np.float32)
    options: dict[str, Any] = {"track": "slalom", "constant_speed": 8.0, "time_limit": 0.2}
    many, single = TrackVectorEnv(3, **options), SyncVectorEnv([partial(TrackEnv, **options)] * 3)
    for envs in (many, single):
        envs.reset(seed=5)
    mask = {"options": {"reset_mask": np.array([False, True, False])}}
    for seed in (9, None, 9):  # a second one without a seed draws on
        for one, other in zip(
            many.reset(seed=seed, **mask), single.reset(seed=seed, **mask), strict=True
        ):
            if isinstance(one, np.ndarray):
                np.testing.assert_array_equal(one, other)
        for _ in range(6):  # past the end of all: each draws its next
            np.testing.assert_array_equal(many.step(actions)[0], single.step(actions)[0])


def test_episode_backwards_is_the_one_forwards_turned_by_half_a_turn() -> None:
    options: dict[str, Any] = {"start_offset": (0.3, 0.3), "start_yaw": (0.1, 0.1)}
    found = []
    for twin in (SELF, BACKWARDS):
        env = TrackEnv(twin.path(XY, [3.0] * 41), **options)
        _, info = env.reset(seed=1)
        infos = [info]
        while info["progress"] < 0.9:
            _, _, terminated, truncated, info = env.step([0.0])
            assert (terminated, truncated) == (False, False)
            infos.append(info)
        found.append({name: np.array([each[name] for each in infos]) for name in info})
    forth, back = found
    # The rear axle leads: it begins beside the first waypoint either way.
    assert (forth["speed"][0], back["speed"][0]) == (3.0, -3.0)
    assert (forth["x"][0], forth["y"][0]) == pytest.approx((0.0, 0.3), abs=1e-9)
    assert (back["x"][0], back["y"][0]) == pytest.approx((0.0, -0.3), abs=1e-9)
    assert forth["yaw"][0] == pytest.approx(0.1)
    assert back["yaw"][0] == pytest.approx(0.1)
    assert np.abs(back["speed"] + 3.0).max() < 0.2
    # The front axle, whose progress counts, begins 3 m ahead or behind the rear axle.
    assert (forth["progress"][0], back["progress"][0]) == pytest.approx((0.15, 0.0), abs=1e-3)
    both = min(len(forth["x"]), len(back["x"]))
    assert back["x"][:both] == pytest.approx(-forth["x"][:both], abs=0.5)


def test_vector_begins_without_a_seed_too_each_vehicle_at_a_place_of_its_own() -> None:
    envs = TrackVectorEnv(3, track="slalom")
    _, infos = envs.reset()
    assert len(set(infos["y"].tolist())) == 3


def test_start_speed_is_that_of_the_path_or_the_one_asked_for_in_its_direction() -> None:
    for twin in (SELF, BACKWARDS):
        path = twin.path(XY, [2.0 + 0.1 * k for k in range(41)])
        for asked, speed in ((None, 2.0), (1.5, 1.5), (0.0, 0.0)):
            _, info = TrackEnv(path, start_speed=asked).reset(seed=0)
            assert info["speed"] == twin.speed * speed, asked
        _, info = TrackEnv(twin.path(XY), constant_speed=4.0).reset(seed=0)
        assert info["speed"] == twin.speed * 4.0


def test_random_start_lies_anywhere_on_a_lap_and_on_nine_tenths_of_an_open_path() -> None:
    lap = tracks.get("figure-eight")
    closed = popsteer.Path(lap.xy, speed=4.0 + np.sin(np.arange(len(lap.xy))), closed=True)
    for path, most in ((closed, 1.0), (popsteer.Path(XY, speed=[3.0] * 41), 0.9)):
        task = TrackEnv(path, random_start=True, start_offset=(0.0, 0.0)).task
        rng = np.random.default_rng(0)
        shares = []
        for _ in range(400):
            (x, y, yaw), speed = task.begin(rng, task.plant)[1:]
            place = path.relocalise(x, y, yaw)
            arc = path.locate(x, y, yaw, place, 10.0).arc_length
            shares.append(arc / path.length)
            # As fast as the waypoint before it asks for.
            assert path.speed is not None
            segment = np.searchsorted(path.s, arc + 1e-6, side="right") - 1
            assert speed == path.speed[segment]
        counts, _ = np.histogram(shares, np.linspace(0.0, 1.0, 11))
        assert (counts[: round(10 * most)] > 15).all(), counts
        assert max(shares) <= most + 1e-9
        # And anywhere between two waypoints.
        length = path.length / (len(path) - (most < 1.0))
        between = np.remainder(np.array(shares) * path.length, length) / length
        assert np.histogram(between, 5, (0.0, 1.0))[0].min() > 30


def test_start_is_drawn_between_the_bounds_about_the_path() -> None:
    task = TrackEnv(
        popsteer.Path(XY, speed=[3.0] * 41), start_offset=(0.1, 0.9), start_yaw=(-0.3, -0.1)
    ).task
    rng = np.random.default_rng(0)
    starts = np.array([task.begin(rng, task.plant)[1] for _ in range(200)])
    rear = starts[:, 1]
    assert 0.1 <= rear.min() < 0.15
    assert 0.85 < rear.max() <= 0.9
    assert -0.3 <= starts[:, 2].min() < -0.29
    assert -0.11 < starts[:, 2].max() <= -0.1


def test_limit_of_steps_and_time_end_an_episode_after_as_many_steps() -> None:
    envs = TrackVectorEnv(1, track="slalom", max_episode_steps=7, dt=0.1)
    envs.reset(seed=0)
    taken = 0
    while True:
        _, _, _, truncated, infos = envs.step(np.zeros((1, 1)))
        taken += 1
        if truncated[0]:
            break
    assert taken == 7
    assert infos["time"][0] == pytest.approx(0.7)
    assert infos["ending"][0] == "time limit"


def test_action_is_a_share_of_the_largest_angle_and_the_pedals_move_the_car() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, max_steer=0.5, steer_lag=0.0)
    env = TrackEnv("straight", sim.KinematicBicycle(car), constant_speed=5.0)
    env.reset(seed=0)
    seen, *_ = env.step([0.4])
    named = dict(zip(env.observation_names, seen.tolist(), strict=True))
    assert named["previous_steer"] == pytest.approx(0.2, rel=1e-6)
    rate = named["speed"] * math.tan(0.2) / 2.7
    assert named["yaw_rate"] == pytest.approx(rate, rel=5e-3)
    for pedal, sign in ((0.5, 1.0), (-0.5, -1.0)):
        env = TrackEnv("straight", actions="steer-and-pedals", start_speed=5.0)
        env.reset(seed=0)
        *_, info = env.step([0.0, pedal])
        assert (info["speed"] - 5.0) * sign > 0.01


def test_random_start_on_the_last_segment_of_a_lap_heads_for_the_first_waypoint() -> None:
    xy = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0)]
    path = popsteer.Path(xy, speed=[3.0] * 4, closed=True)
    task = TrackEnv(path, random_start=True, start_offset=(0.0, 0.0), start_yaw=(0.0, 0.0)).task
    rng = np.random.default_rng(0)
    car = sim.vehicle_of(task.plant)
    sides = set()
    for _ in range(60):
        x, y, yaw = task.begin(rng, task.plant)[1]
        x, y = x + car.rear_axle * math.cos(yaw), y + car.rear_axle * math.sin(yaw)
        side = round(yaw / (0.5 * math.pi)) % 4
        sides.add(side)
        assert math.remainder(yaw - side * 0.5 * math.pi, math.tau) == pytest.approx(0.0, abs=1e-9)
        assert (y, x, y, x)[side] == pytest.approx((0.0, 20.0, 20.0, 0.0)[side], abs=1e-9)
    assert sides == {0, 1, 2, 3}


def test_pictures_are_shown_as_fast_as_they_are_driven() -> None:
    for dt, fps in ((0.05, 20), (0.1, 10), (0.02, 50), (1.0, 1)):
        assert TrackEnv("straight", dt=dt).metadata["render_fps"] == fps
