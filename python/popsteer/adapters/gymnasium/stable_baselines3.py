"""Many vehicles on a path as a `VecEnv` of stable-baselines3, which takes no `VectorEnv`.

It needs stable-baselines3 beside the extra ``gym``: ``pip install stable-baselines3``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

from popsteer.adapters.gymnasium.vector import TrackVectorEnv

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray


class TrackVecEnv(VecEnv):  # type: ignore[misc]
    """Many vehicles on a path, stepped together in Rust, as stable-baselines3 takes them.

    ::

        envs = VecMonitor(TrackVecEnv(512, track="slalom", constant_speed=8.0))
        PPO("MlpPolicy", envs).learn(1_000_000)

    An episode that is over is followed by the next at once. The info of its last step has what that
    of `TrackEnv` has, the last observation as ``terminal_observation``, and
    ``TimeLimit.truncated``; the infos of the other steps are empty.

    Parameters
    ----------
    num_envs : int
        How many vehicles.
    **options
        Those of `TrackVectorEnv`, but `autoreset_mode`.
    """

    def __init__(self, num_envs: int, **options: Any) -> None:  # noqa: ANN401 - checked there
        self.envs = TrackVectorEnv(num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **options)
        self._actions = np.zeros(self.envs.action_space.shape or ())
        super().__init__(
            num_envs, self.envs.single_observation_space, self.envs.single_action_space
        )

    def reset(self) -> NDArray[np.float32]:
        """Begin an episode with every vehicle; gives the observations."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        observations, infos = self.envs.reset(seed=seeds)
        self.reset_infos = [_of(infos, place) for place in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions of the next `step_wait`."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Move every vehicle by one control step."""
        observations, rewards, ended, truncated, infos = self.envs.step(self._actions)
        over = ended | truncated
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for place in np.flatnonzero(over).tolist():
            told[place] = _of(infos["final_info"], place) | {
                "terminal_observation": infos["final_obs"][place],
                "TimeLimit.truncated": bool(truncated[place] and not ended[place]),
            }
        return observations, rewards.astype(np.float32), over, told

    def close(self) -> None:
        """Let the vehicles go."""
        self.envs.close()

    def get_images(self) -> list[NDArray[np.uint8] | None]:
        """Draw every vehicle, where a `render_mode` was asked for."""
        pictures = self.envs.render()
        return [None] * self.num_envs if pictures is None else list(pictures)

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """Give an attribute of the batch, once for each vehicle."""
        value = getattr(self.envs, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(
        self,
        attr_name: str,
        value: Any,  # noqa: ANN401, ARG002 - as stable-baselines3
        indices: int | Iterable[int] | None = None,
    ) -> None:
        """Refuse: the vehicles share their options, which are given at the start."""
        raise AttributeError(f"{attr_name} of {indices}: a batch has one set of options for all")

    def env_method(
        self,
        method_name: str,
        *method_args: Any,  # noqa: ANN401 - as stable-baselines3
        indices: int | Iterable[int] | None = None,
        **method_kwargs: Any,  # noqa: ANN401
    ) -> list[Any]:
        """Call a method of the batch once; each vehicle has the answer."""
        answer = getattr(self.envs, method_name)(*method_args, **method_kwargs)
        return [answer for _ in self._get_indices(indices)]

    def env_is_wrapped(
        self,
        wrapper_class: type,  # noqa: ARG002 - no vehicle has a wrapper of its own
        indices: int | Iterable[int] | None = None,
    ) -> list[bool]:
        """Say for each vehicle that it is not."""
        return [False for _ in self._get_indices(indices)]


def _of(infos: dict[str, Any], place: int) -> dict[str, Any]:
    """Give one vehicle's info, without the masks of the batch."""
    return {name: column[place] for name, column in infos.items() if not name.startswith("_")}
