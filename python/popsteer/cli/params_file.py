"""Parameters of a controller from a TOML file."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from popsteer import controllers
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["read_params"]


def read_params(file: Path) -> tuple[str, Any]:
    r"""Read the parameters of a controller.

    Parameters
    ----------
    file : pathlib.Path
        A TOML file: ``controller`` names the controller; the other keys, or those of a table
        ``params``, are its parameters.

    Returns
    -------
    tuple
        The controller's name and its parameters.

    Raises
    ------
    ConfigError
        The file cannot be read, or a name or a value is not one of the controller's.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "tuned.toml"
    ...     _ = file.write_text('controller = "pop"\nlookahead_gain = 0.3\n')
    ...     read_params(file)[1].lookahead_gain
    0.3
    """
    try:
        document = tomllib.loads(file.read_bytes().decode("utf-8"))
    except OSError as error:
        raise ConfigError("--params", str(file), f"readable: {error.strerror}") from error
    except ValueError as error:
        raise ConfigError("--params", str(file), f"a TOML file: {error}") from error
    name = document.pop("controller", None)
    if not isinstance(name, str):
        raise ConfigError("--params", str(file), 'a file with controller = "NAME"')
    given = document.get("params", document)
    law = controllers.get(name)
    known: dict[str, Any] = law.params().as_dict()
    for key in given:
        if key not in known:
            raise ConfigError.unknown(f"parameter of {name}", key, known)
    try:
        return name, law.params(**given)
    except TypeError as error:
        raise ConfigError("--params", str(file), f"with numbers for {name}: {error}") from error
