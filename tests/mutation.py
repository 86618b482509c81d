"""Mutation testing of the Python half: how many small faults its tests catch.

    python -m tests.mutation lab/sweep planning --count 60 --seed 1

A mutant is a function of `popsteer` with one operator, number, branch or statement changed.
Which tests reach which line is measured once with coverage.py. A mutant is then tried in a process
of its own, by the tests that reach its line, the quickest first, until one fails. What is not
mutated: texts, annotations, what runs when a module is imported (constants, defaults).
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import copy
import gc
import io
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, FunctionType
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).resolve().parents[1]
_SPEC = find_spec("popsteer")
assert _SPEC is not None
assert _SPEC.origin is not None
PACKAGE = Path(_SPEC.origin).parent
"""What is imported: the installed package, or the sources where they come first."""
MOST_SECONDS = 25.0
"""How long the tests of a mutant may take without it; the slowest are left out beyond that."""
_QUIET = ("-q", "--no-header", "-p", "no:cacheprovider", "-p", "no:randomly")
_COMPARED = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_COMPUTED = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
_CALLED = {
    "min": "max",
    "max": "min",
    "minimum": "maximum",
    "maximum": "minimum",
    "sin": "cos",
    "cos": "sin",
    "degrees": "radians",
    "radians": "degrees",
    "any": "all",
    "all": "any",
}


class Mutant(NamedTuple):
    """One fault: where it is, of which kind, and how to make it."""

    file: Path
    line: int
    kind: str
    function: str
    number: int


def _changes(node: ast.AST) -> Iterator[tuple[str, Any]]:  # noqa: C901 - a kind each
    """Give the faults that a node can have: their kind, and what makes one of a copy."""
    if isinstance(node, ast.Compare) and type(node.ops[0]) in _COMPARED:
        other = _COMPARED[type(node.ops[0])]
        yield "comparison", lambda it: it.ops.__setitem__(0, other())
    elif isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in _COMPUTED:
        if not any(isinstance(each, ast.JoinedStr) for each in ast.walk(node)):
            made = _COMPUTED[type(node.op)]
            yield "arithmetic", lambda it: setattr(it, "op", made())
    elif isinstance(node, ast.BoolOp):
        turned = ast.Or if isinstance(node.op, ast.And) else ast.And
        yield "and, or", lambda it: setattr(it, "op", turned())
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "sign", lambda it: setattr(it, "op", ast.UAdd())
    elif isinstance(node, ast.If | ast.IfExp | ast.While):
        yield "branch", lambda it: setattr(it, "test", ast.UnaryOp(ast.Not(), it.test))
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
        value: Any = node.value
        other_value = (
            (not value) if isinstance(value, bool) else value + 1 if value < 2 else value * 2
        )
        yield "number", lambda it: setattr(it, "value", other_value)
    elif isinstance(node, ast.Call):
        yield from _calls(node)
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield "left out", lambda it: setattr(it, "value", ast.Constant(None))
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
        yield "left out", lambda it: setattr(it, "targets", [ast.Name("_", ast.Store())])


def _calls(node: ast.Call) -> Iterator[tuple[str, Any]]:
    name = getattr(node.func, "attr", getattr(node.func, "id", ""))
    if name in _CALLED:
        field = "attr" if isinstance(node.func, ast.Attribute) else "id"
        yield "function", lambda it: setattr(it.func, field, _CALLED[name])
    elif name == "abs" and len(node.args) == 1:
        field, other = (
            ("attr", "positive") if isinstance(node.func, ast.Attribute) else ("id", "float")
        )
        yield "function", lambda it: setattr(it.func, field, other)


def _nodes(tree: ast.Module) -> Iterator[tuple[str, ast.AST]]:
    """Give the nodes of functions and methods that compute, each with its function's name."""
    for outer in tree.body:
        inside = outer.body if isinstance(outer, ast.ClassDef) else [outer]
        prefix = f"{outer.name}." if isinstance(outer, ast.ClassDef) else ""
        for each in inside:
            if isinstance(each, ast.FunctionDef):
                yield from (
                    (prefix + each.name, node) for part in each.body for node in _walk(part)
                )


def _walk(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom):
        return
    yield node
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        if isinstance(node, ast.keyword) and node.arg == "strict":
            continue  # of zip: it says of a fault what `Raise` says, and changes no answer
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _walk(child)


def mutants(file: Path) -> list[Mutant]:
    """List the mutants of a file."""
    found: list[Mutant] = []
    for name, node in _nodes(ast.parse(file.read_text(encoding="utf-8"))):
        for kind, _ in _changes(node):
            found.append(Mutant(file, node.lineno, kind, name, len(found)))  # type: ignore[attr-defined]
    return found


def _mutated(mutant: Mutant) -> tuple[CodeType, str]:
    """Compile the file with the fault; also the line that it changes."""
    tree = copy.deepcopy(ast.parse(mutant.file.read_text(encoding="utf-8")))
    number = 0
    for _, node in _nodes(tree):
        for _, change in list(_changes(node)):
            if number == mutant.number:
                change(node)
                text = ast.unparse(node).splitlines()[0]
                return compile(ast.fix_missing_locations(tree), str(mutant.file), "exec"), text
            number += 1
    raise AssertionError(mutant)


def _codes(code: CodeType, prefix: str = "") -> Iterator[tuple[str, CodeType]]:
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield prefix + each.co_name, each
            yield from _codes(each, f"{prefix}{each.co_name}.")


class _Traced:
    """Which test reaches which line, and how long each takes."""

    def __init__(self) -> None:
        import coverage

        self.coverage = coverage.Coverage(data_file=None, include=[f"{PACKAGE}/*"])
        self.seconds: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Any:
        # What a fixture of a module does counts for all of its tests.
        self.coverage.switch_context(f"{item.nodeid.partition('::')[0]}::")
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Any:
        self.coverage.switch_context(item.nodeid)
        began = time.perf_counter()
        found = yield
        self.seconds[item.nodeid] = time.perf_counter() - began
        return found


def trace(tests: list[str], out: Path) -> int:
    """Run the tests once, and write which of them reach which line of which file."""
    traced = _Traced()
    traced.coverage.start()
    status = int(pytest.main([*_QUIET, *tests], plugins=[traced]))
    traced.coverage.stop()
    data = traced.coverage.get_data()
    lines = {file: data.contexts_by_lineno(file) for file in data.measured_files()}
    out.write_text(json.dumps({"lines": lines, "seconds": traced.seconds}))
    return status


def _tests_of(mutant: Mutant, traced: dict[str, Any]) -> list[str]:
    lines = traced["lines"].get(str(mutant.file), {})
    seconds: dict[str, float] = traced["seconds"]
    hit = lines.get(str(mutant.line), [])
    whole = tuple(each for each in hit if each.endswith("::"))
    reach = [each for each in seconds if each in hit or (whole and each.startswith(whole))]
    chosen: list[str] = []
    total = 0.0
    for each in sorted(reach, key=lambda name: seconds[name]):
        total += seconds[each]
        if total > MOST_SECONDS and chosen:
            break
        chosen.append(each)
    return chosen


def _try(
    mutant: Mutant, tests: list[str], functions: dict[tuple[str, str], list[FunctionType]]
) -> str:
    """Try a mutant in a process of its own; say what became of it."""
    code, _ = _mutated(mutant)
    found = dict(_codes(code))[mutant.function]
    own = functions.get((str(mutant.file), mutant.function), [])
    if not tests or not own:
        return "not reached"
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        for function in own:
            function.__code__ = found
        os._exit(int(pytest.main([*_QUIET, "-x", *tests])) != 0)
    until = time.monotonic() + 60.0 + 4.0 * MOST_SECONDS
    while time.monotonic() < until:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return "caught" if status else "survived"
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return "caught"


def _functions() -> dict[tuple[str, str], list[FunctionType]]:
    found: dict[tuple[str, str], list[FunctionType]] = {}
    for each in gc.get_objects():
        if isinstance(each, FunctionType) and each.__code__.co_filename.startswith(str(PACKAGE)):
            found.setdefault((each.__code__.co_filename, each.__qualname__), []).append(each)
    return found


def _interval(caught: int, tried: int) -> tuple[float, float]:
    from scipy.stats import binomtest

    ends = binomtest(caught, tried).proportion_ci(method="wilson")
    return 100.0 * float(ends.low), 100.0 * float(ends.high)


def main() -> None:
    """Trace the tests, sample mutants of each module, try them, and print what became of them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("modules", nargs="+", help="folders or files of the package")
    parser.add_argument(
        "--tests", nargs="+", default=["tests/unit", "tests/values", "tests/adapters"]
    )
    parser.add_argument("-k", default="", help="which tests, as pytest takes it")
    parser.add_argument("--count", type=int, default=50, help="how many mutants of each module")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--traced", type=Path, help="a file for what reaches what, kept for later")
    parser.add_argument("--trace", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.trace:
        sys.exit(trace([*asked.tests, "-k", asked.k], asked.traced))
    with tempfile.TemporaryDirectory() as folder:
        file = asked.traced or Path(folder) / "traced.json"
        if not file.exists():
            command = [sys.executable, "-m", "tests.mutation", "--trace", "--traced", str(file)]
            options = ["-k", asked.k, "--tests", *asked.tests]
            subprocess.run([*command, "-", *options], cwd=ROOT, check=True)
        traced = json.loads(file.read_text())
    with contextlib.redirect_stdout(io.StringIO()):
        pytest.main([*_QUIET, "--collect-only", *asked.tests])
    for module in asked.modules:
        place = PACKAGE / module
        sources = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
        for source in sources:  # what is imported late is not there yet
            parts = source.relative_to(PACKAGE.parent).with_suffix("").parts
            with contextlib.suppress(ImportError):  # an extra that is not installed
                import_module(".".join(parts).removesuffix(".__init__"))
        functions = _functions()
        every = [each for source in sources for each in mutants(source)]
        chosen = random.Random(asked.seed).sample(every, min(asked.count, len(every)))
        became: Counter[str] = Counter()
        for mutant in chosen:
            result = _try(mutant, _tests_of(mutant, traced), functions)
            became[result] += 1
            if result != "caught":
                where = f"{mutant.file.relative_to(PACKAGE)}:{mutant.line}"
                print(f"{result}: {where}: {mutant.kind}: {_mutated(mutant)[1]}", flush=True)
        low, high = _interval(became["caught"], len(chosen))
        print(
            f"{module}: {len(every)} mutants, {len(chosen)} tried, {became['caught']} caught"
            f" ({100.0 * became['caught'] / len(chosen):.1f} %; 95 %: {low:.1f} to {high:.1f} %),"
            f" {became['survived']} survived, {became['not reached']} not reached",
            flush=True,
        )


if __name__ == "__main__":
    main()
