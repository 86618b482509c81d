"""Every block of code on a page and every program of examples/ runs, here or where it says."""

from __future__ import annotations

import contextlib
import io
import re
import subprocess
import sys
import textwrap
from typing import TYPE_CHECKING

import pytest

from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from pathlib import Path

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGES = ["README.md", *(f"docs/{file.name}" for file in sorted((ROOT / "docs").glob("*.md")))]
# Pages whose code is run elsewhere, by the tests that drive what it needs.
ELSEWHERE = {
    "README.md": "tests/meta/test_readme.py",
    "docs/c.md": "tests/adapters/c/test_c_interface.py",
    "docs/carla.md": "tests/adapters/test_pages.py",
    "docs/compare_your_controller.md": "tests/cli/test_own.py",
    "docs/edges.md": "tests/closed_loop/test_cars_loop_stop.py",
    "docs/results.md": "tests/cli/test_suite.py",
    "docs/ros2.md": "tests/adapters/test_pages.py",
}
# What the code of a page takes as given, and what it needs beside popsteer.
GIVEN = {
    "docs/files.md": """
import numpy as np
yaw = 0.1 * np.arange(60)
x, y, one = 20.0 * np.sin(yaw), 20.0 * (1.0 - np.cos(yaw)), np.ones(60)
def write(name, head, *columns):
    np.savetxt(name, np.column_stack(columns), "%.9f", ",", header=head, comments="")
tum = "# 17b4de0d\\n# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2"
psi = yaw - np.pi / 2.0
rows = np.column_stack((20.0 * yaw, x, y, psi, 0.05 * one, 5.0 * one, 0.0 * one))
np.savetxt("raceline.csv", rows, "%.7f", "; ", header=tum, comments="")
np.savetxt("logged.csv", np.column_stack((x, y, yaw)), "%f", ", ")
np.savetxt("three.csv", np.column_stack((x, y, 18.0 * one)), "%f", ",")
write("survey.csv", "Nr,Rechtswert,Hochwert,Tempo", np.arange(60), x, y, 18.0 * one)
turn = (np.sin(0.5 * yaw), np.cos(0.5 * yaw))
s, ns = 1650775094 + np.arange(60) // 20, 50_000_000 * (np.arange(60) % 20)
head = "s,ns,x,y,qx,qy,qz,qw,V,delta"
with open("drive.csv", "w", encoding="utf-8") as file:
    print(head, file=file)
    for k in range(60):
        row = (0.25 * k, 0.0, 0.0, 0.0, 0.0, 1.0, 5.0, 0.0)
        print(s[k], ns[k], *row, sep=",", file=file)
""",
    "docs/loop.md": """
import popsteer
controller = popsteer.Stanley(popsteer.Path([(0.0, 0.0), (50.0, 0.0)]))
pose, passed, dt = (0.0, 0.1, 0.0, 5.0), 0.0, 0.05
with open("waypoints.csv", "w") as file:
    file.write("x,y,speed\\n0,0,5\\n50,0,5\\n")
driving, localise, present_angle = iter([True, False]).__next__, lambda: pose, lambda: 0.0
log = actuate = watch = stop = lambda *given: None
""",
    "docs/tune.md": """
import popsteer
popsteer.PopParams(min_lookahead=4.0).save("tuned.toml")
""",
}
NEEDS = {
    "docs/gymnasium.md": "gymnasium",
    "docs/identify.md": "scipy",
    "docs/sweep.md": "pyarrow",
}
# No code to run: a citation, and settings of another program.
NOT_RUN = {"bibtex", "toml", "yaml"}


def _blocks(page: str) -> list[tuple[str, str]]:
    return BLOCK.findall((ROOT / page).read_text(encoding="utf-8"))


def _printed(code: str, names: dict[str, object]) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(code, "page", "exec"), names)
    return out.getvalue()


HERE = [page for page in PAGES if page not in ELSEWHERE and _blocks(page)]


@pytest.mark.parametrize("page", HERE)
def test_code_of_the_page_prints_what_the_page_says(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if page in NEEDS:
        pytest.importorskip(NEEDS[page])
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    exec(GIVEN.get(page, ""), names)
    last = ""
    for kind, text in _blocks(page):
        if kind == "python":
            assert not last, f"the page does not show what was printed: {last}"
            last = _printed(text, names)
        elif kind == "text":
            assert text == last
            last = ""
        else:
            assert kind in NOT_RUN, f"nothing says how ```{kind} is run"
    assert not last, f"the page does not show what was printed: {last}"


@pytest.mark.parametrize(("page", "test"), ELSEWHERE.items())
def test_code_of_other_pages_is_run_by_the_test_that_is_named(page: str, test: str) -> None:
    assert _blocks(page)
    assert page.rpartition("/")[2] in (ROOT / test).read_text(encoding="utf-8")


def test_what_is_given_belongs_to_a_page_with_code() -> None:
    assert set(GIVEN) | set(NEEDS) <= set(HERE)
    assert {"docs/index.md", "docs/identify.md", "docs/loop.md"} <= set(HERE)


EXAMPLES = ROOT / "examples"
# Run by the tests of what they drive, with the options that a simulator of others needs.
RUN_ELSEWHERE = {
    "carla_drive.py": "tests/adapters/test_carla_example.py",
    "from_log_to_car.sh": "tests/cli/test_from_log_to_car.py",
    "highway_env.py": "tests/adapters/test_highway_env.py",
    "ros2_vehicle.py": "tests/adapters/test_pages.py",
    "embedded": "tests/core/test_embedded.py",
}
RUN_HERE = ("compare_controllers.py", "own_controller.py", "own_loop.py")
LONGEST = 59  # lines
MOST = 9


def _run(name: str, folder: Path) -> str:
    program = [sys.executable, "-W", "error", str(EXAMPLES / name)]
    ran = subprocess.run(program, cwd=folder, check=False, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert not list(folder.iterdir())
    return ran.stdout


def test_own_loop_stays_on_paths_that_are_new_each_step(tmp_path: Path) -> None:
    found = re.fullmatch(
        r"(\d+) steps, as many paths; after 5 s at most ([\d.]+) m off\n",
        _run("own_loop.py", tmp_path),
    )
    assert found is not None
    assert int(found[1]) > 500
    assert float(found[2]) < 0.05


def test_compared_controllers_have_the_order_that_the_pages_give(tmp_path: Path) -> None:
    _, *rows = _run("compare_controllers.py", tmp_path).splitlines()
    errors = {row.split()[0]: float(row.split()[1]) for row in rows}
    assert sorted(errors, key=errors.__getitem__) == ["PreviewPop", "Stanley", "PurePursuit", "Pop"]
    assert all(row.split()[-1] == "0" for row in rows)


def test_bang_bang_leaves_the_road_where_pop_does_not(tmp_path: Path) -> None:
    said = _run("own_controller.py", tmp_path)
    first, second = said.splitlines()
    assert first.startswith("bang-bang: too far from the path after ")
    assert second.startswith("pop: finished after ")
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    assert textwrap.indent(said, "    ") in page


def _names() -> list[str]:
    return sorted(file.name for file in EXAMPLES.iterdir() if file.name != "__pycache__")


@looped("name", _names())
def test_example_is_short(name: str) -> None:
    file = EXAMPLES / name
    source = file / "src" / "main.rs" if file.is_dir() else file
    lines = source.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= LONGEST
    assert max(map(len, lines)) <= 100


def test_every_example_is_run_and_on_the_page() -> None:
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    found = _names()
    assert len(found) <= MOST
    assert set(found) == {*re.findall(r"^\| `([\w.]+)/?` \|", page, re.MULTILINE)}
    # The script runs the program that records its log.
    assert set(found) == {*RUN_HERE, *RUN_ELSEWHERE, "recorded_drive.py"}
    assert "recorded_drive.py" in (EXAMPLES / "from_log_to_car.sh").read_text(encoding="utf-8")
    for name, test in RUN_ELSEWHERE.items():
        assert name in (ROOT / test).read_text(encoding="utf-8")
