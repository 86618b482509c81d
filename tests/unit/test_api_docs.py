"""Every public object is documented, and its signature shows the real defaults.

What it takes is named, and what it shows runs. Classes of the Rust core carry their documentation
in the extension module, where doctest's own finder does not look.
"""

from __future__ import annotations

import dataclasses
import doctest
import importlib
import inspect
import math
import pkgutil
import pydoc
import re
from pathlib import Path
from typing import Any

import pytest

import popsteer
import popsteer.lab
from popsteer import _core, paper, reference, sim

MODULES = [
    *(
        "popsteer",
        "popsteer.paper",
        "popsteer.planning",
        "popsteer.plants",
        "popsteer.reference",
        "popsteer.sim",
    ),
    "popsteer.adapters.carla",
    "popsteer.adapters.ros2",
    *("popsteer.controllers", "popsteer.presets", "popsteer.tracks", "popsteer.vehicles"),
    *(f"popsteer.lab.{name}" for name in popsteer.lab.__all__),
]
# What a module needs that neither popsteer nor the group `test` brings.
OF_EXTRAS = {
    "popsteer.adapters.carla": "carla",
    "popsteer.adapters.carla.conversions": "carla",
    **dict.fromkeys(
        (
            "popsteer.adapters.ros2",
            *(
                f"popsteer.adapters.ros2.{name}"
                for name in ("conversions", "dds", "diagnostics", "idl", "intake", "messages")
            ),
            *(f"popsteer.adapters.ros2.{name}" for name in ("node", "recording", "waiting")),
        ),
        "cyclonedds",
    ),
    "popsteer.adapters.gymnasium.stable_baselines3": "stable_baselines3",
    "popsteer.plants.commonroad": "vehiclemodels",
    "popsteer.plants.mujoco_car": "mujoco",
}
# Begins a section of numpydoc: a line, and dashes under it.
_SECTION = re.compile(r"^([A-Z][A-Za-z ]+)\n-{3,}\n", re.MULTILINE)


def _members(kind: type) -> dict[str, Any]:
    """Public methods and attributes of a class, those of Python's own classes left out."""
    own = [each for each in kind.__mro__ if each.__module__.startswith("popsteer")]
    return {
        name: getattr(kind, name)
        for each in own
        # PyO3 adds them in an order of its own, which the workers of pytest-xdist must share.
        for name, member in sorted(vars(each).items())
        if not name.startswith("_")
        and (callable(getattr(kind, name)) or inspect.isdatadescriptor(member))
        # The fields of a named tuple are documented where they stand.
        and not issubclass(kind, tuple)
    }


def _public() -> dict[str, Any]:
    """Every public function and class, and the members of the classes, by name."""
    found: dict[str, Any] = {}
    for name in MODULES:
        module = importlib.import_module(name)
        for public in module.__all__:
            thing = getattr(module, public)
            if inspect.isroutine(thing) or inspect.isclass(thing):
                found[f"{name}.{public}"] = thing
            if inspect.isclass(thing):
                found |= {f"{name}.{public}.{each}": at for each, at in _members(thing).items()}
    return found


def _sections(thing: Any) -> dict[str, str]:
    parts = _SECTION.split(inspect.getdoc(thing) or "")
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def _entries(section: str) -> dict[str, str]:
    """Names in a section, and what is said of their type: entries begin at the margin."""
    entries: dict[str, str] = {}
    for line in section.splitlines():
        if line and not line[0].isspace():
            names, _, kind = line.partition(" : ")
            entries |= {name.strip().lstrip("*"): kind for name in names.split(",")}
    return entries


def _documented(thing: Any) -> dict[str, str]:
    sections = _sections(thing)
    # The fields of a dataclass are its parameters.
    title = "Attributes" if dataclasses.is_dataclass(thing) else "Parameters"
    return _entries(sections.get("Parameters", sections.get(title, "")))


def _parameters(thing: Any) -> dict[str, Any]:
    """Parameters by name, with their defaults."""
    try:
        signature = inspect.signature(thing)
    except ValueError:  # a class whose objects the library alone makes
        return {}
    return {
        name: parameter.default
        for name, parameter in signature.parameters.items()
        if name not in ("self", "cls")
    }


def _is_of_core(thing: Any) -> bool:
    home = thing if inspect.isclass(thing) else getattr(thing, "__objclass__", thing)
    return any(home is each for each in vars(_core).values())


PUBLIC = _public()
CALLABLES = {name: thing for name, thing in PUBLIC.items() if callable(thing)}
# What drives a vehicle, and the paper's functions.
CORE = {
    name: thing
    for name, thing in CALLABLES.items()
    if _is_of_core(thing) or name.startswith("popsteer.paper.")
}
DOCUMENTED = {name: thing for name, thing in CALLABLES.items() if _documented(thing)}
DEFAULTS = {
    (name, parameter): kind.partition("default ")[2]
    for name, thing in CORE.items()
    for parameter, kind in _documented(thing).items()
    if "default " in kind
}


def test_enumeration_of_public_objects_finds_the_essential_ones() -> None:
    laws = ("Pop", "PreviewPop", "Pid", "PurePursuit", "Stanley")
    for home, method in (("popsteer", "step"), ("popsteer.reference", "decide")):
        wanted = {f"{home}.{law}{part}" for law in laws for part in ("", "Params", f".{method}")}
        assert wanted <= set(CALLABLES)
    assert {f"popsteer.{law}.state" for law in laws} <= set(PUBLIC)
    assert {"popsteer.paper.wrap", "popsteer.Path.project", "popsteer.Pop.steer"} <= set(CORE)
    assert {"popsteer.sim.Simulation", "popsteer.sim.Simulation.step"} <= set(CORE)
    assert "popsteer.reference.wrap" not in CORE
    assert len(DOCUMENTED) > 60
    assert len(DEFAULTS) > 50


@pytest.mark.parametrize("name", MODULES)
def test_public_module_has_a_docstring(name: str) -> None:
    assert importlib.import_module(name).__doc__


def test_public_object_has_a_docstring_that_begins_with_a_sentence() -> None:
    first = {name: (inspect.getdoc(thing) or "").split("\n\n")[0] for name, thing in PUBLIC.items()}
    assert [name for name, text in first.items() if not text.rstrip().endswith((".", ":"))] == []


def test_callable_of_the_core_documents_its_parameters() -> None:
    # A few share them with a neighbour, which they name; `replace` takes any.
    wrong = [
        name
        for name, thing in CORE.items()
        if bool(_documented(thing)) != bool(_parameters(thing))
        and "Parameters and errors as `" not in (inspect.getdoc(thing) or "")
        and not name.endswith(".replace")
    ]
    assert wrong == []


def test_parameters_section_names_exactly_the_parameters() -> None:
    for name, thing in DOCUMENTED.items():
        if inspect.isclass(thing) and not _parameters(thing):
            assert "Attributes" in _sections(thing), name
        else:
            assert list(_documented(thing)) == list(_parameters(thing)), name


def test_parameter_is_said_to_be_optional_where_it_is() -> None:
    for name in (name for name in CORE if name in DOCUMENTED):
        defaults = _parameters(CORE[name])
        for parameter, said in _documented(CORE[name]).items():
            has_default = defaults[parameter] is not inspect.Parameter.empty
            assert has_default == ("default " in said or "optional" in said), (name, parameter)


def test_documented_default_is_the_real_one() -> None:
    for (name, parameter), said in DEFAULTS.items():
        stated = eval(said, {"PI": math.pi})
        real = _parameters(CORE[name])[parameter]
        if (name, parameter) == ("popsteer.sim.Simulation", "plant"):  # None stands for it
            path = popsteer.Path([(0.0, 0.0), (9.0, 0.0)])
            real = CORE[name](path, real, start=(0.0, 0.0, 0.0)).plant
        assert (real, type(real)) == (stated, type(stated)), (name, parameter)


@pytest.mark.parametrize("name", [name for name in CORE if "Examples" in _sections(CORE[name])])
def test_examples_of_the_core_run(name: str) -> None:
    doc = inspect.getdoc(CORE[name]) or ""
    test = doctest.DocTestParser().get_doctest(doc, {"popsteer": popsteer}, name, None, None)
    assert test.examples
    said: list[str] = []
    result = doctest.DocTestRunner().run(test, out=said.append)
    assert result.failed == 0, "".join(said)


def test_laws_and_functions_of_the_core_each_have_an_example() -> None:
    wanted = {"Path", "Pop", "Pid", "PurePursuit", "Stanley", "SpeedPid", "wrap"}
    wanted |= {"CoupledLongitudinal", "saturate", "get_distance", "get_predicted_location"}
    wanted |= {"state_transition", "kinematic_bicycle", "PreviewPop", "Vehicle", "AdaptParams"}
    wanted |= {
        "MonitorParams",
        "Estimate",
        "Command",
        "CommandBatch",
        "Batch",
        "Projection",
        "Lookahead",
    }
    things = {**vars(popsteer), **vars(paper)}
    assert all("Examples" in _sections(things[name]) for name in wanted)


def _modules() -> list[str]:
    modules = pkgutil.walk_packages(popsteer.__path__, "popsteer.")
    return [
        module.name
        for module in modules
        if module.name not in ("popsteer._core", "popsteer.__main__")
    ]


@pytest.mark.parametrize("name", ["popsteer", *_modules()])
def test_examples_of_the_module_run(name: str) -> None:
    if name in OF_EXTRAS:
        pytest.importorskip(OF_EXTRAS[name])
    module = importlib.import_module(name)
    result = doctest.testmod(
        module, extraglobs={"popsteer": popsteer}, optionflags=doctest.IGNORE_EXCEPTION_DETAIL
    )
    assert result.failed == 0
    source = Path(module.__file__ or "").read_text(encoding="utf-8")
    assert (result.attempted > 0) == (">>> " in source)


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
