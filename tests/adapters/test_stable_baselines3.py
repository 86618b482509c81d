"""The batch as a `VecEnv`: by stable-baselines3 where it is installed, its seeds everywhere."""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason='the extra "gym" is not installed')

from popsteer.adapters.gymnasium import TrackEnv, TrackVectorEnv


def test_batch_is_a_vec_env_of_stable_baselines3() -> None:
    pytest.importorskip("stable_baselines3")
    from stable_baselines3.common import env_checker, vec_env

    from popsteer.adapters.gymnasium.stable_baselines3 import TrackVecEnv

    env_checker.check_env(TrackEnv("slalom", constant_speed=8.0))
    options: dict[str, Any] = {"track": "slalom", "constant_speed": 8.0, "time_limit": 1.0}
    made = TrackVecEnv(3, **options)
    envs = vec_env.VecMonitor(vec_env.VecCheckNan(made, raise_exception=True))
    plain = TrackVectorEnv(3, autoreset_mode="SameStep", **options)
    envs.seed(4)
    seen = envs.reset()
    np.testing.assert_array_equal(seen, plain.reset(seed=4)[0])
    for step in range(1, 45):
        actions = np.full((3, 1), 0.1 * np.sin(step), np.float32)
        seen, rewards, dones, infos = envs.step(actions)
        expected, values, _, truncated, told = plain.step(actions)
        np.testing.assert_array_equal(seen, expected)
        np.testing.assert_allclose(rewards, values, rtol=1e-6)
        assert (dones == truncated).all()
        assert dones.all() == (step % 20 == 0)
        if dones.all():
            assert infos[0]["TimeLimit.truncated"]
            assert infos[0]["ending"] == "time limit"
            assert infos[1]["episode"]["l"] == 20
            np.testing.assert_array_equal(infos[2]["terminal_observation"], told["final_obs"][2])
    assert envs.get_attr("dt") == [0.05] * 3
    assert not any(envs.env_is_wrapped(vec_env.VecMonitor))
    envs.close()


class _VecEnv:
    """What stable-baselines3's base class does with seeds, where it is not installed."""

    def __init__(self, num_envs: int, *spaces: Any) -> None:
        self.num_envs = num_envs
        self._reset_seeds()

    def seed(self, seed: int) -> None:
        self._seeds: list[int | None] = [seed + place for place in range(self.num_envs)]

    def _reset_seeds(self) -> None:
        self._seeds = [None] * self.num_envs

    def _reset_options(self) -> None:
        pass


def test_seed_of_stable_baselines3_counts_for_the_reset_after_it_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("stable_baselines3", "stable_baselines3.common"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    base: Any = ModuleType("stable_baselines3.common.vec_env")
    base.VecEnv = _VecEnv
    monkeypatch.setitem(sys.modules, base.__name__, base)
    adapter = "popsteer.adapters.gymnasium.stable_baselines3"
    monkeypatch.delitem(sys.modules, adapter, raising=False)
    options: dict[str, Any] = {"track": "slalom", "constant_speed": 8.0}
    envs = importlib.import_module(adapter).TrackVecEnv(3, **options)
    monkeypatch.delitem(sys.modules, adapter)
    plain = TrackVectorEnv(3, **options)
    envs.seed(4)
    first = envs.reset()
    np.testing.assert_array_equal(first, plain.reset(seed=4)[0])
    second = envs.reset()
    np.testing.assert_array_equal(second, plain.reset()[0])
    assert (first != second).any()
    envs.seed(4)
    np.testing.assert_array_equal(envs.reset(), first)
