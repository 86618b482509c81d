"""How hard hypothesis tries (HYPOTHESIS_PROFILE=thorough), and what all tests need."""

from __future__ import annotations

import os
import signal
import sys
from typing import IO, TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

from tests.browser import Browser

if TYPE_CHECKING:
    from collections.abc import Iterator

# Hypothesis mixes the constants of all modules from outside of site-packages into what it draws: a
# popsteer on PYTHONPATH, and whichever of benches/ other tests have imported, would change the
# examples. No setting turns it off. `_local_constants` is empty as long as this is not called.
providers._get_local_constants = lambda: providers._local_constants

# No deadline anywhere: a slow machine is no fault of the code.
# `default` draws the same examples each time, on every machine: a run that fails has failed for
# the change at hand, and can be repeated from the log alone. New examples are `thorough`'s work;
# `smoke` takes a tenth of them.
settings.register_profile(
    "default",
    max_examples=100,
    deadline=None,
    derandomize=True,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("smoke", settings.get_profile("default"), max_examples=10)
settings.register_profile(
    "thorough",
    max_examples=10_000,
    deadline=None,
    derandomize=False,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
# A shell starts background jobs with SIGINT ignored, and what they start inherits that; the tests
# that interrupt a process of their own need it heard.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The workers fill the cores: threads of each for the small matrices of an identification wait for
# each other, and it takes twice the processor's time. numpy looks at this when it is imported.
if "numpy" not in sys.modules:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests of a worker: it takes longer to start than to open a page."""
    with Browser(tmp_path_factory.mktemp("profile")) as found:
        yield found


@pytest.fixture
def _blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures that are made and not drawn, which takes seconds: here only their files count."""

    from matplotlib.figure import Figure

    def save(self: Figure, stream: IO[bytes], **_: object) -> None:
        stream.write(b"blank")

    monkeypatch.setattr(Figure, "draw_without_rendering", lambda self: None)
    monkeypatch.setattr(Figure, "savefig", save)
