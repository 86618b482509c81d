from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import laws, presets, sim
from popsteer.errors import ConfigError, InputError, PathError
from tests.closed_loop.paths import track

if TYPE_CHECKING:
    from popsteer.sim import Run

PLANTS = sim.plant_names()


def _law(name: str, path: popsteer.Path, plant: str) -> Any:
    params = sim.fitted(presets.get(name, "reproduction"), plant)
    return laws.get(name).controller(path, params)  # type: ignore[arg-type]


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
    """A law of popsteer, in the shape of a law of the user's own."""

    def __init__(self, law: Any, *, angle_alone: bool = False) -> None:
        self._law = law
        self._angle_alone = angle_alone
        self.reference_offset = law.reference_offset

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


def test_run_of_bang_bang_on_racetrack_leaves_the_road() -> None:
    metrics = sim.run(_law("bang-bang", track("racetrack"), "carla-identified")).metrics
    assert not metrics.finished
    assert metrics.max_abs_cross_track_error > 10.0


@pytest.mark.parametrize("name", ["circle", "figure-eight"])
def test_run_on_closed_track_goes_round_once(name: str) -> None:
    path = track(name)
    result = sim.run(popsteer.Pop(path))
    assert result.metrics.finished
    driven = result.metrics.mean_speed * result.metrics.time
    assert driven == pytest.approx(path.length, rel=0.05)


@pytest.mark.parametrize("longitudinal", [None, popsteer.SpeedPid()], ids=["coupled", "speed"])
@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("name", laws.names())
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
@pytest.mark.parametrize("name", laws.names())
def test_run_of_law_without_offset_measures_at_the_plants_axle(name: str, plant: str) -> None:
    path = track("straight")
    law = laws.get(name)
    result = sim.run(law.controller(path), plant, settings=sim.Settings(time_limit=0.1))
    at = sim.geometry(plant)
    wanted = {"front": at.front_offset, "rear": at.rear_offset, "pose": 0.0}[law.axle]
    ahead = result.records["reference_x"][0] - result.records["x"][0]
    assert ahead == pytest.approx(wanted, abs=1e-12)
    assert result.params["reference_offset"] == wanted


def test_run_keeps_an_offset_that_the_user_gave() -> None:
    params = popsteer.StanleyParams(reference_offset=2.0)
    result = sim.run(popsteer.Stanley(track("straight"), params))
    assert result.params["reference_offset"] == 2.0


def test_default_start_is_right_of_the_first_waypoint_along_the_path() -> None:
    path = popsteer.Path([(5.0, 5.0), (5.0, 15.0), (20.0, 30.0)])
    x, y, yaw = sim.default_start(path)
    assert (x, y) == pytest.approx((7.44, 5.0))
    assert yaw == pytest.approx(math.pi / 2)


def test_speed_pid_on_racetrack_follows_the_reference_speeds() -> None:
    path = track("racetrack")
    result = sim.run(popsteer.Pop(path), longitudinal=popsteer.SpeedPid())
    assert result.metrics.finished
    assert path.speed is not None
    assert result.metrics.mean_speed == pytest.approx(
        path.length / np.sum(np.diff(path.s) / path.speed[:-1]), rel=0.1
    )


def test_speed_pid_without_reference_speeds_is_refused() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(50)])
    with pytest.raises(PathError, match="no reference speeds"):
        sim.run(popsteer.Pop(path), longitudinal=popsteer.SpeedPid())


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


@pytest.mark.parametrize("field", sim.CarlaIdentified().as_dict())
def test_identified_plant_with_nan_is_refused_by_name(field: str) -> None:
    with pytest.raises(ConfigError) as caught:
        sim.CarlaIdentified(**{field: math.nan})
    assert caught.value.field == field


@pytest.mark.parametrize("field", sim.KinematicBicycle().as_dict())
def test_bicycle_plant_with_nan_is_refused_by_name(field: str) -> None:
    with pytest.raises(ConfigError) as caught:
        sim.KinematicBicycle(**{field: math.nan})
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


def test_own_law_that_raises_is_not_hidden() -> None:
    class Broken:
        def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
            raise ZeroDivisionError("in the law")

    with pytest.raises(ZeroDivisionError, match="in the law"):
        sim.run(Broken(), path=track("straight"))


def test_own_law_without_a_path_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="carries no path"):
        sim.run(Constant(0.0))


@pytest.mark.parametrize("own", [False, True])
def test_progress_that_raises_ends_the_run(own: bool) -> None:
    class StopError(Exception):
        pass

    def stop(share: float) -> None:
        raise StopError

    path = track("racetrack")
    law = _law("pop", path, "carla-identified")
    with pytest.raises(StopError):
        sim.run(Own(law) if own else law, path=path, progress=stop)


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
