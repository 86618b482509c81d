"""Ctrl-C in the long commands: a bar until then, at most one line after, no half-written file."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer.lab.sweep import rows, runs
from popsteer.lab.sweep.job import Job
from popsteer.lab.tune import study
from tests.cli import command
from tests.helpers import PATIENCE, looped

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytest.importorskip("optuna")
pytest.importorskip("scipy")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a terminal and signals")

KEPT = "popsteer: stopped; the same command goes on with what is in "
SWEEP = ("sweep", "--track", "racetrack", "--out", "sweep.csv")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two hours of S-bends, without a simulation: nobody looks at what comes out."""
    t = 0.05 * np.arange(144_000)
    yaw = 0.5 * np.sin(0.2 * t)
    speed = 8.0 + 2.0 * np.sin(0.05 * t)
    columns: dict[str, Any] = {
        "t": t,
        "x": np.cumsum(0.05 * speed * np.cos(yaw)),
        "y": np.cumsum(0.05 * speed * np.sin(yaw)),
        "yaw": yaw,
        "speed": speed,
        "steer": np.arctan(2.7 * 0.1 * np.cos(0.2 * t) / speed),
    }
    return command.write_csv(tmp_path_factory.mktemp("log") / "drive.csv", columns)


@pytest.fixture(scope="module")
def waypoints(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """30 km of bends."""
    x = np.arange(30_000.0)
    file = tmp_path_factory.mktemp("course") / "waypoints.csv"
    np.savetxt(file, np.column_stack((x, 20.0 * np.sin(x / 40.0))), delimiter=",", fmt="%.4f")
    return file


# Begun as the installed script is, with a bar from the beginning: a machine may be so fast that
# the command is over before the second after which it comes otherwise.
CODE = """
import sys
sys.argv[0] = "/usr/bin/popsteer"
from popsteer.cli import main, outputs
outputs._PATIENCE = 0.0
main()
"""
AT_ONCE = (sys.executable, "-c", CODE)


def _interrupted(
    folder: Path, arguments: tuple[str, ...], shown: str, begin: tuple[str, ...] = AT_ONCE
) -> str:
    """Interrupt a command once its bar shows `shown`; what it says after that on either stream."""
    reading, writing = os.openpty()
    environment = {**os.environ, "COLUMNS": "80", "LINES": "40", "TERM": "xterm"}
    process = subprocess.Popen(
        [*begin, *arguments],
        stdout=writing,
        stderr=writing,
        cwd=folder,
        env=environment,
        start_new_session=True,
    )
    os.close(writing)
    sent, interrupted = b"", None
    try:
        # A machine with much else to do may show the bar late; the command ends by itself.
        while select.select([reading], [], [], None if interrupted is None else PATIENCE)[0]:
            try:
                part = os.read(reading, 65536)
            except OSError:  # Linux says so where the other end is closed
                break
            if not part:
                break
            sent += part
            if interrupted is None and re.search(shown.encode(), sent):
                interrupted = len(sent)
                # To all of its processes, as a terminal does.
                os.killpg(process.pid, signal.SIGINT)
        assert process.wait(PATIENCE) == 130, sent
    finally:
        os.close(reading)
        process.kill()
    assert interrupted is not None
    plain = re.sub(rb"\x1b\[[0-9;?]*[A-Za-z]", b"", sent[interrupted:]).decode()
    lines = [line.strip() for line in re.split(r"[\r\n]+", plain)]
    return "\n".join(line for line in lines if line and "\u2501" not in line)


def test_identify_interrupted_says_and_writes_nothing(tmp_path: Path, log: Path) -> None:
    said = _interrupted(tmp_path, ("identify", str(log), "--out", "car.toml"), "identify")
    assert said == ""
    assert not any(tmp_path.iterdir())


def test_installed_command_interrupted_while_it_drives_says_and_writes_nothing(
    tmp_path: Path,
) -> None:
    endless = ("compare", "--dt", "1e-6", "--out", "out")  # for hours
    assert _interrupted(tmp_path, endless, "start|pop", begin=(command.script(),)) == ""
    assert not any(tmp_path.iterdir())


def test_plan_interrupted_says_and_writes_nothing(tmp_path: Path, waypoints: Path) -> None:
    arguments = ("plan", str(waypoints), "--set", "max_jerk=1", "--out", "course.csv")
    assert _interrupted(tmp_path, arguments, "plan|figures") == ""
    assert not any(tmp_path.iterdir())


def test_replay_interrupted_says_and_writes_nothing(tmp_path: Path, log: Path) -> None:
    said = _interrupted(tmp_path, ("replay", str(log), "--out", "replay"), "stanley|pop|figures")
    assert said == ""
    assert not any(tmp_path.iterdir())


def test_tune_interrupted_keeps_its_trials(tmp_path: Path) -> None:
    # The default's trials are over in seconds.
    study = ("tune", "--controller", "pop", "--cars", "1", "--trials", "1000")
    arguments = (*study, "--out", "tuned.toml")
    assert _interrupted(tmp_path, arguments, r"trial \d+") == f"{KEPT}tuned.journal"
    assert {file.name for file in tmp_path.iterdir()} == {"tuned.journal"}


def test_interrupted_tune_lets_go_of_its_journal_and_of_no_one_elses(tmp_path: Path) -> None:
    # Where Ctrl-C comes between the lock and what is written under it, and while it waits for one.
    code = """
import signal, sys
from pathlib import Path
from popsteer.lab.tune import study

lock = study._Lock(Path(sys.argv[1]))
signal.signal(signal.SIGALRM, signal.default_int_handler)
if sys.argv[2] == "waits":
    import filelock
    # Again and again: one may come just before it waits.
    signal.setitimer(signal.ITIMER_REAL, 0.1, 0.1)
lock.acquire()
print("held", flush=True)
signal.raise_signal(signal.SIGALRM)
print("went on", flush=True)
"""
    ends = [sys.executable, "-c", code, str(tmp_path / "study.journal")]
    held = study._Lock(tmp_path / "study.journal")
    held.acquire()
    waiting = subprocess.run([*ends, "waits"], capture_output=True, check=False)
    assert b"KeyboardInterrupt" in waiting.stderr
    assert waiting.stdout == b""
    held.release()
    for _ in range(2):
        done = subprocess.run([*ends, "holds"], capture_output=True, check=False)
        assert done.stdout == b"held\n"
    assert [file.name for file in tmp_path.iterdir()] == ["study.journal"]


@pytest.mark.parametrize(
    "who",
    [(), ("--plant", "commonroad-st-2", "--workers", "2"), ("--dask",)],
    ids=["threads", "processes", "dask"],
)
def test_sweep_interrupted_keeps_its_rows(tmp_path: Path, who: tuple[str, ...]) -> None:
    if "--plant" in who:
        pytest.importorskip("vehiclemodels")
    arguments = (*SWEEP, "--runs", "30000", "--workers", "2") if not who else (*SWEEP, *who)
    with ExitStack() as stack:
        if "--dask" in who:
            distributed = pytest.importorskip("distributed")
            made = distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=":0")
            arguments = (*arguments, stack.enter_context(made).scheduler_address)
        said = _interrupted(tmp_path, arguments, "[0-9]+ of [0-9]+ runs")
    assert said == f"{KEPT}sweep.csv.part"
    assert {file.name for file in tmp_path.iterdir()} == {"sweep.csv.part"}
    _, kept = rows.read(tmp_path / "sweep.csv.part")
    assert len({row["run"] for row in kept}) == len(kept)


@looped(
    "module", ["numpy", "popsteer._core", "popsteer.status", "rich", "typer", "popsteer.cli.app"]
)
def test_interrupted_while_it_loads_says_nothing(module: str) -> None:
    # Ctrl-C comes as this module is looked for; the script is begun as the installed one is.
    code = f"""
import os, signal, sys

class Interrupts:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupts())
sys.argv = ["/usr/bin/popsteer", "tracks"]
from popsteer.cli import main
main()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")


def test_interrupt_that_a_library_makes_another_error_of_says_nothing() -> None:
    code = """
import os, signal, sys
sys.argv = ["/usr/bin/popsteer", "tracks"]
from popsteer.cli import entry

def run(given):
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        pass
    raise ValueError("Invalid affine transformation matrix")

entry._run = run
entry.main()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")
    code = code.replace("os.kill(os.getpid(), signal.SIGINT)", "pass")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert done.returncode == 1
    assert b"ValueError: Invalid affine" in done.stderr


ENDLESS = """
import atexit, os, signal, sys, time
sys.argv = ["/usr/bin/popsteer", "tracks"]
from popsteer import interrupt
from popsteer.cli import entry

interrupt._AGAIN = interrupt._LEAVING = 0.1

def run(given):
    os.kill(os.getpid(), signal.SIGINT)

def swallowed(often):
    for _ in range(often):
        try:
            run(())
            time.sleep(1000.0)
        except KeyboardInterrupt:
            pass
    time.sleep(1000.0)

{}
entry.main()
"""


@looped(
    "line",
    [
        # As an extension that clears the error of an import, and as a loop that goes on after any.
        "entry._run = lambda given: swallowed(1)",
        "entry._run = lambda given: swallowed(1000)",
        # What is registered for the end waits, as multiprocessing does for its processes.
        "entry._run = run; atexit.register(time.sleep, 1000.0)",
        """
from multiprocessing import get_context
deaf = lambda: (signal.signal(signal.SIGTERM, signal.SIG_IGN), time.sleep(1000.0))
get_context("fork").Process(target=deaf).start()
entry._run = run
""",
    ],
)
def test_interrupted_command_ends_whatever_goes_on(line: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ENDLESS.format(line)],
        capture_output=True,
        check=False,
        timeout=PATIENCE,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")


def test_interrupt_comes_after_processes_have_started_and_is_not_lost() -> None:
    # Another thread is there to take the signal.
    code = """
import os, signal, threading, time
from popsteer.lab.sweep.runs import _interrupts_held

threading.Thread(target=time.sleep, args=(1000.0,), daemon=True).start()
seen, tells = os.pipe()
os.set_blocking(tells, False)
signal.set_wakeup_fd(tells)
try:
    with _interrupts_held():
        os.kill(os.getpid(), signal.SIGINT)
        os.read(seen, 1)
        print("started")
    print("lost")
except KeyboardInterrupt:
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    print("came")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (done.stdout.split(), done.stderr) == ([b"started", b"came"], b"")


def test_interrupt_of_what_keeps_the_rows_ends_the_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    ended = []

    def drives(*_: Any) -> Iterator[list[dict[str, Any]]]:
        try:
            yield [{"run": 0}]
        finally:
            ended.append("drives")

    def keep(_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(runs, "on_core", drives)
    path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    job = Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", {}, runs=3)
    with pytest.raises(KeyboardInterrupt) as held:
        runs._driven(job, {}, None, None, None, keep)
    assert held.tb is not None  # which holds the drives
    assert ended == ["drives"]


def test_library_leaves_the_interrupt_to_its_program() -> None:
    code = (
        "import signal, popsteer;"
        "assert signal.getsignal(signal.SIGINT) is signal.default_int_handler"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
