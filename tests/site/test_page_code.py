"""Every block of code on a page runs, or is named here with what runs it or why it cannot."""

from __future__ import annotations

import contextlib
import io
import re
from typing import TYPE_CHECKING

import pytest

from tests.helpers import ROOT

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
    "docs/ros2.md": "tests/adapters/test_pages.py",
}
# What the code of a page takes as given, and what it needs beside popsteer.
GIVEN = {
    "docs/loop.md": """
import popsteer
controller = popsteer.Stanley(popsteer.Path([(0.0, 0.0), (50.0, 0.0)]))
pose, passed, dt = (0.0, 0.1, 0.0, 5.0), 0.0, 0.05
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
