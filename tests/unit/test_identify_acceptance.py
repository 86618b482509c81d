"""A few of the drives of `studies.identify_acceptance`, which has many."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer.identification.drive import prepare
from popsteer.identification.pedals import fit_drive
from popsteer.logs import Log
from studies import identify_acceptance as acceptance
from studies import logged

pytest.importorskip("scipy")


def test_stated_values_hold_on_working_drives() -> None:
    stated = [
        one
        for kind, changes in acceptance.KINDS[::2]
        for seed in (3, 4)
        for car, found in [acceptance.identified(kind, seed, **changes)]
        if found is not None
        for one in acceptance.stated(car, found)
    ]
    within, beyond, count = acceptance.shares(stated)
    assert count > 60
    assert within > 0.85
    assert beyond < 0.04


@pytest.mark.parametrize(("kind", "changes"), [("brisk", {"noise": 0.0}), ("brisk", {"digits": 2})])
def test_lengths_of_logs_without_noise_or_digits_are_right_or_unknown(
    kind: str, changes: dict[str, float]
) -> None:
    car, found = acceptance.identified(kind, 1, length=2.5, point=1.2, **changes)
    assert found is not None
    for one in acceptance.stated(car, found):
        if one.name in ("wheelbase", "turning_length"):
            assert one.value == pytest.approx(one.truth, rel=0.01)
        assert one.off < 3.5, one


@pytest.mark.parametrize("kind", ["lines", "blocks"])
def test_digits_that_repeat_make_no_car_longer(kind: str) -> None:
    # 100 Hz: most rows repeat the heading of the row before, whose steps seem to be outliers.
    for seed in (2, 3):
        car, found = acceptance.identified(
            kind, seed, length=9.0, point=1.2, digits=2, dt=0.01, rate=0.5
        )
        assert found is not None
        turns = car.length + car.understeer * found.speed**2
        assert found.turning_length == pytest.approx(turns, rel=0.01)
        off = {one.name: one.off for one in acceptance.stated(car, found)}
        assert off["turning_length"] < 3.0


@pytest.mark.parametrize(
    ("kind", "steps"), [("brisk", 0.1), ("slalom", 0.0174533), ("lines", 0.02)]
)
def test_what_rounded_commands_hide_is_within_its_errors_or_unknown(
    kind: str, steps: float
) -> None:
    car, found = acceptance.identified(kind, 2, length=2.5, point=1.2, steps=steps)
    assert found is not None
    for one in acceptance.stated(car, found):
        assert one.off < 3.0, one
        if one.name == "wheelbase":
            assert one.value == pytest.approx(one.truth, rel=0.01)
    if steps == 0.1:
        low, high = found.ranges["wheelbase"]
        assert low < car.length < high
        assert "steer is recorded in steps of 0.1 rad" in found.unknown["wheelbase"]
        assert "steer_play" in found.unknown


@pytest.mark.parametrize(("kind", "seed", "steps"), [("brisk", 2, 0.0174533), ("laps", 3, 0.01)])
def test_what_rounded_commands_leave_is_known(kind: str, seed: int, steps: float) -> None:
    size = {"length": 2.5, "point": 1.2} if kind == "brisk" else {}
    _, found = acceptance.identified(kind, seed, steps=steps, **size)
    assert found is not None
    assert found.fit.rounded == pytest.approx(steps)
    assert found.explains


@pytest.mark.parametrize("given_in_steps", [False, True])
@pytest.mark.parametrize(("kind", "seed"), [("parking", 1), ("lines", 3)])
def test_steps_that_a_hand_jumps_over_are_told_from_rounding(
    kind: str, seed: int, given_in_steps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if given_in_steps:
        monkeypatch.setattr(logged, "commands", _stepped(0.0174533))
    car, found = acceptance.identified(kind, seed, steps=0.0174533)
    assert found is not None
    assert (found.fit.rounded == 0.0) == given_in_steps
    assert all(one.off < 3.0 for one in acceptance.stated(car, found))


def _stepped(step: float) -> Any:
    """Give the commands of a drive by a program that takes them from a grid."""
    commands = logged.commands

    def stepped(*args: Any) -> Any:
        t, speed, steer = commands(*args)
        return t, speed, step * np.round(steer / step)

    return stepped


@pytest.mark.parametrize("given_in_steps", [False, True])
def test_commands_in_steps_are_told_from_rounded_ones(
    given_in_steps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if given_in_steps:
        monkeypatch.setattr(logged, "commands", _stepped(0.02))
    car, found = acceptance.identified("laps", 2, length=2.5, point=1.2, steps=0.02)
    assert found is not None
    drive = found.fit.candidates[0].task.drive
    assert (drive.commands is drive.recorded) == given_in_steps
    # Only what was rounded hides the length.
    assert ("wheelbase" in found.unknown) != given_in_steps
    for one in acceptance.stated(car, found):
        assert one.off < 3.0, one
        if given_in_steps and one.name == "wheelbase":
            assert one.value == pytest.approx(one.truth, rel=0.002)


def test_errors_of_the_drive_count_the_noise_of_the_heights() -> None:
    off = []
    for seed in range(12):
        car = acceptance.pedalled(seed)
        found = fit_drive(acceptance.drive_log(car, seed))
        assert found is not None
        errors = found.errors
        off += [(found.values["drag"] - car.drag) / errors["drag"]] if "drag" in errors else []
        off += [found.values["air_drag"] / errors["air_drag"]] if "air_drag" in errors else []
    assert len(off) > 15
    assert 0.7 < np.sqrt(np.mean(np.square(off))) < 1.25


@pytest.mark.parametrize("seed", [22, 24, 26])
def test_limit_that_looks_like_lag_is_found(seed: int) -> None:
    # A small car in a slalom turns its wheels at their limit all the time.
    car, found = acceptance.identified("slalom", seed)
    assert found is not None
    assert found.explains
    assert found.vehicle.max_steer_rate == pytest.approx(car.rate, rel=0.02)
    assert found.vehicle.wheelbase == pytest.approx(car.length, rel=0.02)


def test_play_leaves_the_delay_as_it_is() -> None:
    for play in (0.5, 2.0):
        car, found = acceptance.identified("blocks", 2, length=2.7, point=1.0, play=play)
        assert found is not None
        assert found.delay == pytest.approx(car.lag + car.delay, abs=0.015)
        assert found.fit.values["steer_play"] == pytest.approx(car.play, abs=0.0035)


def test_wheels_count_once_they_are_pushed_through_their_play() -> None:
    # Where they lie in it at first nobody knows: that looked like a misfit of the first seconds.
    car = acceptance.car_of(2, length=2.7, point=1.0, play=2.0)
    columns = logged.log("blocks", car, 2)
    found = popsteer.identify(Log(**columns))
    assert found.explains
    asked = columns["steer"]
    for play in (0.0, found.vehicle.steer_play):
        drive = replace(prepare(Log(**columns)), play=play)
        ranges = np.maximum.accumulate(asked) - np.minimum.accumulate(asked)
        pushed = float(columns["t"][np.argmax(ranges > play)]) if play else 0.0
        assert drive.t[drive.parts()[0].start] == pytest.approx(pushed + 1.0, abs=0.05)
    assert pushed > 1.0


@pytest.mark.parametrize("seed", [6, 8])
def test_play_of_a_driver_who_looks_ahead_is_told_from_lag(seed: int) -> None:
    # Without play and rate every structure misfits: none may be dropped for it.
    car, found = acceptance.identified("blocks", seed, play=1.0, ahead=True)
    assert found is not None
    assert found.explains
    assert found.vehicle.steer_play == pytest.approx(car.play, abs=0.0035)
    assert found.vehicle.steer_lag == pytest.approx(car.lag, abs=0.03)
    assert found.delay == pytest.approx(car.lag + car.delay, abs=0.015)


def test_lag_that_is_assumed_is_one_that_the_log_allows() -> None:
    car = logged.Car(
        length=0.443, understeer=0.01, offset=-0.009, lag=0.024, delay=0.1575, rate=0.62, point=0.06
    )
    log = Log(**logged.log("laps", car, 1, noise=3.0, ahead=True))
    told = popsteer.Vehicle(wheelbase=car.length, rear_axle=-car.point, steer_lag=0.25)
    found = popsteer.identify(log, told)
    assert "steer_lag" in found.unknown
    assert found.vehicle.steer_lag < 0.15
    assert found.vehicle.steer_lag + found.vehicle.dead_time == pytest.approx(found.delay)


@pytest.mark.parametrize("seed", [80, 122])
def test_understeer_that_comes_out_negative_leaves_the_length_its_error(seed: int) -> None:
    # 0 is taken for it then, which moves the length as far as the understeer was off.
    car, found = acceptance.identified("parking", seed)
    assert found is not None
    assert found.vehicle.understeer == 0.0
    assert "understeer" not in found.unknown
    for one in acceptance.stated(car, found):
        assert one.off < 3.0, one


@pytest.mark.parametrize("kind", ["parking", "laps"])
def test_point_is_right_where_the_noise_of_poses_is_that_of_a_filter(kind: str) -> None:
    # Noise that stays for 0.5 s turns the measured heading as the car would: it is no regressor.
    car = acceptance.car_of(4, length=9.0, point=5.0)
    columns = logged.log(kind, car, 4, noise=0.0)
    random, kept = np.random.default_rng(4), np.exp(-0.05 / 0.5)
    noise = np.zeros((len(columns["t"]), 3))
    for k, new in enumerate(random.standard_normal(noise.shape)):
        noise[k] = kept * noise[k - 1] + np.sqrt(1.0 - kept**2) * new * (0.02, 0.02, 0.002)
    for name, each in zip(("x", "y", "yaw"), noise.T, strict=True):
        columns[name] = columns[name] + each
    found = popsteer.identify(Log(**columns))
    assert "rear_axle" in found.errors
    for name in {"rear_axle", "no_slip_point"} & found.errors.keys():
        error = np.hypot(found.errors[name], found.model_errors[name])
        assert getattr(found.vehicle, name) == pytest.approx(-car.point, abs=3.0 * error), name
        assert error < 0.3
