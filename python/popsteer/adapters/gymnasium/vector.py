"""Many vehicles on a path as one environment, on the Rust batch."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from popsteer.adapters.gymnasium.env import TrackEnv
from popsteer.adapters.gymnasium.picture import Picture
from popsteer.adapters.gymnasium.task import INFO, actions_of
from popsteer.errors import ConfigError, InputError
from popsteer.ranges import check_count, check_known

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from popsteer import Path, Vehicle

_MOST = 1_000_000


class TrackVectorEnv(VectorEnv["NDArray[np.float32]", "NDArray[np.float32]", "NDArray[Any]"]):
    """Many vehicles on a path, each as in `TrackEnv`: what ``gymnasium.make_vec`` makes.

    Vehicle ``k`` of a reset with ``seed`` is that of `TrackEnv` with ``seed + k``, bit for bit.
    Plants of the core are stepped in Rust on all cores; plants in Python one by one.

    Parameters
    ----------
    num_envs : int, default 1
        How many vehicles, 1 to 1,000,000.
    autoreset_mode : AutoresetMode or str, default AutoresetMode.NEXT_STEP
        When an episode that is over is followed by the next: at the next step, whose action does
        not count then; at the same one, with the last observation in ``infos["final_obs"]`` and
        the rest in ``infos["final_info"]``; or never, but by a reset with a "reset_mask".
    max_episode_steps : int, optional
        The same as a `time_limit` of so many control periods.
    **options
        Those of `TrackEnv`.

    Raises
    ------
    ConfigError
        As `TrackEnv`; also where `num_envs` is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> envs = TrackVectorEnv(3, track="circle", vehicle_ranges={"understeer": (0.0, 0.004)})
    >>> observations, infos = envs.reset(seed=7)
    >>> observations.shape, infos["speed"].round(1)
    ((3, 27), array([14.1, 14.1, 14.1]))
    >>> observations, rewards, ended, truncated, infos = envs.step(np.zeros((3, 1), np.float32))
    >>> ended
    array([False, False, False])
    >>> len({car.understeer for car in envs.vehicles})
    3
    """

    metadata = TrackEnv.metadata | {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
        **options: Any,  # noqa: ANN401 - those of TrackEnv, which checks them
    ) -> None:
        check_count("num_envs", num_envs, 1, _MOST)
        if max_episode_steps is not None:
            options["time_limit"] = max_episode_steps * options.get("dt", 0.05)
        single = TrackEnv(**options)
        self._options = {"num_envs": num_envs, "autoreset_mode": autoreset_mode, **options}
        self._task = single.task
        if not isinstance(autoreset_mode, AutoresetMode):
            known = [each.value for each in AutoresetMode]
            check_known("autoreset_mode", str(autoreset_mode), known)
        self._mode = AutoresetMode(autoreset_mode)
        self.metadata = {**single.metadata, "autoreset_mode": self._mode}
        self.render_mode = single.render_mode
        self.num_envs = num_envs
        self.single_observation_space = single.observation_space
        self.single_action_space = single.action_space
        self.observation_space = batch_space(single.observation_space, num_envs)
        self.action_space = batch_space(single.action_space, num_envs)
        self._episodes = self._task.episodes(num_envs)
        self._plants = [self._task.own_plant() for _ in range(num_envs)]
        self._vehicles = [single.vehicle] * num_envs
        self._rngs: list[np.random.Generator] = []
        self._pictures: list[Picture] = []
        self._all = np.ones(num_envs, dtype=np.bool_)
        self._none = np.zeros(num_envs, dtype=np.bool_)
        self._over = self._none

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy the options; what is drawn is that of the next `reset`."""
        return partial(type(self), **self._options), ()

    @property
    def path(self) -> Path:
        """The path that all follow."""
        return self._task.path

    @property
    def vehicles(self) -> list[Vehicle]:
        """What moves in the present episodes, one for each place."""
        return list(self._vehicles)

    @property
    def dt(self) -> float:
        """Control period [s]."""
        return self._task.settings.dt

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode with every vehicle, or with some.

        Parameters
        ----------
        seed : int or sequence of int, optional
            Where all that is drawn comes from: vehicle ``k`` takes ``seed + k``, or its own.
        options : dict, optional
            With an array of bool of shape (N,) as "reset_mask", only those vehicles begin anew.

        Returns
        -------
        tuple
            Observations of shape (N, D), and infos, an array of shape (N,) for each name.
        """
        which = self._reset_mask(options)
        seeds = self._seeds(seed)
        if not self._rngs:
            seeds = [None] * self.num_envs if seeds is None else seeds
            self._rngs = [np.random.default_rng(one) for one in seeds]
        for vehicle in np.flatnonzero(which).tolist():
            if seeds is not None and seeds[vehicle] is not None:
                self._rngs[vehicle] = np.random.default_rng(seeds[vehicle])
            self._begin(vehicle)
        self._over = self._over & ~which
        observations, _, _, _, info = self._episodes.look()
        return observations, self._named(info)

    def step(
        self, actions: ArrayLike
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """Move every vehicle by one control step.

        Parameters
        ----------
        actions : array of shape (N, 1) or (N, 2)
            An action each, as `TrackEnv` takes them.

        Returns
        -------
        tuple
            Observations of shape (N, D); rewards, whether terminated, whether truncated, each of
            shape (N,); infos. New arrays at each step.

        Raises
        ------
        InputError
            A number is not finite, named with its vehicle as ``action[3]``, or the shape is
            another; nothing moves then.
        """
        given = actions_of(actions, self.action_space.shape or (), "actions")
        if not self._rngs:
            raise InputError("step", "before reset", "after reset")
        rest = self._none
        if self._mode is AutoresetMode.NEXT_STEP and self._over.any():
            rest = self._over
            # What the step would refuse is refused before an episode begins.
            if len(wild := np.argwhere(~np.isfinite(given) & ~rest[:, None])):
                vehicle, part = wild[0].tolist()
                raise InputError(f"action[{vehicle}]", float(given[vehicle, part]), "finite")
            for vehicle in np.flatnonzero(rest).tolist():
                self._begin(vehicle)
        observations, rewards, ended, truncated, info = self._episodes.step(given, rest)
        over = ended | truncated
        infos = self._named(info)
        self._over = over
        if over.any():
            endings = np.full(self.num_envs, None, dtype=object)
            for vehicle in np.flatnonzero(over).tolist():
                endings[vehicle] = self._episodes.ending(vehicle)
            infos.update(ending=endings, _ending=over)
            if self._mode is AutoresetMode.SAME_STEP:
                observations, infos = self._begin_ended(observations, infos, over)
        return observations, rewards, ended, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Draw every vehicle as `TrackEnv.render` does.

        Returns
        -------
        tuple of ndarray, or None
            A picture each; None where no `render_mode` was asked for.
        """
        if self.render_mode is None:
            return None
        if not self._pictures:
            self._pictures = [Picture(self._task.path, car.wheelbase) for car in self._vehicles]
        observations, _, _, _, info = self._episodes.look()
        each = zip(self._pictures, self._vehicles, info, observations, strict=True)
        return tuple(picture.draw(car, row, seen) for picture, car, row, seen in each)

    def _begin(self, vehicle: int) -> None:
        self._vehicles[vehicle] = self._task.begin_in(
            self._episodes, vehicle, self._rngs[vehicle], self._plants[vehicle]
        )
        if self._pictures:
            self._pictures[vehicle].clear()

    def _begin_ended(
        self, observations: NDArray[np.float32], infos: dict[str, Any], over: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        final = np.full(self.num_envs, None, dtype=object)
        for vehicle in np.flatnonzero(over).tolist():
            final[vehicle] = observations[vehicle]
            self._begin(vehicle)
        observations, _, _, _, info = self._episodes.look()
        begun = self._named(info)
        begun.update(final_obs=final, _final_obs=over, final_info=infos, _final_info=over)
        return observations, begun

    def _named(self, info: NDArray[np.float64]) -> dict[str, Any]:
        """Give the columns by name, each with a mask that says that all vehicles tell it."""
        infos: dict[str, Any] = dict(zip(INFO, info.T, strict=True))
        return {**infos, **{f"_{name}": self._all for name in INFO}}

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None] | None:
        if seed is None:
            return None
        if isinstance(seed, int | np.integer):
            return [int(seed) + vehicle for vehicle in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ConfigError("seed", len(seed), f"one or {self.num_envs} numbers")
        return list(seed)

    def _reset_mask(self, options: dict[str, Any] | None) -> NDArray[np.bool_]:
        if not options or "reset_mask" not in options or not self._rngs:
            return self._all
        mask = np.asarray(options["reset_mask"])
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            required = f"an array of bool of shape ({self.num_envs},)"
            raise ConfigError("reset_mask", f"{mask.dtype} of shape {mask.shape}", required)
        return mask
