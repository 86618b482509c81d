from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def _coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures of stability with few points: they take seconds, and here only their files count."""
    from popsteer.lab.stability import figures

    monkeypatch.setattr(figures, "_SPEEDS", np.linspace(1.0, 30.0, 4))
    monkeypatch.setattr(figures, "_DISTANCES", np.geomspace(1.0, 25.0, 4))
