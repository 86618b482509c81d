"""Lists what popsteer is built from and what it uses, with licences.

python -m docs.site.licences     # writes docs/licences.md
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, metadata, requires
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "licences.md"
# Crates whose code is in the wheel, in the C library, or in both.
SHIPPED = ("popsteer-py", "popsteer-c")
ABSENT = "not installed where this was written"
_SUMMARY = 40  # characters; longer is the text of a licence, not its name


def crates() -> tuple[dict[str, str], dict[str, str]]:
    """List the crates that are shipped, and those of builds and tests, with their licences."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--offline"]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    found = json.loads(done.stdout)
    packages = {each["id"]: each for each in found["packages"]}
    nodes = {each["id"]: each for each in found["resolve"]["nodes"]}

    def reached(roots: list[str], kinds: set[str | None]) -> set[str]:
        seen: set[str] = set()
        todo = list(roots)
        while todo:
            package = todo.pop()
            if package not in seen:
                seen.add(package)
                todo += [
                    each["pkg"]
                    for each in nodes[package]["deps"]
                    if any(kind["kind"] in kinds for kind in each["dep_kinds"])
                ]
        return seen

    members = set(found["workspace_members"])
    roots = [each for each in members if packages[each]["name"] in SHIPPED]
    shipped = reached(roots, {None}) - members
    others = reached(sorted(members), {None, "dev", "build"}) - members - shipped

    def licences(ids: set[str]) -> dict[str, str]:
        rows = ((packages[each]["name"], packages[each]["license"] or "-") for each in ids)
        return {name: licence.replace("/", " OR ") for name, licence in sorted(rows)}

    return licences(shipped), licences(others)


def _licence(package: str) -> str:
    try:
        said: Any = metadata(package)
    except PackageNotFoundError:
        return ABSENT
    expression = said.get("License-Expression")
    if expression:
        return str(expression)
    classifiers = [each for each in said.get_all("Classifier") or [] if "License ::" in each]
    if classifiers:
        return " AND ".join(each.rpartition(":: ")[2] for each in classifiers)
    text = str(said.get("License") or "")
    return text if 0 < len(text) <= _SUMMARY and "\n" not in text else "-"


def _name(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement, maxsplit=1)[0].lower()


def asked_for() -> dict[str, list[str]]:
    """List the packages that popsteer names itself, each with the extras that bring it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = {"": project["dependencies"], **project["optional-dependencies"]}
    found: dict[str, list[str]] = {}
    for extra, requirements in groups.items():
        for name in map(_name, requirements):
            if name != "popsteer":
                found.setdefault(name, []).append(extra)
    return dict(sorted(found.items()))


def _brought() -> list[str]:
    """List what the named packages need in turn, where they are installed."""
    named = list(asked_for())
    seen, todo = set(named), list(named)
    while todo:
        try:
            needed = requires(todo.pop()) or []
        except PackageNotFoundError:
            continue
        for name in (_name(each) for each in needed if "extra ==" not in each):
            if name not in seen:
                seen.add(name)
                todo.append(name)
    return sorted(seen - set(named))


def _table(rows: dict[str, str]) -> list[str]:
    return ["| package | licence |", "|---|---|", *(f"| {a} | {b} |" for a, b in rows.items())]


def page() -> str:
    """Write the page."""
    shipped, others = crates()
    named = asked_for()
    lines = [
        "# Licences",
        "",
        "popsteer is under the MIT licence. This page lists what it is built from and what it",
        "uses. `python -m docs.site.licences` writes it; `make audit` checks the crates by",
        "`rust/deny.toml`.",
        "",
        "## Rust crates in the wheel and the C library",
        "",
        *_table(shipped),
        "",
        "## Python packages that popsteer names",
        "",
        "None of them is part of popsteer's wheel: pip installs them. Without an extra these are",
        "numpy, and tomli before Python 3.11. A dash: the package states none in its metadata.",
        "",
        "| package | extras | licence |",
        "|---|---|---|",
        *(
            f"| {name} | {', '.join(extra or 'always' for extra in extras)} | {_licence(name)} |"
            for name, extras in named.items()
        ),
        "",
        "## What these bring",
        "",
        *_table({name: said for name in _brought() if (said := _licence(name)) != ABSENT}),
        "",
        "## Rust crates of builds and tests",
        "",
        "In no binary that is shipped.",
        "",
        *_table(others),
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write docs/licences.md."""
    os.environ.setdefault("CARGO_TERM_COLOR", "never")
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")


if __name__ == "__main__":
    main()
