"""A controller's tuning in a TOML file: what `load` of its parameters reads and `save` writes.

A file has a table a controller, under its name, and nothing else. What a table leaves out has its
default. ``import popsteer`` loads this module, so what reads and writes files is loaded when asked.

Examples
--------
>>> print(as_toml(popsteer.PopParams(min_lookahead=6.0)), end="")  # doctest: +ELLIPSIS
# Tuning of a controller, as popsteer.PopParams.load reads it. ...
[pop]
# Velocity constant `k_v` [s]: `lookahead = min_lookahead + lookahead_gain * speed`.
lookahead_gain = 0.2
# Lookahead at rest `ld_min` [m].
min_lookahead = 6.0
...
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer import controllers
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    import os
    from collections.abc import Collection
    from inspect import Signature

    from popsteer.controllers import Params

_HEAD = """\
# Tuning of a controller, as {kind} reads it. SI units and radians. What is
# left out has its default, which may scale with the vehicle.
"""


def load_all(file: str | os.PathLike[str], named: Collection[str] = ()) -> dict[str, Params]:
    r"""Read the tuning of the controllers that a TOML file has, by name, in the order of the file.

    Code of one's own is run only if it is `named`: a file alone makes none run. Raises ConfigError,
    which names file, table, key and value, where the file cannot be read or is no TOML, or has no
    controller or an unknown one, or an unknown key or a wrong value.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "tuned.toml"
    ...     _ = file.write_text("[pop]\nlookahead_gain = 0\n[preview_pop]\nhorizon = 0.8\n")
    ...     found = load_all(file)
    >>> found["pop"].lookahead_gain, found["preview-pop"].horizon
    (0.0, 0.8)
    """
    from popsteer import own
    from popsteer.toml_file import check, in_file, read

    document = read(file, "tuning file")
    found: dict[str, Params] = {}
    for table, fields in document.items():
        mine = own.is_named("controller", table)
        name = table if mine else table.replace("_", "-")
        if not mine and name not in controllers.names():
            known = [each.replace("-", "_") for each in controllers.names()]
            raise in_file(file, ConfigError.unknown("table", table, known))
        if not isinstance(fields, dict):
            raise in_file(file, ConfigError(table, fields, f"a table of parameters, [{table}]"))
        if own.is_reference(name) and name not in named:
            wanted = "code of your own that the command line names as a controller"
            raise in_file(file, ConfigError("table", table, wanted))
        kind: Any = (
            controllers.get(name).params
            if name in controllers.names()
            else own.params_of(own.load("controller", name))
        )
        check(file, fields, kind().as_dict(), table)
        try:
            found[name] = kind(**fields)
        except ConfigError as error:
            raise in_file(file, error, f"[{table}] {error}") from None
    if not found:
        listed = ", ".join(f"[{each.replace('-', '_')}]" for each in controllers.names())
        raise in_file(file, ConfigError("tables", "none", f"at least one of {listed}"))
    return found


def as_toml(params: Params, name: str | None = None) -> str:
    """Word a controller's tuning as TOML, under `name` if given; None becomes a comment."""
    from popsteer import own
    from popsteer.toml_file import keys, table

    kind = f"popsteer.{type(params).__name__}.load"
    if name is not None and own.is_named("controller", name):
        return _HEAD.format(kind="popsteer --params") + table(name, params.as_dict())
    named = controllers.name_of(type(params)).replace("-", "_")
    return "\n".join([_HEAD.format(kind=kind) + f"[{named}]", *keys(params)]) + "\n"


def add_load_and_save(*kinds: type[Any]) -> None:
    """Give classes of parameters of controllers the methods ``load`` and ``save``.

    Examples
    --------
    >>> popsteer.StanleyParams.load("nowhere.toml")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: nowhere.toml: No such file or directory
    """
    for kind in kinds:
        kind.load = classmethod(load)
        kind.save = save


def load(cls: type[Params], file: str | os.PathLike[str]) -> Params:
    """Read the tuning from a TOML file; it may hold that of other controllers, too.

    Parameters
    ----------
    file : str or os.PathLike
        The file, with a table under the name of the controller.

    Returns
    -------
    parameters of the same class
        What the file says; what it leaves out has its default.

    Raises
    ------
    ConfigError
        The file cannot be read, or holds none of this controller, or something that is unknown,
        of the wrong type or out of range; names file, key and value.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     popsteer.PidParams(kp=0.3).save(Path(folder) / "tuned.toml")
    ...     popsteer.PidParams.load(Path(folder) / "tuned.toml").kp
    0.3
    """
    from popsteer.toml_file import in_file

    name = controllers.name_of(cls)
    found = load_all(file)
    if name not in found:
        wanted = f"{name}, whose parameters these are"
        raise in_file(file, ConfigError("controller", ", ".join(found), wanted))
    return found[name]


def save(self: Params, file: str | os.PathLike[str]) -> None:
    """Write the tuning to a TOML file, whole or not at all.

    Parameters
    ----------
    file : str or os.PathLike
        The file to write; folders that are missing are made. What stood there is replaced.

    Raises
    ------
    OSError
        The file cannot be written; what stood there before still does.
    """
    from popsteer.files import write_text_atomic

    write_text_atomic(file, as_toml(self))


class _Shown:
    """The signature of a class, made when it is asked for: importing inspect takes its time."""

    def __get__(self, _: object, kind: type[Any]) -> Signature:
        from inspect import Parameter, Signature

        return Signature(
            [
                # Left out, the vehicle is that of the plant, of which the class tells.
                Parameter(name, Parameter.POSITIONAL_OR_KEYWORD, default=None)
                if name == "vehicle"
                else Parameter(name, Parameter.KEYWORD_ONLY, default=value)
                for name, value in kind().as_dict().items()
            ]
        )


def spell_out(*classes: type[Any]) -> None:
    """Give classes of values a signature with the defaults that they have.

    The extension module writes down a default only where it is a literal; the others are those of
    a value that was made of nothing. Of its fields ``vehicle`` alone is taken by place.
    """
    for kind in classes:
        kind.__signature__ = _Shown()
