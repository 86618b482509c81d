from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import controllers, presets, sim
from popsteer.errors import ConfigError, InputError
from tests.closed_loop.drives import Bicycle
from tests.closed_loop.paths import line, track

if TYPE_CHECKING:
    from popsteer.sim import Run

PLANTS = sim.plant_names()
SPEED = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))


def _law(name: str, path: popsteer.Path, plant: str) -> Any:
    params = presets.get(name, "reproduction")
    return controllers.get(name).controller(path, sim.vehicle_of(plant), params)  # type: ignore[arg-type]


def _same(left: Run, right: Run) -> bool:
    return (
        repr(left.metrics) == repr(right.metrics)  # repr, because nan differs from itself
        and left.records.keys() == right.records.keys()
        and all(
            np.array_equal(left.records[key].view(np.uint8), right.records[key].view(np.uint8))
            for key in left.records
        )
    )


class Own:
    """A controller of popsteer, in the shape of one of the user's own."""

    def __init__(self, law: Any, *, angle_alone: bool = False) -> None:
        self._law = law
        self._angle_alone = angle_alone
        self.tracked_point = law.tracked_point

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> Any:
        command = self._law.step(x, y, yaw, speed, dt)
        return command.steer if self._angle_alone else command


class Constant:
    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> Any:
        return self.answer


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("name", ["pid", "pure-pursuit", "stanley", "pop"])
def test_run_of_each_law_on_racetrack_finishes(name: str, plant: str) -> None:
    path = track("racetrack")
    result = sim.run(_law(name, path, plant), plant)
    assert result.metrics.finished
    assert result.metrics.max_abs_steer <= 1.22
    assert result.plant == plant
    assert result.law == name


@pytest.mark.parametrize("name", ["circle", "figure-eight"])
def test_run_on_closed_track_goes_round_once(name: str) -> None:
    path = track(name)
    result = sim.run(popsteer.Pop(path))
    assert result.metrics.finished
    driven = result.metrics.mean_speed * result.metrics.time
    assert driven == pytest.approx(path.length, rel=0.05)


@pytest.mark.parametrize("longitudinal", [None, popsteer.SpeedPid()], ids=["coupled", "speed"])
@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("name", controllers.names())
def test_own_law_driven_step_by_step_gives_the_same_bits(
    name: str, plant: str, longitudinal: Any
) -> None:
    path = track("slalom")
    core = sim.run(_law(name, path, plant), plant, longitudinal=longitudinal)
    own = Own(_law(name, path, plant))
    stepped = sim.run(own, plant, path=path, longitudinal=longitudinal)
    assert core.metrics.steps > 100
    assert _same(core, stepped)


def test_own_law_that_returns_the_angle_alone_drives_the_same() -> None:
    path = track("slalom")
    command = sim.run(Own(_law("pop", path, "carla-identified")), path=path)
    angle = sim.run(Own(_law("pop", path, "carla-identified"), angle_alone=True), path=path)
    assert command.metrics == angle.metrics
    assert np.isnan(angle.records["target_x"]).all()
    assert angle.law == "Own"


def test_run_twice_gives_the_same_bits() -> None:
    law = _law("pop", track("racetrack"), "carla-identified")
    first = sim.run(law)
    law.step(3.0, 1.0, 0.2, 5.0, 0.05)  # the state of the object does not matter
    assert _same(first, sim.run(law))


def test_run_leaves_the_state_of_the_law_alone() -> None:
    law = popsteer.Pop(track("slalom"))
    before = law.state
    sim.run(law)
    assert law.state == before


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("name", controllers.names())
def test_run_of_controller_without_vehicle_takes_the_plants(name: str, plant: str) -> None:
    path = track("straight")
    car = sim.vehicle_of(plant)
    settings = sim.Settings(time_limit=2.0)
    given = sim.run(controllers.get(name).controller(path, car), plant, settings=settings)
    left = sim.run(controllers.get(name).controller(path), plant, settings=settings)
    assert _same(given, left)
    assert left.vehicle == left.plant_vehicle == car
    slips = car.rear_axle if car.no_slip_point is None else car.no_slip_point
    wanted = {"pure-pursuit": car.rear_axle, "preview-pop": slips}.get(name, car.front_axle)
    ahead = left.records["reference_x"][0] - left.records["x"][0]
    assert ahead == pytest.approx(wanted, abs=1e-12)


def test_run_of_controller_without_vehicle_adapts_as_its_kind_does_on_the_plant() -> None:
    late = sim.KinematicBicycle(popsteer.Vehicle(dead_time=0.2))
    path = track("slalom")
    given = popsteer.Pop(path, late.vehicle)
    assert given.adapt is not None
    assert _same(sim.run(popsteer.Pop(path), late), sim.run(given, late))
    never = sim.run(popsteer.Pop(path, adapt=None), late)
    assert _same(never, sim.run(popsteer.Pop(path, late.vehicle, adapt=None), late))
    assert never.metrics != sim.run(given, late).metrics


def test_run_keeps_what_the_controller_was_told_beside_what_the_plant_is() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)
    plant = sim.KinematicBicycle(car.replace(understeer=0.01, steer_lag=0.3))
    given = popsteer.Stanley(track("slalom"), car)
    result = sim.run(given, plant)
    assert (result.vehicle, result.plant_vehicle) == (car, plant.vehicle)
    assert result.params["softening"] == given.params.resolved(car).softening
    assert result.metrics != sim.run(popsteer.Stanley(track("slalom")), plant).metrics


def test_run_of_controller_with_the_pose_elsewhere_is_refused() -> None:
    path = track("straight")
    for law in (popsteer.Pop(path, popsteer.Vehicle()), Believing(path, popsteer.Vehicle())):
        with pytest.raises(ConfigError, match=r"rear_axle must be .* -1.94, got 0.0") as caught:
            sim.run(law, "carla-identified")
        assert (caught.value.field, caught.value.value) == ("rear_axle", 0.0)
    amid = sim.vehicle_of("carla-identified").replace(wheelbase=2.5, dead_time=0.1)
    assert sim.run(Believing(path, amid)).vehicle == amid
    with pytest.raises(ConfigError, match="rear_axle"):
        sim.run_many(popsteer.Pop(path, popsteer.Vehicle()), "carla-identified")


class Believing:
    """One that says what it believes."""

    def __init__(self, path: popsteer.Path, vehicle: popsteer.Vehicle) -> None:
        self.path, self.vehicle = path, vehicle

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        return -0.1 * y - yaw


def test_default_start_is_on_the_first_waypoint_along_the_path() -> None:
    path = popsteer.Path([(5.0, 5.0), (5.0, 15.0), (20.0, 30.0)])
    for car in (popsteer.Vehicle(), popsteer.Vehicle(wheelbase=2.0, rear_axle=-1.2)):
        x, y, yaw = sim.default_start(path, vehicle=car)
        assert (x, y + car.front_axle) == pytest.approx((5.0, 5.0))
        assert yaw == pytest.approx(math.pi / 2)
    assert sim.default_start(path) == sim.default_start(path, 0.0, popsteer.Vehicle())


def test_default_start_of_a_path_that_begins_backwards_looks_against_it() -> None:
    back = popsteer.Path([(0.0, 0.0), (-10.0, 0.0), (-20.0, 0.0)], speed=[-2.0, -2.0, -2.0])
    car = popsteer.Vehicle(rear_axle=-1.5)
    x, y, yaw = sim.default_start(back, 1.0, car)
    # The rear axle stands on the first waypoint; 1 m to the left of the way is to the right of x.
    assert (x, y, yaw) == pytest.approx((1.5, -1.0, 0.0))
    result = sim.run(popsteer.PreviewPop(back), sim.KinematicBicycle(car), longitudinal=SPEED)
    assert result.ending == "finished"
    assert result.records["speed"].min() < -1.5


@pytest.mark.parametrize("plant", PLANTS)
def test_start_at_an_axle_is_the_pose_of_the_vehicles_point(plant: str) -> None:
    car = sim.vehicle_of(plant)
    path = track("racetrack")
    at = (30.0, 2.0, 0.4)
    places: list[tuple[sim.StartAt, float]]
    places = [("pose", 0.0), ("rear", car.rear_axle), ("front", car.front_axle)]
    for place, ahead in places:
        settings = sim.Settings(time_limit=0.1)
        result = sim.run(popsteer.Pop(path), plant, start=at, start_at=place, settings=settings)
        records = result.records
        x, y = records["x"][0] + ahead * math.cos(0.4), records["y"][0] + ahead * math.sin(0.4)
        assert (x, y) == pytest.approx(at[:2], abs=1e-12)
        assert result.start == (records["x"][0], records["y"][0], records["yaw"][0])
        many = sim.run_many(popsteer.Pop(path), plant, start=at, start_at=place, settings=settings)
        column = many["max_abs_cross_track_error"]
        assert column.tolist() == [result.metrics.max_abs_cross_track_error]
    with pytest.raises(ConfigError, match="unknown start_at 'axle'; known: pose, rear, front"):
        sim.run(popsteer.Pop(path), start=at, start_at="axle")  # type: ignore[arg-type]


def test_speed_pid_on_racetrack_follows_the_reference_speeds() -> None:
    path = track("racetrack")
    result = sim.run(popsteer.Pop(path), longitudinal=popsteer.SpeedPid())
    assert result.metrics.finished
    assert path.speed is not None
    assert result.metrics.mean_speed == pytest.approx(
        path.length / np.sum(np.diff(path.s) / path.speed[:-1]), rel=0.1
    )


def test_speed_pid_on_a_path_without_speeds_keeps_planned_ones() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(100)])
    car = popsteer.vehicles.get("carla-identified").replace(max_speed=6.0)
    run = sim.run(popsteer.Pop(path, car), longitudinal=popsteer.SpeedPid())
    assert run.metrics.finished
    assert run.path is path
    # Its integral overshoots by a tenth.
    assert 5.0 < run.records["speed"].max() < 7.0


def test_unknown_plant_is_refused_with_the_known_ones() -> None:
    path = track("straight")
    with pytest.raises(ConfigError, match="unknown plant 'tank'; known: carla-identified, kin"):
        sim.run(popsteer.Pop(path), "tank")


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("dt", 0.0),
        ("dt", -0.05),
        ("dt", math.nan),
        ("substeps", 0),
        ("time_limit", math.inf),
        ("give_up_distance", -1.0),
        ("stop_distance", -1.0),
        ("settling_time", math.nan),
    ],
)
def test_settings_out_of_range_are_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(ConfigError) as caught:
        sim.Settings(**{field: value})
    assert caught.value.field == field


def _numbers(plant: sim.CarlaIdentified | sim.KinematicBicycle) -> list[str]:
    return [field for field in plant.as_dict() if field != "vehicle"]


@pytest.mark.parametrize("field", _numbers(sim.CarlaIdentified()))
def test_identified_plant_with_nan_is_refused_by_name(field: str) -> None:
    with pytest.raises(ConfigError) as caught:
        sim.CarlaIdentified().replace(**{field: math.nan})
    assert caught.value.field == field


@pytest.mark.parametrize("field", _numbers(sim.KinematicBicycle()))
def test_bicycle_plant_with_nan_is_refused_by_name(field: str) -> None:
    with pytest.raises(ConfigError) as caught:
        sim.KinematicBicycle().replace(**{field: math.nan})
    assert caught.value.field == field


def test_start_that_is_not_finite_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="yaw must be"):
        sim.run(popsteer.Pop(track("straight")), start=(0.0, 0.0, math.inf))


@pytest.mark.parametrize("angle", [math.nan, math.inf, 3.0])
def test_own_law_with_a_bad_angle_is_refused(angle: float) -> None:
    with pytest.raises(InputError, match="steer"):
        sim.run(Constant(angle), path=track("straight"))


@pytest.mark.parametrize("answer", [None, "left", (0.1,)])
def test_own_law_without_an_angle_is_a_type_error(answer: Any) -> None:
    with pytest.raises(TypeError, match=r"must return an angle or have \.steer"):
        sim.run(Constant(answer), path=track("straight"))


class Watching:
    """Drives straight on, and takes note of what it sees."""

    def __init__(self) -> None:
        self.seen: list[tuple[float, ...]] = []

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        self.seen.append((x, y, yaw, speed))
        return 0.0


@pytest.mark.parametrize("plant", [*PLANTS, "python"])
def test_noise_of_each_quantity_has_its_own_deviation(plant: str) -> None:
    noise = sim.Noise(position=0.5, yaw=0.02, speed=0.1)
    moved: Any = Bicycle() if plant == "python" else plant
    watching = Watching()
    result = sim.run(
        watching, moved, path=line(1201), start=(0.0, 0.0, 0.0), constant_speed=8.0, noise=noise
    )
    columns = np.column_stack([result.records[name] for name in ("x", "y", "yaw", "speed")])
    off = np.array(watching.seen) - columns
    assert len(off) > 2000
    assert off.std(axis=0) == pytest.approx([0.5, 0.5, 0.02, 0.1], rel=0.1)
    assert np.abs(np.corrcoef(off.T) - np.eye(4)).max() < 0.1
    # What is measured is without noise: the car went straight.
    assert result.metrics.max_abs_cross_track_error == 0.0


@pytest.mark.parametrize("own", [False, True])
def test_noise_comes_from_its_seed_alone(own: bool) -> None:
    noise = sim.Noise(position=0.1, yaw=0.005, speed=0.1)
    path = track("slalom")

    def run(seed: int) -> Run:
        law = _law("stanley", path, PLANTS[0])
        return sim.run(Own(law) if own else law, path=path, noise=noise, seed=seed)

    assert _same(run(3), run(3))
    assert run(3).metrics != run(4).metrics
    many = sim.run_many(_law("stanley", path, PLANTS[0]), noise=noise, seed=3)
    assert many["rms_steer_rate"].tolist() == [run(3).metrics.rms_steer_rate]
    silent = sim.run(_law("stanley", path, PLANTS[0]), noise=sim.Noise(), seed=3)
    assert _same(silent, sim.run(_law("stanley", path, PLANTS[0])))


@pytest.mark.parametrize("seed", [-1, 2**64])
def test_seed_out_of_range_is_refused(seed: int) -> None:
    with pytest.raises(ConfigError, match="seed must be a count in"):
        sim.run(popsteer.Pop(track("slalom")), seed=seed)


def test_own_law_that_raises_is_not_hidden() -> None:
    class Broken:
        def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
            raise ZeroDivisionError("in the law")

    with pytest.raises(ZeroDivisionError, match="in the law"):
        sim.run(Broken(), path=track("straight"))


def test_own_law_without_a_path_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="carries no path"):
        sim.run(Constant(0.0))


class Slow:
    """Takes its time over a step [s]."""

    def __init__(self, seconds: float) -> None:
        self.seconds, self.steps = seconds, 0

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        self.steps += 1
        time.sleep(self.seconds)
        return 0.0


class StopError(Exception):
    pass


def _stop(share: float) -> None:
    raise StopError


def test_progress_that_raises_ends_the_run() -> None:
    law = popsteer.Pop(popsteer.Path([(0.0, 0.0), (1e6, 0.0)]))
    with pytest.raises(StopError):
        sim.run(law, settings=sim.Settings(time_limit=1e6, keep_records=False), progress=_stop)


def test_progress_is_looked_at_every_tenth_of_a_second_whatever_a_step_takes() -> None:
    slow = Slow(0.03)
    with pytest.raises(StopError):
        sim.run(slow, path=line(), progress=_stop)
    assert slow.steps < 20
    quick, shares = Slow(0.002), []

    def look(share: float) -> None:
        shares.append(share)
        if len(shares) == 4:
            raise StopError

    with pytest.raises(StopError):
        sim.run(quick, path=line(), settings=sim.Settings(time_limit=1e4), progress=look)
    assert quick.steps > len(shares)  # by far, unless a machine takes 0.1 s for each step
    assert shares == sorted(shares)


def test_heading_errors_of_a_run_to_the_west_are_wrapped() -> None:
    west = popsteer.Path([(-float(x), 0.0) for x in range(61)])
    result = sim.run(popsteer.Stanley(west), start=(0.0, 0.5, 0.2 - math.pi))
    yaw = result.records["yaw"]
    expected = np.mod(yaw, 2.0 * math.pi) - math.pi
    for name in ("heading_error", "rear_heading_error"):
        assert np.abs(result.records[name] - expected).max() < 1e-9
    assert abs(expected[0] - 0.2) < 1e-9


def test_metrics_of_a_run_follow_from_its_records() -> None:
    result = sim.run(popsteer.Stanley(track("racetrack")))
    metrics, records = result.metrics, result.records
    error = np.abs(records["cross_track_error"])
    settled = records["time"] >= result.settings.settling_time - 0.5 * result.dt
    assert metrics.mean_abs_cross_track_error == pytest.approx(error.mean())
    assert metrics.rms_cross_track_error == pytest.approx(math.sqrt((error**2).mean()))
    assert metrics.max_abs_cross_track_error == error.max()
    assert metrics.settled_mean_abs_cross_track_error == pytest.approx(error[settled].mean())
    assert metrics.rear_axle_mean_abs_heading_error == pytest.approx(
        np.abs(records["rear_heading_error"]).mean()
    )
    rate = np.diff(records["steer"]) / result.dt
    assert metrics.rms_steer_rate == pytest.approx(math.sqrt((rate**2).mean()))
    assert metrics.max_abs_steer == np.abs(records["steer"]).max()
    assert metrics.steps == len(error)
    assert metrics.time == pytest.approx(metrics.steps * result.dt)
