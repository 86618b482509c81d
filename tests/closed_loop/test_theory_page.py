"""The tables of docs/theory.md are what the library computes and what is driven."""

from __future__ import annotations

import math
import re

import pytest

import popsteer
from popsteer import Vehicle, controllers, presets, vehicles
from popsteer.lab import stability
from popsteer.lab.stability import carrot_offset, margins
from studies.layout import DOCS, table
from studies.theory import CAR, carrot_lines, choice_lines, late_line, margins_of

PAGE = (DOCS / "theory.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("place", range(len(controllers.names())))
def test_page_table_of_margins_is_computed_and_driven(place: int) -> None:
    name = controllers.names()[place]
    title, *cells = (cell.strip() for cell in table("theory.md", "margins")[place].split("|")[1:-1])
    assert title == controllers.get(name).title
    for column, (computed, driven) in enumerate(margins_of(name)):
        assert cells[2 * column] == f"{computed:.1f}"
        assert float(cells[2 * column + 1]) == pytest.approx(driven, rel=1e-3, abs=0.1)


def test_page_table_of_offsets_is_computed_and_driven() -> None:
    assert table("theory.md", "carrot") == carrot_lines()


@pytest.mark.parametrize("place", range(len(controllers.names())))
def test_page_table_of_late_commands_is_driven(place: int) -> None:
    assert table("theory.md", "late")[place] == late_line(controllers.names()[place])


def test_page_margins_of_the_identified_plant_are_computed() -> None:
    found = stability.run(controllers.names(), vehicles.get("carla-identified"), [16.0]).margins
    shown = [f"{1e3 * found[name][0].dead_time:.0f}" for name in controllers.names()]
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
    rows = table("theory.md", "choice")
    default = popsteer.PreviewPopParams().resolved(CAR).steer_rate_cost
    assert rows[1].startswith(f"| {default:g} |")
    assert rows == choice_lines()


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
        assert (DOCS / "figures" / f"{name}{suffix}.png").is_file()
