"""The environment against Gymnasium itself, against its vector form, and against `popsteer.sim`."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import plants, sim, tracks
from popsteer.errors import ConfigError, InputError, PathError
from tests.helpers import looped

gymnasium = pytest.importorskip("gymnasium", reason='the extra "gym" is not installed')

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402
from gymnasium.wrappers.vector import RecordEpisodeStatistics  # noqa: E402

from popsteer.adapters.gymnasium import RewardWeights, TrackEnv, TrackVectorEnv  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import Callable

ID = "popsteer/Track-v0"
OPTIONS: dict[str, dict[str, Any]] = {
    "default": {},
    "pedals": {"actions": "steer-and-pedals"},
    "drawn": {
        "plant": "carla-identified",
        "vehicle_ranges": {"dead_time": (0.0, 0.2), "understeer": (0.0, 0.004)},
        "random_start": True,
    },
    "closed": {"track": "figure-eight", "random_start": True},
    "mujoco": {"plant": "mujoco-car", "constant_speed": 5.0},
    "commonroad": {"plant": "commonroad-st-2", "constant_speed": 8.0, "substeps": 5},
    "own plant": {"plant": sim.KinematicBicycle(popsteer.Vehicle(wheelbase=0.3), drive=3.0)},
}


def _steer_back(observations: Any) -> Any:
    """Steer for the fifth point of the preview, a share of the largest angle."""
    return np.clip(0.5 * np.arctan2(observations[:, 16:17], observations[:, 15:16]), -1.0, 1.0)


@pytest.mark.parametrize("name", OPTIONS)
def test_environment_passes_the_check_of_gymnasium_without_a_warning(name: str) -> None:
    env = gymnasium.make(ID, render_mode="rgb_array", **OPTIONS[name])
    check_env(env.unwrapped)  # warnings are errors in these tests
    env.close()


@looped("name", OPTIONS)
def test_made_vector_keeps_to_its_spaces_and_answers_with_new_arrays(name: str) -> None:
    envs = gymnasium.make_vec(ID, num_envs=3, max_episode_steps=8, **OPTIONS[name])
    assert isinstance(envs.unwrapped, TrackVectorEnv)
    envs = RecordEpisodeStatistics(envs)
    before, _ = envs.reset(seed=1)
    assert before in envs.observation_space
    envs.action_space.seed(1)
    ends = 0
    for _ in range(20):
        kept = before.copy()
        seen, rewards, ended, truncated, _ = envs.step(envs.action_space.sample())
        np.testing.assert_array_equal(before, kept)
        assert seen in envs.observation_space
        assert rewards.shape == ended.shape == truncated.shape == (3,)
        assert rewards.dtype == np.float64
        assert ended.dtype == truncated.dtype == np.bool_
        ends += int((ended | truncated).sum())
        before = seen
    assert ends >= 6
    envs.close()


@looped("name", ["default", "drawn", "pedals", "closed", "mujoco"])
@looped("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_vector_is_so_many_single_environments(name: str, mode: AutoresetMode) -> None:
    options = {**OPTIONS[name], "time_limit": 1.0}
    many = TrackVectorEnv(3, autoreset_mode=mode, **options)
    single = gymnasium.vector.SyncVectorEnv(
        [lambda: TrackEnv(**options) for _ in range(3)], autoreset_mode=mode
    )
    seen, infos = many.reset(seed=5)
    expected, expected_infos = single.reset(seed=5)
    np.testing.assert_array_equal(seen, expected)
    single.action_space.seed(3)
    for _ in range(50):
        actions = single.action_space.sample()
        answer, expected_answer = many.step(actions), single.step(actions)
        for one, other in zip(answer[:4], expected_answer[:4], strict=True):
            np.testing.assert_array_equal(one, other)
        infos, expected_infos = answer[4], expected_answer[4]
        assert set(infos) == set(expected_infos)
        for key in ("x", "cross_track_error", "time"):
            np.testing.assert_array_equal(infos[key], expected_infos[key])
        if "final_obs" in infos:
            for one, other in zip(infos["final_obs"], expected_infos["final_obs"], strict=True):
                np.testing.assert_array_equal(one, other)


def test_large_batch_is_that_of_single_ones_and_of_itself() -> None:
    count = 300  # more than one thread takes
    many, again = TrackVectorEnv(count, track="slalom"), TrackVectorEnv(count, track="slalom")
    singles = {k: TrackEnv("slalom") for k in (0, 150, 299)}
    seen, _ = many.reset(seed=11)
    again.reset(seed=11)
    for k, env in singles.items():
        np.testing.assert_array_equal(env.reset(seed=11 + k)[0], seen[k])
    for _ in range(60):
        actions = _steer_back(seen)
        seen, rewards, *_ = many.step(actions)
        np.testing.assert_array_equal(again.step(actions)[0], seen)
        for k, env in singles.items():
            one, reward, *_ = env.step(actions[k])
            np.testing.assert_array_equal(one, seen[k])
            assert reward == rewards[k]


@looped("plant", ["kinematic-bicycle", "carla-identified", "commonroad-st-2"])
def test_controller_in_the_environment_drives_as_in_the_simulation(plant: str) -> None:
    env = TrackEnv("slalom", plant, constant_speed=8.0, start_offset=(0.3, 0.3))
    pop = popsteer.PreviewPop(env.path, env.vehicle)
    _, info = env.reset(seed=0)
    start, speed = (info["x"], info["y"], info["yaw"]), info["speed"]
    driven, over = [start], False
    while not over:
        steer = pop.step(info["x"], info["y"], info["yaw"], info["speed"], env.dt).steer
        *_, terminated, truncated, info = env.step([steer / env.vehicle.max_steer])
        over = terminated or truncated
        driven.append((info["x"], info["y"], info["yaw"]))
    assert info["ending"] == "finished"
    controller = popsteer.PreviewPop(env.path, env.vehicle)
    run = sim.run(
        controller,
        plant,
        start=start,
        speed=speed,
        path=env.path,
        longitudinal=env.task.longitudinal,
    )
    columns = [run.records[name] for name in ("x", "y", "yaw")]
    assert run.metrics.steps == len(driven) - 1
    # The action is a share of the largest angle, which rounds the angle's last bit.
    np.testing.assert_allclose(np.column_stack(columns), driven[:-1], rtol=0.0, atol=1e-9)


def test_observation_has_the_path_ahead_in_the_frame_of_the_rear_axle() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)
    straight = popsteer.Path([(float(x), 0.0) for x in range(100)], speed=np.full(100, 6.0))
    env = TrackEnv(
        straight,
        sim.KinematicBicycle(car),
        start_offset=(0.5, 0.5),
        start_yaw=(0.2, 0.2),
        preview=(10.0,),
    )
    seen, info = env.reset(seed=0)
    named = dict(zip(env.observation_names, seen.tolist(), strict=True))
    expected = {"cross_track_error": 0.5, "heading_error": 0.2, "speed": 6.0, "yaw_rate": 0.0}
    assert named == pytest.approx(
        {
            **expected,
            "wheel": 0.0,
            "previous_steer": 0.0,
            "reference_speed": 6.0,
            "preview_x[0]": 10.0 * np.cos(0.2) - 0.5 * np.sin(0.2),
            "preview_y[0]": -10.0 * np.sin(0.2) - 0.5 * np.cos(0.2),
        },
        abs=1e-6,
    )
    assert (info["x"], info["y"]) == pytest.approx((1.35 * np.cos(0.2), 0.5 + 1.35 * np.sin(0.2)))


def test_positive_action_turns_left_and_reward_is_what_is_documented() -> None:
    env = TrackEnv("straight", constant_speed=5.0, reward={"steer_rate": 0.2})
    env.reset(seed=2)
    weights, previous = RewardWeights(steer_rate=0.2), 0.0
    _, before = env.reset(seed=3)
    for action in (0.2, 0.2, 0.1):
        _, reward, _, _, info = env.step([action])
        steer = action * env.vehicle.max_steer
        gained = (info["progress"] - before["progress"]) * env.path.length
        cost = info["cross_track_error"] ** 2 + info["heading_error"] ** 2
        cost += weights.steer_rate * ((steer - previous) / env.dt) ** 2
        assert reward == pytest.approx(0.1 * gained - env.dt * cost, abs=1e-9)
        assert info["yaw"] > before["yaw"]
        previous, before = steer, info


def test_leaving_the_path_ends_the_episode_at_its_cost() -> None:
    env = TrackEnv("straight", constant_speed=10.0)
    env.reset(seed=0)
    over = truncated = False
    while not (over or truncated):
        _, reward, over, truncated, info = env.step([0.2])
    assert info["ending"] == "off the path"
    assert not truncated
    assert reward < -9.0


def test_episode_draws_its_vehicle_anew_and_a_seed_repeats_it() -> None:
    ranges = {"dead_time": (0.0, 0.2), "max_steer_rate": (0.3, 0.6)}
    env = TrackEnv("slalom", vehicle_ranges=ranges)
    cars = []
    for seed in (1, None, 1):
        env.reset(seed=seed)
        cars.append(env.vehicle)
    assert cars[0] == cars[2] != cars[1]
    assert all(
        0.0 <= car.dead_time <= 0.2 and 0.3 <= (car.max_steer_rate or 0.0) <= 0.6 for car in cars
    )


def test_plant_at_its_limit_ends_the_episode_and_says_which() -> None:
    class Cliff:
        name, vehicle, reverses = "cliff", popsteer.Vehicle(steer_lag=0.0), False

        def reset(self, x: float, y: float, yaw: float, speed: float) -> None:
            self.x = x

        def advance(self, *command: Any) -> plants.PlantState:
            self.x += 1.0
            if self.x > 5.0:
                raise plants.PlantLimit("the edge")
            return plants.PlantState(self.x, 0.0, 0.0, 5.0, 0.0, 0.0)

    env = TrackEnv("straight", Cliff(), start_offset=(0.0, 0.0), start_yaw=(0.0, 0.0))
    env.reset(seed=0)
    steps, over = 0, False
    while not over and steps < 100:
        _, reward, over, _, info = env.step([0.0])
        steps += 1
    assert (steps, info["ending"]) == (6, "plant limit: the edge")
    assert reward < -9.0
    many = TrackVectorEnv(2, track="straight", plant=Cliff())
    many.reset(seed=0)
    assert len({id(plant) for plant in many._plants}) == 2


@looped("action", [[np.nan], [np.inf], ["left"], [0.0, 0.0], 0.0, None])
def test_action_that_is_none_is_refused_and_nothing_moves(action: Any) -> None:
    env, twin = TrackEnv("slalom"), TrackEnv("slalom")
    env.reset(seed=1)
    twin.reset(seed=1)
    with pytest.raises(InputError, match="action"):
        env.step(action)
    np.testing.assert_array_equal(env.step([0.1])[0], twin.step([0.1])[0])


def test_wild_action_in_a_batch_is_named_with_its_vehicle_and_nothing_moves() -> None:
    many, twin = (TrackVectorEnv(4, time_limit=0.1) for _ in range(2))
    many.reset(seed=1)
    twin.reset(seed=1)
    actions = np.full((4, 1), 0.1)
    wild = actions.copy()
    wild[2] = np.nan
    for _ in range(4):  # the third is that of the new episodes, whose actions do not count
        if not many._over.any():
            with pytest.raises(InputError, match=r"action\[2\]"):
                many.step(wild)
        np.testing.assert_array_equal(many.step(actions)[0], twin.step(actions)[0])


def test_wild_action_where_others_begin_anew_leaves_what_they_draw() -> None:
    many, twin = (TrackVectorEnv(2, time_limit=0.1) for _ in range(2))
    for envs in (many, twin):
        envs.reset(seed=1)
        envs.step(np.zeros((2, 1)))
        envs.reset(options={"reset_mask": np.array([True, False])})
        _, _, _, truncated, _ = envs.step(np.zeros((2, 1)))
        assert truncated.tolist() == [False, True]
    with pytest.raises(InputError, match=r"action\[0\]"):
        many.step([[np.nan], [0.0]])
    np.testing.assert_array_equal(many.step([[0.0], [np.nan]])[0], twin.step([[0.0], [0.0]])[0])


def test_only_masked_vehicles_begin_anew_where_nothing_does_so_by_itself() -> None:
    many = TrackVectorEnv(3, autoreset_mode="Disabled", time_limit=0.1)
    many.reset(seed=1)
    for _ in range(2):
        _, _, _, truncated, infos = many.step(np.zeros((3, 1)))
    assert truncated.all()
    assert list(infos["ending"]) == ["time limit"] * 3
    _, infos = many.reset(options={"reset_mask": np.array([True, False, True])})
    np.testing.assert_allclose(infos["time"], [0.0, 0.1, 0.0])
    with pytest.raises(ConfigError, match="reset_mask"):
        many.reset(options={"reset_mask": [1, 0, 1]})


@looped(
    ("options", "error", "named"),
    [
        ({"track": "monaco"}, ConfigError, "monaco"),
        ({"track": 3}, TypeError, "track"),
        ({"plant": "tank"}, ConfigError, "tank"),
        ({"actions": "fly"}, ConfigError, "actions 'fly'"),
        ({"vehicle_ranges": {"wheels": (3, 4)}}, ConfigError, "wheels"),
        ({"vehicle_ranges": {"dead_time": (0.2, 0.1)}}, ConfigError, "dead_time"),
        ({"vehicle_ranges": {"dead_time": (0.0, 99.0)}}, ConfigError, "dead_time"),
        ({"vehicle_ranges": {"dead_time": 0.1}}, ConfigError, "dead_time"),
        ({"reward": {"speed": 1.0}}, ConfigError, "speed"),
        ({"reward": {"progress": -1.0}}, ConfigError, "progress"),
        ({"off_path_distance": 0.0}, ConfigError, "give_up_distance"),
        ({"dt": float("nan")}, ConfigError, "dt"),
        ({"preview": [-1.0]}, ConfigError, "preview"),
        ({"start_offset": (1.0, float("nan"))}, ConfigError, "start_offset"),
        ({"render_mode": "human"}, ConfigError, "render_mode"),
        ({"track": popsteer.Path([(0, 0), (9, 0)])}, PathError, "reference speeds"),
        (
            {"plant": "mujoco-car", "vehicle_ranges": {"dead_time": (0, 1)}},
            ConfigError,
            "mujoco-car",
        ),
    ],
)
def test_option_that_is_wrong_is_named(options: dict[str, Any], error: Any, named: str) -> None:
    with pytest.raises(error, match=named):
        TrackEnv(**options)
    with pytest.raises(error, match=named):
        TrackVectorEnv(2, **options)


def test_path_driven_backwards_is_tracked_in_its_gear() -> None:
    x = np.concatenate([np.arange(0.0, 21.0), np.arange(19.0, -1.0, -1.0)])
    back = np.arange(len(x)) >= 20
    path = popsteer.Path(
        np.column_stack((x, np.zeros_like(x))),
        speed=np.full(len(x), 2.0),
        reverse=back,
    )
    env = TrackEnv(path, start_offset=(0.0, 0.0), start_yaw=(0.0, 0.0))
    _, info = env.reset(seed=0)
    slowest, over = 0.0, False
    while not over:  # the time limit ends it at the latest
        *_, terminated, truncated, info = env.step([0.0])
        slowest, over = min(slowest, info["speed"]), terminated or truncated
    assert info["ending"] == "finished"
    assert slowest < -1.0


def test_pictures_of_a_vector_are_those_of_its_environments() -> None:
    env = TrackEnv("slalom", render_mode="rgb_array", start_offset=(0.0, 0.0))
    env.reset(seed=0)
    first = env.render()
    assert first is not None
    assert first.shape == (400, 400, 3)
    assert first.dtype == np.uint8
    many = TrackVectorEnv(2, track="slalom", render_mode="rgb_array", start_offset=(0.0, 0.0))
    many.reset(seed=0)
    pictures = many.render()
    assert pictures is not None
    np.testing.assert_array_equal(pictures[0], first)
    assert TrackEnv("slalom").render() is None


def _python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=120
    )


def test_missing_extra_is_named_with_its_command() -> None:
    hidden = "import sys; sys.modules['gymnasium'] = None\nimport popsteer.adapters.gymnasium"
    ran = _python(hidden)
    assert ran.returncode == 1
    assert 'pip install "popsteer-VERSION-PLATFORM.whl[gym]"' in ran.stderr.splitlines()[-1]


def test_import_of_popsteer_brings_neither_gymnasium_nor_the_adapter() -> None:
    ran = _python(
        "import sys, popsteer, popsteer.sim\n"
        "print([name for name in sys.modules if 'gymnasium' in name or '.adapters' in name])"
    )
    assert ran.stdout.strip() == "[]"


def test_tracks_are_all_driven() -> None:
    for name in tracks.names():
        env = TrackEnv(name, constant_speed=5.0, random_start=True)
        env.reset(seed=1)
        assert env.step([0.0])[0] in env.observation_space


def test_short_name_is_found_without_an_import() -> None:
    code = (
        "import gymnasium\n"
        f"gymnasium.make('popsteer.adapters.gymnasium:{ID}', track='slalom').reset(seed=1)\n"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


def test_step_before_reset_is_refused() -> None:
    with pytest.raises(InputError, match="step must be after reset"):
        TrackEnv("slalom").step([0.0])


def test_full_lock_is_truncated_where_it_stops_making_progress() -> None:
    single = TrackEnv("straight", constant_speed=3.0, off_path_distance=50.0)
    many = TrackVectorEnv(2, track="straight", constant_speed=3.0, off_path_distance=50.0)
    single.reset(seed=1)
    many.reset(seed=1)
    steps, truncated = 0, False
    while not truncated and steps < 1000:
        steps += 1
        *_, ended, truncated, info = single.step([1.0])
        *_, others, infos = many.step([[1.0], [0.0]])
        assert others[0] == truncated
    assert (ended, info["ending"], infos["ending"][0]) == (False, "no progress", "no progress")
    assert 200 < steps < 400
    assert not others[1]
    patient = TrackEnv(
        "straight", constant_speed=3.0, off_path_distance=50.0, stall_time=None, time_limit=20.0
    )
    patient.reset(seed=1)
    while not patient.step([1.0])[3]:
        pass
    assert patient._episodes.ending(0) == "time limit"


def test_copies_of_environments_and_of_pedals_go_on_alike() -> None:
    pedals = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=0.7, ki=0.2))
    pedals.step(3.0, 5.0, 0.05)
    options: dict[str, Any] = {
        "longitudinal": pedals,
        "vehicle_ranges": {"dead_time": (0.0, 0.1)},
        "plant": sim.KinematicBicycle(popsteer.Vehicle(steer_lag=0.2)),
    }
    env, envs = TrackEnv("slalom", **options), TrackVectorEnv(2, track="slalom", **options)
    env.reset(seed=3)
    copies: list[Callable[[Any], Any]] = [
        copy.deepcopy,
        lambda thing: pickle.loads(pickle.dumps(thing)),
    ]
    for copied in copies:
        again = copied(pedals)
        assert again.state == pedals.state
        assert again.params == pedals.params
        assert again.step(3.1, 5.0, 0.05) == copied(pedals).step(3.1, 5.0, 0.05)
        coupled = popsteer.CoupledLongitudinal(popsteer.CoupledLongitudinalParams(cutoff=0.4))
        assert copied(coupled).params == coupled.params
        np.testing.assert_array_equal(copied(env).reset()[0], copied(env).reset()[0])
        with pytest.raises(InputError, match="after reset"):
            copied(env).step([0.0])
        seen, _ = copied(envs).reset(seed=5)
        np.testing.assert_array_equal(seen, envs.reset(seed=5)[0])
    drawn = copy.deepcopy(env).reset()[0]
    np.testing.assert_array_equal(drawn, env.reset()[0])
