"""One vehicle on a path as an environment."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np

from popsteer.adapters.gymnasium.picture import Picture
from popsteer.adapters.gymnasium.task import INFO, Actions, RewardWeights, Task, actions_of
from popsteer.errors import InputError
from popsteer.ranges import check_known
from popsteer.sim import Plant, vehicle_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray

    from popsteer import CoupledLongitudinal, Path, SpeedPid, Vehicle
    from popsteer.tracks import Track

PREVIEW = (2.0, 4.0, 6.0, 8.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0)
"""How far ahead along the path the points lie that are observed by default [m]."""


class TrackEnv(gymnasium.Env["NDArray[np.float32]", "NDArray[np.float32]"]):
    """A vehicle on a path, steered by an agent: ``popsteer/Track-v0``.

    Parameters
    ----------
    track : str or Track or Path, default "racetrack"
        What is followed: the name of a track of `popsteer.tracks`, a track, or a path.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant, default "kinematic-bicycle"
        What moves: any plant that `popsteer.sim.run` takes.
    actions : {"steer", "steer-and-pedals"}, default "steer"
        What the agent does. With "steer" a speed controller works the pedals.
    constant_speed : float, optional
        Speed to keep [m/s]; by default the path's reference speeds are followed.
    longitudinal : SpeedPid or CoupledLongitudinal, optional
        What works the pedals in place of a PI controller (1 s/m, 0.5 /m); of "steer" alone.
    vehicle_ranges : mapping of str to (float, float), optional
        Fields of `popsteer.Vehicle` that are drawn for each episode, uniformly between two bounds,
        as ``{"dead_time": (0.0, 0.2), "understeer": (0.0, 0.004)}``. For plants of the core.
    random_start : bool, default False
        Whether an episode begins anywhere on the path, on the first nine tenths of an open one.
    start_offset : tuple of float, default (-0.5, 0.5)
        How far to the left of the path the rear axle starts [m]: drawn uniformly between two
        bounds.
    start_yaw : tuple of float, default (-0.1, 0.1)
        Heading error at the start [rad], drawn likewise.
    start_speed : float, optional
        Speed at the start [m/s]; the path's reference speed there by default, 0 where it has none.
    preview : sequence of float, default (2, 4, 6, 8, 10, 15, 20, 25, 30, 40)
        How far ahead along the path the points lie that are observed [m], 0 to 1000.
    reward : RewardWeights or mapping of str to float, optional
        What is rewarded.
    off_path_distance : float, default 5.0
        The episode ends this far from the path [m], measured at the front axle.
    time_limit : float, default 200.0
        The episode is truncated after this time [s].
    stall_time : float, optional
        The episode is truncated that gets no farther along the path for so long [s], as one that
        stands or drives in a circle; 10 by default, None for never.
    dt : float, default 0.05
        Control period [s].
    substeps : int, default 10
        Plant steps in a control period.
    render_mode : {"rgb_array"}, optional
        What `render` gives.

    Raises
    ------
    ConfigError
        A track, plant or field is not known, or a number is out of its range.
    InputError
        The plant cannot start like that.
    PathError
        The path has no reference speeds to follow, or is driven backwards in places and the plant
        does not reverse.
    PopsteerError
        The plant needs an extra that is not installed.

    Notes
    -----
    *Action*, Box(-1, 1, (1,)) of float32: the steering as a share of the vehicle's `max_steer`,
    positive to the left. With "steer-and-pedals", (2,): then the throttle above 0, the brake below.
    Values beyond -1 and 1 are clipped, as by the stops of the wheels; a number that is not finite
    is refused with an `InputError`. Gear is that of the path.

    *Observation*, Box of float32 in SI units, clipped to its bounds; `observation_names` has the
    names in order:

    - ``cross_track_error`` [m] and ``heading_error`` [rad] of the rear axle, as in a `Command`;
    - ``speed`` [m/s], ``yaw_rate`` [rad/s], ``wheel``, the angle of the front wheels [rad];
    - ``previous_steer`` [rad], the last angle commanded (earlier commands in flight are not shown);
    - ``reference_speed`` [m/s] of the path there, 0 where it has none;
    - for each distance of `preview` a point of the path, that far ahead of the rear axle's
      projection, in the frame of the rear axle: x forward, y left [m]. An open path goes on
      straight beyond its end, a closed one goes round.

    *Reward*: see `RewardWeights`.

    *End*: terminated at the end of the path (once around a closed one), farther from the path than
    `off_path_distance`, and at a limit of the plant's model; truncated at `time_limit` and after
    `stall_time` without progress. Then ``info["ending"]`` says which: "finished", "off the path",
    "plant limit: WHICH", "time limit", "no progress".

    *Copies*: a pickled or deep-copied environment has the same options, and draws what the original
    would draw; it begins with `reset`.

    *Info*: ``x``, ``y``, ``yaw``, ``speed``: pose of the vehicle's point, as a controller's `step`
    takes it; ``cross_track_error``, ``heading_error`` of the rear axle, not clipped; ``progress``,
    share of the path driven; ``time`` [s].

    Dead time and steering offset of the vehicle lie between the action and the plant, as in
    `popsteer.sim.run`; the plants, the pedals and the measurements are the same.

    Examples
    --------
    A controller of popsteer as the agent:

    >>> import popsteer
    >>> env = TrackEnv("slalom", constant_speed=8.0)
    >>> pop = popsteer.PreviewPop(env.path, env.vehicle)
    >>> _, info = env.reset(seed=1)
    >>> over = False
    >>> while not over:
    ...     steer = pop.step(info["x"], info["y"], info["yaw"], info["speed"], env.dt).steer
    ...     _, _, terminated, truncated, info = env.step([steer / env.vehicle.max_steer])
    ...     over = terminated or truncated
    >>> info["ending"], abs(info["cross_track_error"]) < 0.05
    ('finished', True)
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as Gymnasium declares it
        "render_modes": ["rgb_array"],
        "render_fps": 20,
    }

    def __init__(  # noqa: PLR0913 - each is one thing that may differ
        self,
        track: str | Track | Path = "racetrack",
        plant: Plant = "kinematic-bicycle",
        *,
        actions: Actions = "steer",
        constant_speed: float | None = None,
        longitudinal: SpeedPid | CoupledLongitudinal | None = None,
        vehicle_ranges: Mapping[str, tuple[float, float]] | None = None,
        random_start: bool = False,
        start_offset: tuple[float, float] = (-0.5, 0.5),
        start_yaw: tuple[float, float] = (-0.1, 0.1),
        start_speed: float | None = None,
        preview: Sequence[float] = PREVIEW,
        reward: RewardWeights | Mapping[str, float] | None = None,
        off_path_distance: float = 5.0,
        time_limit: float = 200.0,
        stall_time: float | None = 10.0,
        dt: float = 0.05,
        substeps: int = 10,
        render_mode: str | None = None,
    ) -> None:
        options: dict[str, Any] = dict(locals())  # all of the above, as `__reduce__` gives them
        del options["self"]
        self._options = dict(options)
        del options["render_mode"]
        if render_mode is not None:
            check_known("render_mode", str(render_mode), self.metadata["render_modes"])
        self._task = Task(**options)
        self._begun = False
        self.metadata = {**self.metadata, "render_fps": max(1, round(1.0 / dt))}
        self.render_mode = render_mode
        self.observation_space = self._task.observation_space()
        self.action_space = self._task.action_space()
        self._plant = self._task.own_plant()
        self._episodes = self._task.episodes(1)
        self._rest = np.zeros(1, dtype=np.bool_)
        self._vehicle = vehicle_of(self._plant)
        self._picture: Picture | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        drawn = {name: getattr(self, name) for name in ("_np_random", "_np_random_seed")}
        return partial(type(self), **self._options), (), drawn

    @property
    def task(self) -> Task:
        """What the environment is about, checked."""
        return self._task

    @property
    def path(self) -> Path:
        """The path that is followed, with the reference speeds that are kept."""
        return self._task.path

    @property
    def vehicle(self) -> Vehicle:
        """What moves in the present episode; before the first, the plant as it is."""
        return self._vehicle

    @property
    def dt(self) -> float:
        """Control period [s]."""
        return self._task.settings.dt

    @property
    def observation_names(self) -> list[str]:
        """Names of the entries of an observation, in order."""
        return self._task.observation_names()

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 - Gymnasium's signature
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode: draw the start, and the vehicle where it is to be drawn.

        Parameters
        ----------
        seed : int, optional
            Where all that is drawn comes from, from here on; the same seed gives the same bits.
        options : dict, optional
            None are known; they are left alone.

        Returns
        -------
        tuple
            The observation, and info.
        """
        super().reset(seed=seed)
        self._begun = True
        self._vehicle = self._task.begin_in(self._episodes, 0, self.np_random, self._plant)
        if self._picture is not None:
            self._picture.clear()
        observations, _, _, _, info = self._episodes.look()
        return observations[0], self._named(info)

    def step(
        self, action: ArrayLike
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Move by one control step.

        Parameters
        ----------
        action : array of shape (1,) or (2,)
            The steering as a share of the largest angle, then the pedals where the agent works
            them.

        Returns
        -------
        tuple
            Observation, reward, whether the episode is terminated, whether it is truncated, info.

        Raises
        ------
        InputError
            A number of the action is not finite, or there are more or fewer than asked for, or
            there was no `reset`; nothing moves then.
        """
        if not self._begun:
            raise InputError("step", "before reset", "after reset")
        actions = actions_of(action, (1, *(self.action_space.shape or ())), "action")
        observations, rewards, ended, truncated, info = self._episodes.step(actions, self._rest)
        named = self._named(info)
        if ended[0] or truncated[0]:
            named["ending"] = self._episodes.ending(0)
        return observations[0], float(rewards[0]), bool(ended[0]), bool(truncated[0]), named

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the vehicle from above, with the path and where it has driven.

        Returns
        -------
        ndarray of shape (400, 400, 3) of uint8, or None
            The picture; None where no `render_mode` was asked for.
        """
        if self.render_mode is None:
            return None
        if self._picture is None:
            self._picture = Picture(self._task.path, self._vehicle.wheelbase)
        observations, _, _, _, info = self._episodes.look()
        return self._picture.draw(self._vehicle, info[0], observations[0])

    def _named(self, info: NDArray[np.float64]) -> dict[str, Any]:
        return dict(zip(INFO, info[0].tolist(), strict=True))
