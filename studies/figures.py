"""Draws the figures of README and docs/ anew.

    python -m studies.figures          # those of commands of popsteer

The others are drawn by the commands that measure what they show; `MADE_BY` has all of them.
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from studies.layout import DOCS, ROOT

FIGURES = DOCS / "figures"
_STABILITY = "popsteer stability --out ."
# The command that draws each figure, light and dark, by the beginning of its name.
MADE_BY = {
    "results": "popsteer paper --out .",
    "carrot-offset": "python -m studies.carrot",
    "preview-choice": "python -m studies.carrot",
    "stability-map": _STABILITY,
    "stability-margins": _STABILITY,
    "stability-loops": _STABILITY,
    "plan": "popsteer plan racetrack.csv --closed --out plan.csv",
    "identify": "popsteer identify drive.mcap --out identify.toml",
    "tune": "popsteer tune --controller pop --tracks slalom --trials 40 --cars 3 --out tune.toml",
    "sweep": "popsteer sweep --controller pop --track slalom --runs 300"
    ' --vary "dead_time=uniform(0,0.4)" --vary "steer_lag=uniform(0.05,0.3)" --out sweep.csv',
    "versus": "python -m studies.versus",
    "matrix": "make matrix",
    "report": "python -m studies.report",
    "limits-map": "python -m studies.limits",
    "front": "python -m studies.front",
    "suite": "make suite",
}
# What a command reads, and what makes it.
_READ = {
    "racetrack.csv": "popsteer tracks export racetrack racetrack.csv",
    "drive.mcap": f"python {ROOT}/examples/recorded_drive.py . 120",
}


def _run(command: str, folder: Path) -> None:
    _, *words = shlex.split(command.replace("popsteer ", "python -m popsteer ", 1))
    subprocess.run([sys.executable, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def main() -> None:
    """Run the commands and copy what the pages show."""
    commands = {by for by in MADE_BY.values() if by.startswith("popsteer")}
    for command in sorted(commands):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for file, made_by in _READ.items():
                if file in command:
                    _run(made_by, folder)
            _run(command, folder)
            for figure, by in MADE_BY.items():
                for suffix in ("", "-dark") if by == command else ():
                    shutil.copy(folder / f"{figure}{suffix}.png", FIGURES)
    print(f"drew {FIGURES}: {', '.join(name for name, by in MADE_BY.items() if by in commands)}")


if __name__ == "__main__":
    main()
