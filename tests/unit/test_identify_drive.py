"""The drive of a car that shares no code with popsteer: delay, lag, gains, drag, grade."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import sim, vehicle_file
from popsteer.identification.pedals import fit_drive
from popsteer.logs import Log
from studies import logged
from studies.identify_acceptance import beyond_stop, drive_log, pedalled
from tests.cli import command

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("scipy")


@pytest.mark.parametrize("seed", range(6))
def test_drive_of_three_stops_is_found_on_the_level_and_on_hills(seed: int) -> None:
    car = pedalled(seed)
    found = fit_drive(drive_log(car, seed, hills=0.05 * (seed % 2)))
    assert found is not None
    assert found.values["drive_delay"] == pytest.approx(car.drive_delay, abs=0.02)
    assert found.values["drive_lag"] == pytest.approx(car.drive_lag, abs=0.03)
    assert found.values["drive"] == pytest.approx(car.throttle, rel=0.05)
    assert found.values["braking"] == pytest.approx(car.braking, rel=0.05)
    for name, truth in (("drive_delay", car.drive_delay), ("drive", car.throttle)):
        assert abs(found.values[name] - truth) < 4.0 * found.errors[name]
    pedals = sim.PedalMap(**found.pedals)
    assert pedals(2.0, 0.0)[0] == pytest.approx(2.0 / car.throttle, rel=0.05)


def test_drive_of_a_small_robot_is_found_though_its_rest_is_noisy() -> None:
    # What is 0.1 m/s of a car would be 0.012 m/s of it, less than the noise of its speed.
    car = pedalled(3)
    found = fit_drive(drive_log(car, 3), size=0.12)
    assert found is not None
    assert found.values["drive_delay"] == pytest.approx(car.drive_delay, abs=0.02)
    assert found.values["drive_lag"] == pytest.approx(car.drive_lag, abs=0.03)
    assert found.values["braking"] == pytest.approx(car.braking, rel=0.05)


@pytest.mark.parametrize("seed", [7, 8])
def test_car_stops_in_its_place_with_the_file_of_three_stops(seed: int, tmp_path: Path) -> None:
    car, file = pedalled(seed), tmp_path / "car.toml"
    log = Log(**logged.log("brisk", car, seed))
    popsteer.identify(log, stops=drive_log(car, seed)).save(file)
    assert abs(beyond_stop(car, file, seed)) < 0.05
    # It is the drive in the file that brings it there.
    text = re.sub(r"^drive_(delay|lag) = .*$", "", file.read_text(), flags=re.MULTILINE)
    file.write_text(text)
    assert abs(beyond_stop(car, file, seed)) > 0.05


@pytest.mark.parametrize("seed", [2, 5])
def test_brake_that_holds_the_car_for_a_moment_is_not_taken_for_the_drive(seed: int) -> None:
    car = pedalled(seed)
    log = drive_log(car, seed, starts=6)
    # Of each rest the last 0.6 s are kept, in which the brake has long arrived.
    moves = np.abs(log.speed) > 0.1
    kept = moves.copy()
    for k in np.flatnonzero(np.diff(moves.astype(int)) == 1):
        kept[max(k - 11, 0) : k + 1] = True
    columns = {name: values[kept] for name, values in log.as_dict().items()}
    columns["t"] = 0.05 * np.arange(int(kept.sum()))
    signals = {name: np.asarray(values)[kept] for name, values in log.signals.items()}
    found = fit_drive(Log(**columns, signals=signals))
    assert found is not None
    truth = {"drive_delay": car.drive_delay, "drive_lag": car.drive_lag, "drive": car.throttle}
    truth |= {"braking": car.braking, "drag": car.drag}
    for name in truth.keys() & found.errors.keys():
        assert abs(found.values[name] - truth[name]) < 3.5 * found.errors[name], name
    assert {"drive_delay", "drive_lag"} <= found.errors.keys()


def test_drive_of_a_long_log_is_that_of_the_minutes_in_which_most_is_commanded() -> None:
    car = pedalled(1)
    log = drive_log(car, 1, starts=6)
    # It stands for six minutes, drives, and stands again.
    before, after = 7200, 1200
    count = before + len(log) + after

    def padded(values: Any) -> Any:
        return np.pad(np.asarray(values), (before, after), "edge")

    columns = {name: padded(values) for name, values in log.as_dict().items()}
    columns |= {"t": 0.05 * np.arange(count), "speed": np.pad(log.speed, (before, after))}
    signals = {name: padded(values) for name, values in log.signals.items()}
    signals["throttle"][:before] = 0.0
    found, short = fit_drive(Log(**columns, signals=signals)), fit_drive(log)
    assert found is not None
    assert short is not None
    for name, error in short.errors.items():
        assert found.values[name] == pytest.approx(short.values[name], abs=error), name


def test_log_that_begins_with_throttle_at_rest_shows_the_lag() -> None:
    # Before it the pedals were not what they are in the first row.
    car = replace(pedalled(8), drive_lag=0.5)
    found = fit_drive(drive_log(car, 8))
    assert found is not None
    assert found.values["drive_lag"] == pytest.approx(car.drive_lag, abs=0.03)
    assert found.values["braking"] == pytest.approx(car.braking, rel=0.03)


def test_hills_without_their_height_are_not_taken_for_the_drive() -> None:
    car = pedalled(1)
    log = drive_log(car, 1, hills=0.05)
    blind = Log(**log.as_dict(), signals={k: v for k, v in log.signals.items() if k != "z"})
    found = fit_drive(blind)
    assert found is not None
    for name, error in found.errors.items():
        truth = {"drive": car.throttle, "braking": car.braking, "drag": car.drag, "air_drag": 0.0}
        truth |= {"drive_delay": car.drive_delay, "drive_lag": car.drive_lag}
        assert abs(found.values[name] - truth[name]) < 5.0 * error, name


def test_other_commands_give_their_gain() -> None:
    car = replace(pedalled(2), throttle=1.0, braking=1.0, drag=0.0)
    columns = logged.stops(replace(car, throttle=4.0, braking=8.0), 3)
    wanted = 4.0 * columns["throttle"] - 8.0 * columns["brake"]
    poses = {name: columns[name] for name in ("t", "x", "y", "yaw", "speed", "steer")}
    # Of an acceleration that is scaled by 0.8 on its way.
    found = fit_drive(Log(**poses, signals={"acceleration_command": wanted / 0.8}))
    assert found is not None
    assert found.values["gain"] == pytest.approx(0.8, rel=0.05)
    assert found.values["drive_delay"] == pytest.approx(car.drive_delay, abs=0.02)
    # A commanded speed, which the car has 0.97 of, after a delay and a lag.
    t = 0.05 * np.arange(1200)
    given = 2.0 + np.floor(t / 6.0) % 3
    speed = np.zeros_like(t)
    for k in range(1, len(t)):
        late = given[max(k - 1 - 4, 0)]
        speed[k] = speed[k - 1] + (0.97 * late - speed[k - 1]) * (1.0 - np.exp(-0.05 / 0.4))
    noisy = speed + 0.02 * np.random.default_rng(1).standard_normal(len(t))
    zero = 0.0 * t
    x = np.cumsum(0.05 * speed)
    found = fit_drive(Log(t, x, zero, zero, noisy, zero, signals={"speed_command": given}))
    assert found is not None
    assert found.values["gain"] == pytest.approx(0.97, rel=0.02)
    assert found.values["drive_delay"] == pytest.approx(0.2, abs=0.02)
    assert found.values["drive_lag"] == pytest.approx(0.4, abs=0.03)


def test_drive_that_is_not_shown_is_asked_for_and_one_without_commands_is_none() -> None:
    car = pedalled(4)
    log = drive_log(car, 4)
    assert fit_drive(Log(**log.as_dict())) is None
    steady = {"throttle": 0.2 + 0.002 * np.sin(log.t), "brake": 0.0 * log.t}
    poses = log.as_dict() | {
        "speed": 8.0 + 0.02 * np.random.default_rng(0).standard_normal(len(log))
    }
    found = fit_drive(Log(**poses, signals=steady))
    assert found is not None
    assert {"drive_delay", "drive_lag", "drive"} <= set(found.unknown)
    assert "drive three stops and starts" in found.unknown["drive_delay"]
    assert found.pedals == {}


def test_file_says_of_each_number_what_it_is_and_carries_the_pedals(tmp_path: Any) -> None:
    car = logged.Car()
    told = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, max_steer=0.6)
    found = popsteer.identify(Log(**logged.log("brisk", car, 1)), told, stops=drive_log(car, 1))
    file = tmp_path / "car.toml"
    found.save(file)
    assert popsteer.Vehicle.load(file) == found.vehicle
    lines: list[str] = file.read_text().splitlines()

    def above(key: str) -> str:
        return next(
            lines[k - 1] for k, line in enumerate(lines) if line.lstrip("# ").startswith(key)
        )

    assert above("dead_time =").startswith("# identified: ± ")
    assert above("drive_delay =").startswith("# identified: ± ")
    assert above("max_steer =") == "# given"
    assert above("max_lateral_acceleration =") == "# default"
    # What equals its default is what it was all the same.
    same = replace(found, vehicle=found.vehicle.replace(dead_time=0.0))
    lines = same.as_toml(["max_lateral_acceleration"]).splitlines()
    assert above("dead_time =").startswith("# identified: ± ")
    assert above("max_lateral_acceleration =") == "# given"
    assert {"dead_time = 0.0", "max_lateral_acceleration = 4.0"} <= set(lines)
    pedals = sim.PedalMap.load(file)
    assert pedals.drive == pytest.approx(car.throttle, rel=0.05)
    assert pedals.braking == pytest.approx(car.braking, rel=0.05)
    # The same map drives a plant.
    plant = sim.KinematicBicycle(found.vehicle, drive=pedals.drive, braking=pedals.braking)
    assert sim.PedalMap.of(plant).drive == pedals.drive
    for text, message in (
        ("", r"\[pedals\] in the vehicle file"),
        ("[pedals]\nspring = 1\n", "spring"),
    ):
        file.write_text(text)
        with pytest.raises(popsteer.ConfigError, match=message):
            sim.PedalMap.load(file)


def test_commands_say_which_defaults_a_drive_hangs_on(
    capsys: pytest.CaptureFixture[str], tmp_path: Any
) -> None:
    file, log = tmp_path / "car.toml", command.write_csv(tmp_path / "drive.csv", command.drive())
    rest = "wheelbase = 2.7\nundersteer = 0.0\nsteer_lag = 0.1\n"
    for text, said in (
        ("wheelbase = 2.7\n", "does not set: understeer = 0, steer_lag = 0.1, dead_time = 0"),
        (rest, "does not set: dead_time = 0"),
        (rest + "dead_time = 0.2\n", None),
        (rest.split("\n", 1)[1] + "dead_time = 0.2\n", "does not set: wheelbase = "),
    ):
        file.write_text(text)
        outcome = command.call(capsys, "replay", str(log), "--vehicle", str(file))
        shown = " ".join(outcome.out.split())
        assert ("does not set" in shown) == (said is not None)
        assert said is None or said in shown
    assert vehicle_file.defaults(file, 5.0, 0.31) == ["wheelbase", "max_steer_rate"]
    assert vehicle_file.defaults(file, 5.0, 0.29) == ["wheelbase"]
    file.write_text(rest + "dead_time = 0.2\n")
    turns = command.drive()
    turns["steer"] = 0.1 * np.sign(np.sin(6.0 * turns["t"]))
    fast = command.write_csv(tmp_path / "fast.csv", turns)
    outcome = command.call(capsys, "replay", str(fast), "--vehicle", str(file))
    assert "does not set: max_steer_rate = none" in " ".join(outcome.out.split())
    outcome = command.call(
        capsys,
        "compare",
        "--plant",
        "kinematic-bicycle",
        "--track",
        "double-lane-change",
        "--controllers",
        "stanley",
        "--vehicle",
        str(file),
    )
    assert "drive_delay = 0.1, drive_lag = 0" in " ".join(outcome.out.split())
