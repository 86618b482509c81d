"""Parameters set by name, and what their documentation says of them."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

from popsteer.errors import ConfigError
from popsteer.ranges import check_known

_TRUTH = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
_SETTABLE = (bool, int, float, str)  # what a text can be the value of


_P = TypeVar("_P")


def pairs(
    option: str, given: Sequence[str] | None, form: str = "NAME=VALUE", *, whole: bool = False
) -> Iterator[tuple[str, str]]:
    """Split ``NAME=VALUE`` each; ConfigError where a sign, or of a `whole` pair a part, is missing.

    `form` says in messages how one is written.
    """
    for each in given or []:
        name, sign, value = (part.strip() for part in each.partition("="))
        if not sign or (whole and not (name and value)):
            raise ConfigError(option, each, f"written {form}")
        yield name, value


def assigned(params: _P, assignments: Sequence[str] | None, owner: str) -> _P:
    """Give a copy of parameters, changed as `assigned_each` has it."""
    changed: _P = assigned_each([params], assignments, owner)[0]
    return changed


def assigned_each(parts: Sequence[Any], assignments: Sequence[str] | None, owner: str) -> list[Any]:
    """Give copies of several sets of parameters: each assignment changes those that have its name.

    The assignments are ``NAME=VALUE`` each, with ``none`` for None; of two for one name the later
    counts. `owner` says in messages whose parameters they are. Only numbers, truth values, texts
    and None can be set. Sets of which nothing was named are the same objects.
    """
    known = [
        {k: v for k, v in each.as_dict().items() if v is None or isinstance(v, _SETTABLE)}
        for each in parts
    ]
    names = list(dict.fromkeys(name for fields in known for name in fields))
    changes: list[dict[str, Any]] = [{} for _ in parts]
    for name, text in pairs(f"a parameter of {owner}", assignments):
        check_known(f"parameter of {owner}", name, names)
        for fields, changed in zip(known, changes, strict=True):
            if name in fields:
                changed[name] = _value(name, text, fields[name])
    return [_replaced(params, changed) for params, changed in zip(parts, changes, strict=True)]


def _replaced(params: Any, changes: dict[str, Any]) -> Any:  # noqa: ANN401 - any parameters
    """Give a changed copy; of one that must not be None say so."""
    if not changes:
        return params
    try:
        return params.replace(**changes)
    except TypeError:
        for name, value in changes.items():
            if value is None:
                raise ConfigError(name, "none", "a number") from None
        raise


def _value(name: str, text: str, default: object) -> object:
    """Read a value of the kind that the default is of."""
    if text.lower() == "none":
        return None
    if isinstance(default, bool):
        if text.lower() not in _TRUTH:
            raise ConfigError(name, text, "true or false")
        return _TRUTH[text.lower()]
    if isinstance(default, str):
        return text
    kind = int if isinstance(default, int) else float
    try:
        return kind(text)
    except ValueError:
        raise ConfigError(name, text, "a whole number" if kind is int else "a number") from None


def described(kind: type[object]) -> dict[str, tuple[str, str]]:
    """Give what the documentation of a class says of each parameter: its text, and its range.

    Defaults, which stand there as the declaration has them, are left out.
    """
    _, _, rest = (inspect.getdoc(kind) or "").partition("Parameters\n----------\n")
    entries = re.split(r"\n\n", rest, maxsplit=1)[0]
    found = {}
    for entry in re.split(r"\n(?=\S)", entries):
        name, _, text = entry.partition("\n")
        text = re.sub(r" [Bb]y default `[^`]*`\.", "", " ".join(text.split()))
        text, _, ends = text.partition(" In [")
        low_high = " to ".join(map(_end, ends.removesuffix("].").split(","))) if ends else ""
        found[name.partition(" : ")[0]] = text, low_high
    return found


def _end(text: str) -> str:
    """Word the end of a range that a declaration has as ``0.5 * PI`` or ``- 1e3``, or by a name."""
    plain, pi, _ = text.replace(" ", "").replace("*", "").replace("_", "").partition("PI")
    try:
        return f"{float(plain or 1.0) * (math.pi if pi else 1.0):g}"
    except ValueError:
        return text.strip()
