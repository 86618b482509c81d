"""The stub says what the extension module has: names, order, defaults and types.

stubtest finds what the stub lacks. What the stub has too much of in its private bases, and what a
property or a default really is, is found here; the planted faults show that it is.
"""

from __future__ import annotations

import ast
import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import _core

if TYPE_CHECKING:
    from collections.abc import Iterator

STUB = Path(inspect.getfile(_core)).with_name("_core.pyi").read_text(encoding="utf-8")
READ_ONLY = "    adapt: Final[AdaptParams | None]\n"
GETTER = "    @property\n    def adapt(self) -> AdaptParams | None: ...\n"
SETTER = "    @adapt.setter\n    def adapt(self, adapt: None) -> None: ...\n"
LAWS = ("Pop", "PreviewPop", "Pid", "PurePursuit", "Stanley")


class Stub:
    """The classes of a stub with all that they inherit, its functions and its aliases."""

    def __init__(self, text: str) -> None:
        nodes = [_with_constructor(node) for node in ast.parse(text).body]
        self.all = {node.name: node for node in nodes if isinstance(node, ast.ClassDef)}
        self.classes = {name: node for name, node in self.all.items() if not name.startswith("_")}
        self.functions = [node for node in nodes if isinstance(node, ast.FunctionDef)]
        self.aliases = {
            node.target.id: node.value
            for node in nodes
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value
        }

    def members(self, name: str) -> dict[str, ast.FunctionDef]:
        """Methods and properties of a class, those of its bases included."""
        found: dict[str, ast.FunctionDef] = {}
        for each in reversed(self._line(name)):
            body = [_as_property(node) for node in self.all[each].body]
            methods = [node for node in body if isinstance(node, ast.FunctionDef)]
            # A setter stands behind its getter.
            found |= {node.name: node for node in reversed(methods)}
        return found

    def has_setter(self, name: str, member: str) -> bool:
        """Whether a property of a class can be set."""
        text = "\n".join(ast.unparse(self.all[each]) for each in self._line(name))
        return f"@{member}.setter" in text

    def _line(self, name: str) -> list[str]:
        """A class of the stub, then its bases there."""
        parts = [
            each.value if isinstance(each, ast.Subscript) else each for each in self.all[name].bases
        ]
        bases = [each.id for each in parts if isinstance(each, ast.Name) and each.id in self.all]
        return [name, *(ancestor for base in bases for ancestor in self._line(base))]

    def callables(self) -> Iterator[tuple[Any, ast.FunctionDef]]:
        """Every function and method, as the module has it and as the stub has it."""
        for node in self.functions:
            yield getattr(_core, node.name), node
        for name in self.classes:
            kind = getattr(_core, name)
            for member, node in self.members(name).items():
                if not _is_property(node):
                    yield kind if member == "__new__" else getattr(kind, member), node


def _with_constructor(node: ast.stmt) -> ast.stmt:
    """A class with `name: kind = default` fields as one that has a constructor and properties."""
    if isinstance(node, ast.ClassDef):
        fields = [
            each
            for each in node.body
            if isinstance(each, ast.AnnAssign)
            and not ast.unparse(each.annotation).startswith(("Final[", "ClassVar["))
        ]
        if fields:
            said = f"def __new__(cls, *, {', '.join(map(ast.unparse, fields))}) -> Self: ..."
            node.body.append(ast.parse(said).body[0])
        for each in fields:
            each.annotation = ast.parse(f"Final[{ast.unparse(each.annotation)}]").body[0].value  # type: ignore[attr-defined]
            each.value = None
    return node


def _as_property(node: ast.stmt) -> ast.stmt:
    """`name: Final[kind]` as the property that it stands for; another statement as it is."""
    if isinstance(node, ast.AnnAssign):
        kind = ast.unparse(node.annotation)
        if kind.startswith("Final["):
            said = f"@property\ndef {ast.unparse(node.target)}(self) -> {kind[6:-1]}: ..."
            return ast.parse(said).body[0]
    return node


def _is_property(node: ast.FunctionDef) -> bool:
    return any(ast.unparse(each) == "property" for each in node.decorator_list)


def _arguments(node: ast.FunctionDef) -> dict[str, tuple[ast.expr | None, ast.expr | None]]:
    """Annotation and default of each argument, but for self."""
    given = [*node.args.posonlyargs, *node.args.args]
    missing: list[ast.expr | None] = [None] * (len(given) - len(node.args.defaults))
    pairs = [
        *zip(given, [*missing, *node.args.defaults], strict=True),
        *zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True),
    ]
    return {
        argument.arg: (argument.annotation, default)
        for argument, default in pairs
        if argument.arg not in ("self", "cls")
    }


def _defaults(stub: Stub) -> Iterator[tuple[Any, str, ast.expr]]:
    """Every default in the stub: of what, of which parameter, as it is written."""
    for thing, node in stub.callables():
        for name, (_, default) in _arguments(node).items():
            if default is not None:
                yield thing, name, default


def wrong_defaults(stub: Stub) -> list[str]:
    """Defaults of the stub that are not those of the module."""
    found = []
    for thing, name, written in _defaults(stub):
        real = inspect.signature(thing).parameters[name].default
        said = ast.literal_eval(written)
        if (said, type(said)) != (real, type(real)):
            found.append(f"{thing.__name__}: {name} = {ast.unparse(written)}, not {real!r}")
    return found


def wrong_names(stub: Stub) -> list[str]:
    """Members that the module lacks, and constructors whose parameters are others there."""
    found = []
    for name in stub.classes:
        kind, members = getattr(_core, name), stub.members(name)
        found += [f"{name}.{each}" for each in members if not hasattr(kind, each)]
        if "__new__" in members:
            said = list(_arguments(members["__new__"]))
            real = list(inspect.signature(kind).parameters)
            found += [f"{name}({', '.join(said)}), not {real}"] if said != real else []
    return found


def _fits(value: Any, said: ast.expr, stub: Stub) -> bool:
    """Whether a value is of the type that an annotation says; an int is no float here."""
    text = ast.unparse(said)
    if isinstance(said, ast.BinOp):
        return _fits(value, said.left, stub) or _fits(value, said.right, stub)
    if text in stub.aliases:
        return _fits(value, stub.aliases[text], stub)
    if isinstance(said, ast.Subscript):
        return _holds(value, said, stub)
    plain = {"float": float, "int": int, "bool": bool, "str": str, "None": type(None)}
    return type(value) is plain.get(text, getattr(popsteer, text, getattr(_core, text, None)))


def _holds(value: Any, said: ast.Subscript, stub: Stub) -> bool:
    """Whether a value is the array, the list or the tuple that an annotation says."""
    kind = ast.unparse(said.value)
    parts = said.slice.elts if isinstance(said.slice, ast.Tuple) else [said.slice]
    if kind == "NDArray":
        number = ast.unparse(said.slice).removeprefix("np.").rstrip("_")
        return isinstance(value, np.ndarray) and value.dtype == np.dtype(number)
    if type(value).__name__ != kind:
        return False
    if kind == "list" or ast.unparse(parts[-1]) == "...":
        parts = [parts[0]] * len(value)
    return len(parts) == len(value) and all(map(_fits, value, parts, [stub] * len(parts)))


def _values() -> list[Any]:
    """Objects of every class, such that each property has something else than None in one."""
    path = popsteer.Path(
        [(float(k), 0.0) for k in range(60)],
        speed=[5.0] * 30 + [-5.0] * 30,
        reverse=[False] * 30 + [True] * 30,
    )
    late = popsteer.Vehicle(dead_time=0.2, max_steer_rate=0.5)
    optional = [name for name, value in popsteer.Vehicle().as_dict().items() if value is None]
    all_given = late.replace(**dict.fromkeys(optional, 1.0))
    values: list[Any] = [path, popsteer.Path([(0.0, 0.0), (9.0, 0.0)]), late, all_given]
    values += [
        popsteer.AdaptParams(turn_time=1.0),
        popsteer.MonitorParams(deviation_limit=1.0),
        path.project(1.0, 0.5),
        path.get_lookahead_point(1.0, 0.5, 3.0),
    ]
    for name in LAWS:
        params = getattr(popsteer, f"{name}Params")()
        controller = getattr(popsteer, name)(path, late, params, adapt=popsteer.AdaptParams())
        values += [params, params.resolved(late), controller]
        controller.reset(steer=0.1)
        for k in range(3):
            command = controller.step(0.3 * k, 0.5, 0.0, 5.0, 0.05, pose_age=0.1)
        values += [controller.estimate, command]
    batch = popsteer.Batch(popsteer.Pop(path), 2)
    values += [batch, batch.step([0.0, 1.0], [0.5, 0.5], [0.0, 0.0], [5.0, 5.0], 0.05)]
    speed, tracker = popsteer.SpeedPid(), popsteer.SpeedTracker(path, late)
    speed.step(1.0, 2.0, 0.05)
    values += [tracker.step(1.0, 0.5, 0.0, 4.0, 0.05), tracker, tracker.params]
    values += [speed, speed.params, popsteer.CoupledLongitudinal()]
    driver = popsteer.Driver(path, late, popsteer.StanleyParams(), adapt=popsteer.AdaptParams())
    values += [driver.step(1.0, 0.5, 0.0, 4.0, 0.05), driver, driver.params]
    simulation = _core.Simulation(path, "kinematic-bicycle", start=(0.0, 0.0, 0.0))
    simulation.drive(popsteer.Pop(path, late))
    values += [popsteer.CoupledLongitudinalParams(), simulation, simulation.settings]
    return [*values, _core.Noise(), _core.CarlaIdentified(), _core.KinematicBicycle()]


VALUES = _values()


def wrong_types(stub: Stub) -> list[str]:
    """Properties that are not of the type that the stub says, or not of their parameter's."""
    found = []
    for value in VALUES:
        name = type(value).__name__
        members = stub.members(name)
        parameters = _arguments(members["__new__"]) if "__new__" in members else {}
        for each, node in members.items():
            if not _is_property(node) or node.returns is None:
                continue
            said = ast.unparse(node.returns)
            # A controller's own classes are those of its base's brackets.
            own = f"{name}Params" if said == "_ParamsT" else said
            real = getattr(value, each)
            if not _fits(real, ast.parse(own, mode="eval").body, stub):
                found.append(f"{name}.{each}: {own}, not {real!r}")
            given, _ = parameters.get(each, (None, None))
            if given is not None and hasattr(value, "as_dict") and ast.unparse(given) != said:
                found += [f"{name}.{each}: {said}"] * (said not in ast.unparse(given))
    return found


def wrong_setters(stub: Stub) -> list[str]:
    """Properties that the stub lets one set and the module does not, or the other way round."""
    found = []
    for value in VALUES:
        name = type(value).__name__
        for each, node in stub.members(name).items():
            if not _is_property(node):
                continue
            try:
                setattr(value, each, getattr(value, each))
                settable = True
            except AttributeError:
                settable = False
            found += [f"{name}.{each}"] * (settable != stub.has_setter(name, each))
    return found


def test_stub_has_the_classes_and_functions_of_the_module() -> None:
    stub = Stub(STUB)
    assert {type(value).__name__ for value in VALUES} >= set(stub.classes) - {"Episodes"}
    assert len(stub.classes) > 30
    own = {"_path_curvature", "_path_headings", "_with_speed", "_path_cusps", "_plan_speeds"}
    own |= {"_lagged", "_recursion"}
    assert {function.name for function in stub.functions} == {"run_many", *own}
    assert sum(1 for _ in _defaults(stub)) > 200
    assert sum(1 for name in stub.classes for _ in stub.members(name)) > 400


@pytest.mark.parametrize("check", [wrong_names, wrong_defaults, wrong_types, wrong_setters])
def test_stub_is_that_of_the_module(check: Any) -> None:
    assert check(Stub(STUB)) == []


@pytest.mark.parametrize(
    ("check", "written", "planted"),
    [
        (wrong_defaults, "lookahead_gain: float = 0.2\n", "lookahead_gain: float = 0.3\n"),
        (wrong_defaults, "substeps: int = 10", "substeps: int = ..."),
        (wrong_defaults, "candidate_count: int = 21", "candidate_count: float = 21.0"),
        (wrong_defaults, "hold_limit: int = 10,", "hold_limit: int = 9,"),
        (wrong_names, "def predict(", "def foresee("),
        (wrong_names, "    lost_distance: float", "    gone_distance: float"),
        (wrong_names, "params: _ParamsT | None = None,", "tuning: _ParamsT | None = None,"),
        (wrong_types, "    candidate_count: int = 21", "    candidate_count: float = 21"),
        (wrong_types, "def state(self) -> State", "def state(self) -> _ParamsT"),
        (wrong_types, "    reverse: bool\n", "    reverse: float\n"),
        (wrong_types, "    tracked_point: Final[float]", "    tracked_point: Final[_Point]"),
        (
            wrong_setters,
            "    @state.setter\n    def state(self, state: State) -> None: ...\n",
            "",
        ),
        (wrong_setters, READ_ONLY, GETTER + SETTER),
        (wrong_types, "lost_distance: float | None = None", "lost_distance: int | None = None"),
    ],
)
def test_planted_fault_in_the_stub_is_found(check: Any, written: str, planted: str) -> None:
    assert written in STUB
    assert check(Stub(STUB.replace(written, planted, 1)))
