"""Tables on pages, and the tracks that several studies drive."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import popsteer
from popsteer import tracks
from popsteer.files import write_text_atomic

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.figure import Figure

    from popsteer.lab.common.theme import Theme
    from popsteer.sim import Pose

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
AUTHORS = ROOT.parent / "shared" / "data" / "carla_racetrack"
"""The run that the paper's authors recorded, beside the checkout."""
AUTHORS_START = (-183.8, 78.7, -1.574)
"""Where its front axle starts [m, m, rad]."""


def table(page: str, name: str) -> list[str]:
    """Rows of a table of a page, without its two lines of heads."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return text.partition(f"<!-- table: {name} -->\n")[2].partition("\n\n")[0].splitlines()[2:]


def write_figures(draw: Mapping[str, Callable[[Theme], Figure]]) -> None:
    """Draw figures of the pages, for both backgrounds."""
    from popsteer.lab.common.draw import files_of

    for name, content in files_of(draw).items():
        if name.endswith(".png"):
            (DOCS / "figures" / name).write_bytes(content)


def write_table(page: str, name: str, rows: Sequence[str]) -> None:
    """Put rows in the place of those of a table of a page, below a comment with its name."""
    file = DOCS / page
    before, mark, rest = file.read_text(encoding="utf-8").partition(f"<!-- table: {name} -->\n")
    if not mark:
        raise SystemExit(f"there is no table {name}")
    old, gap, after = rest.partition("\n\n")
    heads = old.splitlines()[:2]
    write_text_atomic(file, before + mark + "\n".join([*heads, *rows]) + gap + after)


def line(*cells: str) -> str:
    """Set out cells as a line of a table."""
    return f"| {' | '.join(cells)} |"


def cells(row: str) -> list[str]:
    """Give the cells of a line of a table, without what makes them bold."""
    return [cell.strip(" *") for cell in row.split("|")[1:-1]]


def replace_block(text: str, name: str, content: str) -> str:
    """Put new content between a block's marks, which stay; the text without such a block as is."""
    block = re.compile(
        rf"^(<!-- {re.escape(name)}: begin\b[^\n]*-->\n).*?^(<!-- {re.escape(name)}: end -->)$",
        re.MULTILINE | re.DOTALL,
    )
    if len(block.findall(text)) > 1:
        raise SystemExit(f"there is more than one block {name}")
    return block.sub(lambda found: f"{found[1]}{content}\n{found[2]}", text)


def write_blocks(file: Path, blocks: Mapping[str, str]) -> bool:
    """Put new content into the blocks of these names of a page; whether that changed it."""
    old = new = file.read_text(encoding="utf-8")
    for name, content in blocks.items():
        new = replace_block(new, name, content)
    if new != old:
        write_text_atomic(file, new)
    return new != old


def track(name: str) -> popsteer.Path:
    """Give a shipped track as a path."""
    shipped = tracks.get(name)
    return popsteer.Path(shipped.xy, speed=shipped.speed, closed=shipped.closed)


def course(name: str) -> tuple[popsteer.Path, Pose | None]:
    """Give a shipped track, or that of the paper's authors, and where a run starts on it."""
    if name == "authors":
        return popsteer.Path.from_csv(AUTHORS / "waypoints.csv", columns="x,y,speed"), (
            -183.797,
            79.760,
            -1.574,
        )
    return track(name), None
