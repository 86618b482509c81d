"""The reader of waypoint files, given any bytes: finite waypoints or an error that names the place.

As a program it hands `check` to atheris (`run.py csv_reader`); a test replays the corpus without.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from popsteer import PathError

_PLACE = re.compile(r", line \d+(, column \d+)?: ")
_TOO_FEW = re.compile(r": at least 2 waypoints are needed, found [01]$")


def check(data: bytes, file: Path) -> None:
    """Write the bytes to `file` and read them as waypoints."""
    from popsteer import PathError
    from popsteer.tables import read_waypoints

    file.write_bytes(data)
    try:
        found = read_waypoints(file)
    except PathError as error:
        _check_refusal(error, data, str(file))
        return
    xy, speed = found.xy, found.speed
    _check_waypoints(xy, speed)
    assert "\n" not in found.source()
    # Written out in full they are read as the same.
    columns = xy if speed is None else np.column_stack([xy, speed])
    file.write_text("\n".join(",".join(map(repr, row)) for row in columns.tolist()), "utf-8")
    again = read_waypoints(file, columns="x,y" if speed is None else "x,y,speed")
    again_speed = again.speed
    assert again.xy.tobytes() == xy.tobytes()
    assert (again_speed is None) == (speed is None)
    assert speed is None or again_speed is None or again_speed.tobytes() == speed.tobytes()


def _check_refusal(error: PathError, data: bytes, name: str) -> None:
    message = str(error)
    assert message.startswith(name), message
    rest = message.removeprefix(name)
    assert _PLACE.match(rest) or _TOO_FEW.match(rest), message
    assert "\n" not in message, message
    assert len(rest) < 600, message  # 40 characters of the entry, each escaped
    assert error.index is None or 0 <= error.index <= data.count(b"\n") + data.count(b"\r")


def _check_waypoints(xy: np.ndarray, speed: np.ndarray | None) -> None:
    assert xy.ndim == 2
    assert xy.shape[0] >= 2
    assert xy.shape[1] == 2
    for values in (xy,) if speed is None else (xy, speed):
        assert values.dtype == np.float64
        assert values.flags.c_contiguous
        assert values.shape[0] == xy.shape[0]
        assert np.isfinite(values).all()


def main() -> None:
    """Fuzz until told to stop."""
    import atheris

    # Before `check` imports it: only what is imported here reports what it reaches.
    with atheris.instrument_imports(include=["popsteer.tables"]):
        import popsteer.tables  # noqa: F401 - imported to be instrumented
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        file = Path(folder) / "waypoints.csv"
        # The command by which libFuzzer starts itself again when it minimises a corpus.
        again = shlex.join([sys.executable, __file__])
        atheris.Setup([again, *sys.argv[1:]], lambda data: check(data, file))
        atheris.Fuzz()


if __name__ == "__main__":
    main()
