"""The pages of the suite: their rows are what is driven."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

import pytest

from popsteer import controllers, lab
from popsteer.lab.suite.conditions import CONDITIONS
from popsteer.lab.suite.runs import Cell, mean_error
from popsteer.lab.suite.scenarios import SCENARIOS
from studies.front import HEADING, STEER_RATE, front_line
from studies.layout import DOCS, table
from studies.suite import FIGURES, loss_lines, read, update

if TYPE_CHECKING:
    from pathlib import Path

PAGE = (DOCS / "results.md").read_text(encoding="utf-8")


def shown() -> tuple[list[str], dict[str, list[str]]]:
    """The heads of the page's table, and its rows by their first cell."""
    block = PAGE.partition("<!-- suite: begin")[2].partition("<!-- suite: end")[0]
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


def test_row_of_the_hairpin_is_what_is_driven() -> None:
    heads, rows = shown()
    found = lab.suite.run(controllers.names(), scenarios=["hairpin"])
    for name in controllers.names():
        own = [each for each in found.cells if each.controller == name]
        at = heads.index(controllers.get(name).title)
        cell = rows[SCENARIOS["hairpin"].title][at - (len(heads) - len(rows["Slalom"]))]
        assert cell.split()[0] == f"{mean_error(own):.4f}", name


def test_row_of_the_default_costs_is_what_is_driven() -> None:
    row = front_line(STEER_RATE[1], HEADING[0])
    assert row in table("preview_pop.md", "front")
    assert row.startswith("| **L/12** | **L** |")


def test_update_replaces_the_blocks_and_the_figures(tmp_path: Path) -> None:
    cells = [
        Cell("slalom", "noise", "suite-car", name, error, 0.1, 0.0, 0.1, 1.0, 0.0, True, "finished")
        for name, error in (("preview-pop", 0.02), ("stanley", 0.01))
    ]
    document = {
        "suite": "standard-1",
        "step_times": {"preview-pop": 1e-6, "stanley": 1e-6},
        "cells": [asdict(each) for each in cells],
    }
    (tmp_path / "suite.json").write_text(json.dumps(document), encoding="utf-8")
    (tmp_path / "docs" / "figures").mkdir(parents=True)
    (tmp_path / "docs" / "results.md").write_text(PAGE, encoding="utf-8")
    for name in FIGURES:
        (tmp_path / name).write_bytes(name.encode())
    update(tmp_path, tmp_path)
    text = (tmp_path / "docs" / "results.md").read_text(encoding="utf-8")
    assert "| Slalom | 0.0200 | **0.0100** |" in text
    assert "Of 1 cells it loses 1." in text
    assert "| suite-car | 0.0200 | Stanley | 0.0100 | 2.00 |" in text
    assert text.count("<!-- losses") == 2
    assert (tmp_path / "docs" / "figures" / FIGURES[0]).read_bytes() == FIGURES[0].encode()
    assert loss_lines(read(tmp_path))[-1].endswith("| 2.00 |")
    for name in FIGURES:
        assert f"figures/{name}" in PAGE
        assert (DOCS / "figures" / name).is_file(), name
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "docs")
