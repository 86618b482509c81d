"""examples/carla_drive.py drives; the simulator is the stand-in of `carla_actor.py`."""

from __future__ import annotations

import re
import runpy
import sys
from typing import Any

import pytest

import popsteer
from popsteer import sim
from tests.helpers import ROOT

pytest.importorskip("carla", reason='the extra "carla" is not installed')
pytest.importorskip("scenariogeneration", reason="scenariogeneration is not installed")

import carla

from tests.adapters.carla_actor import CAR, Actor, World, road, route


class _SpawnedActor(Actor):
    destroyed = False

    def destroy(self) -> None:
        self.destroyed = True


class _Simulator(World):
    """What the example asks of a world, and what it left behind."""

    def __init__(self) -> None:
        super().__init__(road())
        self.settings = carla.WorldSettings()
        self.was_synchronous = False
        places = [waypoint.transform.location for waypoint in route(self.map)]
        path = popsteer.Path([(place.x, -place.y) for place in places])
        start = sim.default_start(path, 0.0, CAR)
        self.actor = _SpawnedActor(
            self.map, sim.Simulation(path, sim.KinematicBicycle(CAR), start=start)
        )
        self.actor.world = self
        self.free = True

    def get_blueprint_library(self) -> _Library:
        return _Library()

    def get_map(self) -> Any:
        return _Spawns(self.map)

    def try_spawn_actor(self, model: str, place: str) -> Actor | None:
        assert model == "vehicle.tesla.model3"
        return self.actor if place == "free" and self.free else None

    def get_settings(self) -> carla.WorldSettings:
        return carla.WorldSettings(
            synchronous_mode=self.settings.synchronous_mode,
            fixed_delta_seconds=self.settings.fixed_delta_seconds or 0.0,
        )

    def apply_settings(self, settings: carla.WorldSettings) -> None:
        self.settings = settings
        self.was_synchronous |= settings.synchronous_mode

    def tick(self) -> None:
        self.actor.tick()


class _Library:
    def find(self, name: str) -> str:
        return name


class _Spawns:
    """The real map, with spawn points; OpenDRIVE has none."""

    def __init__(self, lane_map: carla.Map) -> None:
        self.get_waypoint = lane_map.get_waypoint

    def get_spawn_points(self) -> list[str]:
        return ["taken", "free"]


def _run(simulator: _Simulator, monkeypatch: pytest.MonkeyPatch) -> None:
    class Client:
        def __init__(self, host: str, port: int) -> None:
            assert (host, port) == ("127.0.0.1", 2000)

        def set_timeout(self, seconds: float) -> None:
            assert seconds == 10.0

        def get_world(self) -> _Simulator:
            return simulator

    monkeypatch.setattr(carla, "Client", Client)
    monkeypatch.setattr(sys, "argv", ["carla_drive.py"])
    runpy.run_path(str(ROOT / "examples" / "carla_drive.py"), run_name="__main__")


def test_example_drives_to_the_end_of_the_road_and_cleans_up(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    simulator = _Simulator()
    _run(simulator, monkeypatch)
    found = re.fullmatch(
        r"([\d.]+) s, never farther than ([\d.]+) m from the middle of the lane\n",
        capsys.readouterr().out,
    )
    assert found
    assert 25.0 < float(found[1]) < 60.0
    assert float(found[2]) < 0.1
    assert simulator.was_synchronous
    assert not simulator.settings.synchronous_mode
    assert simulator.actor.destroyed


def test_example_without_a_free_place_ends_with_one_line_and_status_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    simulator = _Simulator()
    simulator.free = False
    with pytest.raises(SystemExit, match="2"):
        _run(simulator, monkeypatch)
    assert capsys.readouterr().err == "carla_drive: no spawn point of the map is free\n"
