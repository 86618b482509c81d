"""Puts what `make suite` measured into docs/results.md and its figure into docs/figures.

    python -m studies.suite out/suite

The folder holds what `popsteer suite --out` wrote.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from popsteer.lab.common.names import title_of
from popsteer.lab.suite import Cell, Suite
from popsteer.lab.suite.conditions import CONDITIONS
from popsteer.lab.suite.scenarios import SCENARIOS
from popsteer.lab.suite.table import losses, sentences, suite_lines
from studies.layout import ROOT, line, write_blocks

OURS = "preview-pop"
FIGURES = ("suite.png", "suite-dark.png")


def read(folder: Path) -> Suite:
    """Read the cells that a run wrote."""
    document = json.loads((folder / "suite.json").read_text(encoding="utf-8"))
    cells = [Cell(**each) for each in document["cells"]]
    return Suite(document["suite"], cells, document["step_times"], [])


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
    return [f"Of {len(places)} cells it loses {len(lost)}.", "", *lines]


def update(folder: Path, root: Path) -> None:
    """Rewrite the blocks and the figures of a checkout."""
    found = read(folder)
    said = [f"- {each}" for each in sentences(found)]
    blocks = {"said": said, "suite": suite_lines(found), "losses": loss_lines(found)}
    texts = {name: "\n".join(lines) for name, lines in blocks.items()}
    write_blocks(root / "docs" / "results.md", texts)
    for name in FIGURES:
        shutil.copyfile(folder / name, root / "docs" / "figures" / name)


if __name__ == "__main__":
    update(Path(sys.argv[1]), ROOT)
    print("wrote docs/results.md and docs/figures/suite*.png")
