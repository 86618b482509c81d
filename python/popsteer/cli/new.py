"""``popsteer new``: a project to begin from."""

from __future__ import annotations

import math
import os
import shlex
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from popsteer import files
from popsteer._core import Vehicle
from popsteer.errors import ConfigError, printable

HELP = """\
Write a project to begin from: a vehicle, a path, a control loop that follows it, and a test.

It runs at once, with a simulated car in the place of yours. DIR must not exist, or be empty; it
is written completely or not at all.

\b
Examples:
  popsteer new my-car
  cd my-car && python drive.py

\b
What is in DIR:
  vehicle.toml     describes the car; each field with its unit
  waypoints.csv    the path: x [m], y [m], speed [m/s]
  car.py           the connection to the car, here a simulated one
  drive.py         the control loop
  test_drive.py    a drive, a fault and a lost localisation
  README.md        what to change, and in which order
"""

# The car of car.py, except for what is never known exactly.
_VEHICLE = Vehicle(wheelbase=2.7, rear_axle=-1.35, steer_lag=0.15, dead_time=0.15).replace(
    max_steer=0.6, max_steer_rate=0.4, max_speed=10.0
)
_SUFFIX = ".template"


def new(
    *, folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder to write.")]
) -> None:
    """Write a project to begin from: own control loop, vehicle, path, test."""
    _check(folder)
    place = folder.absolute()
    files.check_folder(place.parent)  # whose error has its name, not that of a part
    place.parent.mkdir(parents=True, exist_ok=True)
    # Beside it, so that it takes its place in one step.
    with TemporaryDirectory(dir=place.parent, prefix=".popsteer-") as beside:
        part = Path(beside) / place.name  # with the permissions of the umask
        part.mkdir()
        _write(part)
        if folder.is_dir():
            folder.rmdir()  # empty, and Windows renames onto no folder
        part.rename(place)
    written = ", ".join(sorted(each.name for each in folder.iterdir()))
    print(f"Written to {printable(str(folder))}{os.sep}: {written}")
    print(f"Next: cd {printable(shlex.quote(str(folder)))} && python drive.py")


def _check(folder: Path) -> None:
    if folder.is_symlink() or (folder.exists() and (not folder.is_dir() or any(folder.iterdir()))):
        raise ConfigError("DIR", str(folder), "a new or an empty folder, not a file or a link")


def _write(folder: Path) -> None:
    for file in resources.files("popsteer.cli").joinpath("starter").iterdir():
        if file.name.endswith(_SUFFIX):
            text = file.read_text(encoding="utf-8").replace("{name}", folder.name)
            (folder / file.name.removesuffix(_SUFFIX)).write_text(text, encoding="utf-8")
    _VEHICLE.save(folder / "vehicle.toml")
    rows = ["# x [m], y [m], speed [m/s]"]
    for k in range(201):
        x = float(k)
        # Straight at both ends, with bends to both sides in between.
        y = 6.0 * (1.0 - math.cos(2.0 * math.pi * max(0.0, min(x - 20.0, 160.0)) / 80.0))
        rows.append(f"{x:g}, {y:.3f}, 8")
    (folder / "waypoints.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
