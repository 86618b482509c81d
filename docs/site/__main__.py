"""Builds the site into a folder, from nothing but the checkout and the installed packages.

    python -m docs.site out/site

The pages are Markdown as a forge reads it; `forge.py` prepares it for Zensical. The pages of the
API are made of the docstrings. A playground that was built (`out/playground`) is taken along.
"""

from __future__ import annotations

import argparse
import itertools
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from docs.site import forge, licences, pages

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PLAYGROUND = ROOT / "out" / "playground"
_OBJECTS = 2  # level of the headings of classes and functions; members are below


def _chapters(folder: Path, places: dict[str, str]) -> list[Any]:
    """Write each page where it is to be, and give the navigation."""
    navigation: list[Any] = []
    shown = [source for source in places if source.endswith(".md")]
    texts = {source: (ROOT / source).read_text(encoding="utf-8") for source in shown}
    titles = {
        places[source]: text.partition("\n")[0].removeprefix("# ").strip()
        for source, text in texts.items()
    }
    for title, sources in pages.CHAPTERS.items():
        for source in sources:
            staged = forge.staged(texts[source], source, places.get, titles)
            (folder / places[source]).write_text(staged, encoding="utf-8")
        entries = [{titles[places[source]]: places[source]} for source in sources]
        navigation.append({title: entries if len(entries) > 1 else places[sources[0]]})
    return navigation


def _api(folder: Path) -> list[Any]:
    (folder / "api").mkdir()
    navigation: list[Any] = []
    for module in pages.MODULES:
        written = pages.api_pages(module)
        for name, text in written.items():
            (folder / "api" / f"{name}.md").write_text(text, encoding="utf-8")
        # The module's own page is that of its heading.
        entries: list[Any] = [f"api/{module}.md"]
        entries += [{name.rpartition(".")[2]: f"api/{name}.md"} for name in list(written)[1:]]
        navigation.append({module: entries if len(entries) > 1 else entries[0]})
    return navigation


def stage(folder: Path) -> None:
    """Write the pages and the configuration into a folder; the site is built beside them."""
    content = folder / "pages"
    content.mkdir(parents=True)
    sources = itertools.chain(*pages.CHAPTERS.values())
    places = pages.ELSEWHERE | {source: pages.name_of(source) for source in sources}
    (content / "figures").mkdir()
    for figure in (*ROOT.glob("docs/figures/*"), *ROOT.glob("benches/figures/*")):
        places[figure.relative_to(ROOT).as_posix()] = f"figures/{figure.name}"
        shutil.copy(figure, content / "figures")
    shutil.copy(HERE / "site.css", content)

    navigation = _chapters(content, places)
    if PLAYGROUND.is_dir():
        navigation.insert(1, {"Playground": "playground/index.html"})
        first = content / "index.md"
        first.write_text(led_by_playground(first.read_text(encoding="utf-8")), encoding="utf-8")
    development = navigation.pop()
    chapters = [*navigation, {"API": _api(content)}, development]
    configuration = (HERE / "mkdocs.yml").read_text(encoding="utf-8").replace("$ROOT", str(ROOT))
    nav = f"nav: {json.dumps(chapters)}\n"  # what is JSON is YAML
    (folder / "mkdocs.yml").write_text(configuration + nav, encoding="utf-8")


def fold_members(file: Path) -> None:
    """Let the search find members in their class, where they would come before the guide."""
    index = json.loads(file.read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = []
    for item in index["items"]:
        if item["location"].startswith("api/") and item["level"] > _OBJECTS:
            found[-1]["text"] += f"<p>{item['title']}</p>{item['text']}"
        else:
            found.append(item)
    file.write_text(json.dumps(index | {"items": found}), encoding="utf-8")


def led_by_playground(first: str) -> str:
    """Let the first page lead to the playground, below its title."""
    title, _, rest = first.partition("\n")
    play = '<a class="play" href="playground/index.html">Drive it in your browser</a>'
    return f"{title}\n\n{play}\n{rest}"


def linked_back(playground: str) -> str:
    """Let the page of the playground, which elsewhere stands alone, lead back to the site."""
    back = '<p><a href="../index.html">Documentation</a></p>'
    return playground.replace("</header>", f"{back}\n</header>", 1)


def main() -> None:
    """Stage the pages, build them, and put the site in its place as a whole."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("site", type=Path, help="folder of the site; replaced")
    site: Path = parser.parse_args().site.resolve()
    folder = site.with_name(f"{site.name}.part")
    shutil.rmtree(folder, ignore_errors=True)
    licences.main()
    stage(folder)
    command = (sys.executable, "-m", "zensical", "build", "--strict")
    built = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True)
    said = built.stdout + built.stderr
    if built.returncode != 0 or "No issues found" not in said:
        sys.exit(f"the site was not built:\n{said}")
    fold_members(folder / "site" / "search.json")
    if PLAYGROUND.is_dir():
        file = Path(shutil.copytree(PLAYGROUND, folder / "site" / "playground")) / "index.html"
        file.write_text(linked_back(file.read_text(encoding="utf-8")), encoding="utf-8")
    shutil.rmtree(site, ignore_errors=True)
    (folder / "site").rename(site)
    shutil.rmtree(folder)
    print(f"the site is in {site}: open index.html")
    print(f"its search needs a server: python -m http.server --directory {site}")


if __name__ == "__main__":
    main()
