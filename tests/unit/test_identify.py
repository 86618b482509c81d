from __future__ import annotations

import dataclasses
import math
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer._core import _Wheels as Wheels
from popsteer.identification import drive
from popsteer.identification.chain import Chain
from popsteer.identification.drive import prepare
from popsteer.identification.whiten import known
from popsteer.logs import Log, LogError
from popsteer.vehicle_file import as_toml
from studies.chain import Chain as Car

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("scipy")

CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    understeer=0.003,
    steer_offset=math.radians(-0.7),
    steer_lag=0.12,
    dead_time=0.2,
    max_steer=0.6,
)
DT = 0.05


def _commands(t: np.ndarray) -> np.ndarray:
    """Bends to both sides, and a driver who corrects."""
    steady = 0.08 * np.sin(0.35 * t) + 0.05 * np.sign(np.sin(0.6 * t))
    return steady + 0.02 * np.sin(2.3 * t)


def _speeds(t: np.ndarray) -> np.ndarray:
    return 8.0 + 3.5 * np.sin(0.11 * t)


def _drive(
    car: popsteer.Vehicle = CAR,
    seconds: float = 60.0,
    commands: Any = _commands,
    speeds: Any = _speeds,
    noise: float = 1.0,
    dt: float = DT,
) -> dict[str, Any]:
    """The log of a car that popsteer's simulation knows nothing of."""
    random = np.random.default_rng(7)
    t = dt * np.arange(round(seconds / dt))
    steer, speed = np.broadcast_to(commands(t), t.shape), np.broadcast_to(speeds(t), t.shape)
    mover = Car(car, (0.0, 0.0, 0.3), float(speed[0]), dt, substeps=10)
    poses = np.empty((len(t), 3))
    for k, (angle, now) in enumerate(zip(steer.tolist(), speed.tolist(), strict=True)):
        poses[k] = mover.pose
        mover.speed = now
        mover.advance(angle)
    poses += noise * random.standard_normal(poses.shape) * (0.02, 0.02, 0.002)
    x, y, yaw = poses.T
    measured = speed + noise * 0.02 * random.standard_normal(len(t))
    return {"t": t, "x": x, "y": y, "yaw": yaw, "speed": measured, "steer": steer.copy()}


@pytest.fixture(scope="module")
def columns() -> dict[str, Any]:
    return _drive()


def test_chain_moves_its_wheels_as_the_car_does() -> None:
    # Against the wheels in small steps, with all that a vehicle's chain has.
    car = CAR.replace(max_steer_rate=0.3)
    columns = _drive(car, seconds=20.0, noise=0.0)
    chain = Chain(prepare(Log(**columns)), "wheels")
    yaw = chain.yaw(
        turning_wheelbase=2.7,
        understeer=0.003,
        steer_offset=CAR.steer_offset,
        steer_lag=0.12,
        dead_time=0.2,
        max_steer_rate=0.3,
    )
    # The car starts with straight wheels, the simulation with those of the first command.
    settled = columns["t"] > 2.0
    difference = (yaw - columns["yaw"])[settled]
    assert np.ptp(difference) < 2e-3


def test_wheels_turn_as_in_small_steps() -> None:
    times = np.array([1.0, 1.4, 2.0, 2.05, 3.5])
    commands = np.array([0.1, 0.3, -0.2, 0.0, 0.4])
    h = 1e-4
    for lag, rate in ((0.2, None), (0.2, 0.3), (0.05, 0.6), (0.0, 0.25)):
        wheels = Wheels(times, commands, lag, rate)
        fine = np.arange(0.0, 6.0, h)
        asked = commands[np.clip(np.searchsorted(times, fine, side="right") - 1, 0, None)]
        angle, angles = 0.1, []
        for target in asked.tolist():
            angles.append(angle)
            wanted = (target - angle) / max(lag, h)
            angle += h * (wanted if rate is None else max(-rate, min(wanted, rate)))
        # From the first command on, and before it.
        total = np.concatenate(([0.0], np.cumsum(angles) * h))
        at = np.array([0.5, 1.2, 1.9, 2.02, 3.0, 3.6, 5.5])
        wanted_total = np.interp(at, np.append(fine, 6.0), total) - 0.1
        assert wheels.integral(at) == pytest.approx(wanted_total, abs=2e-4), (lag, rate)
        places = np.rint(times / h).astype(int)
        assert wheels.angle == pytest.approx(np.array(angles)[places], abs=1e-3), (lag, rate)


def test_heading_between_the_edges_of_cells_is_that_of_finer_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # A straight line between them lags behind by half of a cell's square: 0.6 ms of lag at 50 Hz.
    t = 0.02 * np.arange(1000)
    yaw = 0.44 * (1.0 - np.cos(0.15 * t))
    log = Log(t, 8.0 * t, 0.0 * t, yaw, 8.0 + 0.0 * t, 0.1 * np.sin(1.5 * t))
    values = {"turning_wheelbase": 2.7, "understeer": 0.003, "steer_offset": 0.01}
    found = []
    for cell in (0.025, 0.001):
        monkeypatch.setattr(drive, "CELL", cell)
        chain = Chain(prepare(log), "wheels")
        assert chain.drive.cell == pytest.approx(cell)
        found.append(chain.yaw(**values, steer_lag=0.12, dead_time=0.2))
    assert found[0] == pytest.approx(found[1], abs=1e-5)


def test_identify_finds_the_car_with_its_errors(columns: dict[str, Any]) -> None:
    found = popsteer.identify(Log(**columns))
    car = found.vehicle
    assert car.wheelbase == pytest.approx(2.7, abs=0.02)
    assert car.understeer == pytest.approx(0.003, abs=4e-4)
    assert math.degrees(car.steer_offset + math.radians(0.7)) == pytest.approx(0.0, abs=0.02)
    assert found.delay == pytest.approx(0.32, abs=0.005)
    assert car.dead_time == pytest.approx(0.2, abs=0.02)
    assert car.rear_axle == pytest.approx(-1.35, abs=0.05)
    assert car.max_steer_rate is None
    for name, error in found.errors.items():
        assert 0.0 < error < 0.1, name
        assert abs(getattr(car, name) - getattr(CAR, name)) < 5.0 * error + 1e-3, name


def test_identify_with_what_a_tape_measures_keeps_it(columns: dict[str, Any]) -> None:
    told = popsteer.Vehicle(wheelbase=2.65, rear_axle=-1.35, max_steer=0.5)
    car = popsteer.identify(Log(**columns), told).vehicle
    assert (car.wheelbase, car.rear_axle, car.max_steer) == (2.65, -1.35, 0.5)
    assert car.turning_wheelbase == pytest.approx(2.7, abs=0.02)
    assert car.no_slip_point is None


@pytest.mark.parametrize("pace", [1.0, 0.5])
def test_identify_of_a_model_car_sees_an_axle_that_was_told_wrong(pace: float) -> None:
    # 0.1 m between the axles, driven at 0.2 or 0.1 m/s; its rear axle was told 45 mm off.
    car = CAR.replace(wheelbase=0.1, rear_axle=-0.05, understeer=0.0)
    drive = _drive(car, speeds=lambda t: pace * (0.2 + 0.08 * np.sin(0.2 * t)), noise=0.02)
    told = popsteer.Vehicle(wheelbase=0.1, rear_axle=-0.005)
    found = popsteer.identify(Log(**drive), told).vehicle
    assert found.no_slip_point == pytest.approx(-0.05, abs=1e-3)
    assert found.turning_wheelbase == pytest.approx(0.1, rel=0.01)


def test_identify_finds_a_rate_limit_that_was_reached() -> None:
    car = CAR.replace(max_steer_rate=0.25)

    def commands(t: np.ndarray) -> np.ndarray:
        return 0.15 * np.sign(np.sin(0.5 * t)) + 0.03 * np.sin(1.7 * t)

    found = popsteer.identify(Log(**_drive(car, commands=commands)))
    assert found.vehicle.max_steer_rate == pytest.approx(0.25, rel=0.05)
    assert found.delay == pytest.approx(0.32, abs=0.02)


def test_identify_outliers_and_gaps_stand_aside(columns: dict[str, Any]) -> None:
    broken = {name: values.copy() for name, values in columns.items()}
    random = np.random.default_rng(3)
    for name, size in (("yaw", 0.5), ("x", 5.0), ("y", 5.0), ("speed", 6.0)):
        hit = random.choice(len(broken["t"]), 12, replace=False)
        broken[name][hit] += size
    kept = np.ones(len(broken["t"]), dtype=bool)
    kept[400:440] = kept[700:760] = False
    log = Log(**{name: values[kept] for name, values in broken.items()})
    found = popsteer.identify(log)
    assert found.vehicle.wheelbase == pytest.approx(2.7, abs=0.03)
    assert math.degrees(found.vehicle.steer_offset) == pytest.approx(-0.7, abs=0.03)
    assert found.delay == pytest.approx(0.32, abs=0.01)
    assert found.vehicle.rear_axle == pytest.approx(-1.35, abs=0.1)
    notes = " ".join(found.notes)
    assert "2 gaps, the longest" in notes
    assert "numbers stand out from their neighbours" in notes


def test_identify_at_one_speed_says_what_it_cannot_tell_apart() -> None:
    def steady(t: np.ndarray) -> np.ndarray:
        return np.full_like(t, 8.0)

    # With noise, and as a simulator logs it: then the information has a null direction.
    for noise in (1.0, 0.0):
        found = popsteer.identify(Log(**_drive(speeds=steady, noise=noise)))
        assert "one speed only" in found.unknown["understeer"]
        assert "drive steps of" in found.unknown["understeer"]
        assert "understeer" not in found.errors
        assert found.vehicle.understeer == 0.0
        assert found.turning_length == pytest.approx(2.7 + 0.003 * 64.0, abs=0.02)


def test_known_of_a_null_direction_is_infinite_but_for_what_is_excited() -> None:
    random = np.random.default_rng(5)
    one, other = random.standard_normal((2, 500))
    # Two columns alike, one that is nothing, one that stands alone.
    jacobian = np.column_stack([one, 10.0 * one, 0.0 * one, other])
    found = known(jacobian, random.standard_normal(500), 3)
    assert found.errors()[:3] == [math.inf] * 3
    assert found.errors()[3] == pytest.approx(500**-0.5, rel=0.2)
    # The sum that the data show, 1 a + 10 b, has an error; another has none.
    assert found.error(np.array([1.0, 10.0, 0.0, 0.0])) == pytest.approx(500**-0.5, rel=0.2)
    assert found.error(np.array([1.0, 0.0, 0.0, 1.0])) == math.inf


def test_identify_of_smooth_drives_invents_no_limit_of_the_rate() -> None:
    car = CAR.replace(max_steer_rate=0.4)
    for seed in (1, 3):
        random = np.random.default_rng(seed)
        sizes, pace = random.uniform(0.01, 0.08, 3), random.uniform(0.2, 0.9, 3)

        def commands(t: np.ndarray, sizes: Any = sizes, pace: Any = pace) -> Any:
            return np.sin(np.outer(t, pace)) @ sizes

        found = popsteer.identify(Log(**_drive(car, commands=commands)))
        assert found.vehicle.max_steer_rate is None, seed
        assert "drive steps of 0.2 rad" in found.unknown["max_steer_rate"]


def test_identify_at_rest_learns_nothing_not_even_the_noise() -> None:
    moved = _drive()
    rest = {name: np.full(1800, values[0]) for name, values in moved.items()}
    rest["t"] = DT * np.arange(1800)
    random = np.random.default_rng(1)
    for name, size in (("x", 0.02), ("y", 0.02), ("yaw", 0.002)):
        rest[name] = rest[name] + size * random.standard_normal(1800)
    rest["speed"] = np.zeros(1800)
    moved["t"] = moved["t"] + 90.0
    whole: dict[str, Any] = {name: np.concatenate((rest[name], moved[name])) for name in moved}
    found = popsteer.identify(Log(**whole))
    assert found.vehicle.wheelbase == pytest.approx(2.7, abs=0.02)
    # The start, from 0 to 8 m/s in one step, stands out; the rest of the drive does not.
    replaced = [int(note.split()[0]) for note in found.notes if "stand out" in note]
    assert sum(replaced) < 12


def test_identify_of_frozen_positions_does_not_say_where_the_axle_lies(
    columns: dict[str, Any],
) -> None:
    frozen = columns | {name: 0.0 * columns[name] for name in ("x", "y")}
    found = popsteer.identify(Log(**frozen))
    assert not {"rear_axle", "no_slip_point"} & set(found.errors)
    assert "positions move 0 % as far" in found.unknown["rear_axle"]
    assert found.vehicle.rear_axle == 0.0


def test_identify_of_slow_steering_knows_the_delay_as_a_whole() -> None:
    def slow(t: np.ndarray) -> np.ndarray:
        return 0.12 * np.sin(0.25 * t)

    found = popsteer.identify(Log(**_drive(commands=slow)))
    assert not {"steer_lag", "dead_time"} & set(found.errors)
    for name in ("steer_lag", "dead_time"):
        assert "only their sum, 0.3" in found.unknown[name]
        assert "is assumed" in found.unknown[name]
    assert found.vehicle.steer_lag == 0.1
    assert found.delay == pytest.approx(0.32, abs=0.03)
    assert abs(found.delay - 0.32) < 4.0 * found.delay_error


def test_identification_saves_what_is_not_known_as_comments(
    columns: dict[str, Any], tmp_path: Path
) -> None:
    found = popsteer.identify(Log(**columns))
    found.save(tmp_path / "car.toml")
    text = (tmp_path / "car.toml").read_text()
    assert "# NOT FOUND: the wheels were not seen against a limit of their rate" in text
    assert "\n# max_steer_rate" in text
    assert popsteer.Vehicle.load(tmp_path / "car.toml") == found.vehicle
    # A value that was given is kept, with the reason why it was not found.
    slow = popsteer.Vehicle(wheelbase=2.7, understeer=0.001)
    text = as_toml(slow, {"understeer": "one speed only"})
    assert "# NOT FOUND: one speed only\nundersteer = 0.001\n" in text


def test_identify_commands_with_times_of_their_own_count_there(
    columns: dict[str, Any],
) -> None:
    # The angles arrive 20 ms after the poses: rows would lay that to the dead time.
    late = (columns["t"] + 0.02, columns["steer"])
    found = popsteer.identify(Log(**columns, commands=late))
    assert found.delay == pytest.approx(0.30, abs=0.005)


def test_identify_of_100_hz_finds_the_same() -> None:
    found = popsteer.identify(Log(**_drive(seconds=40.0, dt=0.01)))
    assert found.vehicle.wheelbase == pytest.approx(2.7, abs=0.02)
    assert found.delay == pytest.approx(0.32, abs=0.006)


def test_identify_does_not_depend_on_where_and_which_way(columns: dict[str, Any]) -> None:
    turned = dict(columns)
    east, north = columns["x"], columns["y"]
    turned["x"] = 5e5 + east * math.cos(2.0) - north * math.sin(2.0)
    turned["y"] = -3e5 + east * math.sin(2.0) + north * math.cos(2.0)
    turned["yaw"] = np.array([math.remainder(yaw + 2.0, math.tau) for yaw in columns["yaw"]])
    first, second = (popsteer.identify(Log(**each)) for each in (columns, turned))
    for name in ("wheelbase", "steer_offset", "dead_time", "rear_axle"):
        value = getattr(first.vehicle, name)
        assert getattr(second.vehicle, name) == pytest.approx(value, abs=1e-3), name


def _never(t: np.ndarray) -> np.ndarray:
    return np.full_like(t, math.radians(0.7))  # straight on, with the car's offset


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seconds": 9.0}, "8.0 s of driving are too short: at least 10 s"),
        ({"speeds": lambda t: 0.0 * t, "noise": 0.0}, "of driving are too short"),
        ({"commands": _never}, "too straight: its heading changes by .* degrees in all"),
    ],
)
def test_identify_of_a_log_that_shows_nothing_says_what_is_missing(
    changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(LogError, match=message):
        popsteer.identify(Log(**_drive(**changes)))


@pytest.mark.parametrize(
    ("factor", "message"),
    [
        (-1.0, "turns right where steer says left"),
        (math.degrees(1.0), "more than a quarter turn"),
        (0.0, "steer changes by 0.00 degrees only"),
    ],
)
def test_identify_of_a_wrong_unit_or_sign_says_so(
    columns: dict[str, Any], factor: float, message: str
) -> None:
    with pytest.raises(LogError, match=message):
        popsteer.identify(Log(**{**columns, "steer": factor * columns["steer"]}))


def test_identify_of_a_heading_that_is_turned_says_by_how_much(
    columns: dict[str, Any],
) -> None:
    found = popsteer.identify(Log(**{**columns, "yaw": columns["yaw"] + math.radians(1.0)}))
    assert any(
        "1.0" in note and "to the left of where the car moves" in note for note in found.notes
    )


def test_identification_is_a_value_with_records(columns: dict[str, Any]) -> None:
    log = Log(**columns)
    found = popsteer.identify(log)
    assert all(len(values) == len(log) for values in found.records.values())
    assert found.yaw_rate_rms > 0.1
    assert found.verdict.startswith("The vehicle explains the heading to within the noise")
    # The noise that was added, and the drift that speeds of 0.02 m/s of noise make of it.
    assert found.noise["yaw"] == pytest.approx(0.002, rel=0.1)
    assert found.noise["yaw_drift"] == pytest.approx(1.2e-4, abs=1e-4)
    assert found.position_residual < 0.2
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.delay = 0.0  # type: ignore[misc]


def test_import_of_popsteer_does_not_load_the_identification() -> None:
    lines = "import sys, popsteer; print('scipy' in sys.modules, 'popsteer.logs' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", lines], capture_output=True, encoding="utf-8", check=True
    )
    assert done.stdout.split() == ["False", "False"]
