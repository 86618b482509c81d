"""Nothing lower knows anything higher: which part of the package may import which."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from tests.helpers import ROOT, looped
from tests.meta.imports import circles, import_statements, python_graph, sources

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

PACKAGE = ROOT / "python" / "popsteer"
# From the ground up. A part may import the parts of the layers below its own, and itself; the
# parts of one layer do not know each other.
LAYERS = (
    ("_core", "errors", "interrupt"),
    ("ranges", "extras", "files"),
    (
        "state",
        "status",
        "tables",
        "toml_file",
        "parameters",
        "prediction",
        "signatures",
    ),
    ("own", "controllers", "vehicles", "vehicle_file", "reference"),
    ("paper", "planning", "logs", "params_file"),
    ("identification",),
    ("popsteer",),  # what `import popsteer` brings
    ("presets", "plants", "tracks"),
    ("sim",),
    ("lab.opponents",),
    ("lab.baselines",),
    ("lab.common",),
    ("lab.compare", "lab.stability"),
    ("lab.identify", "lab.plan", "lab.replay"),
    ("lab.suite", "lab.tune", "lab.sweep"),
    ("lab.report",),
    ("lab",),
    ("adapters",),
    ("cli",),
    ("__main__",),
)
RANK = {part: rank for rank, layer in enumerate(LAYERS) for part in layer}


def _part(module: str) -> str:
    """What a module belongs to: `lab` is many parts, all else one a folder or file."""
    names = module.split(".")[1:]
    if not names:
        return "popsteer"
    return ".".join(names[: 2 if names[0] == "lab" else 1])


def _sources() -> dict[str, str]:
    """Every module by name; of the extension, which imports none of them, the name alone."""
    return {**sources(PACKAGE, "popsteer"), "popsteer._core": ""}


def _imports(source: str, modules: Mapping[str, str]) -> Iterator[str]:
    """Modules of popsteer that a source imports, also inside functions and for types alone."""
    for node in import_statements(source):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.startswith("popsteer"))
        elif (node.module or "").startswith("popsteer"):
            for name in node.names:
                if name.name == name.asname:
                    continue  # passed on, to type checkers alone: `popsteer` loads it when asked
                full = f"{node.module}.{name.name}"
                yield full if full in modules else str(node.module)


def _upward(modules: Mapping[str, str]) -> list[str]:
    """Imports that go up, or across to another part of the same layer."""
    found = []
    for module, source in modules.items():
        own = _part(module)
        for imported in _imports(source, modules):
            other = _part(imported)
            if own != other and RANK[other] >= RANK[own]:
                found.append(f"{module} imports {imported}")
    return sorted(found)


def test_reference_is_imported_by_paper_alone() -> None:
    modules = _sources()
    users = {
        module
        for module, source in modules.items()
        if _part(module) != "reference"
        and any(_part(each) == "reference" for each in _imports(source, modules))
    }
    assert users == {"popsteer.paper"}


def test_every_part_of_the_package_has_its_layer() -> None:
    parts = {_part(module) for module in _sources()}
    assert len(parts) > 20
    assert parts <= set(RANK)


def test_no_part_imports_one_of_its_own_layer_or_above() -> None:
    assert _upward(_sources()) == []


@looped(
    ("module", "planted"),
    [
        ("popsteer.tracks.track", "from popsteer.lab import compare"),
        ("popsteer.sim.closed_loop", "def f():\n    import popsteer.cli.inputs"),
        ("popsteer.lab.compare.runs", "from popsteer.lab.stability.runs import Margins"),
        ("popsteer.controllers", "from popsteer import presets"),
        ("popsteer.lab.common.names", "from popsteer.lab.compare.runs import Comparison"),
    ],
)
def test_planted_import_is_found(module: str, planted: str) -> None:
    modules = _sources()
    modules[module] += f"\n{planted}\n"
    (found,) = _upward(modules)
    assert found.startswith(f"{module} imports popsteer.")


def test_no_command_imports_another() -> None:
    commands = {
        f"popsteer.cli.{file.stem}"
        for file in (PACKAGE / "cli").glob("*.py")
        if "\nHELP = " in file.read_text(encoding="utf-8")
    }
    assert len(commands) >= 7
    modules = _sources()
    for command in commands:
        assert commands.isdisjoint(_imports(modules[command], modules)), command


def test_no_files_import_each_other_in_a_circle() -> None:
    graph = python_graph(_sources())
    assert len(graph) > 200
    assert sum(map(len, graph.values())) > 1000
    assert circles(graph) == []
    node = python_graph(sources(ROOT / "ros2" / "popsteer_ros" / "popsteer_ros", "popsteer_ros"))
    assert node["popsteer_ros.node"] >= {"popsteer_ros.follow_path", "popsteer_ros.frames"}
    assert circles(node) == []


@looped(
    ("module", "planted", "circle"),
    [
        (
            "popsteer.adapters.carla.route",
            "if TYPE_CHECKING:\n    from popsteer.adapters.carla.planner import LocalPlanner",
            ["popsteer.adapters.carla.planner", "popsteer.adapters.carla.route"],
        ),
        (
            "popsteer.sim.geometry",
            "def f():\n    from popsteer.sim import pedals",
            ["popsteer.sim.geometry", "popsteer.sim.pedals"],
        ),
        # A name that a package passes on from outside is the package's.
        (
            "popsteer.sim.metrics",
            "from popsteer.sim import KinematicBicycle",
            ["popsteer.sim", "popsteer.sim.closed_loop", "popsteer.sim.metrics"],
        ),
    ],
)
def test_planted_circle_is_found(module: str, planted: str, circle: list[str]) -> None:
    modules = _sources()
    modules[module] += f"\n{planted}\n"
    (found,) = circles(python_graph(modules))
    assert set(circle) <= set(found)
