"""The help of the commands, and the words that they use."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections import defaultdict
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from rich.progress import Progress as Bar
from rich.progress import TimeRemainingColumn

import popsteer
from popsteer import controllers, tracks
from popsteer.cli import params
from popsteer.cli.app import made
from popsteer.cli.outputs import Progress
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

_COMMANDS = (
    "compare",
    "suite",
    "params",
    "new",
    "plan",
    "stability",
    "identify",
    "replay",
    "tune",
    "sweep",
    "ros2",
    "record",
    "tracks",
)


def test_help_of_the_command_reads_as_a_page() -> None:
    outcome = command.run("--help")
    assert outcome.status == 0
    assert outcome.err == ""
    assert "\x1b" not in outcome.out
    for part in (
        "Examples:",
        "--report FILE",
        "status 2",
    ):
        assert part in outcome.out
    for name in _COMMANDS:
        assert f"\n  {name} " in outcome.out


def test_command_without_arguments_shows_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    bare = command.call(capsys)
    assert bare.status == 0
    assert bare.out.strip() == command.call(capsys, "--help").out.strip()


@looped("name", _COMMANDS)
def test_help_of_each_command_has_examples(capsys: pytest.CaptureFixture[str], name: str) -> None:
    outcome = command.call(capsys, name, "--help")
    assert outcome.status == 0
    assert "Examples:" in outcome.out
    assert f"  popsteer {name}" in outcome.out


@looped("name", ("", *_COMMANDS, "paper"))
def test_help_fits_a_screen(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    outcome = command.call(capsys, *([name] if name else []), "--help")
    assert outcome.out.count("\n") <= 50
    assert max(map(len, outcome.out.splitlines())) <= 80


def test_params_lists_each_parameter_with_a_number_for_its_default(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    overview = command.call(capsys, "params").out
    for name in params._kinds():
        said = command.call(capsys, "params", name).out
        assert name.partition("-st")[0].partition("-mb")[0] in overview
        rows = (line.split() for line in said.splitlines() if re.match(r"\w+ ", line))
        listed = {words[0]: words[1] for words in rows}
        for field in params._kinds()[name].params().as_dict():
            assert field == "vehicle" or re.fullmatch(
                r"[\d.e+-]+\*?|none|true|false", listed[field]
            )
        assert not re.search(r"unwrap_or|\bPI\b|\{|wheelbase \*|\* wheelbase", said)
        sets = "--set also takes those of adapt and monitor" in said
        assert sets == (name in controllers.names())
    pedals = command.call(capsys, "params", "commonroad-mb-2").out
    assert "Acceleration at full throttle [m/s^2].\n" in re.sub(r" +\n", "\n", pedals)
    assert "heading error squared" in command.call(capsys, "params", "mpc").out
    (tmp_path / "own.py").write_text("def plain(path, vehicle): ...\n")
    own = f"{tmp_path / 'own.py'}:plain"
    assert command.call(capsys, "params", own).out == f"{own} has no parameters\n"
    usual = command.call(capsys, "params", "pop").out
    assert re.search(r"^min_lookahead +6\* +0 to 10000 ", usual, re.MULTILINE)
    popsteer.Vehicle(wheelbase=0.33).save(tmp_path / "car.toml")
    small = command.call(capsys, "params", "pop", "--vehicle", str(tmp_path / "car.toml")).out
    assert re.search(r"^min_lookahead +0\.66\* ", small, re.MULTILINE)
    assert "car.toml of 0.33 m wheelbase" in small


def test_params_refuses_and_suggests_a_name(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = command.call(capsys, "params", "prevew-pop")
    assert (outcome.status, outcome.out) == (2, "")
    assert "unknown name of parameters 'prevew-pop', did you mean preview-pop?" in outcome.err


@looped("options", [("--version",), ("--version", "compare")])
def test_version_is_that_of_the_package(
    capsys: pytest.CaptureFixture[str], options: tuple[str, ...]
) -> None:
    outcome = command.call(capsys, *options)
    assert (outcome.status, outcome.out) == (0, f"popsteer {popsteer.__version__}\n")


@looped(
    ("line", "left_out"),
    [
        (["--version"], ("popsteer.lab", "popsteer.sim", "rich.table", "popsteer.cli.compare")),
        (["tracks"], ("popsteer.lab.sweep", "popsteer.cli.compare", "matplotlib")),
        (["compare", "--help"], ("popsteer.lab.sweep", "popsteer.cli.tune", "matplotlib")),
    ],
)
def test_command_loads_nothing_that_it_does_not_need(
    line: list[str], left_out: tuple[str, ...]
) -> None:
    code = f"""
import sys
from popsteer.cli import main
try:
    main({line!r})
except SystemExit as end:
    assert end.code == 0
loaded = [name for name in {left_out!r} if name in sys.modules]
assert not loaded, loaded
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_tracks_lists_them_all(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = command.call(capsys, "tracks")
    assert outcome.status == 0
    for name in tracks.names():
        assert name in outcome.out
        assert tracks.get(name).title in outcome.out


def test_tracks_that_are_named_are_listed_and_no_others(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = command.call(capsys, "tracks", "--tracks", "slalom,circle").out
    assert [line.split()[0] for line in found.splitlines() if line[:1].isalpha()] == [
        "slalom",
        "circle",
    ]
    slalom = tracks.get("slalom")
    assert f"{len(slalom.xy)} waypoints, {slalom.length:.0f} m, open" in found


def test_tracks_write_what_compare_reads(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "new"
    assert command.call(capsys, "tracks", "--tracks", "slalom", "--out", str(out)).status == 0
    file = out / "slalom.csv"
    path = popsteer.Path.from_csv(file)
    assert np.array_equal(np.column_stack((path.x, path.y)), tracks.get("slalom").xy)
    outcome = command.call(capsys, "compare", "--waypoints", str(file), "--controllers", "pop")
    shipped = command.call(capsys, "compare", "--track", "slalom", "--controllers", "pop")
    said, _, rest = outcome.out.partition("\n")
    assert said.startswith("Read slalom.csv: 308 waypoints of x (x [m]), y (y [m]), speed (speed")
    assert rest.replace("slalom.csv", "slalom") == shipped.out


def test_tracks_with_out_writes_each(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert command.call(capsys, "tracks", "--out", str(tmp_path / "all")).status == 0
    files = {file.name for file in (tmp_path / "all").iterdir()}
    assert files == {f"{name}.csv" for name in tracks.names()}


def test_progress_off_a_terminal_or_in_the_first_second_shows_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with Progress() as progress:
        progress.update("pop", 0.5)
    monkeypatch.setattr("popsteer.cli.outputs._PATIENCE", 0.0)
    with Progress() as progress:
        progress.update("pop", 0.5)
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "")


def test_progress_on_a_terminal_shows_what_is_done_and_goes_away(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("popsteer.cli.outputs._PATIENCE", 0.0)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    with Progress() as progress:
        progress.update("figures", 0.5)
        for thread in threading.enumerate():
            if isinstance(thread, threading.Timer):
                thread.join()  # which shows the bar
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "figures" in captured.err


def test_progress_tells_the_time_that_remains_of_each_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr("popsteer.cli.outputs.Bar", partial(Bar, get_time=lambda: now[0]))
    with Progress() as progress:
        assert any(isinstance(each, TimeRemainingColumn) for each in progress._bar.columns)
        for work, least in (("runs", 20.0), ("figures", 5.0)):
            for share in (0.0, 0.25, 0.5):
                progress.update(work, share)
                now[0] += least / 2.0
            # Half is done, in the time of two updates.
            assert progress._bar.tasks[0].time_remaining == least


def test_help_of_every_command_needs_nothing_that_windows_lacks() -> None:
    code = f"""
import sys
import threading
sys.modules.update(fcntl=None, resource=None, termios=None)
from popsteer.cli import main
for name in {_COMMANDS!r}:
    try:
        main([name, "--help"])
    except SystemExit as end:
        assert end.code == 0, name
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("Usage: popsteer ") == len(_COMMANDS)


def test_completion_completes_commands_and_is_offered() -> None:
    # Typer asks the process that called for its shell, which may be one without completion.
    named = {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    shown = command.run("--show-completion", "bash", environment=named)
    assert (shown.status, shown.err) == (0, "")
    assert "_POPSTEER_COMPLETE=complete_bash" in shown.out
    asked = {
        "_POPSTEER_COMPLETE": "complete_bash",
        "COMP_WORDS": "popsteer comp",
        "COMP_CWORD": "1",
    }
    assert command.run(environment=asked).out.split() == ["compare"]


# What each command can take; the rest of its options are its own.
RUNS = {"--controllers", "--preset", "--params", "--set", "--no-adapt", "--dt", "--out"}
PEDALS = {"--longitudinal", "--set-longitudinal"}
START = {"--start", "--start-at", "--start-offset", "--speed", "--constant-speed"}
GIVEN = {"--vehicle", "--set-vehicle"}
TABLE = {"--closed", "--columns", "--origin"}
ONE = {"--waypoints", "--track", "--plant", "--set-plant"} | TABLE
MANY = {"--waypoints", "--tracks", "--plants"} | TABLE
DRAWN = {"--controller", "--vary", "--distributions", "--seed"}
LOG = {"--columns", "--origin", "--topic", "--unit"}
WIRE = {"--topic", "--path-type", "--command-type", "--autoware"}
WIRE |= {"--domain", "--localhost", "--timeout"}
WANTED = {
    "compare": RUNS
    | START
    | PEDALS
    | GIVEN
    | MANY
    | {"--set-plant", "--set-run", "--step-time", "--record", "--report"},
    "paper": {"--preset", "--waypoints", "--columns", "--out", "--report"},
    "suite": RUNS - {"--preset", "--dt"} | {"--plants", "--scenarios", "--conditions"},
    "params": {"--vehicle"},
    # Nothing is driven.
    "stability": RUNS - {"--no-adapt"} | GIVEN | {"--plant", "--set-plant", "--speeds", "--report"},
    "new": set(),
    "plan": GIVEN
    | TABLE
    | {"--set", "--out", "--smooth", "--keep-speeds", "--speed-limit"}
    | {"--driving", "--braking", "--report"},
    "identify": GIVEN | LOG | {"--out", "--report", "--course", "--stops"},
    "replay": GIVEN
    | LOG
    | {"--controllers", "--params", "--preset", "--set", "--no-adapt"}
    | {"--waypoints", "--closed", "--path-columns", "--track", "--out", "--report"},
    # Where it starts, and how, is drawn.
    "sweep": RUNS - {"--controllers"}
    | DRAWN
    | START - {"--start", "--start-at"}
    | PEDALS
    | GIVEN
    | ONE
    | {"--run", "--runs", "--deviation", "--workers", "--dask", "--report"},
    "tune": RUNS - {"--controllers"}
    | DRAWN
    | PEDALS
    | GIVEN
    | ONE - {"--track"}
    | {"--tracks", "--constant-speed", "--cars", "--search", "--trials", "--seconds"}
    | {"--effort-limit", "--storage", "--report"},
    "ros2": GIVEN
    | WIRE
    | {"--controller", "--preset", "--params", "--set", "--no-adapt", "--closed", "--record"}
    | {"--max-speed", "--rate", "--stale", "--hold", "--keep-path", "--sim-time"}
    | {"--ros-args", "--params-file", "--log-level"},
    "record": WIRE | {"--seconds"},
    "tracks": {"--tracks", "--out"},
}
# Where the metavar of an option has to differ, as what can be named does.
SEVERAL = {"--out": {"DIR", "FILE"}}


def _commands() -> dict[str, dict[str, Any]]:
    """The options of each command by their longest spelling."""
    group: Any = typer.main.get_command(made())
    return {
        name: {
            max(parameter.opts, key=len): parameter
            for parameter in command.params
            if parameter.opts[0].startswith("--") and "--help" not in parameter.opts
        }
        for name, command in group.commands.items()
    }


def test_commands_have_the_options_that_they_can_take() -> None:
    found = {name: set(options) for name, options in _commands().items()}
    for name, wanted in WANTED.items():
        assert found[name] == wanted, name


def test_option_has_one_spelling_and_one_metavar_everywhere() -> None:
    metavars: dict[str, set[str]] = defaultdict(set)
    for options in _commands().values():
        for name, option in options.items():
            assert option.opts[1:] in ([], [option.opts[0].removesuffix("s")]), option.opts
            metavars[name].add(str(option.metavar))
    assert {name: found for name, found in metavars.items() if len(found) > 1} == SEVERAL


def test_option_of_several_is_the_plural_of_that_of_one() -> None:
    names = {name for options in _commands().values() for name in options}
    assert {"--controller", "--plant", "--track"} <= names
    for one in ("--controller", "--plant", "--track"):
        assert f"{one}s" in names
        assert not any({one, f"{one}s"} <= set(options) for options in _commands().values())


def test_every_option_is_explained_in_sentences() -> None:
    for called, options in _commands().items():
        for name, option in options.items():
            assert option.help, (called, name)
            assert option.help.endswith("."), (called, name)
            assert option.help[0].isupper(), (called, name)
