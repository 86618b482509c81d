"""One vocabulary: an option has one spelling, one metavar and one meaning in all commands."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import typer

from popsteer.cli.app import app

# What each command can take; the rest of its options are its own.
RUNS = {"--controllers", "--preset", "--params", "--set", "--no-adapt", "--dt", "--out"}
PEDALS = {"--longitudinal", "--set-longitudinal"}
START = {"--start", "--start-at", "--start-offset", "--speed", "--constant-speed"}
GIVEN = {"--vehicle", "--set-vehicle"}
ONE = {"--waypoints", "--closed", "--track", "--plant", "--set-plant"}
MANY = {"--waypoints", "--closed", "--tracks", "--plants"}
DRAWN = {"--controller", "--vary", "--distributions", "--seed"}
LOG = {"--column", "--topic", "--unit"}
WIRE = {"--topic", "--path-type", "--command-type", "--autoware"}
WIRE |= {"--domain", "--localhost", "--timeout"}
WANTED = {
    "compare": RUNS
    | START
    | PEDALS
    | GIVEN
    | ONE
    | {"--set-run", "--replay-run", "--step-time", "--record", "--report"},
    # Many tracks have no start in common, many plants no parameters.
    "matrix": RUNS | START - {"--start", "--start-at"} | GIVEN | MANY | {"--report"},
    # Nothing is driven.
    "stability": RUNS | GIVEN | {"--plant", "--set-plant", "--speeds"},
    "new": set(),
    "plan": GIVEN
    | {"--closed", "--set", "--out", "--smooth", "--keep-speeds", "--speed-limit"}
    | {"--driving", "--braking"},
    "identify": GIVEN | LOG | {"--out", "--report"},
    "replay": GIVEN
    | LOG
    | {"--controllers", "--params", "--preset", "--set", "--no-adapt"}
    | {"--waypoints", "--closed", "--track", "--out", "--report"},
    # Where it starts, and how, is drawn.
    "sweep": RUNS - {"--controllers"}
    | DRAWN
    | START - {"--start", "--start-at"}
    | PEDALS
    | GIVEN
    | ONE
    | {"--runs", "--deviation", "--workers", "--dask", "--report"},
    "tune": RUNS - {"--controllers"}
    | DRAWN
    | PEDALS
    | GIVEN
    | ONE - {"--track"}
    | {"--tracks", "--constant-speed", "--cars", "--search", "--trials", "--seconds"}
    | {"--effort-limit", "--storage"},
    "ros2": GIVEN
    | WIRE
    | {"--controller", "--preset", "--params", "--set", "--no-adapt", "--closed", "--record"}
    | {"--max-speed", "--rate", "--stale", "--hold", "--keep-path", "--sim-time"}
    | {"--ros-args", "--params-file"},
    "record": WIRE | {"--seconds"},
    "bench": {"--out", "--yardsticks"},
    "tracks": {"--tracks", "--out"},
}
# Where the metavar of an option has to differ, as what can be named does.
SEVERAL = {"--out": {"DIR", "FILE"}}


def _commands() -> dict[str, dict[str, Any]]:
    """The options of each command by their longest spelling."""
    group: Any = typer.main.get_command(app)
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
            assert len(option.opts) == 1, option.opts
            metavars[name].add(str(option.metavar))
    assert {name: found for name, found in metavars.items() if len(found) > 1} == SEVERAL


def test_option_of_several_is_the_plural_of_that_of_one() -> None:
    names = {name for options in _commands().values() for name in options}
    assert {"--controller", "--plant", "--track"} <= names
    for one in ("--controller", "--plant", "--track"):
        assert f"{one}s" in names
        assert not any({one, f"{one}s"} <= set(options) for options in _commands().values())


def test_every_option_is_explained_in_sentences() -> None:
    for command, options in _commands().items():
        for name, option in options.items():
            assert option.help, (command, name)
            assert option.help.endswith("."), (command, name)
            assert option.help[0].isupper(), (command, name)
