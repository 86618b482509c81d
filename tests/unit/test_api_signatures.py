"""Signatures show the real defaults."""

from __future__ import annotations

import inspect
import pydoc
from typing import Any

import popsteer
from popsteer import reference, sim
from tests.unit.test_api_docs import CALLABLES


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
    wanted = {"PopParams", "Vehicle", "AdaptParams", "SpeedPidParams"}
    assert {f"popsteer.{name}" for name in wanted} <= set(VALUES)
    assert {"popsteer.sim.Settings", "popsteer.sim.CarlaIdentified"} <= set(VALUES)


def test_signature_leaves_no_default_out() -> None:
    for name, shown in SHOWN.items():
        for parameter in shown.parameters.values():
            assert parameter.default is not ..., (name, parameter)


def test_default_in_a_signature_is_what_the_value_has() -> None:
    for name, kind in VALUES.items():
        made = kind()
        for parameter in SHOWN[name].parameters.values():
            if parameter.name == "vehicle":
                continue
            has = getattr(made, parameter.name)
            default = parameter.default
            assert (default, type(default)) == (has, type(has)), (name, parameter)


def test_documented_number_is_no_none_in_the_signature() -> None:
    # "default 0.05" in the text and None in the signature would hide the number.
    for name, shown in SHOWN.items():
        documented = inspect.getdoc(CALLABLES[name]) or ""
        for parameter in shown.parameters.values():
            for line in documented.splitlines():
                if line.startswith(f"{parameter.name} : ") and "default " in line:
                    said = line.partition("default ")[2]
                    assert (parameter.default is None) <= (not said[:1].isdigit()), (name, line)


def test_help_shows_the_defaults() -> None:
    assert "adapt='auto', monitor='auto'" in pydoc.render_doc(popsteer.Pop)
    assert "lookahead_gain=0.2" in pydoc.render_doc(popsteer.PopParams)
    assert "dt=0.05, substeps=" in pydoc.render_doc(sim.Settings)
    assert "wheelbase=3.0" in pydoc.render_doc(popsteer.Vehicle).replace(
        "wheelbase: 'float' = ", ""
    )
    assert "lookahead_gain: 'float' = 0.2" in pydoc.render_doc(reference.PopParams)
