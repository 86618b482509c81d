"""What has a reset begins anew after it: the second run is the first one to the last bit.

Every class of the package that has a `reset` has a case here, or one that says who drives it.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import own, reference
from popsteer.errors import PopsteerError
from popsteer.lab import opponents

if TYPE_CHECKING:
    from collections.abc import Callable

pytest.importorskip("scipy")

X = np.arange(0.0, 90.0, 1.0)
PATH = popsteer.Path(np.column_stack((X, 2.0 * np.sin(X / 8.0))), speed=4.0 + 0.02 * X)
CAR = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.15, dead_time=0.1, max_steer_rate=0.6)


def _poses(first: float) -> list[tuple[float, float, float, float, float]]:
    """Poses beside the path, at a speed that changes: what a run leaves behind is not nothing."""
    found = []
    for k in range(30):
        x = first + 0.22 * k
        y, yaw = 2.0 * np.sin(x / 8.0) + 0.03, np.arctan(0.25 * np.cos(x / 8.0)) + 0.004
        # It ends nearly as fast as it begins: what is kept while the speed hardly changes, too.
        speed = 4.0 + 0.3 * np.sin(np.pi * k / 29) + 0.01 * (k > 20)
        found.append((x, float(y), float(yaw), float(speed), 0.05))
    return found


def _steered(made: Any, first: float) -> list[Any]:
    return [getattr(found := made.step(*pose), "steer", found) for pose in _poses(first)]


def _tracked(made: Any, first: float) -> list[Any]:
    return [made.step(*pose) for pose in _poses(first)]


def _kept(made: Any, first: float) -> list[Any]:
    return [made.step(0.1 * first + 0.1 * k, 4.0, 0.05) for k in range(30)]


def _batched(made: Any, first: float) -> list[Any]:
    rows = [np.array(pose) for pose in _poses(first)]
    return [made.step(*(np.full(2, each) for each in row[:4]), 0.05).steer.tolist() for row in rows]


def _moved(made: Any, first: float) -> list[Any]:
    """A plant is put where it begins by its reset itself."""
    made.reset(0.0, 0.0, 0.3, 5.0)
    # The longer the first run, the more there is to forget.
    count = 20 + int(first)
    found = [tuple(made.advance(0.05 * np.sin(k), 0.3, 0.0, 0.01, 2, False)) for k in range(count)]
    return [[float(each) for each in row] for row in found[:20]]


MINE = """
import popsteer


class Mine:
    name, reverses = "mine", False

    def __init__(self):
        self.vehicle = popsteer.Vehicle()

    def reset(self, x, y, yaw, speed):
        self.state = [x, y, yaw, speed]

    def advance(self, steer, throttle, brake, dt, substeps, reverse=False):
        self.state[0] += self.state[3] * dt * substeps
        return (*self.state, steer)
"""


def _episode(made: Any, first: float) -> list[Any]:
    many = hasattr(made, "num_envs")
    seen, _ = made.reset(seed=11)
    found = [np.asarray(seen).tolist()]
    for k in range(20 + int(first)):
        action = [0.1 * np.sin(k)]
        seen, reward, *_ = made.step(np.array([action, action]) if many else action)
        found.append([np.asarray(seen).tolist(), np.asarray(reward).tolist()])
    return found[:21]


def _opponent(name: str) -> Callable[[], Any]:
    def make() -> Any:
        (asked,) = [each for each in opponents.names() if each.endswith(f":{name}")]
        kind = own.load("controller", asked)
        return kind(PATH, CAR, kind.Params())

    return make


def _of(module: str, name: str, *given: Any, **named: Any) -> Callable[[], Any]:
    return lambda: getattr(importlib.import_module(f"popsteer.{module}"), name)(*given, **named)


def _env(name: str, *first: Any) -> Callable[[], Any]:
    ranges = {"steer_lag": (0.0, 0.3)}
    options = {"vehicle_ranges": ranges, "random_start": True, "plant": "kinematic-bicycle"}
    return _of("adapters.gymnasium", name, *first, track="slalom", **options)


def _own() -> Any:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "mine.py")
        file.write_text(MINE, encoding="utf-8")
        return _of("plants.registry", "OwnPlant", f"{file}:Mine")()


def _reference_tracker() -> Any:
    path = reference.Path(zip(PATH.x.tolist(), PATH.y.tolist(), strict=True))
    car = reference.Vehicle(**CAR.as_dict())
    return reference.Tracker(reference.Stanley(car), path)


LAWS = ("Pid", "Pop", "PreviewPop", "PurePursuit", "Stanley")
CASES: dict[str, tuple[Callable[[], Any], Callable[[Any, float], list[Any]]]] = {
    **{name: (lambda name=name: getattr(popsteer, name)(PATH, CAR), _tracked) for name in LAWS},  # type: ignore[misc]
    "SpeedPid": (lambda: popsteer.SpeedPid(popsteer.SpeedPidParams(kd=0.2)), _kept),
    "SpeedTracker": (lambda: popsteer.SpeedTracker(PATH, CAR), _tracked),
    "Driver": (lambda: popsteer.Driver(PATH, CAR), _steered),
    "Batch": (lambda: popsteer.Batch(popsteer.PreviewPop(PATH, CAR), 2), _batched),
    **{
        name: (_opponent(name.rpartition(".")[2]), _steered)
        for name in ("Lqr", "RearWheelFeedback", "AutowarePurePursuit", "AccelerationPursuit")
    },
    "opponents.Mpc": (_opponent("Mpc"), _steered),
    "CommonRoad": (_of("plants.commonroad", "CommonRoad", "std", 2), _moved),
    "MujocoCar": (_of("plants.mujoco_car", "MujocoCar"), _moved),
    "OwnPlant": (_own, _moved),
    "TrackEnv": (_env("TrackEnv"), _episode),
    "TrackVectorEnv": (_env("TrackVectorEnv", 2), _episode),
    "reference.SpeedPid": (_of("reference", "SpeedPid"), _kept),
    "reference.Tracker": (_reference_tracker, _steered),
}
NEEDED = {
    "opponents.Mpc": "daqp",
    "CommonRoad": "vehiclemodels",
    "MujocoCar": "mujoco",
    "TrackEnv": "gymnasium",
    "TrackVectorEnv": "gymnasium",
}
ELSEWHERE = {
    "Opponent": "its controllers",
    "_EmptyCall": "does nothing",
    "TrackVecEnv": "tests/adapters/test_gymnasium.py",
}


def _classes() -> set[str]:
    """The classes of the package that have a reset."""
    found = set()
    for each in pkgutil.walk_packages(popsteer.__path__, "popsteer."):
        if each.name.endswith("__main__"):
            continue
        try:
            module = importlib.import_module(each.name)
        except (ImportError, PopsteerError):
            continue
        for kind in vars(module).values():
            here = inspect.isclass(kind) and kind.__module__.startswith("popsteer")
            protocol = getattr(kind, "_is_protocol", False)
            if here and not protocol and callable(getattr(kind, "reset", None)):
                found.add(kind.__name__)
    return found


def test_every_class_with_a_reset_has_a_case() -> None:
    cases = {name.rpartition(".")[2] for name in CASES}
    assert _classes() - cases - set(ELSEWHERE) == set()


def test_second_run_after_a_reset_is_the_first_one() -> None:
    for name, (make, drive) in CASES.items():
        if name in NEEDED and find_spec(NEEDED[name]) is None:
            continue
        fresh, used = drive(make(), 3.0), make()
        drive(used, 11.0)
        if drive not in (_moved, _episode):  # which reset what they drive
            assert drive(used, 3.0) != fresh, name  # else there is nothing to forget
            used.reset()
        assert drive(used, 3.0) == fresh, name
