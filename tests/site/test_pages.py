"""Links of the pages lead somewhere, figures have a command, tables are what others measured."""

from __future__ import annotations

import posixpath
import re

import pytest

from docs.site import forge, pages
from studies import figures
from studies.choose import CHOICES, choose_lines, matrix, paper_lines
from studies.layout import table
from tests.helpers import ROOT, authors_data, looped

READ = [
    *sorted(ROOT.glob("*.md")),
    *sorted((ROOT / "docs").glob("*.md")),
    ROOT / "benches" / "README.md",
]
NAMES = [file.relative_to(ROOT).as_posix() for file in READ]


def faults(page: str, text: str) -> list[str]:
    """Links of a page, as a forge shows it, that lead nowhere."""
    found = []
    for link in forge.links(text):
        if forge.is_external(link):
            continue
        file, _, anchor = link.partition("#")
        place = posixpath.normpath(posixpath.join(posixpath.dirname(page), file)) if file else page
        if not (ROOT / place).exists():
            found.append(f"{link}: no such file")
        elif anchor and anchor not in forge.anchors(
            text if place == page else (ROOT / place).read_text(encoding="utf-8")
        ):
            found.append(f"{link}: no such heading")
    return found


@looped("page", NAMES)
def test_links_of_the_page_lead_to_files_and_headings(page: str) -> None:
    assert not faults(page, (ROOT / page).read_text(encoding="utf-8"))


@looped("page", NAMES)
def test_no_paragraph_stands_twice_on_a_page(page: str) -> None:
    paragraphs = (ROOT / page).read_text(encoding="utf-8").split("\n\n")
    told = [each for each in paragraphs if len(each) > 120 and not each.startswith("    ")]
    assert len(set(told)) == len(told)


def test_no_page_header_or_stub_words_a_default_in_rust() -> None:
    read = [
        *READ,
        *(ROOT / "rust" / "c" / "include").iterdir(),
        ROOT / "python" / "popsteer" / "_core.pyi",
    ]
    for file in read:
        text = file.read_text(encoding="utf-8")
        code = re.sub(r"^```rust\n.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
        told = re.findall(r"\.unwrap\w*\(|\bf(?:32|64)::|\bPI\b(?! controller)|\bSome\(", code)
        assert not told, (file.name, told)


@looped(
    ("text", "fault"),
    [
        ("[a](docs/none.md)", "docs/none.md: no such file"),
        ("[a](docs/loop.md#none)", "docs/loop.md#none: no such heading"),
        ("# A\n\n[a](#b)", "#b: no such heading"),
        ("[`a`\nb](docs/none.md)", "docs/none.md: no such file"),
        ('<img src="docs/none.png">', "docs/none.png: no such file"),
    ],
)
def test_link_that_leads_nowhere_is_found(text: str, fault: str) -> None:
    assert faults("README.md", text) == [fault]


@looped(
    ("heading", "anchor"),
    [
        ("Where to stop, which gear, how fast", "where-to-stop-which-gear-how-fast"),
        ("Driver: `applied_steer` and shadow mode", "driver-applied_steer-and-shadow-mode"),
        ("4. What the controller - estimates", "4-what-the-controller---estimates"),
    ],
)
def test_anchors_are_those_of_a_forge(heading: str, anchor: str) -> None:
    assert forge.slug(heading) == anchor
    assert forge.anchors(f"# {heading}\n\n```\n# no heading\n```\n## {heading}\n") == {
        anchor,
        f"{anchor}-1",
    }


def test_every_page_of_docs_is_on_the_site() -> None:
    listed = [source for sources in pages.CHAPTERS.values() for source in sources]
    assert len(set(listed)) == len(listed)
    assert {name for name in NAMES if name.startswith("docs/")} <= set(listed)


def test_every_guide_has_a_picture() -> None:
    bare = {
        file.stem for file in (ROOT / "docs").glob("*.md") if "<picture>" not in file.read_text()
    }
    # The licences are written where they are asked for.
    assert bare - {"licences"} == {"fuzzing", "mutation_testing", "parameters"}


def test_every_figure_is_shown_and_has_the_command_that_draws_it() -> None:
    shown = {
        posixpath.basename(link)
        for file in READ
        for link in forge.links(file.read_text(encoding="utf-8"))
    }
    names = {file.name for file in (ROOT / "docs" / "figures").iterdir()}
    assert names <= shown
    assert {re.sub(r"(-dark)?\.png$", "", name) for name in names} == set(figures.MADE_BY)


def test_table_of_the_choice_is_that_of_the_records() -> None:
    assert table("choose.md", "choose") == choose_lines()
    assert len(matrix()[0]) == len(CHOICES)


def test_table_of_the_paper_is_driven() -> None:
    authors_data()
    assert table("paper.md", "paper") == paper_lines()


def test_staged_page_leads_to_the_places_of_the_site() -> None:
    pytest.importorskip("latex2mathml", reason='the group "site" is not installed')
    code = "```\n[f](b.md) $1$\n```\n"
    text = f"# A\n\n[b.md](b.md#c), [`x`](../y.py), [d](#a), `[e](b.md)`, $x_1$\n\n{code}"
    staged = forge.staged(text, "docs/a.md", {"docs/b.md": "b.md"}.get, {"b.md": "Title"})
    assert staged.startswith("# A\n\n[Title](b.md#c), `x`, [d](#a), `[e](b.md)`, <span")
    assert staged.count("<math") == 1
    assert staged.endswith(code)
