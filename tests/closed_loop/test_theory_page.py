"""The tables of docs/theory.md are what the library computes and what is driven."""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict
from typing import TYPE_CHECKING

import pytest

import popsteer
from popsteer import Vehicle, controllers, lab, presets, vehicles
from popsteer.lab import stability
from popsteer.lab.common.names import title_of
from popsteer.lab.stability import margins
from popsteer.lab.suite.runs import Cell, mean_error
from popsteer.lab.suite.scenarios import CONDITIONS, SCENARIOS
from popsteer.lab.suite.table import spoken
from studies.carrot import carrot_offset
from studies.front import HEADING, STEER_RATE, front_line
from studies.layout import DOCS, cells, table
from studies.suite import FIGURES, loss_lines, read, update
from studies.theory import CAR, carrot_lines, choice_lines, late_line, margins_of

if TYPE_CHECKING:
    from pathlib import Path

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


RESULTS = (DOCS / "results.md").read_text(encoding="utf-8")


def shown() -> tuple[list[str], dict[str, list[str]]]:
    """The heads of the page's table, and its rows by their first cell."""
    block = RESULTS.partition("<!-- suite: begin")[2].partition("<!-- suite: end")[0]
    lines = [
        [each.strip(" *") for each in line.strip("| ").split("|")] for line in block.split("\n")
    ]
    rows = {line[0]: line[1:] for line in lines if len(line) > 2}
    heads = next(line for line in lines if len(line) > 2)
    return heads, rows


def test_page_has_every_scenario_and_condition() -> None:
    _, rows = shown()
    titles = [each.title for each in SCENARIOS.values()]
    titles += [each.title for each in CONDITIONS.values()]
    assert set(titles) <= set(rows)


def test_page_says_what_its_table_shows() -> None:
    block = RESULTS.partition("<!-- suite: begin")[2].partition("<!-- suite: end")[0]
    lines = [line.strip("| ").split(" | ") for line in block.split("\n") if line.startswith("| ")]
    names = lines[0]  # the cell above the titles is empty
    titled = {line[0]: dict(zip(names, line[1:], strict=True)) for line in lines[2:]}
    upto = [*titled].index("All") + 1
    said = RESULTS.partition("<!-- said: begin")[2].partition("<!-- said: end")[0].split("\n")[1:-1]
    assert said == [f"- {each}" for each in spoken(dict(list(titled.items())[:upto]))]


def test_readme_says_what_the_suite_shows() -> None:
    heads, rows = shown()
    ours, mpc, *others = (float(each.split()[0]) for each in rows["All"])
    assert mpc < ours < min(others)
    assert float(rows["rate of the command, rms [rad/s]"][0]) < 0.25 * float(
        rows["rate of the command, rms [rad/s]"][1]
    )
    ours, mpc = (float(each.split()[0]) for each in rows["As told"][:2])
    assert mpc < 0.5 * ours
    for name in ("noise", "fresh path", "smoothed path"):
        row = rows[CONDITIONS[name].title]
        ours, *others = (float(each.strip("=* ").split()[0]) for each in row)
        assert ours < min(others), name
        tied = [head for head, each in zip(heads[-len(row) :], row, strict=True) if "=" in each]
        assert tied == [], name


def test_weights_are_searched_for_the_suite_of_the_page() -> None:
    heads, rows = shown()
    titles = heads[-len(rows["All"]) :]
    for row in map(cells, table("results.md", "weights")):
        at = titles.index(row[0])
        assert row[3] == rows["All"][at].strip("=* ").split()[0].strip("*"), row[0]
        assert row[4] == rows["rate of the command, rms [rad/s]"][at], row[0]
        # Opponents whose defaults are within a tenth of the least keep them.
        if row[0] not in map(title_of, controllers.names()):
            assert float(row[2]) < 1.1 * float(row[6]), row[0]


def test_row_of_the_hairpin_is_what_is_driven() -> None:
    heads, rows = shown()
    found = lab.suite.run(controllers.names(), scenarios=["hairpin"])
    for name in controllers.names():
        own = [each for each in found.cells if each.controller == name]
        at = heads.index(controllers.get(name).title)
        cell = rows[SCENARIOS["hairpin"].title][at - (len(heads) - len(rows["Slalom"]))]
        assert cell.lstrip("= ").split()[0] == f"{mean_error(own):.4f}", name


def test_row_of_the_default_costs_is_what_is_driven() -> None:
    row = front_line(STEER_RATE[1], HEADING[0])
    assert row in table("preview_pop.md", "front")
    assert row.startswith("| **L/12** | **L** |")


def test_page_says_what_the_table_of_the_costs_shows() -> None:
    read = [[each.strip("*") for each in cells(row)] for row in table("preview_pop.md", "front")]
    rows = {(row[0], row[1]): [float(each.split()[0]) for each in row[2:]] for row in read}
    usual = rows["L/12", "L"]

    def shares(rate: str, heading: str) -> list[float]:
        """Of the defaults': error as told, in noise, effort, dead time at 10 m/s."""
        return [rows[rate, heading][at] / usual[at] for at in (0, 1, 4, 6)]

    assert min(rows, key=lambda costs: rows[costs][1]) == ("L/12", "L/2")
    _, noise, effort, margin = shares("L/12", "L/2")
    assert (1.0 / noise, 1.0 / margin, 1.0 / effort) == pytest.approx((1.01, 1.13, 1.0), abs=0.04)
    assert shares("L/200", "L/2") == pytest.approx([0.2, 1.5, 2.1, 0.5], abs=0.1)
    told, noise, effort, _ = shares("L/6", "L/2")
    assert told > 2.0
    assert (noise, effort) == pytest.approx((1.11, 0.62), abs=0.02)


def test_update_replaces_the_blocks_and_the_figures(tmp_path: Path) -> None:
    driven = [
        Cell("slalom", "noise", "suite-car", name, error, 0.1, 0.0, 0.1, 1.0, 0.0, True, "finished")
        for name, error in (("preview-pop", 0.02), ("stanley", 0.01))
    ]
    document = {
        "suite": "standard-2",
        "step_times": {"preview-pop": 1e-6, "stanley": 1e-6},
        "cells": [asdict(each) for each in driven],
    }
    (tmp_path / "suite.json").write_text(json.dumps(document), encoding="utf-8")
    (tmp_path / "docs" / "figures").mkdir(parents=True)
    (tmp_path / "docs" / "results.md").write_text(RESULTS, encoding="utf-8")
    for name in FIGURES:
        (tmp_path / name).write_bytes(name.encode())
    update(tmp_path, tmp_path)
    text = (tmp_path / "docs" / "results.md").read_text(encoding="utf-8")
    assert "| Slalom | 0.0200 | **0.0100** |" in text
    assert "Of 1 cells it loses 1, and 0 more by 1 mm or less." in text
    assert "- Stanley alone has the least: Slalom; Noise of 5 cm and 0.01 rad.\n" in text
    assert "- Behind the least in every row: Preview POP.\n" in text
    assert "| suite-car | 0.0200 | Stanley | 0.0100 | 2.00 |" in text
    assert text.count("<!-- losses") == 2
    assert (tmp_path / "docs" / "figures" / FIGURES[0]).read_bytes() == FIGURES[0].encode()
    assert loss_lines(read(tmp_path))[-1].endswith("| 2.00 |")
    for name in FIGURES:
        assert f"figures/{name}" in RESULTS
        assert (DOCS / "figures" / name).is_file(), name
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "docs")
