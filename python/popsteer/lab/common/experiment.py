"""What steers in an experiment, and what a sweep and a tuning share: runs that differ."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, TypeAlias

import numpy as np

from popsteer import controllers, own, sim
from popsteer._core import (
    AdaptParams,
    CarlaIdentified,
    KinematicBicycle,
    MonitorParams,
    Path,
    Pop,
    Settings,
    SpeedTrackerParams,
    Vehicle,
)
from popsteer.controllers import Controller, Params
from popsteer.lab.common.longitudinal import LongitudinalParams, beginning
from popsteer.lab.common.longitudinal import made as pedals_of
from popsteer.lab.common.names import law_of
from popsteer.lab.common.varied import START, Distribution, Varied, varied
from popsteer.parameters import Parameters
from popsteer.sim import OwnSimpleController, Run
from popsteer.sim.closed_loop import at_constant_speed, start_speed, with_speeds
from popsteer.sim.geometry import object_of
from popsteer.sim.pedals import Longitudinal, PedalMap, check_longitudinal

Road: TypeAlias = tuple[Path, Longitudinal | None]


Adapt: TypeAlias = AdaptParams | Literal["auto"] | None
"""How a controller adapts; None: not at all."""
Monitor: TypeAlias = MonitorParams | Literal["auto"] | None
"""How it watches for faults, likewise."""


def controller(
    name: str,
    path: Path,
    vehicle: Vehicle,
    params: Params | Parameters,
    adapt: Adapt = "auto",
    monitor: Monitor = "auto",
) -> Controller | OwnSimpleController:
    """Make what steers, one of `controller_names` or your own, in a fresh state.

    Baselines neither adapt nor watch. Raises PopsteerError where one needs a missing extra.
    """
    make: Any = law_of(name).controller  # the registries pair each with its parameters
    how = {"adapt": adapt, "monitor": monitor} if name in controllers.names() else {}
    return make(path, vehicle, params, **how)  # type: ignore[no-any-return]


JOINED = 10.0
"""How far a vehicle drives until it counts as on its path, in wheelbases."""
_JOINING = 30.0  # s, at most


class _Driven:
    """What is a field of each experiment, in its own place among the others."""

    controller: str
    plant: Any


@dataclass(frozen=True, eq=False, kw_only=True)
class Experiment(_Driven):
    """One controller, and a plant that varies: what a sweep's Job and tune's Problem share."""

    vehicle: Vehicle | None = None
    """What the controller is given, in all runs; by default what the plant is before it varies."""
    adapt: Adapt = "auto"
    """How the controller adapts; None: not at all."""
    monitor: Monitor = "auto"
    """How it watches for faults, likewise."""
    speed: float | None = None
    """Speed at the start, as `popsteer.sim.run` has it; left out where the draws have it."""
    constant_speed: float | None = None
    """Speed to be kept throughout, as `popsteer.sim.run` has it."""
    longitudinal: LongitudinalParams | None = None
    """Parameters of the controller of the pedals, `popsteer.lab.common.longitudinal.KINDS`; the
    paper's by default. A `SpeedTracker` plans for `vehicle`, and its pedals are those of the plant
    before it varies."""
    settings: Settings = field(default_factory=Settings)
    """Control period, limits and the like."""
    joined: bool = False
    """Whether the settling time is that of `joining`, which reports then say."""

    @cached_property
    def whole(self) -> Any:
        """The plant before it varies, as an object; by default parameters where it was a name."""
        return object_of(self.plant)

    @cached_property
    def given(self) -> Vehicle:
        """What the controller is given of the vehicle: the same in all runs."""
        return sim.vehicle_of(self.whole) if self.vehicle is None else self.vehicle

    @property
    def is_of_core(self) -> bool:
        """Whether the Rust core drives it alone: neither plant nor controller is in Python."""
        core = isinstance(self.whole, CarlaIdentified | KinematicBicycle)
        return core and self.controller in controllers.names()

    @cached_property
    def code(self) -> dict[str, dict[str, dict[str, str]]]:
        """Give hashes of the code of one's own that is run: a file of other code is another's."""
        plant = sim.plant_name(self.whole)
        found = {self.controller: own.code("controller", self.controller)}
        kept = {k: v for k, v in (found | {plant: own.code("plant", plant)}).items() if v}
        return {"files": kept} if kept else {}

    @property
    def pedals(self) -> PedalMap | None:
        """The pedals for accelerations where they are commanded: of the plant before it varies."""
        planned = isinstance(self.longitudinal, SpeedTrackerParams) and self.constant_speed is None
        return PedalMap.of(self.whole) if planned else None

    def road_of(self, path: Path) -> Road:
        """Give the path that is driven, and what works the pedals: None for those of the paper."""
        if self.constant_speed is None:
            pedals = pedals_of(self.longitudinal, path, self.given)
            road: Road = with_speeds(path, pedals, self.given), pedals
        else:
            road = at_constant_speed(path, self.constant_speed)
        check_longitudinal(road[1], road[0], sim.vehicle_of(self.whole))
        return road

    def joining(self, paths: Iterable[Path]) -> Settings:
        """Let errors count when the plant, as it is, has driven `JOINED` wheelbases of each path.

        The settling time is at most half of a run, and 30 s.
        """
        return self.settings.replace(settling_time=max(map(self._joining, paths)))

    def _joining(self, path: Path) -> float:
        road, car = self.road_of(path), sim.vehicle_of(self.whole)
        start = sim.default_start(path, vehicle=car)
        found = sim.run(
            Pop(road[0], car),
            self.whole,
            start=start,
            speed=self._speed(road, Varied(self.whole, start, None, None)),
            longitudinal=road[1],
            pedals=self.pedals,
            settings=self.settings.replace(time_limit=_JOINING, keep_records=True),
            keep_going=True,
        )
        driven = np.cumsum(np.abs(found.records["speed"])) * found.dt
        taken = found.dt * int(np.searchsorted(driven, JOINED * car.wheelbase))
        ended = found.metrics.time * (0.5 if found.metrics.finished else 1.0)
        return round(min(taken, ended), 2)

    @property
    def settled(self) -> str:
        """Say from when on errors count: whether that is when the vehicle has joined its path."""
        said = f"after the first {self.settings.settling_time:g} s"
        if not self.joined:
            return said
        distance = JOINED * sim.vehicle_of(self.whole).wheelbase
        return f"{said}, in which the vehicle drives {JOINED:g} wheelbases ({distance:.3g} m)"

    def begins(
        self, road: Road, plant: Any, vary: Mapping[str, Distribution], offset: float | None = None
    ) -> str:
        """Say in one line where the runs of a plant start, and how fast they then drive."""
        path, pedals = road
        begun = {name: each for name, each in vary.items() if name in START}
        middle = {name: each.quantile(0.5) for name, each in begun.items()}
        first = varied(plant, path, middle, offset)
        speed = self.speed if first.speed is None else first.speed
        drawn = {name: each for name, each in begun.items() if not each.is_constant}
        return beginning(first.start, path, plant, speed, self.constant_speed, pedals, drawn)

    def drive_one(
        self,
        params: Params | Parameters,
        road: Road,
        made: Varied,
        seed: int,
        *,
        keep_records: bool = False,
        **how: Any,
    ) -> Run:
        """Drive one run, from its plant, start and noise."""
        return sim.run(
            self._driver(params, road),
            made.plant,
            path=road[0],
            start=made.start,
            speed=self._speed(road, made),
            longitudinal=road[1],
            pedals=self.pedals,
            settings=self.settings.replace(keep_records=keep_records),
            noise=made.noise,
            seed=seed,
            **how,
        )

    def drive_each(
        self,
        params: Params | Parameters,
        runs: Iterable[tuple[Road, Varied, int]],
        count: int,
        progress: Callable[[float], object] | None,
        *,
        threads: int | None = None,
        keep_going: bool = False,
    ) -> list[dict[str, Any]]:
        """Drive runs of so many; give the figures of `popsteer.sim.Metrics` of each, by name."""
        if self.is_of_core:
            runs = list(runs)
            roads = {id(road): road for road, _, _ in runs}
            drivers: Any = {key: self._driver(params, road) for key, road in roads.items()}
            columns = sim.run_many(
                [drivers[id(road)] for road, _, _ in runs],
                [made.plant for _, made, _ in runs],
                start=[made.start for _, made, _ in runs],
                speed=[self._speed(road, made) for road, made, _ in runs],
                longitudinal=[road[1] for road, _, _ in runs],
                pedals=self.pedals,
                settings=self.settings,
                noise=[made.noise or sim.Noise() for _, made, _ in runs],
                seed=[seed for _, _, seed in runs],
                threads=threads,
                progress=progress,
            )
            rows = zip(*(column.tolist() for column in columns.values()), strict=True)
            return [dict(zip(columns, row, strict=True)) for row in rows]
        found = []
        for run in runs:
            found.append(vars(self.drive_one(params, *run, keep_going=keep_going).metrics))
            if progress is not None:
                progress(len(found) / count)
        return found

    def _driver(self, params: Params | Parameters, road: Road) -> Controller | OwnSimpleController:
        given = road[0], self.given, params, self.adapt, self.monitor
        return controller(self.controller, *given)

    def _speed(self, road: Road, made: Varied) -> float:
        """Give the speed at the start [m/s]: the one drawn, the one given, or the path's."""
        given = self.speed if made.speed is None else made.speed
        return start_speed(road[0], self.constant_speed, self.whole) if given is None else given
