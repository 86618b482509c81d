"""What computations give of inputs that are written here, number by number as last looked at.

    python -m tests.values.test_recorded_numbers

writes `recorded_numbers.json` anew; what changed in it is to be looked at. It is for what no other
calculation gives: programs that are solved, splines that are searched for, fits.
"""

from __future__ import annotations

import json
import math
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import planning
from popsteer.logs import Log
from popsteer.planning import SpeedLimits
from tests.planned import closed_spline, random_course
from tests.values import tables as documents

if TYPE_CHECKING:
    from collections.abc import Callable

pytest.importorskip("scipy")

RECORDED = FilePath(__file__).with_name("recorded_numbers.json")
CLOSE = 2e-4
"""What solvers of different versions may differ by, as a share."""


def _jerk_limited() -> dict[str, Any]:
    """Plans within a limit of the jerk: tables over speed, and zones whose speeds are traded."""
    course = popsteer.Path(random_course(3, 60))
    driving, braking = [(0.0, 2.5), (4.0, 3.0), (8.0, 0.6)], [(0.0, 1.0), (3.0, 0.5), (5.0, 3.0)]
    tables = SpeedLimits(max_acceleration=driving, max_deceleration=braking, max_jerk=6.0)
    lap = popsteer.Path(closed_spline(5, 60, 30.0), closed=True)
    grip = SpeedLimits(longitudinal_grip=1.6, exponent=1.3, max_jerk=4.0, max_speed=9.0)
    plans = {
        "tables": planning.speed_profile(course, tables),
        "grip": planning.speed_profile(lap, grip),
        "grip, no ellipse": planning.speed_profile(lap, grip.replace(exponent=math.inf)),
    }
    for seed, kind in (
        (3, "start"),
        (6, "start"),
        (3, "stop"),
        (7, "stop"),
        (0, "lap"),
        (9, "lap"),
    ):
        random = np.random.default_rng(seed)
        closed = kind == "lap"
        xy = closed_spline(seed, 24, 15.0) if closed else random_course(seed, 24)
        bounds = np.where(random.random(24) < 0.3, random.uniform(0.5, 6.0, 24), 20.0)
        limits = SpeedLimits(max_jerk=float(random.choice([0.5, 1.0, 2.0, 4.0])))
        if not closed:
            bounds[[0, -1]] = 20.0
            start = float(random.choice([0.5, 1.0, 2.0, 3.0]))
            limits = limits.replace(start_speed=start, end_speed=2.0)
        if kind == "stop":
            bounds[12] = 0.0
        path = popsteer.Path(xy, closed=closed)
        plans[f"{kind} {seed}"] = planning.speed_profile(path, limits, speed_limits=bounds)
    return {
        name: {"speed": plan.speed, "time": plan.time, "limit": plan.limit}
        for name, plan in plans.items()
    }


def _smoothed() -> dict[str, Any]:
    """Recordings with noise, of a bend, a lap that runs on, and a turn with a piece backwards."""
    random = np.random.default_rng(11)
    s = np.cumsum(random.uniform(0.1, 0.4, 150))
    bend = np.column_stack((s, 4.0 * np.cos(s / 7.0)))
    turn = np.linspace(0.0, 2.2 * np.pi, 180)
    lap = np.column_stack((9.0 * np.cos(turn), 6.0 * np.sin(turn)))
    out, back = np.arange(0.0, 9.0, 0.15), np.arange(9.0, 4.0, -0.15)
    cusp = np.column_stack((np.append(out, back), np.append(0.03 * out**2, 4.86 - 0.03 * back**2)))
    noise = {
        name: each + random.normal(0.0, size, each.shape)
        for name, each, size in (("bend", bend, 0.05), ("lap", lap, 0.02), ("cusp", cusp, 0.01))
    }
    speed = np.where(np.arange(len(cusp)) < len(out), 1.0, -1.0)
    made = {
        "bend": planning.smooth(noise["bend"], 0.15),
        "bend, coarse": planning.smooth(noise["bend"], 0.6, spacing=2.0),
        "bend, clean": planning.smooth(bend[::3], 0.02, spacing=0.7),
        "few": planning.smooth(bend[:36:4], 0.1),
        "lap": planning.smooth(noise["lap"], 0.06, closed=True, spacing=1.0),
        "cusp": planning.smooth(popsteer.Path(noise["cusp"], speed=speed), 0.05, spacing=0.5),
    }
    return {
        name: {
            "count": len(path),
            "x": path.x[::3],
            "y": path.y[::3],
            "ends": [path.x[-1], path.y[-1]],
            "reverse": None if path.reverse is None else np.flatnonzero(path.reverse),
        }
        for name, path in made.items()
    }


def _fitted() -> dict[str, Any]:
    """The steps of a fit at values that are given: costs, noise, errors, the first guess."""
    from popsteer.identification.chain import Chain
    from popsteer.identification.checks import first_length
    from popsteer.identification.drive import prepare
    from popsteer.identification.fit import LAGS, Task

    t = 0.05 * np.arange(320) + np.where(np.arange(320) < 180, 0.0, 4.0)
    random = np.random.default_rng(12)
    steer = 0.1 * np.sin(0.5 * t) + 0.06 * np.sign(np.sin(0.9 * t))
    speed = 7.0 + 2.5 * np.sin(0.4 * t)
    wheel = np.interp(t - 0.2, t, steer) + 0.01
    yaw = np.cumsum(np.diff(t, prepend=-0.05) * speed * np.tan(wheel) / (2.7 + 0.003 * speed**2))
    noise = {name: size * random.standard_normal(320) for name, size in (("v", 0.03), ("h", 2e-3))}
    noise["h"][[40, 233]] += (0.3, -0.01)
    place = np.cumsum(0.05 * speed * np.exp(1j * yaw))
    columns = (t, place.real, place.imag, yaw + noise["h"], speed + noise["v"], steer)
    drive = prepare(Log(*columns))
    usual = {"turning_wheelbase": 2.75, "understeer": 0.0028, "steer_offset": 0.012}
    tried: dict[str, dict[str, float]] = {
        "usual": {**usual, "steer_lag": 0.08, "dead_time": 0.12, "load_shift": 1e-5},
        "at bounds": {**usual, "steer_lag": 0.0, "dead_time": 0.0, "load_shift": 0.0},
        "slow wheels": {
            **usual,
            "steer_lag": 0.1,
            "dead_time": 0.1,
            "load_shift": 0.0,
            "max_steer_rate": 0.12,
        },
    }
    prior = {"load_shift": (0.0, 5e-4)}
    found: dict[str, Any] = {
        "first length": first_length(drive, "log"),
        "prepared": [drive.usual_speed, drive.speed_noise, drive.usual_step, drive.outliers],
    }
    for kind in LAGS:
        task = Task(drive, Chain(drive, kind), {}, prior)
        found[f"first, {kind}"] = task.first({"turning_wheelbase": 2.7})
        for name, values in tried.items():
            task.weigh(values)
            report = task.report(values)
            found[f"{name}, {kind}"] = {
                "cost": [task.cost(values), task.criterion(values), task.noise, task.theta],
                "of the noise": task.theta_of_noise(task.error(values)),
                "errors": report.errors,
                "rate": [report.rate_seen, float(report.yaw[-1])],
            }
    fixed = {"understeer": 0.003, "load_shift": 0.0, "steer_lag": 0.0}
    task = Task(drive, Chain(drive, "yaw rate"), fixed, prior)
    solved = task.solve(task.first({"turning_wheelbase": 2.5}))
    found["solved"] = {name: round(value, 4) for name, value in solved.items()}
    return found


def _tuned() -> dict[str, Any]:
    """What a search proposes after others, and where a replay's path and waypoints lie."""
    from popsteer.lab.replay import runs
    from popsteer.lab.tune import study
    from tests.values.test_known_answers_tune import problem, trial

    tried = [trial(k, 1.0 / (k + 1), 0.1, 0.9 + 0.02 * k) for k in range(22)]
    proposed = [study._near_the_best(problem(seed=4), tried[:k], 1.2) for k in range(15, 22)]
    t = 0.05 * np.arange(500)
    random = np.random.default_rng(6)
    speed = np.where(t < 11.0, 4.0, -2.0) + random.normal(0.0, 0.02, 500)
    speed[300:330] = 0.0
    yaw = 0.2 * np.sin(0.3 * t)
    place = np.cumsum(0.05 * speed * np.exp(1j * yaw)) + random.normal(0.0, 0.02, 500)
    late = t + np.where(np.arange(500) < 150, 0.0, 1.5)
    log = Log(late, place.real, place.imag, yaw, speed, 0.0 * t)
    found: dict[str, Any] = {"proposed": proposed}
    for ahead, wheelbase in ((0.0, 2.7), (1.3, 0.6)):
        path, near = runs._own(log, ahead, wheelbase)
        found[f"{ahead} m ahead"] = {
            "count": [len(path), path.length],
            "x": path.x[::10],
            "y": path.y[::10],
            "speed": None if path.speed is None else path.speed[::10],
            "reverse": None if path.reverse is None else np.flatnonzero(np.diff(path.reverse)),
            "near": near[::25],
        }
    return found


COMPUTED: dict[str, Callable[[], dict[str, Any]]] = {
    "plans within a jerk": _jerk_limited,
    "smoothed recordings": _smoothed,
    "steps of a fit": _fitted,
    "proposals and own paths": _tuned,
}


@pytest.mark.parametrize("name", COMPUTED)
def test_computations_give_what_they_gave(name: str) -> None:
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))[name]
    found = documents.plain(COMPUTED[name]())
    assert documents.differences(found, recorded, close=CLOSE) == []


def _lines(value: Any, indent: str = " ") -> str:
    """Write a document a line for each quantity."""
    if not isinstance(value, dict) or not value:
        return json.dumps(documents.plain(value), ensure_ascii=False)
    rows = [
        f"{indent}{json.dumps(str(key), ensure_ascii=False)}: {_lines(each, indent + ' ')}"
        for key, each in value.items()
    ]
    return "{\n" + ",\n".join(rows) + "\n" + indent[:-1] + "}"


if __name__ == "__main__":
    RECORDED.write_text(
        _lines({name: make() for name, make in COMPUTED.items()}) + "\n", encoding="utf-8"
    )
