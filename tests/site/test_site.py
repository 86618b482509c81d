"""The site builds, its links lead somewhere, and it loads nothing from elsewhere."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from typing import TYPE_CHECKING
from urllib.parse import unquote

import pytest

from docs.site.__main__ import led_by_playground, linked_back
from tests.helpers import ROOT

if TYPE_CHECKING:
    from pathlib import Path

for extra in ("zensical", "mkdocstrings", "latex2mathml", "piplicenses"):
    pytest.importorskip(extra, reason='the group "site" is not installed')

# Elements that make a browser load what their attribute names.
LOADS = {"img": "src", "script": "src", "link": "href", "source": "srcset", "iframe": "src"}


class Page(HTMLParser):
    """What a page links to, what it loads, and its anchors."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.ids: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if "id" in given:
            self.ids.add(given["id"])
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if LOADS.get(tag, "") in given and given.get("rel") not in ("canonical", "next", "prev"):
            self.loads.append(given[LOADS[tag]])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "site"
    built = subprocess.run(
        [sys.executable, "-m", "docs.site", str(folder)],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    return folder


@pytest.fixture(scope="module")
def read(site: Path) -> dict[Path, Page]:
    return {
        file: Page(file.read_text(encoding="utf-8"))
        for file in site.rglob("*.html")
        if "playground" not in file.relative_to(site).parts
    }


def faults(site: Path, read: dict[Path, Page]) -> list[str]:
    """Links within the site that lead nowhere."""
    found = []
    for file, page in read.items():
        # A server shows this one at any address.
        for link in [] if file.name == "404.html" else page.links + page.loads:
            if "://" in link or link.startswith(("mailto:", "data:")):
                continue
            name, _, anchor = unquote(link).partition("#")
            target = (file.parent / name).resolve() if name else file
            if target.is_dir():
                target /= "index.html"
            if not target.is_relative_to(site.resolve()) or not target.exists():
                found.append(f"{file.name}: {link}: no such file")
            elif anchor and target in read and anchor not in read[target].ids:
                found.append(f"{file.name}: {link}: no such anchor")
    return found


def test_links_of_the_site_lead_to_pages_and_anchors(site: Path, read: dict[Path, Page]) -> None:
    assert len(read) > 30
    assert sum(len(page.links) for page in read.values()) > 1000
    assert not faults(site.resolve(), {file.resolve(): page for file, page in read.items()})


def test_link_of_the_site_that_leads_nowhere_is_found(tmp_path: Path) -> None:
    page = Page('<h1 id="a"><a href="#a"></a><a href="#b"></a><a href="c.html"></a></h1>')
    (tmp_path / "index.html").touch()
    found = faults(tmp_path, {tmp_path / "index.html": page})
    assert found == ["index.html: #b: no such anchor", "index.html: c.html: no such file"]


def test_pages_load_nothing_from_elsewhere(read: dict[Path, Page]) -> None:
    outside = {each for page in read.values() for each in page.loads if "//" in each}
    assert not outside


def test_api_pages_show_docstrings_of_the_compiled_module(site: Path) -> None:
    module = (site / "api" / "popsteer.html").read_text(encoding="utf-8")
    assert 'href="popsteer.Vehicle.html"' in module
    assert "popsteer.PreviewPop.step" not in module  # each class has a page
    page = (site / "api" / "popsteer.PreviewPop.html").read_text(encoding="utf-8")
    for part in ("popsteer.PreviewPop.step", "Returns"):
        assert part in page
    assert "the vehicle's point" in page.replace("&#39;", "'")
    page = (site / "api" / "popsteer.State.html").read_text(encoding="utf-8")
    assert "&gt;&gt;&gt; " in page.replace('<span class="gp">&gt;&gt;&gt; </span>', "&gt;&gt;&gt; ")


def test_licences_of_crates_and_packages_are_listed(site: Path) -> None:
    page = (site / "licences.html").read_text(encoding="utf-8")
    for name in ("nalgebra", "criterion", "numpy", "zensical"):
        assert name in page


def test_search_leads_to_the_guide_and_the_playground_back(site: Path) -> None:
    items = json.loads((site / "search.json").read_text(encoding="utf-8"))["items"]
    titled = [each["location"] for each in items if "dead" in each["title"].lower()]
    assert "edges.html#dead-time" in titled
    # Attributes are found in the text of their class.
    assert not [each for each in titled if "Margins.dead_time" in each]
    (margins,) = (each for each in items if each["location"].endswith("stability.Margins"))
    assert "dead_time" in margins["text"]
    source = (ROOT / "docs/playground/index.html").read_text(encoding="utf-8")
    linked = Page(linked_back(source))
    assert [each for each in linked.links if each] == ["../index.html"]


def test_first_screen_says_how_to_install(site: Path) -> None:
    page = (site / "index.html").read_text(encoding="utf-8").partition("<article")[2]
    assert "pip install" in page.partition("<img")[0]


def test_first_page_leads_to_the_playground_before_all_else() -> None:
    page = led_by_playground("# popsteer\n\nIt drives.\n")
    assert page.startswith("# popsteer\n\n<a ")
    assert Page(page).links == ["playground/index.html"]
    assert page.endswith("It drives.\n")


def test_figures_follow_the_switch_of_the_page_and_open_at_full_size(site: Path) -> None:
    page = (site / "theory.html").read_text(encoding="utf-8")
    assert page.count('data-md-color-scheme="') >= 2  # the page's, and the switch's
    assert "Dark pages" in page
    assert "<picture" not in page
    for kind, dark in (("light", ""), ("dark", "-dark")):
        file = f"figures/stability-margins{dark}.png"
        assert re.search(f'<a class="figure {kind}" href="{file}"[^>]*><img src="{file}"', page)
    style = (site / "site.css").read_text(encoding="utf-8")
    assert '[data-md-color-scheme="slate"] .figure.light' in style


def test_mathematics_is_in_the_page_itself(site: Path) -> None:
    page = (site / "theory.html").read_text(encoding="utf-8")
    assert page.count("<math") > 50
    assert page.count("<mtext>nbd</mtext>") == 5  # one word, not a product of three
    assert "$" not in page.partition("<article")[2].partition("</article")[0]
