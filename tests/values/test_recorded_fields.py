"""What each field and option does that tunes something in Python, as it was last looked at.

    python -m tests.values.test_recorded_fields

writes `recorded_fields.json` anew; what changed in it is to be looked at. Each class of parameters
and each option is changed by itself, also those that are added: a field that changes nothing fails.
"""

from __future__ import annotations

import inspect
import json
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import own, planning
from popsteer.lab import opponents
from popsteer.planning import SpeedLimits
from tests.values import tables

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

pytest.importorskip("scipy")

RECORDED = Path(__file__).with_name("recorded_fields.json")
CLOSE = 2e-3
"""What solvers and physics of different versions may differ by, as a share."""
X = np.arange(0.0, 90.0, 1.5)
BENDS = np.column_stack((X, 4.0 * np.sin(X / 9.0)))
CAR = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.15, dead_time=0.1, max_steer_rate=0.8)

# Another value of each option of an environment, with what else it needs.
EPISODES: dict[str, dict[str, Any]] = {
    "track": {"track": "circle"},
    "plant": {"plant": "carla-identified"},
    "actions": {"actions": "steer-and-pedals"},
    "constant_speed": {"constant_speed": 4.0},
    "longitudinal": {"longitudinal": popsteer.SpeedPid(popsteer.SpeedPidParams(kp=0.3))},
    "vehicle_ranges": {"vehicle_ranges": {"wheelbase": (2.0, 4.0)}},
    "random_start": {"random_start": True},
    "start_offset": {"start_offset": (0.2, 0.8)},
    "start_yaw": {"start_yaw": (-0.3, -0.2)},
    "start_speed": {"start_speed": 2.0},
    "preview": {"preview": (3.0, 9.0)},
    "reward": {"reward": {"progress": 0.5}},
    "off_path_distance": {"off_path_distance": 0.2, "start_offset": (0.3, 0.5)},
    "time_limit": {"time_limit": 0.6},
    "stall_time": {"stall_time": 0.3, "start_speed": 0.0, "constant_speed": 0.01},
    "dt": {"dt": 0.1},
    "substeps": {"substeps": 1, "plant": "carla-identified"},
}
SHOWN = {"render_mode"}
"""What changes a picture alone."""


def _episode(**options: Any) -> dict[str, Any]:
    """Drive 20 steps of an episode; what it says in the end."""
    from popsteer.adapters.gymnasium import TrackEnv

    env: Any = TrackEnv(**{"track": "slalom", **options})
    seen, info = env.reset(seed=4)
    rewards, ended = [], ""
    for k in range(20):
        action = [0.2 * np.sin(0.4 * k), 0.3][: env.action_space.shape[0]]
        seen, reward, terminated, truncated, info = env.step(action)
        rewards.append(reward)
        if terminated or truncated:
            ended = info["ending"]
            break
    numbers = {name: info[name] for name in ("x", "y", "yaw", "speed", "progress", "time")}
    return {**numbers, "reward": sum(rewards), "seen": seen, "ended": ended, "steps": len(rewards)}


def _episodes() -> Iterator[tuple[str, Any]]:
    from popsteer.adapters.gymnasium import TrackEnv
    from popsteer.adapters.gymnasium.task import RewardWeights

    options = set(inspect.signature(TrackEnv).parameters)
    assert options == set(EPISODES) | SHOWN
    yield "usual", _episode()
    for name, given in EPISODES.items():
        yield name, _episode(**given)
    off = {"off_path_distance": 0.2, "start_offset": (0.3, 0.5)}
    for name in RewardWeights.__dataclass_fields__:
        yield f"reward {name}", _episode(reward={name: 3.0}, **off)["reward"]


def _changed(usual: Any, *skip: str) -> Iterator[tuple[str, Any]]:
    yield "usual", usual
    yield from tables.changed(usual, skip)


def _plans() -> Iterator[tuple[str, Any]]:
    path = popsteer.Path(BENDS, speed=0.0 * X + 8.0)
    usual = SpeedLimits(
        max_speed=9.0,
        max_lateral_acceleration=2.0,
        max_acceleration=1.5,
        max_deceleration=2.0,
        longitudinal_grip=2.5,
        smoothing_length=2.0,
        start_speed=1.0,
        end_speed=1.0,
    )
    cases = [*_changed(usual, "max_jerk"), ("max_jerk", usual.replace(max_jerk=3.0))]
    for name, limits in cases:
        plan = planning.speed_profile(path, limits, CAR)
        yield name, [plan.time, plan.speed.max(), plan.speed[[0, 9, -4, -1]], plan.speed.std()]


def _plants() -> Iterator[tuple[str, Any]]:
    """Plants in Python, driven, braked and turned; their parameters by field."""
    made: dict[str, tuple[str, Callable[[Any], Any]]] = {
        "CommonRoad": ("vehiclemodels", lambda p: _of("commonroad", "CommonRoad")("st", 2, p)),
        "MujocoCar": ("mujoco", _of("mujoco_car", "MujocoCar")),
    }
    for plant, (needed, make) in made.items():
        if find_spec(needed) is None:
            continue
        for name, params in _changed(make(None).params):
            car = make(params)
            car.reset(1.0, 2.0, 0.4, 6.0)
            car.advance(0.3, 0.6, 0.0, 0.01, 20, False)
            state = car.advance(-0.5, 0.0, 0.4, 0.01, 20, False)
            yield f"{plant} {name}", list(state)


def _of(module: str, name: str) -> Any:
    return getattr(import_module(f"popsteer.plants.{module}"), name)


def _laws() -> Iterator[tuple[str, Any]]:
    """Controllers in Python on a bend, forwards and backwards; their parameters by field."""
    kinds = {name: own.load("controller", name) for name in opponents.names()}
    if find_spec("daqp") is None:
        kinds = {name: kind for name, kind in kinds.items() if not name.endswith(":Mpc")}
    made = {name.rpartition(":")[2]: (kind.Params(), kind) for name, kind in kinds.items()}
    for law, (usual, kind) in made.items():
        yield f"{law} usual", _steered(kind, usual)
        for name in vars(usual):
            other = type(usual)(**{name: 0.6 * getattr(usual, name) or 0.2})
            yield f"{law} {name}", _steered(kind, other)


def _steered(kind: Any, params: Any) -> list[float]:
    """Angles along a bend of a vehicle beside it: fast and close, slow and far, and backwards.

    The first and the last one are so fast and so far that no distance ahead is at its bound.
    """
    found = []
    for speed, aside in ((14.0, 0.2), (1.2, 0.7), (3.0, -0.8), (-4.0, 0.3), (2.0, 5.0)):
        path = popsteer.Path(BENDS, reverse=np.full(len(X), speed < 0.0))
        law, turn = kind(path, CAR, params), np.pi if speed < 0.0 else 0.0
        for k in range(12):
            x = 20.0 + 0.05 * abs(speed) * k
            y, slope = 4.0 * np.sin(x / 9.0) + aside, 4.0 / 9.0 * np.cos(x / 9.0)
            given = (x, float(y), float(np.arctan(slope)) + 0.05 + turn, speed, 0.05)
            backwards = {"reverse": speed < 0.0} if hasattr(law, "vehicle_given") else {}
            steer = law.step(*given, **backwards)
            if k in (0, 3, 11):
                found.append(float(getattr(steer, "steer", steer)))
    return found


KINDS: dict[str, Callable[[], Iterator[tuple[str, Any]]]] = {
    "episodes": _episodes,
    "plans": _plans,
    "plants": _plants,
    "laws": _laws,
}


def _found(kind: str) -> dict[str, Any]:
    found = {name: tables.plain(each) for name, each in KINDS[kind]()}
    for name, each in found.items():
        group = name.partition(" ")[0]
        usual = found.get(f"{group} usual", found.get("usual"))
        assert each != usual or name.endswith("usual"), f"{kind}: {name} changes nothing"
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_does_what_it_did(kind: str) -> None:
    if kind == "episodes":
        pytest.importorskip("gymnasium")
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))[kind]
    found = _found(kind)
    assert tables.differences(found, {k: recorded[k] for k in found}, close=CLOSE) == []


if __name__ == "__main__":
    text = json.dumps({kind: _found(kind) for kind in KINDS}, indent=0, ensure_ascii=False)
    RECORDED.write_text(text + "\n", encoding="utf-8")
