"""TOML files of popsteer: written with what each key means, read, and refused by their name.

`keys`, `table` and `worded` are all that popsteer has of a writer: `Vehicle.save` and those of the
parameters belong to the base install, which has numpy alone, and a library would spare `worded`.
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
import textwrap
from typing import TYPE_CHECKING, Any

from popsteer.errors import ConfigError
from popsteer.files import read_bytes

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["check", "in_file", "keys", "read", "tomllib"]


def read(file: str | os.PathLike[str], kind: str) -> dict[str, Any]:
    """Read the keys and tables of a TOML file; `kind` says in an error what it should be.

    Raises ConfigError, which names the file, where it cannot be read or is no TOML.
    """
    try:
        return tomllib.loads(read_bytes(file).decode("utf-8"))
    except OSError as error:
        why = error.strerror or str(error)
    except UnicodeDecodeError as error:
        why = f"not UTF-8 at byte {error.start}"
    except (ValueError, RecursionError) as error:  # broken, too long a number, or nested too deep
        why = f"not TOML: {error}"
    refused = ConfigError(kind, os.fspath(file), f"a readable TOML file: {why}")
    raise in_file(file, refused, why)


def check(
    file: str | os.PathLike[str],
    fields: Mapping[str, Any],
    defaults: Mapping[str, Any],
    of: str = "",
) -> None:
    """Refuse keys that have no default, and values of another type; `of` is their table."""
    for key, value in fields.items():
        if key not in defaults:
            what = f"key of [{of}]" if of else "key"
            raise in_file(file, ConfigError.unknown(what, key, defaults))
        kind: Any = type(defaults[key])
        wanted = {bool: "true or false", int: "a whole number", str: "text"}.get(kind, "a number")
        fits = isinstance(value, kind if kind in (bool, int, str) else int | float)
        if not fits or (isinstance(value, bool) and kind is not bool):
            raise in_file(file, ConfigError(f"{of}.{key}" if of else key, value, wanted))


def in_file(
    file: str | os.PathLike[str], error: ConfigError, words: str | None = None
) -> ConfigError:
    """Put the file before the words of an error."""
    error.args = (f"{os.fspath(file)}: {error if words is None else words}",)
    return error


def keys(
    params: Any,  # noqa: ANN401 - a class of parameters of the core
    unknown: Mapping[str, str] | None = None,
    said: Mapping[str, str] | None = None,
) -> list[str]:
    """Word parameters as lines of a table, each key below a comment with its meaning and unit.

    A key that is None by default and has no value is a comment: left out, it is None. One with
    another default is inf then. An `unknown` key has the reason above it, and is a comment where
    its value is the default. Where anything is `said` of keys, each has it above, or whether it was
    given or is the default; then it is a comment.
    """
    unknown = unknown or {}
    kind = type(params)
    defaults = kind().as_dict()
    lines = []
    for key, value in params.as_dict().items():
        meaning = getattr(kind, key).__doc__
        lines += textwrap.wrap(meaning, 100, initial_indent="# ", subsequent_indent="# ")
        if key in unknown:
            lines += textwrap.wrap(f"# NOT FOUND: {unknown[key]}", 100, subsequent_indent="# ")
        elif said is not None:
            word = "default" if value == defaults[key] else "given"
            lines.append(f"# {said.get(key, word)}")
        if value is None:
            lines.append(f"# {key} =" if defaults[key] is None else f"{key} = inf")
        else:
            stands = key not in unknown if said is None else key in said
            comment = "" if stands or value != defaults[key] else "# "
            lines.append(f"{comment}{key} = {worded(value)}")
    return lines


def table(name: str, values: Mapping[str, Any]) -> str:
    r"""Word values as a table; one that TOML does not have, as None, is a comment.

    Examples
    --------
    >>> print(table("mine.py:Mpc", {"gain": 1.5, "gains": (1, 2), "limit": None}), end="")
    ["mine.py:Mpc"]
    gain = 1.5
    # gains = (1, 2)
    # limit =
    """
    lines = [f"[{_key(name)}]"]
    for key, value in values.items():
        if hasattr(value, "as_dict"):
            given = {k: v for k, v in value.as_dict().items() if v is not None}
            inner = ", ".join(f"{_key(k)} = {worded(v)}" for k, v in given.items())
            lines.append(f"{_key(key)} = {{ {inner} }}")
        elif isinstance(value, bool | int | float | str):
            lines.append(f"{_key(key)} = {worded(value)}")
        else:
            said = "" if value is None else repr(value)
            lines.append(" ".join(["#", _key(key), "=", *said.split()]))
    return "\n".join(lines) + "\n"


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else worded(key)


def worded(value: bool | float | str) -> str:  # noqa: FBT001 - a value, no switch
    r"""Word a value as TOML.

    Examples
    --------
    >>> print(worded(True), worded(float("inf")), worded('a "b"'))
    true inf "a \"b\""
    """
    if isinstance(value, float) and not math.isfinite(value):
        return str(float(value))
    # JSON's, but for the one control character that it lets stand in strings.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
