"""What tests of several folders share."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from hypothesis import settings

from studies.layout import AUTHORS

ROOT = Path(__file__).resolve().parents[1]


def authors_data() -> Path:
    """The folder with the run that the paper's authors recorded; the test skips without it."""
    if not AUTHORS.is_dir():
        pytest.skip(f"the authors' recorded run is not at hand in {AUTHORS}")
    return AUTHORS


def named(field: str) -> str:
    """What to look for in a TypeError about `field`: Python 3.10 takes no notes with a name."""
    return field if sys.version_info >= (3, 11) else "."


def long_drives() -> settings:
    """How often to draw a property that drives for hundreds of steps in the reference.

    Fewer times than the others, since each drive has as many steps as they have examples; a
    thorough run draws all.
    """
    asked = settings().max_examples
    return settings(max_examples=40 if asked == 100 else asked)
