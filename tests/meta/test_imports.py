"""Nothing lower knows anything higher, and no Rust files know each other in a circle.

The reference has the order of the core; `test_imports_python` has the package's, and its circles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.helpers import ROOT, looped
from tests.meta.imports import circles, python_graph, rust_graph, sources, upward

if TYPE_CHECKING:
    from tests.meta.imports import Graph

# What each part may import, beside itself. A part is a module with all below it; of several that
# hold a module the longest counts. Another package or crate is added with its parts here.
_GROUND = ("math", "geometry", "bounds", "error", "params", "row", "status")


def _core(root: str) -> dict[str, set[str]]:
    """Say what the parts of the core may know, and alike those of its reference."""
    layers = {
        "math": (),
        "bounds": (),
        "error": (),
        "row": (),
        "status": (),
        "geometry": ("math",),
        "params": ("math", "error"),
        "vehicle": _GROUND,
        "path": (*_GROUND, "vehicle"),
        "laws": (*_GROUND, "vehicle", "path"),
        "tracker": (*_GROUND, "vehicle", "path", "laws"),
        "speed": (*_GROUND, "vehicle", "path"),
        "driver": (*_GROUND, "vehicle", "path", "laws", "tracker", "speed"),
    }
    allowed = {
        f"{root}.{part}": {f"{root}.{other}" for other in known} for part, known in layers.items()
    }
    return {**allowed, root: set(allowed)}


_CORE = _core("popsteer_core")
_SIM = {
    "popsteer_sim": {*_CORE, "popsteer_sim.plant"},
    # A plant knows the vehicle, and nothing of paths and controllers.
    "popsteer_sim.plant": {f"popsteer_core.{part}" for part in (*_GROUND, "vehicle")},
}
_BINDING = {"popsteer_py": {*_CORE, *_SIM}}
_C = {"popsteer_c": {*_CORE}}
_WASM = {"popsteer_wasm": {*_CORE, *_SIM}}
_REFERENCE = _core("popsteer.reference")

RUST = {**_CORE, **_SIM, **_BINDING, **_C, **_WASM}
PYTHON = {**_REFERENCE}


def _rust() -> dict[str, str]:
    crates = {}
    for crate in ("core", "sim", "py", "c", "wasm"):
        crates.update(sources(ROOT / "rust" / crate / "src", f"popsteer_{crate}"))
    return crates


def _python() -> dict[str, str]:
    return sources(ROOT / "python" / "popsteer" / "reference", "popsteer.reference")


def test_rust_imports_lead_down() -> None:
    graph = rust_graph(_rust())
    assert len(graph) > 60
    assert sum(map(len, graph.values())) > 200
    assert upward(graph, RUST) == []


def test_rust_files_know_each_other_in_no_circle() -> None:
    assert circles(rust_graph(_rust())) == []


def test_python_imports_lead_down() -> None:
    graph = python_graph(_python())
    assert len(graph) > 35
    assert sum(map(len, graph.values())) > 150
    assert upward(graph, PYTHON) == []


# A core as small as can be, to plant imports in: `path.near` knows nothing of `path.locate`, and
# `path` nothing of `laws`.
_SMALL_CORE = {
    "popsteer_core": "pub mod laws;\npub mod path;\npub use laws::{Command, Status};",
    "popsteer_core.math": "",
    "popsteer_core.path": "pub mod locate;\nmod near;\npub use locate::locate;",
    "popsteer_core.path.locate": "use super::near::near;\npub fn locate() {}",
    "popsteer_core.path.near": "pub(super) fn near() {}",
    "popsteer_core.laws": "pub mod command;\npub use command::{Command, Status};",
    "popsteer_core.laws.command": "use crate::path::locate;\npub struct Command;",
}
_SMALL_REFERENCE = {
    "popsteer.reference": "from popsteer.reference.laws.command import Command",
    "popsteer.reference.path": "",
    "popsteer.reference.path.locate": "from popsteer.reference.path.near import near",
    "popsteer.reference.path.near": "import math",
    "popsteer.reference.laws": "",
    "popsteer.reference.laws.command": "from popsteer.reference.path.locate import locate",
}


def _with(sources: dict[str, str], module: str, planted: str) -> dict[str, str]:
    return {**sources, module: f"{sources[module]}\n{planted}\n"}


@looped(
    "planted",
    [
        "use crate::laws::Command;",
        "use crate::{\n    math::sin,\n    laws::{Command, Status},\n};",
        "pub use super::super::laws::Status;",
        "fn f() -> crate::laws::Status { todo!() }",
        "macro_rules! m { () => { $crate::laws::Command } }",
        "use crate::Status;",
    ],
)
def test_rust_import_upward_is_found(planted: str) -> None:
    assert upward(rust_graph(_SMALL_CORE), RUST) == []
    graph = rust_graph(_with(_SMALL_CORE, "popsteer_core.path.locate", planted))
    found = "popsteer_core.path.locate imports popsteer_core.laws.command"
    assert upward(graph, RUST) == [f"{found}: popsteer_core.path may not know popsteer_core.laws"]


@looped(
    "planted",
    [
        "// use crate::laws::Command;",
        "/// See [`Command`](crate::laws::Command).\nfn f() {}",
        "#[cfg(test)]\nmod tests {\n    use crate::laws::Command;\n}",
    ],
)
def test_rust_words_and_tests_import_nothing(planted: str) -> None:
    graph = rust_graph(_with(_SMALL_CORE, "popsteer_core.path.locate", planted))
    assert graph == rust_graph(_SMALL_CORE)


@looped(
    "planted",
    ["use super::locate::locate;", "use super::{locate::OPPOSITE};", "use super::locate;"],
)
def test_rust_circle_is_found(planted: str) -> None:
    assert circles(rust_graph(_SMALL_CORE)) == []
    graph = rust_graph(_with(_SMALL_CORE, "popsteer_core.path.near", planted))
    assert circles(graph) == [["popsteer_core.path.locate", "popsteer_core.path.near"]]


@looped(
    "planted",
    [
        "from popsteer.reference.laws.command import Command",
        "import popsteer.reference.laws.command",
        "def f():\n    from popsteer.reference.laws import command",
        "if TYPE_CHECKING:\n    from popsteer.reference.laws.command import Command",
        "from popsteer.reference import Command",
    ],
)
def test_python_import_upward_is_found(planted: str) -> None:
    assert upward(python_graph(_SMALL_REFERENCE), PYTHON) == []
    module = "popsteer.reference.path.locate"
    graph = python_graph(_with(_SMALL_REFERENCE, module, planted))
    found = f"{module} imports popsteer.reference.laws.command"
    parts = ("popsteer.reference.path", "popsteer.reference.laws")
    assert upward(graph, PYTHON) == [f"{found}: {parts[0]} may not know {parts[1]}"]


def test_python_circle_is_found() -> None:
    assert circles(python_graph(_SMALL_REFERENCE)) == []
    planted = "from popsteer.reference.path import locate"
    graph = python_graph(_with(_SMALL_REFERENCE, "popsteer.reference.path.near", planted))
    assert circles(graph) == [["popsteer.reference.path.locate", "popsteer.reference.path.near"]]


def test_module_beside_the_table_is_found() -> None:
    graph: Graph = {"popsteer_new.thing": set()}
    assert upward(graph, RUST) == ["popsteer_new.thing is in no part of the table"]
