"""What an identification doubts, says and keeps, at both sides of each of its bounds."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer.identification import checks, fit, identifiability, procedure, signals
from popsteer.identification.drive import prepare, size_of
from popsteer.identification.result import described
from popsteer.identification.whiten import Error
from popsteer.logs import Log, LogError
from tests.values.test_known_answers_replay import identification

pytest.importorskip("scipy")

VALUES = dict(zip(fit.NAMES, (2.8, 0.003, 0.01, 0.1, 0.2, 1e-4), strict=True))
GIVEN = popsteer.Vehicle(understeer=0.001, steer_offset=0.02, steer_lag=0.07, dead_time=0.15)


def _fit(values: Any = None, **errors: Any) -> Any:
    """A fit of independent parameters with these errors; the others' are tiny."""
    values = {**VALUES, **(values or {})}
    all_errors = {**dict.fromkeys(values, 1e-9), **errors}

    def error_of(**weights: float) -> float:
        return math.hypot(*(weight * all_errors[name] for name, weight in weights.items()))

    names = [name for name in values if all_errors[name] >= 0.0]
    known = {name: all_errors[name] for name in names}

    def split(**weights: float) -> Error:
        return Error(0.6 * error_of(**weights), 0.8 * error_of(**weights))

    return SimpleNamespace(
        values=values,
        names=names,
        errors=known,
        error_of=error_of,
        split=split,
        rate_seen=True,
        play_seen=False,
        rounded=0.0,
        wheels=SimpleNamespace(times=np.array([0.0, 1.0]), angle=np.array([0.0, 0.1])),
        profile=lambda _, points: [-1e6 * point**2 for point in points],
    )


def _drive(**changes: Any) -> Any:
    given = {"usual_speed": 8.0, "acceleration": np.full(100, -0.5), "outliers": {}}
    return SimpleNamespace(**{**given, **changes})


def _unsure(found: Any, given: popsteer.Vehicle = GIVEN) -> Any:
    """What is not identified, without rate and play; None if everything else is."""
    unknown = identifiability.unidentified(found, _drive(), given)
    for name in ("max_steer_rate", "steer_play"):
        unknown.why.pop(name, None)
    return unknown if unknown.why or unknown.fixed or unknown.notes else None


def test_fit_that_tells_everything_apart_leaves_no_doubt() -> None:
    assert _unsure(_fit()) is None


def test_offset_is_doubted_from_its_bound_on_and_taken_as_given() -> None:
    bound = math.radians(0.3)
    assert _unsure(_fit(steer_offset=0.999 * bound)) is None
    doubt = _unsure(_fit(steer_offset=1.001 * bound))
    assert doubt.fixed == {"steer_offset": 0.02}
    assert set(doubt.why) == {"steer_offset"}
    # It lies within two errors of the estimate, 0.01.
    assert doubt.ranges["steer_offset"] == pytest.approx(
        (0.01 - 2.002 * bound, 0.01 + 2.002 * bound)
    )


def test_one_speed_leaves_the_understeer_as_given() -> None:
    # Both grow together: what they come to at 8 m/s is known to 1 cm.
    for error, doubts in ((0.139, False), (0.141, True)):
        found = _fit(understeer=error / 64.0)
        found.error_of = lambda **_: 0.01
        doubt = _unsure(found)
        assert (doubt is not None) == doubts
        found = _fit(turning_wheelbase=error)
        found.error_of = lambda **_: 0.01
        assert (_unsure(found) is not None) == doubts
    assert doubt is not None
    assert doubt.fixed == {"understeer": 0.001}
    assert "understeer is taken as 0.001 s²/m" in doubt.why["understeer"]
    assert "holds at 8.0 m/s" in doubt.why["understeer"]
    assert "0.2 rad at 4.8 m/s and of 0.04 rad at 11 m/s" in doubt.why["understeer"]
    # As bad at that speed: that is no matter of one speed.
    assert _unsure(_fit(understeer=0.2 / 64.0)) is None
    assert _unsure(_fit(understeer=-1.0)) is None


def test_oversteer_is_taken_as_none_and_said_where_it_is_clear() -> None:
    for slope, error, said in ((-0.003, 0.0011, False), (-0.0034, 0.0011, True)):
        doubt = _unsure(_fit({"understeer": slope}, understeer=error))
        assert doubt is not None
        assert doubt.fixed == {"understeer": 0.0}
        assert bool(doubt.notes) == said, slope
        assert not doubt.why
    assert doubt is not None
    assert f"understeer = {-0.0034:.2g}" in doubt.notes[0]
    assert _unsure(_fit({"understeer": 0.0})) is None


def test_delay_that_is_not_known_is_given_and_its_sum_kept() -> None:
    for error, doubts in ((0.0199, False), (0.0201, True)):
        found = _fit(dead_time=error)
        assert (_unsure(found) is not None) == doubts
    # The sum is known: the lag is the given one, and no more than the sum.
    # One that the log refutes is not assumed: where its lag is known, it is that.
    for total, off, lag, known in (
        ((0.1, 0.2), {"steer_lag": 0.04}, 0.07, 0.05),
        ((0.01, 0.02), {"steer_lag": 0.04}, 0.03, 0.05),
        ((0.1, 0.2), {}, 0.1, 0.03),
    ):
        found = _fit({"steer_lag": total[0], "dead_time": total[1]}, dead_time=0.03, **off)
        doubt = _unsure(found)
        assert doubt is not None
        assert doubt.fixed == {"steer_lag": pytest.approx(lag)}
        assert set(doubt.why) == {"steer_lag", "dead_time"}
        assert f"{sum(total):.3f} ± {known:.2g} s" in doubt.why["dead_time"]
        assert f"that {lag:.3g} s of it" in doubt.why["steer_lag"]
    both = _fit(dead_time=0.03, steer_lag=0.04)
    doubt = _unsure(both)
    assert doubt is not None
    assert "0.300 ± 0.05 s" in doubt.why["dead_time"]
    assert doubt.ranges["dead_time"] == pytest.approx((0.14, 0.26))
    # Not even the sum: nothing is fixed, so that no other takes up what both may be.
    doubt = _unsure(_fit(dead_time=0.051))
    assert doubt is not None
    assert doubt.fixed == {}
    assert "as 0.07 and 0.15 s" in doubt.why["steer_lag"]


def test_steps_to_drive_are_of_two_metres_per_second_squared() -> None:
    for speed, share, said in (
        (10.0, 1.0, "0.05 rad at 10 m/s"),
        (10.0, 0.5, "0.2 rad at 5 m/s"),
        (3.1, 1.0, "0.3 rad at 3.1 m/s"),
        (3.0, 1.0, "0.2 rad at 3 m/s"),
        (1.0, 1.0, "0.3 rad at 1 m/s"),
    ):
        assert identifiability.steps(_drive(usual_speed=speed), share) == said


def test_limit_that_was_not_seen_lies_above_the_fastest_turn() -> None:
    times = 0.1 * np.arange(2001)
    angle = np.cumsum(np.where(np.arange(2001) < 1000, 0.02, -0.035))
    found = _fit()
    for first, fastest in ((2001, 0.35), (1, 0.0)):
        found.wheels = SimpleNamespace(times=times[:first], angle=angle[:first])
        unknown = identifiability.unidentified(found, _drive(), GIVEN)
        assert f"above {fastest:.2f} rad/s" in unknown.why["max_steer_rate"]
        assert unknown.ranges["max_steer_rate"] == pytest.approx((fastest, math.inf))
    # Seen, and known to a tenth of it; or given.
    for error, stated in ((0.039, True), (0.041, False)):
        found = _fit({"max_steer_rate": 0.4}, max_steer_rate=error)
        unknown = identifiability.unidentified(found, _drive(), GIVEN)
        assert ("max_steer_rate" not in unknown.why) == stated
        found.rate_seen = False
        assert "max_steer_rate" in identifiability.unidentified(found, _drive(), GIVEN).why
    told = GIVEN.replace(max_steer_rate=0.3)
    assert "max_steer_rate" not in identifiability.unidentified(_fit(), _drive(), told).why


def test_play_is_stated_where_it_is_seen_and_bounded_where_not() -> None:
    unknown = identifiability.unidentified(_fit(), _drive(), GIVEN)
    # The likelihood falls by 1e6 play²: by 2 within 1.4 mrad, and 2 mrad are asked next.
    assert unknown.ranges["steer_play"] == (0.0, 0.002)
    assert "at most 0.1 degrees" in unknown.why["steer_play"]
    for seen, degrees, stated in ((True, 0.19, True), (True, 0.21, False), (False, 0.1, False)):
        found = _fit({"steer_play": 0.02}, steer_play=math.radians(degrees))
        found.play_seen = seen
        unknown = identifiability.unidentified(found, _drive(), GIVEN)
        assert ("steer_play" not in unknown.why) == stated


def _point(error: float = 0.01, slip_error: float = 1e-5, at: float = 0.01, **values: float) -> Any:
    given = {"rear_axle": -1.3, "slip": 0.0, "heading_bias": 0.0, "speed_excess": 0.0, **values}
    errors = dict.fromkeys(given, 1e-4) | {"rear_axle": error, "slip": slip_error}
    return SimpleNamespace(
        values=given,
        errors=errors,
        error_at=lambda speed: at,
        split=lambda speed: Error(at if speed else error, 0.003),
        noise=0.02,
    )


def test_place_of_the_axles_is_found_kept_or_unknown() -> None:
    place: Any = procedure._place
    drive = _drive()
    unknown: dict[str, str] = {}
    seen: dict[str, str] = {}
    assert place(None, _point(), drive, 2.8, unknown) == (
        {"rear_axle": -1.3},
        {"rear_axle": (0.01, 0.003)},
    )
    # 0.001 s²/m slides the point by 6.4 cm at 8 m/s.
    slipping = _point(slip=0.001)
    assert place(None, slipping, drive, 2.8, unknown) == (
        {"rear_axle": -1.3, "no_slip_point": pytest.approx(-1.236)},
        {"rear_axle": (0.01, 0.003), "no_slip_point": (0.01, 0.003)},
    )
    assert place(None, _point(slip=0.0007), drive, 2.8, unknown)[0] == {"rear_axle": -1.3}
    assert place(None, _point(slip=0.001, slip_error=4e-4), drive, 2.8, unknown)[0] == {
        "rear_axle": -1.3
    }
    # What is badly known at rest is known at the speed of the drive.
    both = _point(error=0.11, slip=0.001, slip_error=4e-4, at=0.02)
    assert place(None, both, drive, 2.8, unknown) == (
        {"rear_axle": pytest.approx(-1.236)},
        {"rear_axle": (0.02, 0.003)},
    )
    assert unknown == {}
    wide = _point(slip_error=0.0032, slip=0.001)
    assert place(None, wide, drive, 2.8, unknown)[0] == {"rear_axle": -1.3}
    assert "at 8.0 m/s" in unknown["no_slip_point"]
    assert place(None, _point(slip_error=0.0031), drive, 2.8, seen) is not None
    assert seen == {}


def test_place_that_the_positions_do_not_show_stays_as_given() -> None:
    for point, said in (
        (_point(at=0.101), "rear_axle would be -1.30 ± 0.1 m"),
        (_point(speed_excess=-0.7), "move 30 % as far"),
    ):
        unknown: dict[str, str] = {}
        assert procedure._place(None, point, _drive(), 2.8, unknown) == ({}, {})
        assert set(unknown) == {"rear_axle", "no_slip_point"}
        assert said in unknown["rear_axle"]
    assert procedure._place(None, _point(at=0.099, speed_excess=-0.4), _drive(), 2.8, {})[0]


def test_place_that_was_given_is_kept_unless_the_drive_contradicts_it() -> None:
    car = popsteer.Vehicle(rear_axle=-1.35)
    kept: Any = procedure._place(car, _point(rear_axle=-1.31), _drive(), 2.8, {})
    # What is kept may be as far off as it lies from the estimate.
    assert kept == ({}, {"rear_axle": (0.01, pytest.approx(math.hypot(0.003, 0.04)))})
    moved = procedure._place(car, _point(rear_axle=-1.29), _drive(), 2.8, {})
    assert moved == ({"no_slip_point": -1.29}, {"no_slip_point": (0.01, 0.003)})
    # It is the point at the usual speed, 8 m/s, that does not slip.
    slides: Any = procedure._place(car, _point(rear_axle=-1.35, slip=0.002), _drive(), 2.8, {})
    assert slides == ({"no_slip_point": pytest.approx(-1.222)}, {"no_slip_point": (0.01, 0.003)})
    unsure: Any = procedure._place(car, _point(rear_axle=-1.19, at=0.09), _drive(), 2.8, {})
    assert unsure == ({}, {"rear_axle": (0.09, pytest.approx(math.hypot(0.003, 0.16)))})
    other = car.replace(no_slip_point=-1.2)
    kept = procedure._place(other, _point(rear_axle=-1.22), _drive(), 2.8, {})
    assert kept == ({}, {"no_slip_point": (0.01, pytest.approx(math.hypot(0.003, 0.02)))})


def test_place_on_a_model_car_is_judged_by_its_wheelbase() -> None:
    # A tenth of a full-size car, which ends at 2 m: 5 mm are another point, 1 cm is unknown.
    car = popsteer.Vehicle(wheelbase=0.2, rear_axle=-0.1)
    for off, at, found in ((4.9e-3, 1e-3, False), (5.1e-3, 1e-3, True), (9e-3, 5e-3, False)):
        point = _point(rear_axle=-0.1 + off, at=at)
        changes, errors = procedure._place(car, point, _drive(), 0.2, {})
        assert set(changes) == ({"no_slip_point"} if found else set()), off
        assert math.hypot(*next(iter(errors.values()))) > (0.0 if found else off)
    for at, unknown in ((9.9e-3, False), (10.1e-3, True)):
        said: dict[str, str] = {}
        place = procedure._place(None, _point(error=1e-3, at=at), _drive(), 0.2, said)
        assert (place == ({}, {})) == ("rear_axle" in said) == unknown, at
    for off, fields in ((4.9e-3, {"rear_axle"}), (5.1e-3, {"rear_axle", "no_slip_point"})):
        point = _point(error=1e-3, slip=off / 64.0, slip_error=1e-6, at=1e-3)
        assert set(procedure._place(None, point, _drive(), 0.2, {})[0]) == fields


def test_speeds_of_a_model_car_are_judged_by_its_wheelbase() -> None:
    # 10 s of driving at 0.3 m/s, or at 0.15 wheelbases a second; a third of it is a rest.
    for size, speed, driven in ((1.0, 0.31, 1), (1.0, 0.29, 0), (0.05, 0.016, 1), (0.05, 0.014, 0)):
        columns = _columns(11.1)
        columns["speed"] = np.full_like(columns["t"], speed)
        ready = prepare(Log(**columns), size)
        assert ready.moving.all()
        if driven:
            checks.first_length(ready, "drive")
        else:
            with pytest.raises(LogError, match=rf"0\.0 s .* faster than {0.3 * size:g} m/s"):
                checks.first_length(ready, "drive")
        columns["speed"] /= 3.3
        assert not prepare(Log(**columns), size).moving.any()
    assert size_of(2.7) == size_of(2.0) == 1.0
    assert size_of(0.1) == 0.05


def test_vehicle_has_what_was_found_and_the_rest_as_given() -> None:
    def made(given: popsteer.Vehicle | None, found: Any, unknown: dict[str, str]) -> Any:
        drive = _drive(commands=np.array([0.0, -0.61]))
        left = identifiability.Unknown(why=unknown)
        return (*procedure._vehicle(given, found, left, _point(), drive), left.notes)

    car, errors, notes = made(None, _fit({"max_steer_rate": 0.4}), {})
    assert (car.wheelbase, car.turning_wheelbase) == (2.8, None)
    assert (car.understeer, car.steer_offset, car.steer_lag) == (0.003, 0.01, 0.1)
    assert (car.dead_time, car.max_steer_rate, car.rear_axle) == (0.2, 0.4, -1.3)
    assert {"wheelbase", "max_steer_rate", "rear_axle", "dead_time"} <= set(errors)
    assert not {"turning_wheelbase", "load_shift", "front_slip"} & set(errors)
    given = GIVEN.replace(wheelbase=2.7, rear_axle=-1.3, max_steer=0.6)
    found = _fit({"understeer": -0.002, "max_steer_rate": 0.4})
    car, errors, notes = made(given, found, {"max_steer_rate": "why"})
    assert (car.wheelbase, car.turning_wheelbase, car.understeer) == (2.7, 2.8, 0.0)
    assert car.max_steer_rate is None
    assert "max_steer_rate" not in errors
    assert any("up to 0.61 rad, more than max_steer, 0.6" in note for note in notes)
    _, _, notes = made(given.replace(max_steer=0.6095), _fit(), {})
    assert not any("max_steer" in note for note in notes)


def test_notes_tell_what_is_odd_from_their_bounds_on() -> None:
    def said(given: Any, bias: float = 0.0, scale: float = 1.0, point: Any = None) -> str:
        seen: Any = SimpleNamespace(heading_bias=bias, speed_scale=scale)
        found = _fit()
        found.lag_of = "wheels"
        return " ".join(described(given, found, point or _point(), seen))

    given = popsteer.Vehicle(wheelbase=2.0)
    assert "no vehicle was given" in said(None)
    assert said(given) == ""
    found = _fit()
    found.lag_of = "tyres"
    plain: Any = SimpleNamespace(heading_bias=0.0, speed_scale=1.0)
    assert "as tyres have it" in described(given, found, _point(), plain)[0]
    for degrees, words in ((0.21, "0.21 degrees to the right"), (-0.3, "0.30 degrees to the left")):
        assert words in said(given, math.radians(degrees))
    assert said(given, math.radians(0.19)) == ""
    # What the positions leave of a large one is added, around the circle.
    turned = said(given, math.radians(179.5), point=_point(heading_bias=math.radians(1.0)))
    assert "179.50 degrees to the left" in turned
    assert "+1.1 % faster" in said(given, scale=1.011)
    assert "--unit speed=0.9890" in said(given, scale=0.989)
    assert said(given, scale=1.0099) == ""
    # Nor is it said what may be chance: four standard errors.
    for bias, excess, odd in ((0.0026, 0.0076, False), (0.0024, 0.0074, True)):
        unsure = _point()
        unsure.errors |= {"heading_bias": bias, "speed_excess": excess}
        assert ("degrees" in said(given, 0.01, 1.03, unsure)) == odd
        assert ("faster" in said(given, 0.01, 1.03, unsure)) == odd


def test_numbers_that_stand_out_are_replaced_unless_they_are_many() -> None:
    t = np.zeros(100)
    for count, said in (
        (0, []),
        (1, ["1 measured number stands out from its neighbours: replaced"]),
        (5, ["5 measured numbers stand out from their neighbours: replaced"]),
    ):
        assert procedure._outliers(_drive(outliers={"x": count, "y": 0}, t=t)) == said
    (note,) = procedure._outliers(_drive(outliers={"x": 6, "y": 0}, t=t))
    assert note.startswith("6 % of the numbers of x stand out")
    assert "replaced" not in note


def test_verdict_says_what_is_not_explained() -> None:
    found = identification()
    assert not replace(found, unexplained=("too loud",)).explains
    assert (
        "does not explain the heading: too loud."
        in replace(found, unexplained=("too loud",)).verdict
    )
    assert "explains the heading to within" in replace(found, unexplained=()).verdict


def _columns(seconds: float = 20.0, turn: float = 0.5, delay: float = 0.2) -> dict[str, Any]:
    """A car of 2.7 m that turns this long after its commands, at 5 m/s."""
    t = 0.05 * np.arange(round(seconds / 0.05))
    steer = 0.15 * np.sign(np.sin(turn * t))
    late = 0.15 * np.sign(np.sin(turn * (t - delay)))
    yaw = np.concatenate(([0.0], np.cumsum(0.05 * 5.0 * np.tan(late) / 2.7)))[:-1]
    zero = 0.0 * t
    return {"t": t, "x": zero, "y": zero, "yaw": yaw, "speed": 5.0 + zero, "steer": steer}


def test_error_of_the_delay_of_a_car_without_lag_does_not_hang_on_the_last_digits() -> None:
    t = 0.05 * np.arange(600)
    speed = 6.0 + 2.5 * np.sin(0.25 * t)
    steer = 0.1 * np.sin(0.7 * t) + 0.04 * np.sign(np.sin(1.3 * t))
    true = np.cumsum(0.05 * speed * np.tan(np.interp(t - 0.15, t, steer)) / 2.7)
    x, y = np.cumsum(0.05 * speed * np.stack((np.cos(true), np.sin(true))), axis=1)
    for seed in (3, 4):
        noise = np.random.default_rng(seed)
        yaw = true + noise.normal(0.0, 0.002, 600)
        found = [
            procedure.identify(Log(t=t, x=x, y=y, yaw=each, speed=speed, steer=steer))
            for each in (yaw, yaw + noise.normal(0.0, 1e-9, 600))
        ]
        errors = [each.delay_error for each in found]
        assert errors[1] == pytest.approx(errors[0], rel=1e-2)
        assert 1e-4 < errors[0] < 2e-3
        assert found[0].delay == pytest.approx(0.1, abs=4.0 * errors[0])


def test_first_length_is_that_of_the_car_whatever_its_delay() -> None:
    for delay in (0.0, 0.2, 0.9):
        length = checks.first_length(prepare(Log(**_columns(delay=delay))), "drive")
        assert length == pytest.approx(2.7, rel=0.03), delay
    turned = _columns()
    turned["steer"] = -turned["steer"]
    with pytest.raises(LogError, match="turns right where steer says left"):
        checks.first_length(prepare(Log(**turned)), "drive")


def test_logs_that_show_too_little_are_refused_at_their_bounds() -> None:
    for seconds, refused in ((10.9, True), (11.1, False)):
        ready = prepare(Log(**_columns(seconds)))
        if refused:  # the first second does not count
            with pytest.raises(LogError, match=r"9\.9 s of driving are too short: at least 10 s"):
                checks.first_length(ready, "drive")
        else:
            checks.first_length(ready, "drive")
    for degrees, refused in ((19.5, True), (20.8, False)):
        columns = _columns()
        columns["yaw"] = math.radians(degrees) * 0.5 * np.sin(columns["t"])
        if refused:
            with pytest.raises(LogError, match=r"19\.4 degrees in all, at least 20 are needed"):
                checks.first_length(prepare(Log(**columns)), "drive")
        else:
            checks.first_length(prepare(Log(**columns)), "drive")
    for degrees, refused in ((0.29, True), (0.31, False)):
        columns = _columns()
        columns["steer"] = math.radians(degrees) * (columns["t"] > 10.0)
        if refused:
            with pytest.raises(LogError, match=r"steer changes by 0\.29 degrees only"):
                checks.first_length(prepare(Log(**columns)), "drive")
        else:
            checks.first_length(prepare(Log(**columns)), "drive")
    for angle, refused in ((0.499 * math.pi, False), (-0.501 * math.pi, True)):
        columns = _columns()
        columns["steer"][7] = angle
        if refused:
            with pytest.raises(LogError, match="more than a quarter turn"):
                signals.checked(Log(**columns))
        else:
            signals.checked(Log(**columns))


def test_what_is_not_shown_is_fixed_at_once_and_fitted_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    free = _fit({"turning_wheelbase": 2.6}, steer_lag=0.03, dead_time=0.04)
    again = _fit({"steer_lag": 0.05, "dead_time": 0.21}, steer_lag=-1.0)
    asked: list[Any] = []

    def fit(_: Any, start: Any, fixed: Any, prior: Any, __: Any) -> Any:
        asked.append((start, fixed, prior))
        return free

    def refit(_: Any, fixed: Any) -> Any:
        asked.append(fixed)
        return again

    monkeypatch.setattr(procedure, "fit", fit)
    monkeypatch.setattr(procedure, "refit", refit)
    monkeypatch.setattr(procedure, "refuse_steer", lambda *_: None)
    drive = _drive(speed=np.ones(100), acceleration=np.tile([0.5, -0.5], 50))
    found, unknown, delay_error = procedure._heading(drive, 2.5, GIVEN, "log", None)
    assert asked[0][:2] == ({"turning_wheelbase": 2.5}, {})
    prior = asked[0][2]
    assert prior["steer_lag"] == (0.07, 0.2)
    assert prior["dead_time"] == (0.15, 0.2)
    # Half of the length at 8 m/s; a tenth of it by 0.5 m/s² of braking.
    assert prior["understeer"] == (0.001, pytest.approx(0.5 * 2.5 / 64.0))
    assert prior["load_shift"] == (0.0, pytest.approx(0.1 * 2.5 / (0.5 * 64.0)))
    assert prior["front_slip"] == (0.0, 0.01)
    assert asked[1] == {"steer_lag": 0.07}
    assert found is again
    assert {"steer_lag", "dead_time"} <= set(unknown.why)
    # The sum moved from 0.3 to 0.26 s against the fit in which both were free.
    assert delay_error == pytest.approx((0.6 * 0.05, math.hypot(0.8 * 0.05, 0.04)))
    # A rate that is given is fixed. A length of 15 % or less is known.
    for error, refused in ((0.389, False), (0.391, True), (math.inf, True)):
        asked.clear()
        free = _fit({"turning_wheelbase": 2.6, "max_steer_rate": 0.3}, turning_wheelbase=error)
        free.error_of = lambda **_: 1.0  # as bad at the usual speed: no matter of the understeer
        again = free
        told = GIVEN.replace(max_steer_rate=0.3)
        if refused:
            with pytest.raises(LogError, match="does not show how the car turns"):
                procedure._heading(drive, 2.5, told, "log", None)
        else:
            procedure._heading(drive, 2.5, told, "log", None)
        assert asked[0][1] == {"max_steer_rate": 0.3}
