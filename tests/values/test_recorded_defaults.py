"""Every default of a function, class or option, and every constant, as it was last looked at.

    python -m tests.values.test_recorded_defaults

writes `recorded_defaults.json` anew; what changed in it is to be looked at, and told to users. What
is added to a module is in it from then on by itself.
"""

from __future__ import annotations

import dataclasses
import enum
import importlib
import inspect
import json
import pkgutil
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer.errors import PopsteerError

if TYPE_CHECKING:
    from collections.abc import Iterator

pytest.importorskip("scipy")
pytest.importorskip("typer")

RECORDED = Path(__file__).with_name("recorded_defaults.json")
LEFT_OUT = ("popsteer.__main__", "popsteer._core")


HERE = str(Path(popsteer.__file__).parent)


def _said(value: Any) -> str | None:
    """Say a value so that another one reads otherwise; None where it is no plain value."""
    fields = getattr(value, "as_dict", None)
    if not inspect.isclass(value) and (fields or dataclasses.is_dataclass(value)):
        return f"{type(value).__name__} {_said(fields() if fields else vars(value))}"
    if isinstance(value, enum.Enum):
        value = f"{type(value).__name__}.{value.name}"
    if inspect.isclass(value) or inspect.isfunction(value):
        return str(value.__qualname__)
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, dict | MappingProxyType):
        value = sorted((str(k), v) for k, v in value.items())
    if isinstance(value, tuple | list | set | frozenset):
        parts = [str(_said(each)) for each in value]
        return f"({', '.join(parts if isinstance(value, tuple | list) else sorted(parts))})"
    if isinstance(value, float):
        return f"{float(value):.12g}"
    if isinstance(value, str):
        return repr(value) if len(value) < 60 and HERE not in value else None
    plain = value is None or isinstance(value, int | bytes | slice)
    return str(value) if plain else None


def _of_signature(name: str, thing: Any) -> Iterator[tuple[str, str]]:
    try:
        parameters = inspect.signature(thing).parameters.values()
    except ValueError:  # a class whose objects the library alone makes
        return
    for each in parameters:
        if each.default is not each.empty and (said := _said(each.default)) is not None:
            yield f"{name}({each.name})", said


def _of_class(name: str, kind: type) -> Iterator[tuple[str, str]]:
    if issubclass(kind, enum.Enum):
        yield from ((f"{name}.{each.name}", str(_said(each.value))) for each in kind)
        return
    if dataclasses.is_dataclass(kind):
        for field in dataclasses.fields(kind):
            if field.default_factory is not dataclasses.MISSING:
                yield f"{name}({field.name})", str(_said(field.default_factory()))
    if not getattr(kind, "_is_protocol", False):
        yield from _of_signature(name, kind)
    for member, value in vars(kind).items():
        inner = getattr(value, "__func__", value)
        if (callable(inner) and not member.startswith("__")) or member == "__call__":
            yield from _of_signature(f"{name}.{member}", inner)
        elif not member.startswith("_") and isinstance(value, int | float | tuple):
            yield f"{name}.{member}", str(_said(value))


def _of_module(module: ModuleType) -> dict[str, str]:
    found: dict[str, str] = {}
    for name, value in vars(module).items():
        home = getattr(value, "__module__", None)
        if inspect.isclass(value) and home in (module.__name__, "popsteer._core", "popsteer.sim"):
            # Those of the core are public where they are exported.
            if home == module.__name__ or name in getattr(module, "__all__", ()):
                found |= _of_class(name, value)
        elif inspect.isroutine(value):
            if home == module.__name__ or name in getattr(module, "__all__", ()):
                found |= _of_signature(name, value)
        elif name.strip("_").isupper() and name != "TYPE_CHECKING":
            said = _said(value)
            if said not in (None, "()"):  # what is filled while it runs is empty here
                found[name] = str(said)
    return found


def _options() -> dict[str, str]:
    """Each option of each command: whether it is a flag, can be repeated, and its default."""
    import typer

    from popsteer.cli.app import made

    group: Any = typer.main.get_command(made())
    return {
        f"{name} {each.opts[0]}": f"{each.metavar} {_said(each.default)}"
        f"{' flag' if getattr(each, 'is_flag', False) else ''}"
        f"{' repeated' if each.multiple else ''}{' required' if each.required else ''}"
        for name, command in group.commands.items()
        for each in command.params
        if getattr(each, "multiple", None) is not None and "--help" not in each.opts
    }


def found() -> dict[str, dict[str, str]]:
    """Give the defaults of each module that can be imported with the extras that there are."""
    whole = {"popsteer": _of_module(popsteer), "options": _options()}
    for each in pkgutil.walk_packages(popsteer.__path__, "popsteer."):
        if each.name in LEFT_OUT:
            continue
        try:
            whole[each.name] = _of_module(importlib.import_module(each.name))
        except (ImportError, PopsteerError):
            assert each.name.startswith(("popsteer.adapters", "popsteer.lab", "popsteer.plants"))
    return whole


def test_defaults_and_constants_are_the_recorded_ones() -> None:
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    # What has moved to another module is what it was; what was added since is not compared.
    anywhere: dict[str, set[str]] = {}
    for names in recorded.values():
        for name, value in names.items():
            anywhere.setdefault(name, set()).add(value)
    compared, changed = 0, []
    for module, names in found().items():
        for name, value in names.items():
            known = recorded.get(module, {}).get(name)
            allowed = anywhere.get(name, {value}) if known is None else {known}
            compared += name in anywhere
            if value not in allowed:
                changed.append(f"{module}: {name} is {value}, was {', '.join(sorted(allowed))}")
    assert changed == []
    assert compared > 2000


if __name__ == "__main__":
    text = json.dumps({k: v for k, v in found().items() if v}, indent=0, ensure_ascii=False)
    RECORDED.write_text(text + "\n", encoding="utf-8")
