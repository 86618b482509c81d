"""Several laws on one plant and one path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from popsteer import baselines, laws, presets
from popsteer.errors import ConfigError
from popsteer.sim import fitted, run

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from popsteer._core import CoupledLongitudinal, Path, Settings, SpeedPid
    from popsteer.baselines import MpcParams
    from popsteer.laws import Controller, Params
    from popsteer.sim import Plant, Run
    from popsteer.sim.run import Pose
    from popsteer.sim.steering import OwnLaw

__all__ = ["DEFAULT_LAWS", "Comparison", "compare", "controller", "law_names", "parameters"]

DEFAULT_LAWS = ("pid", "pure-pursuit", "stanley", "pop")
"""The laws of the paper, in the order of its table."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs of several laws on one plant and one path.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> comparison = compare(path, ["stanley", "pop"])
    >>> comparison.plant, list(comparison.runs)
    ('carla-identified', ['stanley', 'pop'])
    """

    runs: Mapping[str, Run]
    """The runs by name of the law, in the order to show them; at least one."""
    preset: str
    """Where the laws' parameters come from."""
    track: str = ""
    """What the path is called; ``dataclasses.replace`` gives it a name."""
    step_times: Mapping[str, float] = field(default_factory=dict)
    """What a step of each law takes [s], where that was measured: see `time_steps`."""

    @property
    def first(self) -> Run:
        """Any of the runs, for what they have in common.

        Returns
        -------
        Run
            The first one.
        """
        return next(iter(self.runs.values()))

    @property
    def path(self) -> Path:
        """What was followed.

        Returns
        -------
        Path
            The same for all runs.
        """
        return self.first.path

    @property
    def plant(self) -> str:
        """What moved.

        Returns
        -------
        str
            The plant's name.
        """
        return self.first.plant

    @property
    def dt(self) -> float:
        """Control period.

        Returns
        -------
        float
            In [s].
        """
        return self.first.dt


def law_names() -> tuple[str, ...]:
    """Names of all that can be compared.

    Returns
    -------
    tuple of str
        The laws of popsteer, then the baselines.

    Examples
    --------
    >>> law_names()[-2:]
    ('preview-pop', 'mpc')
    """
    return (*laws.names(), *baselines.names())


def parameters(names: Sequence[str], preset: str, plant: Plant) -> dict[str, Params | MpcParams]:
    """Give the parameters of several laws from a preset, fitted to a plant.

    Parameters
    ----------
    names : sequence of str
        Names of laws or baselines; those have no presets.
    preset : str
        Name of a preset.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant whose axles and wheelbase the laws are given.

    Returns
    -------
    dict
        Parameters by name of the law, in the order given.

    Raises
    ------
    ConfigError
        A law, the preset or the plant is not known, or a preset is given to baselines alone.

    Examples
    --------
    >>> parameters(["pid"], "paper", "carla-identified")["pid"].reference_offset
    1.06
    """
    if preset != presets.REPRODUCTION and names and set(names) <= set(baselines.names()):
        requirement = f"left out, as it changes nothing about {', '.join(names)}"
        raise ConfigError("preset", preset, requirement)
    chosen: dict[str, Params | MpcParams] = {}
    for name in names:
        if name in baselines.names():
            chosen[name] = baselines.get(name).params.for_plant(plant)
        elif name in laws.names():
            chosen[name] = fitted(presets.get(name, preset), plant)
        else:
            raise ConfigError.unknown("law", name, law_names())
    return chosen


def controller(name: str, path: Path, params: Params | MpcParams) -> Controller | OwnLaw:
    """Make what steers.

    Parameters
    ----------
    name : str
        One of `law_names`.
    path : Path
        What it follows.
    params : parameters of that law
        As `parameters` gives them.

    Returns
    -------
    Controller or OwnLaw
        In a fresh state.

    Raises
    ------
    PopsteerError
        The law needs an extra that is not installed.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> controller("pop", path, popsteer.PopParams()).steer(0.0, 0.0, 0.0, 5.0, 0.05)
    0.0
    """
    # The registries pair each controller with its parameters.
    if name in baselines.names():
        return baselines.get(name).controller(path, params)  # type: ignore[arg-type]
    return laws.get(name).controller(path, params)  # type: ignore[arg-type]


def compare(  # noqa: PLR0913 - as `popsteer.sim.run`
    path: Path,
    names: Sequence[str] | Mapping[str, Params | MpcParams] = DEFAULT_LAWS,
    plant: Plant = "carla-identified",
    *,
    preset: str = presets.REPRODUCTION,
    start: Pose | None = None,
    speed: float | None = None,
    constant_speed: float | None = None,
    longitudinal: CoupledLongitudinal | SpeedPid | None = None,
    settings: Settings | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> Comparison:
    """Let several laws drive the same plant along the same path, one after the other.

    Parameters
    ----------
    path : Path
        What they follow.
    names : sequence of str, or mapping of str to parameters
        The laws, of `law_names`; by default the paper's four. A mapping gives each its parameters,
        and `preset` then only says what they are called.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant, default "carla-identified"
        What moves. The laws' reference points and wheelbase are its axles'.
    preset : str, default "reproduction"
        Where the parameters come from; see `popsteer.presets`.
    start : tuple of float, optional
        Pose of the front axle at the start, (x, y, yaw) [m, m, rad]; by default 2.44 m to the right
        of the first waypoint.
    speed, constant_speed : float, optional
        Speed at the start, and speed to be kept all the way [m/s]; as `popsteer.sim.run` has them.
    longitudinal : CoupledLongitudinal or SpeedPid, optional
        What works the pedals; the paper's coupled law by default.
    settings : Settings, optional
        Control period, limits and the like.
    progress : callable, optional
        Called now and then with the name of the law and the share of its path done, 0 to 1.

    Returns
    -------
    Comparison
        The runs.

    Raises
    ------
    ConfigError
        A law, the preset or the plant is not known; nothing was driven then.
    InputError
        The start is not finite or beyond its bound.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer import tracks
    >>> comparison = compare(popsteer.Path(tracks.get("slalom").xy))
    >>> {name: run.metrics.finished for name, run in comparison.runs.items()}
    {'pid': True, 'pure-pursuit': True, 'stanley': True, 'pop': True}
    """
    chosen = dict(names) if isinstance(names, Mapping) else parameters(names, preset, plant)
    drivers = {name: controller(name, path, params) for name, params in chosen.items()}
    runs: dict[str, Run] = {}
    for name, law in drivers.items():

        def advance(share: float, name: str = name) -> None:
            if progress is not None:
                progress(name, share)

        advance(0.0)
        runs[name] = run(
            law,
            plant,
            path=path,
            start=start,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=longitudinal,
            settings=settings,
            progress=advance,
        )
        advance(1.0)
    return Comparison(runs=runs, preset=preset)
