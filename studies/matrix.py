"""Puts what `make matrix` measured into README.md and its figure into docs/figures.

    python -m studies.matrix out/matrix

The folder holds what `popsteer matrix --out` wrote. Its table goes between README's
`<!-- matrix: begin ... -->` and `<!-- matrix: end -->`.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from studies.layout import ROOT, write_blocks

FIGURES = ("matrix.png", "matrix-dark.png")


def update(folder: Path, root: Path) -> None:
    """Rewrite the block and the figures of a checkout."""
    table = (folder / "matrix.md").read_text(encoding="utf-8")
    write_blocks(root / "README.md", {"matrix": table.rstrip("\n")})
    for name in FIGURES:
        shutil.copyfile(folder / name, root / "docs" / "figures" / name)


if __name__ == "__main__":
    update(Path(sys.argv[1]), ROOT)
    print("wrote README.md and docs/figures/matrix*.png")
