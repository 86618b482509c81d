"""What tests of several folders share."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def authors_data() -> Path:
    """The folder with the run that the paper's authors recorded; the test skips without it."""
    folder = ROOT.parent / "shared" / "data" / "carla_racetrack"
    if not folder.is_dir():
        pytest.skip(f"the authors' recorded run is not at hand in {folder}")
    return folder
