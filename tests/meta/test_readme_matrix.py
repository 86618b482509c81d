"""README's table of laws, plants and tracks is what its command makes."""

from __future__ import annotations

import re
import shlex
from typing import TYPE_CHECKING

import pytest

import popsteer
from popsteer import lab, sim, tracks
from popsteer.lab.common.names import title_of
from studies.matrix import FIGURES, update
from tests.helpers import ROOT

if TYPE_CHECKING:
    from pathlib import Path

README = (ROOT / "README.md").read_text(encoding="utf-8")
_LISTS = ("controllers", "plants", "tracks")
BLOCK = README.partition("<!-- matrix: begin")[2].partition("<!-- matrix: end")[0]


def _command(text: str) -> list[str]:
    """The words of the first call of `popsteer matrix` with options."""
    found = re.search(r"popsteer matrix --.*?(?<!\\)\n", text, flags=re.DOTALL)
    assert found is not None
    return shlex.split(found[0].replace("\\\n", " "))


def _options() -> dict[str, str]:
    words = _command(README)[2:]
    return dict(zip(words[::2], words[1::2], strict=True))


def _rows() -> list[list[str]]:
    lines = re.findall(r"^\| (.+) \|$", BLOCK, flags=re.MULTILINE)
    return [[cell.strip() for cell in line.split("|")] for line in lines]


def test_command_of_the_matrix_is_that_of_make() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    folder = re.search(r"^MATRIX := (\S+)$", makefile, flags=re.MULTILINE)
    assert folder is not None
    assert _command(makefile.replace("$(MATRIX)", folder[1])) == _command(README)


def test_table_of_the_matrix_has_the_rows_and_columns_of_its_command() -> None:
    options = _options()
    names, plants, courses = (options[f"--{which}"].split(",") for which in _LISTS)
    head, _, *body, steps = _rows()
    assert head == ["plant", "track", *map(title_of, names)]
    assert [row[:2] for row in body] == [[plant, track] for plant in plants for track in courses]
    assert steps[0] == "step, median [µs]"
    for row in (*body, steps):
        assert len(row) == len(head)
        assert all(float(cell.strip("()")) > 0.0 for cell in row[2:])


@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
def test_errors_of_the_matrix_are_those_that_are_driven(plant: str) -> None:
    options = _options()
    names = options["--controllers"].split(",")
    checked = [name for name in names if name in popsteer.controllers.names()]
    assert len(checked) == len(names) - 1  # the MPC's digits are those of a release of osqp
    shown = {row[1]: row[2:] for row in _rows() if row[0] == plant}
    for track, cells in shown.items():
        course = tracks.get(track)
        path = popsteer.Path(course.xy, speed=course.speed, closed=course.closed)
        start = sim.default_start(path, float(options["--start-offset"]), sim.vehicle_of(plant))
        speed = float(options["--constant-speed"])
        found = lab.compare.run(path, checked, plant, start=start, constant_speed=speed)
        for name in checked:
            metrics = found.runs[name].metrics
            assert metrics.finished
            error = f"{metrics.settled_mean_abs_cross_track_error:.4f}"
            assert cells[names.index(name)] == error, (track, name)


def test_update_of_the_matrix_replaces_the_block_and_the_figures(tmp_path: Path) -> None:
    run, checkout = tmp_path / "run", tmp_path / "checkout"
    run.mkdir()
    (checkout / "docs" / "figures").mkdir(parents=True)
    (checkout / "README.md").write_text(README, encoding="utf-8")
    (run / "matrix.md").write_text("| new |\n\nA machine.\n", encoding="utf-8")
    for name in FIGURES:
        (run / name).write_bytes(name.encode())
    update(run, checkout)
    new = (checkout / "README.md").read_text(encoding="utf-8")
    assert "make matrix) -->\n| new |\n\nA machine.\n<!-- matrix: end -->\n" in new
    kept = (text.partition("<!-- matrix: begin")[0] for text in (new, README))
    assert len(set(kept)) == 1
    for name in FIGURES:
        assert f"docs/figures/{name}" in README
        assert (checkout / "docs" / "figures" / name).read_bytes() == name.encode()
        assert (ROOT / "docs" / "figures" / name).is_file()
