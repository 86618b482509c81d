from __future__ import annotations

from typing import IO

import numpy as np
import pytest
from matplotlib.figure import Figure


@pytest.fixture
def _coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures of stability with few points: they take seconds, and here only their files count."""
    from popsteer.lab.stability import figures

    monkeypatch.setattr(figures, "_SPEEDS", np.linspace(1.0, 30.0, 4))
    monkeypatch.setattr(figures, "_DISTANCES", np.geomspace(1.0, 25.0, 4))


@pytest.fixture
def _blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures that are made and not drawn, which takes seconds: here only their files count."""

    def save(self: Figure, stream: IO[bytes], **_: object) -> None:
        stream.write(b"blank")

    monkeypatch.setattr(Figure, "draw_without_rendering", lambda self: None)
    monkeypatch.setattr(Figure, "savefig", save)
