"""Puts what `make matrix` measured into README.md, docs/choose.md and docs/figures.

    python -m studies.matrix out/matrix

The folder holds what `popsteer matrix --out` wrote. Its tables go into the blocks `matrix` of the
two pages: that of `TRACK` into README's, all of them into the other.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from studies.layout import ROOT, write_blocks

TRACK = "slalom"
FIGURES = ("matrix.png", "matrix-dark.png")


def update(folder: Path, root: Path) -> None:
    """Rewrite the block and the figures of a checkout."""
    tables = (folder / "matrix.md").read_text(encoding="utf-8").rstrip("\n")
    one = next(each for each in tables.split("\n\n") if each.startswith(f"| {TRACK} |"))
    write_blocks(root / "README.md", {"matrix": one})
    write_blocks(root / "docs" / "choose.md", {"matrix": tables})
    for name in FIGURES:
        shutil.copyfile(folder / name, root / "docs" / "figures" / name)


if __name__ == "__main__":
    update(Path(sys.argv[1]), ROOT)
    print("wrote README.md, docs/choose.md and docs/figures/matrix*.png")
