"""Plants in Python: the protocol, and the ones from elsewhere with their limits."""

from __future__ import annotations

import builtins
import math
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import plants, sim, study, tracks
from popsteer.errors import ConfigError, InputError, PlantLimit, PopsteerError
from popsteer.plants.pedals import MujocoCarParams, PedalParams
from tests.helpers import authors_data

COMMONROAD = [name for name in plants.names() if name.startswith("commonroad-")]
CAR = "mujoco-car"


def _path(length: int = 121) -> popsteer.Path:
    return popsteer.Path([(float(x), 0.0) for x in range(length)])


def _plant(name: str) -> Any:
    pytest.importorskip("mujoco" if name == CAR else "vehiclemodels")
    return plants.get(name)


class Bicycle:
    """The core's kinematic bicycle in Python, to be compared with it."""

    name = "python-bicycle"

    def __init__(self, last_x: float = math.inf) -> None:
        params = sim.KinematicBicycle()
        self.params, self.last_x = params, last_x
        self.geometry = plants.Geometry(params.wheelbase, 0.0, params.wheelbase)
        self.state = (math.nan,) * 4

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        self.state = x, y, yaw, speed

    def advance(
        self, steer: float, throttle: float, brake: float, dt: float, substeps: int, /
    ) -> plants.PlantState:
        p = self.params
        for _ in range(substeps):
            speed = self.state[3]
            acceleration = p.drive * throttle - p.braking * brake - p.drag * speed
            moved = popsteer.kinematic_bicycle(*self.state, steer, acceleration, p.wheelbase, dt)
            self.state = (*moved[:3], max(moved[3], 0.0))
        if self.state[0] > self.last_x:
            raise PlantLimit("the end of the world")
        return plants.PlantState(*self.state, speed * math.tan(steer) / p.wheelbase, steer)


class Straight:
    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        return 0.0


@pytest.mark.parametrize("own", [False, True])
def test_python_plant_like_one_of_the_core_gives_the_same_run(own: bool) -> None:
    track = tracks.get("slalom")
    path = popsteer.Path(track.xy, speed=track.speed)

    class Wrapped:
        def __init__(self) -> None:
            self.law = popsteer.Pop(path, popsteer.PopParams(reference_offset=3.0))
            self.reference_offset = 3.0

        def step(self, *state: float) -> float:
            return self.law.steer(*state)

    law = Wrapped() if own else popsteer.Pop(path, popsteer.PopParams(reference_offset=3.0))
    of_core = sim.run(
        popsteer.Pop(path, popsteer.PopParams(reference_offset=3.0)), "kinematic-bicycle"
    )
    in_python = sim.run(law, Bicycle(), path=path)
    assert in_python.plant == "python-bicycle"
    assert in_python.metrics == of_core.metrics
    for name in ("x", "y", "yaw", "speed", "steer", "cross_track_error", "throttle"):
        np.testing.assert_array_equal(in_python.records[name], of_core.records[name])
    assert in_python.ending == of_core.ending == "finished"


@pytest.mark.parametrize("law", [popsteer.Pop(_path()), Straight()], ids=["law", "own law"])
def test_python_plant_at_its_limit_ends_the_run_and_says_which(law: Any) -> None:
    result = sim.run(law, Bicycle(last_x=30.0), path=_path(), speed=5.0)
    assert result.ending == "plant limit: the end of the world"
    assert not result.metrics.finished
    assert len(result.records["x"]) == len(result.records["status"]) == result.metrics.steps > 10
    assert np.isfinite(result.records["x"]).all()
    assert 25.0 < result.records["x"][-1] <= 30.0


def test_simulation_at_a_limit_stays_over() -> None:
    simulation = sim.Simulation(_path(), Bicycle(last_x=-2.0), start=(0.0, 0.0, 0.0), speed=50.0)
    assert (simulation.is_over, simulation.ending) == (False, None)
    simulation.step(0.0)
    assert simulation.is_over
    assert simulation.ending == "plant limit: the end of the world"
    simulation.drive(popsteer.Pop(_path()))
    assert simulation.metrics()["steps"] == 1


def test_python_plant_error_reaches_the_caller() -> None:
    class Broken(Bicycle):
        def advance(self, *command: Any) -> plants.PlantState:
            raise RuntimeError("no fuel")

    class Nowhere(Bicycle):
        def advance(self, *command: Any) -> plants.PlantState:
            return plants.PlantState(math.nan, 0.0, 0.0, 1.0, 0.0, 0.0)

    for law in (popsteer.Pop(_path()), Straight()):
        with pytest.raises(RuntimeError, match="no fuel"):
            sim.run(law, Broken(), path=_path())
        with pytest.raises(InputError, match="x must be in"):
            sim.run(law, Nowhere(), path=_path())


def test_run_endings_of_the_core_are_named() -> None:
    path = _path()
    late = sim.run(popsteer.Pop(path), settings=sim.Settings(time_limit=2.0))
    assert late.ending == "time limit"
    lost = sim.run(Straight(), path=path, start=(0.0, 1.0, 1.0))
    assert lost.ending == "too far from the path"


def test_run_many_python_plant_is_refused() -> None:
    with pytest.raises(TypeError, match="python-bicycle, is none of the core's"):
        sim.run_many([popsteer.Pop(_path())], [Bicycle()])  # type: ignore[list-item]


def test_constant_speed_is_kept() -> None:
    result = sim.run(popsteer.Pop(_path(301)), constant_speed=12.0)
    assert result.records["speed"][0] == 12.0
    settled = result.records["time"] >= 5.0
    np.testing.assert_allclose(result.records["speed"][settled], 12.0, atol=0.1)
    rolling = sim.run(popsteer.Pop(_path(301)), constant_speed=12.0, speed=3.0)
    assert rolling.records["speed"][0] == 3.0
    assert rolling.path.speed is None
    with pytest.raises(ConfigError, match="constant_speed"):
        sim.run(popsteer.Pop(_path()), constant_speed=-1.0)
    with pytest.raises(ConfigError, match="constant_speed"):
        sim.run(
            popsteer.Pop(_path()), constant_speed=9.0, longitudinal=popsteer.CoupledLongitudinal()
        )


def test_plant_without_the_extra_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def absent(name: str, *rest: Any) -> Any:
        if name.partition(".")[0] in ("vehiclemodels", "mujoco") or name.endswith(
            ("plants.commonroad", "plants.mujoco_car")
        ):
            raise ModuleNotFoundError(f"No module named {name!r}", name="mujoco")
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", absent)
    for name in ("commonroad-mb-2", CAR):
        with pytest.raises(PopsteerError, match=r'pip install "popsteer\[plants\]"'):
            plants.get(name)


def test_plant_params_out_of_range_are_refused() -> None:
    for kind in (PedalParams, MujocoCarParams):
        with pytest.raises(ConfigError, match="drag"):
            kind(drag=math.nan)
    with pytest.raises(ConfigError, match="friction"):
        MujocoCarParams(friction=-0.1)


@pytest.mark.parametrize("name", [*COMMONROAD, CAR])
def test_plant_in_a_slow_bend_drives_its_circle(name: str) -> None:
    plant = _plant(name)
    start = 3.0, -2.0, 0.7, 4.0
    plant.reset(*start)
    hold = 0.28 * 4.0 / 6.0
    for _ in range(60):
        state = plant.advance(0.1, hold, 0.0, 0.005, 10)
    # No slip to speak of at 4 m/s: the yaw rate is the kinematic bicycle's, within 3 %.
    wheelbase = plant.geometry.wheelbase
    assert state.steer == pytest.approx(0.1, abs=1e-6)
    assert state.yaw_rate == pytest.approx(state.speed * math.tan(0.1) / wheelbase, rel=0.03)
    assert state.yaw > start[2]
    assert state.speed == pytest.approx(4.0, abs=0.15)
    plant.reset(*start)
    again = plant.advance(0.1, hold, 0.0, 0.005, 1)
    assert math.dist(again[:2], start[:2]) == pytest.approx(0.02, rel=0.05)


@pytest.mark.parametrize("name", [*COMMONROAD, CAR])
def test_plant_steering_is_no_faster_than_its_limit(name: str) -> None:
    plant = _plant(name)
    plant.reset(0.0, 0.0, 0.0, 3.0)
    fastest = MujocoCarParams().steer_rate if name == CAR else 0.4
    angles = [plant.advance(-1.5, 0.2, 0.0, 0.005, 10).steer for _ in range(60)]
    assert angles[0] == pytest.approx(-fastest * 0.05)
    assert max(-np.diff(angles)) <= fastest * 0.05 + 1e-9
    most = {"1": 0.91, "2": 1.066, "3": 1.023}.get(name[-1], 0.6)
    assert angles[-1] == pytest.approx(-min(most, fastest * 3.0))


@pytest.mark.parametrize("name", ["commonroad-st-1", "commonroad-std-2", CAR])
def test_plant_braked_to_rest_stays_there_and_starts_again(name: str) -> None:
    plant = _plant(name)
    plant.reset(0.0, 0.0, 0.0, 5.0)
    stopped = [plant.advance(0.05, 0.0, 1.0, 0.005, 10) for _ in range(60)][-1]
    assert abs(stopped.speed) < 1e-3
    assert 1.0 < stopped.x < 3.0
    moved = [plant.advance(0.0, 1.0, 0.0, 0.005, 10) for _ in range(40)][-1]
    assert moved.speed > 5.0


def test_multi_body_at_low_speed_says_so() -> None:
    plant = _plant("commonroad-mb-2")
    path = _path()
    for speed in (0.0, 0.99, -3.0, math.nan):
        with pytest.raises(InputError, match="at least 1 m/s"):
            plant.reset(0.0, 0.0, 0.0, speed)
    with pytest.raises(InputError, match="commonroad-mb-2"):
        sim.run(popsteer.Pop(path), plant)
    slowed = sim.run(popsteer.Pop(path), plant, speed=3.0, longitudinal=_braking(path))
    assert slowed.ending.startswith("plant limit: speed 0.9")
    assert np.isfinite(slowed.records["x"]).all()


def _braking(path: popsteer.Path) -> popsteer.CoupledLongitudinal:
    return popsteer.CoupledLongitudinal(
        popsteer.CoupledLongitudinalParams(cutoff=0.0, speed_limit=0.5)
    )


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("commonroad-mb-1", "leaves the road"),
        ("commonroad-mb-2", "leaves the road"),
        ("commonroad-mb-3", "leaves the road"),
        ("commonroad-st-2", "what the tyres hold"),
    ],
)
def test_plant_beyond_its_grip_says_so(name: str, said: str) -> None:
    plant = _plant(name)
    plant.reset(0.0, 0.0, 0.0, 25.0)
    states: list[plants.PlantState] = []
    with pytest.raises(PlantLimit, match=said):
        states.extend(plant.advance(0.12, 0.9, 0.0, 0.005, 10) for _ in range(100))
    assert states
    assert np.isfinite(states).all()


@pytest.mark.parametrize("name", ["commonroad-std-2", CAR])
def test_plant_whose_tyres_saturate_turns_less_than_it_is_steered(name: str) -> None:
    plant = _plant(name)
    plant.reset(0.0, 0.0, 0.0, 15.0)
    states = [plant.advance(0.3, 0.7, 0.0, 0.005, 10) for _ in range(20)]
    kinematic = states[-1].speed * math.tan(states[-1].steer) / plant.geometry.wheelbase
    assert np.isfinite(states).all()
    assert 0.1 < states[-1].yaw_rate < 0.7 * kinematic


def test_mujoco_car_friction_sets_what_a_bend_allows() -> None:
    pytest.importorskip("mujoco")
    from popsteer.plants.mujoco_car import MujocoCar

    pulls = []
    for friction in (0.3, 0.9):
        car = MujocoCar(MujocoCarParams(friction=friction))
        car.reset(0.0, 0.0, 0.0, 10.0)
        states = [car.advance(0.2, 0.5, 0.0, 0.005, 10) for _ in range(30)]
        pulls.append(max(state.speed * state.yaw_rate for state in states))
    assert pulls[0] < 0.3 * 9.81 * 1.5
    assert pulls[1] > 1.5 * pulls[0]


def test_mujoco_car_far_from_the_origin_drives_the_same() -> None:
    plant = _plant(CAR)
    ends = []
    for x, y in ((0.0, 0.0), (5e3, -3e3)):
        plant.reset(x, y, 0.0, 8.0)
        for _ in range(20):
            state = plant.advance(0.1, 0.4, 0.0, 0.005, 10)
        ends.append((state.x - x, state.y - y, state.yaw))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)


def test_compare_on_a_plant_from_elsewhere_drives_every_law_from_the_same_start() -> None:
    plant = _plant("commonroad-mb-2")
    track = tracks.get("slalom")
    path = popsteer.Path(track.xy)
    comparison = study.compare(path, ["pop", "stanley"], plant, constant_speed=8.0)
    assert comparison.plant == "commonroad-mb-2"
    for run in comparison.runs.values():
        assert run.ending == "finished"
        assert run.metrics.settled_mean_abs_cross_track_error < 0.5
        assert run.records["cross_track_error"][0] == pytest.approx(-2.44, abs=0.01)
        assert run.params["wheelbase"] == plant.geometry.wheelbase


@pytest.mark.parametrize("speed", [10.0, 14.0])
def test_preview_pop_on_the_multi_body_car_errs_a_fifth_of_pop_at_most(speed: float) -> None:
    plant = _plant("commonroad-mb-2")
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    # 1 m to the right of the first waypoint.
    x, y, yaw = sim.default_start(path)
    share = 1.0 - 1.0 / sim.START_OFFSET
    start = (x + share * (path.x[0] - x), y + share * (path.y[0] - y), yaw)
    comparison = study.compare(
        path, ["pop", "preview-pop"], plant, start=start, constant_speed=speed
    )
    error = {
        law: run.metrics.settled_mean_abs_cross_track_error for law, run in comparison.runs.items()
    }
    assert [run.ending for run in comparison.runs.values()] == ["finished", "finished"]
    assert error["preview-pop"] <= 0.2 * error["pop"]
