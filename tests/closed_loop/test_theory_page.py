"""The tables of docs/theory.md are what the library computes and what is driven."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

import pytest

import popsteer
from popsteer import Vehicle, laws, presets, sim, tracks, vehicles
from popsteer.study import (
    LINEAR_LAWS,
    carrot_offset,
    driven_offset,
    margins,
    preview_offset,
    stability,
)
from tests.closed_loop.rolling import Car, Told, critical_dead_time, driven_preview_offset
from tests.helpers import ROOT

if TYPE_CHECKING:
    from popsteer.sim import OwnLaw

PAGE = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
CAR = vehicles.get("paper")
TITLES = {laws.get(name).title: name for name in LINEAR_LAWS}


def _table(name: str) -> dict[str, list[str]]:
    """Rows of a table by their first cell, without its two rows of heads."""
    text = PAGE.partition(f"<!-- table: {name} -->\n")[2].partition("\n\n")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    return {first: rest for first, *rest in rows[2:]}


def test_page_table_of_margins_is_computed_and_driven() -> None:
    table = _table("margins")
    assert [TITLES[title] for title in table] == list(LINEAR_LAWS)
    for title, cells in table.items():
        name = TITLES[title]
        told = Told(name, presets.get(name, "default"), CAR).in_small_signals()
        for column, speed in enumerate((5.0, 10.0, 15.0, 20.0)):
            computed = margins(told.params, CAR, speed).dead_time
            assert cells[2 * column] == f"{1e3 * computed:.1f}"
            driven = critical_dead_time(told, Car.of(CAR), speed, computed)
            assert float(cells[2 * column + 1]) == pytest.approx(1e3 * driven, rel=1e-3, abs=0.1)


def test_page_table_of_offsets_is_computed_and_driven() -> None:
    table = _table("carrot")
    assert list(table) == ["15", "30", "60", "120"]
    for radius, cells in table.items():
        speed = math.sqrt(2.0 * float(radius))
        for column, plant in enumerate(("kinematic-bicycle", "carla-identified")):
            driven, distance = driven_offset(float(radius), plant, speed)
            computed = carrot_offset(distance, float(radius), vehicles.get(plant), speed)
            assert cells[2 * column : 2 * column + 2] == [f"{computed:.2f}", f"{driven:.2f}"]


class _Late:
    """A controller whose commands are held back by some steps."""

    def __init__(self, law: laws.Controller, steps: int) -> None:
        self.path = law.path
        self.tracked_point = law.tracked_point
        self._law = law
        self._in_flight = [0.0] * steps

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        self._in_flight.append(self._law.steer(x, y, yaw, speed, dt))
        return self._in_flight.pop(0)


@pytest.mark.parametrize("name", LINEAR_LAWS)
def test_page_table_of_late_commands_is_driven(name: str) -> None:
    cells = _table("late")[laws.get(name).title]
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed)
    told = Told(name, presets.get(name, "default"), vehicles.get("carla-identified"))
    for cell, milliseconds in zip(cells, (0, 50, 100, 150, 200, 300), strict=True):
        law = told.on(path)
        late: OwnLaw = _Late(law, milliseconds // 50)
        metrics = sim.run(late, path=path).metrics
        if cell == "off the road":
            assert not metrics.finished
        else:
            assert cell == f"{metrics.settled_mean_abs_cross_track_error:.3f}"


def test_page_margins_of_the_identified_plant_are_computed() -> None:
    found = stability(LINEAR_LAWS, vehicles.get("carla-identified"), [16.0]).margins
    shown = [f"{1e3 * found[name][0].dead_time:.0f}" for name in LINEAR_LAWS]
    sentence = re.search(
        r"margins are (\d+) \(PID\), (\d+) \(pure pursuit\), (\d+) \(Stanley\), (\d+) \(POP\) and"
        r" (\d+) ms \(preview POP\)",
        PAGE,
    )
    assert sentence is not None
    assert list(sentence.groups()) == shown


def test_page_choice_of_the_lookahead_is_computed() -> None:
    sentence = " ".join(PAGE.partition("The rope forces a choice.")[2].split())
    shown = []
    for distance in (9.0, 3.0, 1.4):
        params = popsteer.PopParams(lookahead_gain=0.0, min_lookahead=distance)
        delay = margins(params, CAR, 15.0).dead_time
        shown.append((f"{1e3 * delay:.0f}", f"{carrot_offset(distance, 50.0, CAR):.2f}"))
    (d9, e9), (d3, e3), (d1, e1) = shown
    assert f"leaves {d9} ms of dead time and cuts a bend of 50 m radius by {e9} m" in sentence
    assert f"3 m of lookahead cut it by {e3} m and leave {d3} ms" in sentence
    assert f"1.4 m cut it by {e1} m and leave {d1} ms" in sentence


def test_page_table_of_the_choice_is_computed_and_driven() -> None:
    table = _table("choice")
    assert list(table) == ["0.05", "0.25", "1"]
    assert float(list(table)[1]) == popsteer.PreviewPopParams().resolved(CAR).steer_rate_cost
    for cost, (dead_time, *cells) in table.items():
        params = popsteer.PreviewPopParams(steer_rate_cost=float(cost))
        assert dead_time == f"{1e3 * margins(params, CAR, 15.0).dead_time:.0f}"
        wanted = []
        for share in (1.0, 1.15, 0.85):
            believed = CAR.replace(turning_wheelbase=share * 3.0)
            told = Told("preview-pop", params, believed, adapt=None)
            wanted += [
                preview_offset(params, CAR, 50.0, 15.0, believed=believed, adapt=None),
                driven_preview_offset(told, Car.of(CAR), 50.0, 15.0),
            ]
        assert cells == [f"{value:.3f}".replace("-", "−") for value in wanted]


@pytest.mark.parametrize("speed", [8.0, 15.0, 25.0])
@pytest.mark.parametrize("name", ["pop", "pure-pursuit"])
def test_page_condition_of_the_lag_is_the_limit_of_fast_sampling(name: str, speed: float) -> None:
    # l_d + a > τ v, without dead time and with a control period that hardly counts.
    lag, dt = 0.5, 1e-3
    vehicle = Vehicle(wheelbase=2.0, steer_lag=lag)
    ahead = vehicle.front_axle if name == "pop" else vehicle.rear_axle
    for share, stable in ((0.97, False), (1.03, True)):
        changes = {"lookahead_gain": 0.0, "min_lookahead": share * lag * speed - ahead}
        params = presets.get(name, "default").replace(**changes)
        assert margins(params, vehicle, speed, dt).stable is stable


@pytest.mark.parametrize("speed", [5.0, 10.0, 15.0, 20.0])
def test_page_estimate_of_the_dead_time_is_within_a_fifth(speed: float) -> None:
    exact = margins(popsteer.PopParams(), CAR, speed).dead_time
    estimate = 0.5 * math.pi / (speed * (1.0 / 3.0 + 1.0 / (6.0 + 0.2 * speed)))
    assert exact + 0.1 + 0.025 == pytest.approx(estimate, rel=0.2)


@pytest.mark.parametrize(
    "name", ["carrot-offset", "preview-choice", "stability-map", "stability-margins"]
)
def test_page_shows_its_figures_on_both_backgrounds(name: str) -> None:
    for suffix in ("", "-dark"):
        assert f"figures/{name}{suffix}.png" in PAGE
        assert (ROOT / "docs" / "figures" / f"{name}{suffix}.png").is_file()
