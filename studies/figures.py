"""Draws the figures of README and docs/ anew.

    python -m studies.figures          # those of commands of popsteer

    python -m studies.figures replay   # one of them

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
GUIDES = ("driver", "carla", "gymnasium", "c", "examples", "files")
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
    "own-controller": "popsteer compare --controllers pop,mine.py:BangBang --track slalom"
    " --constant-speed 6 --out .",
    "untold": "popsteer compare --controllers preview-pop,stanley,pure-pursuit,pop --track slalom"
    " --plant kinematic-bicycle --constant-speed 8 --set-plant dead_time=0.2"
    " --set-vehicle dead_time=0 --out .",
    "corner": "popsteer compare --controllers preview-pop,stanley,pure-pursuit,pop"
    " --waypoints corner.csv --plant kinematic-bicycle --constant-speed 5 --out .",
    "replay": "popsteer replay drive.mcap --vehicle car.toml --out .",
    "limits-map": "python -m studies.limits",
    "front": "python -m studies.front",
    **{name: f"python -m studies.guides {name}" for name in GUIDES},
    "suite": "make suite",
}
# The file of a command's that is another than the page's name of it.
_DRAWN_AS = dict.fromkeys(("own-controller", "untold", "corner"), "overview")
# What a command reads, and what makes it.
_READ = {
    "racetrack.csv": "popsteer tracks --tracks racetrack --out .",
    "drive.mcap": f"python {ROOT}/examples/recorded_drive.py . 120",
    "car.toml": "popsteer identify drive.mcap --out car.toml",
}


def _texts() -> dict[str, str]:
    """What a command reads that is written here: the code of a page, the waypoints of a corner."""
    page = (DOCS / "compare_your_controller.md").read_text(encoding="utf-8")
    ways = [*((x, 0) for x in range(41)), *((40, y) for y in range(1, 41))]
    return {
        "mine.py": page.partition("```python\n")[2].partition("```")[0],
        "corner.csv": "x,y\n" + "".join(f"{x},{y}\n" for x, y in ways),
    }


def _run(command: str, folder: Path) -> None:
    _, *words = shlex.split(command.replace("popsteer ", "python -m popsteer ", 1))
    subprocess.run([sys.executable, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def main(wanted: list[str]) -> None:
    """Run the commands and copy what the pages show."""
    drawn = {name: by for name, by in MADE_BY.items() if by.startswith("popsteer")}
    drawn = {name: by for name, by in drawn.items() if not wanted or name in wanted}
    for command in sorted(set(drawn.values())):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for file, text in _texts().items():
                (folder / file).write_text(text, encoding="utf-8")
            for file, made_by in _READ.items():
                if file in command:
                    _run(made_by, folder)
            _run(command, folder)
            for figure in (name for name, by in drawn.items() if by == command):
                for suffix in ("", "-dark"):
                    source = folder / f"{_DRAWN_AS.get(figure, figure)}{suffix}.png"
                    shutil.copy(source, FIGURES / f"{figure}{suffix}.png")
    print(f"drew {FIGURES}: {', '.join(drawn)}")


if __name__ == "__main__":
    main(sys.argv[1:])
