"""Plants in Python: the protocol, and the ones from elsewhere with their limits."""

from __future__ import annotations

import gc
import math
import sys
import weakref
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import lab, plants, sim, tracks
from popsteer.errors import ConfigError, InputError, PathError, PlantLimit, PopsteerError
from popsteer.plants.pedals import MujocoCarParams, PedalParams
from studies.chain import Chain
from tests.closed_loop.drives import Bicycle
from tests.closed_loop.paths import cusps, line, shuttle, track
from tests.helpers import authors_data

COMMONROAD = [name for name in plants.names() if name.startswith("commonroad-")]
CAR = "mujoco-car"
_PEDALS = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))


def _plant(name: str) -> Any:
    pytest.importorskip("mujoco" if name == CAR else "vehiclemodels")
    return plants.get(name)


class Straight:
    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        return 0.0


class Wrapped:
    """A controller of popsteer, in the shape of one of the user's own."""

    def __init__(self, path: popsteer.Path, car: popsteer.Vehicle) -> None:
        self.law = popsteer.Pop(path, car)
        self.tracked_point = self.law.tracked_point

    def step(self, *state: float) -> popsteer.Command:
        return self.law.step(*state)


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize(
    "changes", [{}, {"dead_time": 0.13, "steer_offset": 0.02}], ids=["plain", "late"]
)
@pytest.mark.parametrize("name", ["slalom", "cusps"])
def test_python_plant_like_one_of_the_core_gives_the_same_run(
    own: bool, changes: dict[str, float], name: str
) -> None:
    """Dead time and offset of its vehicle included, and driven backwards."""
    path = shuttle() if name == "cusps" else track("slalom")
    car = sim.vehicle_of("kinematic-bicycle").replace(**changes)
    pedals = popsteer.SpeedPid()
    of_core = sim.run(popsteer.Pop(path), sim.KinematicBicycle(car), longitudinal=pedals)
    law = Wrapped(path, car) if own else popsteer.Pop(path)
    in_python = sim.run(law, Bicycle(vehicle=car), path=path, longitudinal=pedals)
    assert in_python.plant == "python-bicycle"
    assert in_python.plant_vehicle == car
    assert in_python.metrics == of_core.metrics
    for column in ("x", "y", "yaw", "speed", "steer", "cross_track_error", "throttle"):
        np.testing.assert_array_equal(in_python.records[column], of_core.records[column])
    assert in_python.ending == of_core.ending == "finished"


CHAINS = {
    "as it is": {},
    "lag": {"steer_lag": 0.3},
    "dead time": {"dead_time": 0.23},
    "rate": {"max_steer_rate": 0.4},
    "offset": {"steer_offset": 0.03},
    "understeer": {"understeer": 0.01},
    "turning": {"turning_wheelbase": 3.6},
    "largest angle": {"max_steer": 0.15},
    "centre": {"rear_axle": -1.35},
    "slipping": {"rear_axle": -1.9, "no_slip_point": 0.1},
    "all": {
        "steer_lag": 0.15,
        "dead_time": 0.15,
        "max_steer_rate": 0.4,
        "steer_offset": -0.02,
        "understeer": 0.002,
        "turning_wheelbase": 2.9,
        "max_steer": 0.3,
        "rear_axle": -1.35,
    },
}


@pytest.mark.parametrize("speed", [8.0, -5.0])
@pytest.mark.parametrize("chain", CHAINS)
def test_bicycle_does_what_its_vehicle_says(chain: str, speed: float) -> None:
    """As the chain of the documentation has it, integrated apart from the library."""
    start = (3.0, -2.0, 0.7)
    commands = [0.35 * math.sin(0.31 * k) + 0.2 * (k % 17 > 8) for k in range(120)]
    settings = sim.Settings(time_limit=1e3, give_up_distance=1e6, substeps=40)

    def driven(car: popsteer.Vehicle) -> Any:
        plant = sim.KinematicBicycle(car, drag=0.0)
        path = popsteer.Path([(-1e4, 0.0), (1e4, 0.0)])
        simulation = sim.Simulation(path, plant, start=start, speed=speed, settings=settings)
        for command in commands:
            simulation.step(command)
        return np.column_stack([simulation.records()[name] for name in ("x", "y", "yaw")])

    def expected(car: popsteer.Vehicle) -> Any:
        rolled, poses = Chain(car, start, speed, 0.05, substeps=100), []
        for command in commands:
            poses.append(rolled.pose)
            rolled.advance(command)
        return np.array(poses)

    plain = popsteer.Vehicle(wheelbase=2.7, max_steer=0.6)
    car = plain.replace(**CHAINS[chain])
    places = driven(car)
    np.testing.assert_allclose(places, expected(car), atol=0.005)
    assert np.ptp(places[:, 2]) > 0.3
    if chain != "as it is":
        # What is changed shows, by much more than the two agree.
        assert np.abs(places - expected(plain)).max() > 0.1


@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
@pytest.mark.parametrize(
    "changes",
    [{"steer_lag": 0.4}, {"dead_time": 0.3}, {"max_steer_rate": 0.2}, {"steer_offset": 0.05}],
    ids=str,
)
def test_plant_of_another_vehicle_moves_otherwise(plant: str, changes: dict[str, float]) -> None:
    kind: Any = {"carla-identified": sim.CarlaIdentified}.get(plant, sim.KinematicBicycle)
    ends = []
    for car in (kind().vehicle, kind().vehicle.replace(**changes)):
        simulation = sim.Simulation(line(), kind(car), start=(0.0, 0.0, 0.0), speed=8.0)
        for _ in range(20):
            simulation.step(0.1, 0.4)
        ends.append(simulation.state)
    assert math.dist(ends[0][:2], ends[1][:2]) > 0.05


def test_python_plant_and_its_simulation_are_let_go_of_together() -> None:
    plant: Any = Bicycle()
    plant.simulation = sim.Simulation(line(), plant, start=(0.0, 0.0, 0.0), speed=5.0)
    plant.simulation.drive(popsteer.Pop(line()))
    seen = weakref.ref(plant)
    del plant
    gc.collect()
    assert seen() is None


def test_object_that_is_no_plant_is_refused_by_what_it_lacks() -> None:
    class Half:
        name, vehicle = "half", popsteer.Vehicle()

    with pytest.raises(TypeError, match="which lacks reverses, reset, advance"):
        sim.run(popsteer.Pop(line()), Half())  # type: ignore[arg-type]


@pytest.mark.parametrize("law", [popsteer.Pop(line()), Straight()], ids=["law", "own law"])
def test_python_plant_at_its_limit_ends_the_run_and_says_which(law: Any) -> None:
    result = sim.run(law, Bicycle(last_x=30.0), path=line(), speed=5.0)
    assert result.ending == "plant limit: the end of the world"
    assert not result.metrics.finished
    assert len(result.records["x"]) == len(result.records["status"]) == result.metrics.steps > 10
    assert np.isfinite(result.records["x"]).all()
    assert 25.0 < result.records["x"][-1] <= 30.0


def test_simulation_at_a_limit_stays_over() -> None:
    simulation = sim.Simulation(line(), Bicycle(last_x=-2.0), start=(0.0, 0.0, 0.0), speed=50.0)
    assert (simulation.is_over, simulation.ending) == (False, None)
    simulation.step(0.0)
    assert simulation.is_over
    assert simulation.ending == "plant limit: the end of the world"
    simulation.drive(popsteer.Pop(line()))
    assert simulation.metrics()["steps"] == 1


def test_python_plant_error_reaches_the_caller() -> None:
    class Broken(Bicycle):
        def advance(self, *command: Any) -> plants.PlantState:
            raise RuntimeError("no fuel")

    class Nowhere(Bicycle):
        def advance(self, *command: Any) -> plants.PlantState:
            return plants.PlantState(math.nan, 0.0, 0.0, 1.0, 0.0, 0.0)

    for law in (popsteer.Pop(line()), Straight()):
        with pytest.raises(RuntimeError, match="no fuel"):
            sim.run(law, Broken(), path=line())
        with pytest.raises(InputError, match="x must be in"):
            sim.run(law, Nowhere(), path=line())


def test_run_endings_of_the_core_are_named() -> None:
    path = line()
    late = sim.run(popsteer.Pop(path), settings=sim.Settings(time_limit=2.0))
    assert late.ending == "time limit"
    lost = sim.run(Straight(), path=path, start=(0.0, 1.0, 1.0))
    assert lost.ending == "too far from the path"


def test_run_many_python_plant_is_refused() -> None:
    with pytest.raises(TypeError, match="python-bicycle, is none of the core's"):
        sim.run_many([popsteer.Pop(line())], [Bicycle()])  # type: ignore[list-item]


def test_constant_speed_is_kept() -> None:
    result = sim.run(popsteer.Pop(line(301)), constant_speed=12.0)
    assert result.records["speed"][0] == 12.0
    settled = result.records["time"] >= 5.0
    np.testing.assert_allclose(result.records["speed"][settled], 12.0, atol=0.1)
    rolling = sim.run(popsteer.Pop(line(301)), constant_speed=12.0, speed=3.0)
    assert rolling.records["speed"][0] == 3.0
    assert rolling.path.speed is None
    assert rolling.path.reverse is None
    with pytest.raises(ConfigError, match="constant_speed"):
        sim.run(popsteer.Pop(line()), constant_speed=-1.0)
    with pytest.raises(ConfigError, match="constant_speed"):
        sim.run(
            popsteer.Pop(line()), constant_speed=9.0, longitudinal=popsteer.CoupledLongitudinal()
        )


def test_plant_without_the_extra_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for name in ("commonroad-mb-2", CAR):
        with pytest.raises(PopsteerError, match=r"\(not installed: mujoco\)"):
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
    wheelbase = plant.vehicle.wheelbase
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
    assert (plant.vehicle.max_steer, plant.vehicle.max_steer_rate) == (most, fastest)


@pytest.mark.parametrize("name", [*COMMONROAD, CAR])
def test_plant_says_what_it_is(name: str) -> None:
    plant = _plant(name)
    wheelbase = {"1": 2.393, "2": 2.579, "3": 2.472}.get(name[-1], 2.7)
    grip = 9.81 if name == CAR else 1.0489 * 9.81
    car = plant.vehicle
    assert car.wheelbase == pytest.approx(wheelbase, abs=1e-3)
    # The VW Vanagon is as high as half its track, and overturns before it slides.
    limit = 7.189 if name.endswith("-3") else 0.8 * grip
    assert car.max_lateral_acceleration == pytest.approx(limit, rel=1e-4)
    assert (car.rear_axle, car.no_slip_point, car.steer_lag) == (0.0, None, 0.1)
    assert (car.dead_time, car.steer_offset) == (0.0, 0.0)
    assert plant.reverses is (name == CAR)
    assert plant.with_params(plant.params.replace(drag=0.0)).vehicle == car


@pytest.mark.parametrize("name", ["commonroad-st-2", CAR])
def test_plant_with_dead_time_and_offset_answers_later_and_elsewhere(name: str) -> None:
    plain = _plant(name)
    late = type(plain)(*(["st", 2] if name != CAR else []), dead_time=0.2, steer_offset=0.05)
    assert late.vehicle == plain.vehicle.replace(dead_time=0.2, steer_offset=0.05)
    assert late.with_params(late.params.replace(drag=0.1)).vehicle == late.vehicle
    turned = []
    for plant in (plain, late):
        simulation = sim.Simulation(line(), plant, start=(0.0, 0.0, 0.0), speed=5.0)
        yaws = []
        for _ in range(20):
            simulation.step(0.1, 0.3)
            yaws.append(simulation.state[2])
        turned.append(yaws)
    # For 0.2 s the offset acts alone, then it adds to the command.
    assert 0.0 < turned[1][3] < turned[0][3]
    rates = [yaws[-1] - yaws[-2] for yaws in turned]
    assert rates[1] == pytest.approx(1.5 * rates[0], rel=0.15)
    with pytest.raises(ConfigError, match="dead_time must be in"):
        type(plain)(*(["st", 2] if name != CAR else []), dead_time=-1.0)


def test_mujoco_car_drives_backwards() -> None:
    plant = _plant(CAR)
    plant.reset(0.0, 0.0, 0.0, 2.0)
    stopped = [plant.advance(0.0, 0.0, 1.0, 0.005, 10, True) for _ in range(40)][-1]
    assert abs(stopped.speed) < 1e-3
    start = stopped.x
    states = [plant.advance(0.1, 0.2, 0.0, 0.005, 10, True) for _ in range(60)]
    speeds = [state.speed for state in states]
    assert speeds == sorted(speeds, reverse=True)
    assert states[-1].speed < -1.5
    assert states[-1].x < start - 2.0
    # Backwards to the left: the car turns to the right.
    turning = states[-1].speed * math.tan(0.1) / plant.vehicle.wheelbase
    assert states[-1].yaw_rate == pytest.approx(turning, rel=0.05)
    plant.reset(5.0, 0.0, 0.0, -3.0)
    rolling = plant.advance(0.0, 0.28 * 3.0 / 6.0, 0.0, 0.005, 10, True)
    assert rolling.speed == pytest.approx(-3.0, abs=0.05)
    assert rolling.x == pytest.approx(4.85, abs=0.01)
    braked = [plant.advance(0.0, 0.0, 1.0, 0.005, 10, True) for _ in range(40)][-1]
    assert abs(braked.speed) < 1e-3


def test_mujoco_car_parks_through_its_cusps() -> None:
    path, plant = cusps("parking"), _plant(CAR)
    start = sim.default_start(path, 0.0, plant.vehicle)
    result = sim.run(popsteer.PreviewPop(path), plant, start=start, longitudinal=_PEDALS)
    assert result.ending == "finished"
    assert result.records["speed"].min() < -0.5
    assert result.metrics.rear_axle_mean_abs_cross_track_error < 0.2
    assert result.metrics.rear_axle_max_abs_cross_track_error < 1.5


def test_commonroad_refuses_to_drive_backwards() -> None:
    plant = _plant("commonroad-st-2")
    plant.reset(0.0, 0.0, 0.0, 1.0)
    with pytest.raises(InputError, match="reverse must be False, as commonroad-st-2 does not"):
        plant.advance(0.0, 0.5, 0.0, 0.005, 10, True)
    path = cusps("parking")
    with pytest.raises(PathError, match="commonroad-st-2 does not reverse"):
        sim.run(popsteer.PreviewPop(path), plant, longitudinal=_PEDALS)


@pytest.mark.parametrize("name", ["commonroad-st-1", "commonroad-std-2", CAR])
def test_plant_braked_to_rest_stays_there_and_starts_again(name: str) -> None:
    plant = _plant(name)
    plant.reset(0.0, 0.0, 0.0, 5.0)
    steps = 24 if "std" in name else 60  # it stands after ten, and takes many near rest
    stopped = [plant.advance(0.05, 0.0, 1.0, 0.005, 10) for _ in range(steps)][-1]
    assert abs(stopped.speed) < 1e-3
    assert 1.0 < stopped.x < 3.0
    moved = [plant.advance(0.0, 1.0, 0.0, 0.005, 10) for _ in range(40)][-1]
    assert moved.speed > 5.0


def test_multi_body_at_low_speed_says_so() -> None:
    plant = _plant("commonroad-mb-2")
    path = line()
    for speed in (0.0, 0.99, -3.0, math.nan):
        with pytest.raises(InputError, match="at least 1 m/s"):
            plant.reset(0.0, 0.0, 0.0, speed)
    with pytest.raises(InputError, match="commonroad-mb-2"):
        sim.run(popsteer.Pop(path), plant, speed=0.0)
    aside = sim.default_start(path, -2.44, plant.vehicle)
    slowed = sim.run(popsteer.Pop(path), plant, start=aside, speed=3.0, longitudinal=_braking(path))
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


def test_plant_steered_the_other_way_moves_and_ends_as_in_a_mirror() -> None:
    sides = {"left": "right", "right": "left"}
    for name in plants.names():
        plant = _plant(name)
        twins = []
        for sign in (1.0, -1.0):
            plant.reset(0.0, 0.0, 0.0, 25.0)
            states: list[plants.PlantState] = []
            said = ""
            try:
                states.extend(plant.advance(sign * 0.12, 0.9, 0.0, 0.005, 10) for _ in range(40))
            except PlantLimit as error:
                said = " ".join(sides.get(word, word) for word in str(error).split())
                said = str(error) if sign > 0.0 else said
            across = np.array(
                [[state.y, state.yaw, state.yaw_rate, state.steer] for state in states]
            )
            along = np.array([[state.x, state.speed] for state in states])
            twins.append((said, np.hstack((along, sign * across))))
        assert twins[0][0] == twins[1][0], name
        # The measured tyres of the drift model pull a little to one side.
        most = 0.5 if "-std-" in name else 5e-3
        assert twins[1][1] == pytest.approx(twins[0][1], rel=0.0, abs=most), name


@pytest.mark.parametrize("name", ["commonroad-std-2", CAR])
def test_plant_whose_tyres_saturate_turns_less_than_it_is_steered(name: str) -> None:
    plant = _plant(name)
    plant.reset(0.0, 0.0, 0.0, 15.0)
    states = [plant.advance(0.3, 0.7, 0.0, 0.005, 10) for _ in range(20)]
    kinematic = states[-1].speed * math.tan(states[-1].steer) / plant.vehicle.wheelbase
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
    path = popsteer.Path(tracks.get("slalom").xy)
    comparison = lab.compare.run(
        path,
        ["pop", "stanley"],
        plant,
        start=sim.default_start(path, -2.44, plant.vehicle),
        constant_speed=8.0,
    )
    assert comparison.plant == "commonroad-mb-2"
    for run in comparison.runs.values():
        assert run.ending == "finished"
        assert run.metrics.settled_mean_abs_cross_track_error < 0.5
        assert run.records["cross_track_error"][0] == pytest.approx(-2.44, abs=0.01)
        assert run.vehicle == run.plant_vehicle == plant.vehicle


@pytest.mark.parametrize("speed", [10.0, 14.0])
def test_preview_pop_on_the_multi_body_car_errs_a_fifth_of_pop_at_most(speed: float) -> None:
    plant = _plant("commonroad-mb-2")
    whole = popsteer.Path.from_csv(authors_data() / "waypoints.csv", columns="x,y,speed")
    half = np.column_stack((whole.x, whole.y))[: len(whole) // 2]  # bends to both sides
    path = popsteer.Path(half)
    start = sim.default_start(path, -1.0, plant.vehicle)
    comparison = lab.compare.run(
        path, ["pop", "preview-pop"], plant, start=start, constant_speed=speed
    )
    error = {
        law: run.metrics.settled_mean_abs_cross_track_error for law, run in comparison.runs.items()
    }
    assert [run.ending for run in comparison.runs.values()] == ["finished", "finished"]
    assert error["preview-pop"] <= 0.2 * error["pop"]
