"""Build the playground: the module for browsers, and one page that holds all it needs.

python docs/playground/build.py [FOLDER]   # out/playground by default

Needs the target wasm32-unknown-unknown, and popsteer for its tracks.
"""

from __future__ import annotations

import base64
import gzip
import json
import os
import re
import subprocess
import sys
from pathlib import Path

from popsteer import tracks
from popsteer.files import write_text_atomic

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = "wasm32-unknown-unknown"
LARGEST = 400_000
"""The page is no larger [bytes]."""


def missing() -> str:
    """Say what keeps this machine from building the module, in one line; empty if nothing does."""
    found = subprocess.run(
        ["rustc", "--print", "target-libdir", "--target", TARGET],
        capture_output=True,
        text=True,
        check=False,
    )
    if found.returncode == 0 and Path(found.stdout.strip()).is_dir():
        return ""
    return f"the Rust target {TARGET} is not installed: rustup target add {TARGET}"


def build_module() -> bytes:
    """Compile the module."""
    command = ["cargo", "build", "--locked", "--package", "popsteer-wasm", "--lib"]
    command += ["--profile", "wasm", "--target", TARGET]
    command += ["--message-format", "json-render-diagnostics"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True)
    messages = map(json.loads, done.stdout.splitlines())
    files = [file for message in messages for file in message.get("filenames", ())]
    return Path(next(file for file in files if file.endswith(".wasm"))).read_bytes()


def embedded_tracks() -> bytes:
    """Give the embedded tracks as JSON: waypoints x, y, x, y, ... [m]."""
    found = {
        track.name: {"title": track.title, "closed": track.closed, "xy": track.xy.ravel().tolist()}
        for track in map(tracks.get, tracks.names())
    }
    return json.dumps(found, separators=(",", ":")).encode()


def packed(name: str, content: bytes) -> str:
    """Give an element that holds bytes."""
    digits = base64.b64encode(gzip.compress(content, mtime=0)).decode()
    return f'<script type="application/gzip" id="{name}">{digits}</script>'


def page(module: bytes) -> str:
    """Put the whole page together."""

    def inlined(found: re.Match[str]) -> str:
        tag = "style" if found[1].endswith(".css") else "script"
        return f"<{tag}>\n{(HERE / found[1]).read_text(encoding='utf-8')}</{tag}>"

    text = (HERE / "index.html").read_text(encoding="utf-8")
    text = re.sub(r'role="alert">[^<]+</p>', 'role="alert" hidden></p>', text)
    text = re.sub(r'<link rel="stylesheet" href="([\w.]+)">', inlined, text)
    data = f"{packed('module', module)}\n{packed('tracks', embedded_tracks())}\n"
    text = text.replace('<script src="engine.js">', f'{data}<script src="engine.js">')
    return re.sub(r'<script src="([\w.]+)"></script>', inlined, text)


def main() -> None:
    """Build it."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/playground")
    if fault := missing():
        sys.exit(fault)
    module = build_module()
    file = folder / "index.html"
    write_text_atomic(file, page(module))
    size = file.stat().st_size
    print(f"{os.fspath(file)}: {size:,} bytes, of a module of {len(module):,} and the tracks")
    if size > LARGEST:
        sys.exit(f"the page is larger than {LARGEST:,} bytes")


if __name__ == "__main__":
    main()
