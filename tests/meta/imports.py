"""Who imports whom: the imports of each source file, in Rust and in Python.

A *module* is a source file, by a name with dots: `path.locate` is `path/locate.rs` or
`path/locate.py`, `path` is `path/mod.rs` or `path/__init__.py`, and the root of a crate is its own
name. An import of a name that a package only passes on counts as one of the module that defines it,
and passing names on is not an import.
"""

from __future__ import annotations

import ast
import re
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

Graph = dict[str, set[str]]
Sources = dict[str, str]

_COMMENT = re.compile(r"//[^\n]*")
_TESTS = re.compile(
    r"#\[cfg\(test\)\]\s*(?:pub(?:\([^)]*\))?\s+)?mod\s+\w+\s*(?:;|\{.*?^\})",
    re.DOTALL | re.MULTILINE,
)
_USE = re.compile(r"(?:^|\n)\s*(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);")
_PATH = re.compile(r"\b(crate|super|self|[a-z]+(?:_[a-z]+)+)((?:::\w+)+)")


def sources(folder: Path, root: str) -> Sources:
    """Read the source files below `folder`, by the names of their modules."""
    found = {}
    for file in sorted(folder.rglob("*.*")):
        # Tests of a module that is too long for them, and what several tests need.
        if file.suffix not in (".rs", ".py") or file.name in ("tests.rs", "fixtures.rs"):
            continue
        parts = list(file.relative_to(folder).with_suffix("").parts)
        if parts[-1] in ("mod", "lib", "__init__"):
            parts.pop()
        found[".".join((root, *parts))] = file.read_text(encoding="utf-8")
    return found


def rust_graph(crates: Sources) -> Graph:
    """Say for each module of crates which modules it uses, tests left out."""
    code = {name: _TESTS.sub("", _COMMENT.sub("", text)) for name, text in crates.items()}
    passed_on: dict[str, str] = {}
    used: dict[str, list[str]] = {}
    for module, text in code.items():
        used[module] = []
        rest = text
        for statement in _USE.finditer(text):
            rest = rest.replace(statement[0], "\n", 1)
            for path, name in _leaves(re.sub(r"\s+", "", statement[2])):
                target = _absolute(path, module, code)
                if target is None:
                    continue
                if statement[1] and target.startswith(f"{module}."):
                    passed_on[f"{module}.{name}"] = target
                else:
                    used[module].append(target)
        for inline in _PATH.finditer(rest):
            target = _absolute(inline[0].split("::"), module, code)
            if target is not None:
                used[module].append(target)
    return _resolved(used, passed_on)


def _leaves(tree: str) -> Iterator[tuple[list[str], str]]:
    """Take a use tree apart: each path in it, and the name that it brings."""
    head, brace, inner = tree.partition("{")
    if not brace:
        path, _, renamed = tree.partition(" as ")
        parts = path.split("::")
        yield parts, renamed or parts[-1]
        return
    depth, start, inner = 0, 0, inner.rpartition("}")[0]
    for end, sign in enumerate(f"{inner},"):
        depth += (sign == "{") - (sign == "}")
        if sign == "," and depth == 0:
            leaf, start = inner[start:end], end + 1
            if leaf:
                path = head.rstrip(":") if leaf == "self" else head + leaf
                yield from _leaves(path)


def _absolute(path: list[str], module: str, known: Mapping[str, str]) -> str | None:
    """Name a path from the root of its crate on; None where it leads out of the crates known."""
    first, *rest = path
    crate = module.split(".", maxsplit=1)[0]
    if first == "crate":
        return ".".join((crate, *rest))
    if first == "self":
        return ".".join((module, *rest))
    if first == "super":
        parent = module.rpartition(".")[0]
        is_above = rest[:1] == ["super"]
        return _absolute(rest, parent, known) if is_above else ".".join((parent, *rest))
    if f"{module}.{first}" in known:
        return ".".join((module, *path))
    return ".".join(path) if first in known else None


@cache
def import_statements(text: str) -> list[ast.Import | ast.ImportFrom]:
    """Find the imports in a source file, also those inside functions and for types alone."""
    nodes = ast.walk(ast.parse(text))
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


def python_graph(package: Sources) -> Graph:
    """Say for each module of a package which modules it imports, for its types alone as well."""
    passed_on: dict[str, str] = {}
    used: dict[str, list[str]] = {}
    for module, text in package.items():
        used[module] = []
        is_package = any(name.startswith(f"{module}.") for name in package)
        for node in import_statements(text):
            if isinstance(node, ast.Import):
                used[module] += [alias.name for alias in node.names]
            else:
                own = module.split(".")  # `from .` is the package's, of which a module is a part
                above = own[: len(own) + is_package - node.level] if node.level else []
                for alias in node.names:
                    target = ".".join((*above, *filter(None, (node.module,)), alias.name))
                    if is_package and target.startswith(f"{module}."):
                        passed_on[f"{module}.{alias.asname or alias.name}"] = target
                    # `import a as a` passes a name on, to type checkers alone: `popsteer` loads
                    # its modules when they are asked for.
                    if alias.asname != alias.name:
                        used[module].append(target)
    return _resolved(used, passed_on)


def _resolved(used: Mapping[str, list[str]], passed_on: Mapping[str, str]) -> Graph:
    """Replace each name by the module that defines it; names from elsewhere go."""
    graph: Graph = {module: set() for module in used}
    for module, names in used.items():
        for name in names:
            target = name
            for _ in range(len(passed_on)):
                owner = _longest(target, passed_on)
                if owner is None:
                    break
                target = passed_on[owner] + target.removeprefix(owner)
            found = _longest(target, used)
            if found is not None and found != module:
                graph[module].add(found)
    return graph


def _longest(name: str, known: Mapping[str, object]) -> str | None:
    """Find the longest start of a dotted name that is known."""
    while name and name not in known:
        name = name.rpartition(".")[0]
    return name or None


def upward(graph: Graph, allowed: Mapping[str, set[str]]) -> list[str]:
    """List the imports from one part of the table into another that the table does not allow.

    A part is a module with all below it; a module belongs to the longest part that holds it.
    """
    found = []
    for module, targets in sorted(graph.items()):
        part = _longest(module, allowed)
        if part is None:
            found.append(f"{module} is in no part of the table")
            continue
        for target in sorted(targets):
            other = _longest(target, allowed)
            if other != part and other not in allowed[part]:
                found.append(f"{module} imports {target}: {part} may not know {other}")
    return found


def circles(graph: Graph) -> list[list[str]]:
    """List the groups of modules that import each other in a circle, the smallest first."""

    def reached(module: str) -> set[str]:
        found: set[str] = set()
        pending = list(graph[module])
        while pending:
            target = pending.pop()
            if target not in found:
                found.add(target)
                pending += graph[target]
        return found

    beyond = {module: reached(module) for module in graph}
    groups = {
        tuple(sorted(other for other in beyond[module] if module in beyond[other]))
        for module in graph
        if module in beyond[module]
    }
    return sorted((list(group) for group in groups), key=len)
