"""Puts what `make suite` measured into docs/results.md and its figure into docs/figures.

    python -m studies.suite out/suite

The folder holds what `popsteer suite --out` wrote.
"""

from __future__ import annotations

import json
import shutil
import sys
from operator import attrgetter
from pathlib import Path as File
from typing import Any

from popsteer import Command, Path, PreviewPop, Vehicle, lab
from popsteer.lab import opponents
from popsteer.lab.common.names import title_of
from popsteer.lab.opponents.observer import Ahead
from popsteer.lab.suite import Cell, Suite
from popsteer.lab.suite.scenarios import CONDITIONS, SCENARIOS
from popsteer.lab.suite.table import sentences, suite_lines, worded
from studies.layout import ROOT, line, write_blocks

OURS = "preview-pop"
ON_CURVE = (OURS, "studies.suite:OnCurve", opponents.names()[0])
# A row is a loss where the error is more than so many times the least.
LOSS = 1.1
FIGURES = ("suite.png", "suite-dark.png")


def read(folder: File) -> Suite:
    """Read the cells that a run wrote."""
    document = json.loads((folder / "suite.json").read_text(encoding="utf-8"))
    cells = [Cell(**each) for each in document["cells"]]
    return Suite(document["suite"], cells, document["step_times"], [])


def losses(found: Suite, name: str, more: float = 0.001) -> list[tuple[Cell, Cell]]:
    """Give the cells where a controller loses by so much [m] to the best, with that one's."""
    lost = []
    places: dict[tuple[str, str, str], list[Cell]] = {}
    for each in found.cells:
        places.setdefault((each.scenario, each.condition, each.plant), []).append(each)
    for cells in places.values():
        succeeded = (each for each in cells if each.success)
        best = min(succeeded, key=attrgetter("mean_error"), default=None)
        for each in cells:
            if best is None or each.controller != name:
                continue
            if each.mean_error > max(LOSS * best.mean_error, best.mean_error + more):
                lost.append((each, best))
    return lost


def loss_lines(found: Suite) -> list[str]:
    """Set out the twenty cells where preview POP loses most, the worst first."""
    lost = sorted(losses(found, OURS), key=lambda each: each[1].mean_error / each[0].mean_error)
    heads = ("scenario", "condition", "plant", "Preview POP", "best of the others", "", "times")
    lines = [line(*heads), "|---|---|---|--:|---|--:|--:|"]
    for own, best in lost[:20]:
        lines.append(
            line(
                SCENARIOS[own.scenario].title,
                CONDITIONS[own.condition].title,
                own.plant,
                f"{own.mean_error:.4f}",
                title_of(best.controller),
                f"{best.mean_error:.4f}",
                f"{own.mean_error / best.mean_error:.2f}",
            )
        )
    places = {(each.scenario, each.condition, each.plant) for each in found.cells}
    slight = len(losses(found, OURS, 0.0)) - len(lost)
    said = f"Of {len(places)} cells it loses {len(lost)}, and {slight} more by 1 mm or less."
    return [said, "", *lines]


class OnCurve:
    """Preview POP that is told the curve of the opponents where a path has none of its own."""

    def __init__(self, path: Path, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self.law = PreviewPop(Ahead(path, vehicle).path, vehicle)
        self.tracked_point = self.law.tracked_point

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self.law.reset()

    def set_path(self, path: Path) -> None:
        """Follow another path from the next step on."""
        self.law.set_path(Ahead(path, self.vehicle).path)

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> Command:
        """Steer."""
        return self.law.step(x, y, yaw, speed, dt)


def curve_lines() -> list[str]:
    """Set out where paths come without tangents, by preview POP both ways and the MPC."""
    rows: dict[str, Any] = {SCENARIOS["zigzag"].title: {"scenarios": ["zigzag"]}}
    rows |= {CONDITIONS[k].title: {"conditions": [k]} for k in ("fresh path", "smoothed path")}
    lines = []
    for title, which in rows.items():
        cells = lab.suite.run(ON_CURVE, **which).cells
        of = [[each for each in cells if each.controller == name] for name in ON_CURVE]
        lines.append(line(title, *(worded(each) for each in of)))
    return lines


def update(folder: File, root: File) -> None:
    """Rewrite the blocks and the figures of a checkout."""
    found = read(folder)
    said = [f"- {each}" for each in sentences(found)]
    blocks = {"said": said, "suite": suite_lines(found), "losses": loss_lines(found)}
    texts = {name: "\n".join(lines) for name, lines in blocks.items()}
    write_blocks(root / "docs" / "results.md", texts)
    for name in FIGURES:
        shutil.copyfile(folder / name, root / "docs" / "figures" / name)


if __name__ == "__main__":
    update(File(sys.argv[1]), ROOT)
    print("wrote docs/results.md and docs/figures/suite*.png")
