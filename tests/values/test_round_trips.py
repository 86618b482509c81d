"""Whatever is written is read back in every field, and a field that differs is a difference."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import controllers, plants, sim
from popsteer._core import AdaptParams, MonitorParams
from popsteer.lab import sweep, tune
from popsteer.lab.common import longitudinal
from popsteer.lab.common.varied import distribution, varied, varying
from popsteer.lab.sweep import rows as files
from popsteer.lab.sweep.job import from_text
from popsteer.planning import SpeedLimits
from tests.values.tables import STRAIGHT, changed, job

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytest.importorskip("scipy")

CAR = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.12)
VARY = {"steer_lag": distribution("steer_lag", "uniform(0.05,0.2)")}
LAP = popsteer.Path([(0, 0), (9, 0), (9, 9), (0, 9)], speed=[3.0] * 4, closed=True)
BACK = popsteer.Path([(0, 0), (9, 0), (3, 0)], speed=[2.0, 0.0, -2.0])


def _core_plants() -> Iterator[tuple[str, Any]]:
    for kind in (sim.CarlaIdentified, sim.KinematicBicycle):
        yield from changed(kind(CAR), skip=("vehicle",))
        for name, car in changed(CAR):
            yield name, kind(car)


OTHERS: dict[str, tuple[Any, ...]] = {
    "path": (
        LAP,
        BACK,
        popsteer.Path([(0.1, 0.2), (9.0, 1 / 3)], speed=[2.0, 1.0]),
        popsteer.Path([(0, 0), (9, 0), (18, 1)], yaw=[0, 0.1, 0.1], curvature=[0, 0.01, 0]),
        popsteer.Path([(0, 0), (9, 0), (18, 1)], yaw="spline", grade=[0.0, 0.1, 0.1]),
    ),
    "adapt": (None,),
    "vary": ({}, {"noise_yaw": distribution("noise_yaw", "normal(0,0.01)")}),
    "plant": ("carla-identified",),
    "runs": (5,),
    "seed": (77,),
    "deviation": (0.31,),
    "start_offset": (-0.4,),
    "speed": (2.5,),
    "constant_speed": (4.5,),
    "joined": (True,),
    "course": ('slalom, "é"',),
    "label": ("another",),
}
"""Other values of the fields of a sweep that are no parameters."""


def _jobs() -> Iterator[tuple[str, sweep.Job]]:
    base = job(vehicle=CAR, vary=VARY)
    yield "base", base
    for name, plant in _core_plants():
        yield f"plant.{name}", replace(base, plant=plant, vehicle=None, vary={})
    for name, car in changed(CAR):
        yield f"vehicle.{name}", replace(base, vehicle=car, plant=sim.KinematicBicycle(car))
    for name in controllers.names():
        for field, params in changed(controllers.get(name).params()):
            yield f"{name}.{field}", replace(base, controller=name, params=params)
    for name, kind in longitudinal.KINDS.items():
        for field, params in changed(kind()):
            yield f"{name}.{field}", replace(base, longitudinal=params)
    wholes = (("adapt", AdaptParams()), ("monitor", MonitorParams()), ("settings", sim.Settings()))
    for part, whole in wholes:
        for field, each in changed(whole):
            yield f"{part}.{field}", replace(base, **{part: each})
    bare = replace(base, vehicle=None)
    yield from ((name, replace(bare, **{name: one})) for name in OTHERS for one in OTHERS[name])


def test_every_field_of_a_sweep_is_among_those_that_are_read_back() -> None:
    parts = {"controller", "params", "longitudinal", "settings", "vehicle", "monitor"}
    assert {each.name for each in fields(sweep.Job)} == {*OTHERS, *parts}


def test_sweep_is_read_back_in_every_field_and_told_from_every_other() -> None:
    texts: dict[str, str] = {}
    for name, each in _jobs():
        again = from_text(each.text)
        assert again.text == each.text, name
        assert again.given == each.given, name
        assert again.params == each.params, name
        assert again.longitudinal == each.longitudinal, name
        assert again.settings == each.settings, name
        assert (again.runs, again.seed, again.deviation) == (each.runs, each.seed, each.deviation)
        assert (again.speed, again.constant_speed) == (each.speed, each.constant_speed), name
        assert again.path.closed == each.path.closed, name
        for column in ("x", "y", "speed", "reverse", "yaw", "curvature", "grade"):
            one, other = getattr(again.path, column), getattr(each.path, column)
            assert np.array_equal(one, other), (name, column)
        assert again.drawn(1) == each.drawn(1), name
        made, expected = again.made(1), each.made(1)
        assert made.start == expected.start, name
        assert made.plant.vehicle == expected.plant.vehicle, name
        assert made.plant.as_dict() == expected.plant.as_dict(), name
        assert each.text not in texts, (name, texts.get(each.text))
        texts[each.text] = name
    assert len(texts) > 100


def test_sweep_of_a_plant_in_python_is_read_back_in_every_field() -> None:
    pytest.importorskip("vehiclemodels")
    plain: Any = plants.get("commonroad-st-1")
    base = replace(job(vary={}), plant=plain)
    cases = [plain.with_params(each) for _, each in changed(plain.params)]
    cases += [plain.with_steering(dead_time=0.2, steer_offset=0.0)]
    cases += [plain.with_steering(dead_time=0.0, steer_offset=0.02)]
    for plant in cases:
        each = replace(base, plant=plant)
        again = from_text(each.text)
        assert again.text == each.text
        assert again.whole.params == plant.params
        assert sim.vehicle_of(again.whole) == plant.vehicle
        assert each.text != base.text
        search = {"min_lookahead": distribution("min_lookahead", "uniform(2,12)")}
        one, other = (
            tune.Problem({"a": STRAIGHT}, "pop", popsteer.PopParams(), search, it, {}, vehicle=CAR)
            for it in (plain, plant)
        )
        assert one.document != other.document


def test_study_tells_apart_every_problem_that_scores_otherwise() -> None:
    params = popsteer.PopParams()
    search = {"min_lookahead": distribution("min_lookahead", "uniform(2,12)")}
    base = tune.Problem(
        {"straight": STRAIGHT}, "pop", params, search, sim.KinematicBicycle(CAR), VARY
    )
    cases: list[tuple[str, Any]] = [("base", base)]
    cases += [(f"plant.{name}", replace(base, plant=plant)) for name, plant in _core_plants()]
    cases += [(f"vehicle.{n}", replace(base, vehicle=car)) for n, car in changed(CAR)]
    cases += [(f"base.{n}", replace(base, base=each)) for n, each in changed(params)]
    for kind in longitudinal.KINDS.values():
        cases += [(f"longitudinal.{n}", replace(base, longitudinal=e)) for n, e in changed(kind())]
    cases += [(f"adapt.{n}", replace(base, adapt=each)) for n, each in changed(AdaptParams())]
    settings = changed(sim.Settings(), skip=("keep_records",))
    cases += [(f"settings.{n}", replace(base, settings=each)) for n, each in settings]
    lap = {"straight": popsteer.Path([(0, 0), (9, 0), (9, 9)], speed=[3.0] * 3)}
    closed = {"straight": popsteer.Path([(0, 0), (9, 0), (9, 9)], speed=[3.0] * 3, closed=True)}
    others: dict[str, tuple[Any, ...]] = {
        "paths": (lap, closed, {"other": STRAIGHT}, {"straight": BACK}),
        "search": ({"min_lookahead": distribution("min_lookahead", "loguniform(2,12)")},),
        "vary": ({},),
        "cars": (3,),
        "seed": (5,),
        "adapt": (None,),
        "constant_speed": (4.0,),
    }
    for field, values in others.items():
        cases += [(field, replace(base, **{field: value})) for value in values]
    seen: dict[str, str] = {}
    for name, each in cases:
        text = repr(sorted(each.document.items()))
        assert text not in seen, (name, seen[text])
        seen[text] = name


def test_rows_are_read_back_with_their_kinds(tmp_path: Path) -> None:
    rows = sweep.run(job())
    rows[1] |= {"success": not rows[1]["success"], "faults": 1 << 20}
    rows[2]["settled_mean_abs_cross_track_error"] = float("inf")
    for kind in ("csv", "parquet"):
        if kind == "parquet":
            pytest.importorskip("pyarrow")
        file = tmp_path / f"rows.{kind}"
        files.write(file, job(), reversed(rows))
        again, found = files.read(file)
        assert again.text == job().text
        assert found == rows
        for one, other in zip(found, rows, strict=True):
            assert {k: type(v) for k, v in one.items()} == {k: type(v) for k, v in other.items()}


def test_files_of_vehicles_and_tunings_keep_every_field(tmp_path: Path) -> None:
    for name, car in changed(CAR):
        car.save(tmp_path / "car.toml")
        assert popsteer.Vehicle.load(tmp_path / "car.toml") == car, name
    for name in controllers.names():
        kind: Any = controllers.get(name).params
        for field, params in changed(kind()):
            params.save(tmp_path / "tuned.toml")
            assert kind.load(tmp_path / "tuned.toml") == params, field


def test_limits_of_a_plan_replace_every_field() -> None:
    for field in fields(SpeedLimits):
        value = 1.5 if field.name == "exponent" else 0.75
        limits = SpeedLimits().replace(**{field.name: value})
        assert limits != SpeedLimits(), field.name
        assert limits.as_dict() == {**SpeedLimits().as_dict(), field.name: value}


def test_everything_that_varies_moves_what_it_names() -> None:
    for plant in (sim.KinematicBicycle(CAR), sim.CarlaIdentified(CAR)):
        plain = varied(plant, STRAIGHT, {})
        for name in varying(plant):
            value = 0.0371 if name != "max_speed" else 7.0
            made = varied(plant, STRAIGHT, {name: value})
            found = {**made.plant.as_dict(), **made.plant.vehicle.as_dict()}
            if name in found:
                assert found[name] == value, name
            elif name.startswith("noise_"):
                assert made.noise is not None
                seen = made.noise.as_dict()
                assert seen[name.removeprefix("noise_")] == value
                assert sum(each != 0.0 for each in seen.values()) == 1, name
            elif name == "start_speed":
                assert made.speed == value
            elif name == "start_yaw":
                assert made.start == (*plain.start[:2], plain.start[2] + value)
            else:
                assert name == "start_offset"
                assert made.start[1] == pytest.approx(value)
