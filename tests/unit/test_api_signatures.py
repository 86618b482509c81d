"""Signatures show the real defaults, and the stub shows the same."""

from __future__ import annotations

import ast
import inspect
import pydoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import _core, reference, sim
from tests.unit.test_api_docs import CALLABLES

if TYPE_CHECKING:
    from collections.abc import Iterator

STUB = Path(inspect.getfile(_core)).with_name("_core.pyi").read_text(encoding="utf-8")


def _signature(thing: Any) -> inspect.Signature | None:
    try:
        return inspect.signature(thing)
    except ValueError:  # a class whose objects the library alone makes
        return None


SHOWN = {name: shown for name, thing in CALLABLES.items() if (shown := _signature(thing))}
# What can be made of nothing says by itself what its defaults come to.
VALUES = {
    name: thing
    for name, thing in CALLABLES.items()
    if inspect.isclass(thing)
    and SHOWN.get(name)
    and hasattr(thing, "as_dict")
    and all(each.default is not each.empty for each in SHOWN[name].parameters.values())
}


def test_enumeration_of_signatures_finds_the_essential_ones() -> None:
    assert len(SHOWN) > 150
    wanted = {"PopParams", "PidState", "Vehicle", "AdaptParams", "SpeedPidParams"}
    assert {f"popsteer.{name}" for name in wanted} <= set(VALUES)
    assert {"popsteer.sim.Settings", "popsteer.sim.CarlaIdentified"} <= set(VALUES)


@pytest.mark.parametrize("name", SHOWN)
def test_signature_leaves_no_default_out(name: str) -> None:
    for parameter in SHOWN[name].parameters.values():
        assert parameter.default is not ..., parameter


@pytest.mark.parametrize("name", VALUES)
def test_default_in_a_signature_is_what_the_value_has(name: str) -> None:
    made = VALUES[name]()
    for parameter in SHOWN[name].parameters.values():
        if parameter.name == "vehicle":
            continue
        has = getattr(made, parameter.name)
        assert (parameter.default, type(parameter.default)) == (has, type(has)), parameter


@pytest.mark.parametrize("name", SHOWN)
def test_documented_number_is_no_none_in_the_signature(name: str) -> None:
    # "default 0.05" in the text and None in the signature would hide the number.
    documented = inspect.getdoc(CALLABLES[name]) or ""
    for parameter in SHOWN[name].parameters.values():
        for line in documented.splitlines():
            if line.startswith(f"{parameter.name} : ") and "default " in line:
                said = line.partition("default ")[2]
                assert (parameter.default is None) <= (not said[:1].isdigit()), line


def test_help_shows_the_defaults() -> None:
    assert "adapt='auto', monitor='auto'" in pydoc.render_doc(popsteer.Pop)
    assert "lookahead_gain=0.2" in pydoc.render_doc(popsteer.PopParams)
    assert "commands_in_flight=()" in pydoc.render_doc(popsteer.PreviewPopState)
    assert "dt=0.05, substeps=" in pydoc.render_doc(sim.Settings)
    assert "wheelbase=3.0" in pydoc.render_doc(popsteer.Vehicle).replace(
        "wheelbase: 'float' = ", ""
    )
    assert "lookahead_gain: 'float' = 0.2" in pydoc.render_doc(reference.PopParams)


def _stub_defaults(stub: str) -> Iterator[tuple[Any, str, ast.expr]]:
    """Every default in the stub: of what, of which parameter, as it is written."""
    for node in ast.parse(stub).body:
        inside = node.body if isinstance(node, ast.ClassDef) else [node]
        for each in inside:
            if not isinstance(each, ast.FunctionDef):
                continue
            thing = getattr(_core, node.name if isinstance(node, ast.ClassDef) else each.name)
            if isinstance(node, ast.ClassDef) and each.name != "__new__":
                thing = getattr(thing, each.name)
            given = [*each.args.posonlyargs, *each.args.args]
            for argument, default in zip(reversed(given), reversed(each.args.defaults)):  # noqa: B905
                yield thing, argument.arg, default
            for argument, keyword in zip(each.args.kwonlyargs, each.args.kw_defaults, strict=True):
                if keyword is not None:
                    yield thing, argument.arg, keyword


def _wrong(stub: str) -> list[str]:
    """Defaults of the stub that are not those of the module."""
    found = []
    for thing, name, written in _stub_defaults(stub):
        real = inspect.signature(thing).parameters[name].default
        said = ast.literal_eval(written)
        if (said, type(said)) != (real, type(real)):
            found.append(f"{thing.__name__}: {name} = {ast.unparse(written)}, not {real!r}")
    return found


def test_stub_has_the_defaults_of_the_module() -> None:
    assert sum(1 for _ in _stub_defaults(STUB)) > 300
    assert _wrong(STUB) == []


@pytest.mark.parametrize(
    ("written", "planted"),
    [
        ("lookahead_gain: float = 0.2,", "lookahead_gain: float = 0.3,"),
        ("substeps: int = 10", "substeps: int = ..."),
        (
            "commands_in_flight: tuple[_Point, ...] = ()",
            "commands_in_flight: tuple[_Point, ...] = (0,)",
        ),
        ("candidate_count: int = 21", "candidate_count: float = 21.0"),
    ],
)
def test_planted_default_in_the_stub_is_found(written: str, planted: str) -> None:
    assert written in STUB
    assert _wrong(STUB.replace(written, planted, 1))
