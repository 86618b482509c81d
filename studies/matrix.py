"""Puts what `make matrix` measured into README.md and its figure into docs/figures.

    python -m studies.matrix out/matrix

The folder holds what `popsteer matrix --out` wrote. Its table goes between README's
`<!-- matrix: begin ... -->` and `<!-- matrix: end -->`.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from popsteer.files import write_text_atomic
from studies.layout import ROOT, replace_block

FIGURES = ("matrix.png", "matrix-dark.png")


def update(folder: Path, root: Path) -> None:
    """Rewrite the block and the figures of a checkout."""
    readme = root / "README.md"
    table = (folder / "matrix.md").read_text(encoding="utf-8")
    text = readme.read_text(encoding="utf-8")
    write_text_atomic(readme, replace_block(text, "matrix", table.rstrip("\n")))
    for name in FIGURES:
        shutil.copyfile(folder / name, root / "docs" / "figures" / name)


def main() -> None:
    """Take what one run wrote."""
    parser = argparse.ArgumentParser(description="Write one run's matrix into README.md.")
    parser.add_argument("folder", type=Path, help="what `popsteer matrix --out` wrote")
    update(parser.parse_args().folder, ROOT)
    print("wrote README.md and docs/figures/matrix*.png")


if __name__ == "__main__":
    main()
