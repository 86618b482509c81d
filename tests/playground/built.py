"""The built page, what is in it, and a browser to open it in."""

from __future__ import annotations

import base64
import contextlib
import gzip
import re
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING, NamedTuple

import pytest

from tests.helpers import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from playwright.sync_api import Browser

BUILD = ROOT / "docs" / "playground" / "build.py"
ENGINE = ROOT / "docs" / "playground" / "engine.js"


class Built(NamedTuple):
    page: Path
    module: Path
    """The module as it is in the page."""


def program(name: str) -> str:
    """A program by name; the test skips without it."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def build(folder: Path) -> Built:
    """The page, built; the test skips where that is not possible."""
    program("cargo")
    done = subprocess.run(
        [sys.executable, str(BUILD), str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    if "is not installed: rustup target add" in done.stderr:
        pytest.skip(done.stderr.strip())
    assert done.returncode == 0, done.stderr
    page = folder / "index.html"
    held = re.search(r'id="module">([^<]+)<', page.read_text(encoding="utf-8"))
    assert held
    module = folder / "popsteer.wasm"
    module.write_bytes(gzip.decompress(base64.b64decode(held[1])))
    return Built(page, module)


@contextlib.contextmanager
def chromium() -> Iterator[Browser]:
    """A browser without a window; the test skips where there is none."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = shutil.which("chromium") or program("chromium-browser")
    with playwright.sync_playwright() as driver:
        # The page is the project's own; without a sandbox it opens for root too, as in containers.
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()
