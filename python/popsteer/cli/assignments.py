"""Parameters set by name, and listed with what they mean."""

from __future__ import annotations

import inspect
import re
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from typing_extensions import Self

__all__ = ["assigned", "listed"]

_TRUTH = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


class _Params(Protocol):
    def as_dict(self) -> dict[str, Any]: ...
    def replace(self, **changes: Any) -> Self: ...  # noqa: ANN401


_P = TypeVar("_P", bound=_Params)


def assigned(params: _P, assignments: Sequence[str], owner: str) -> _P:
    """Change parameters as assignments say.

    Parameters
    ----------
    params : any class of parameters
        What is to be changed; it stays as it is.
    assignments : sequence of str
        ``NAME=VALUE`` each; of two for one name the later counts.
    owner : str
        Whose parameters they are, for messages.

    Returns
    -------
    same as `params`
        A changed copy.

    Raises
    ------
    ConfigError
        A name is not known, or a value is not of its kind or out of its range.

    Examples
    --------
    >>> import popsteer
    >>> assigned(popsteer.PopParams(), ["lookahead_gain=0.3"], "pop").lookahead_gain
    0.3
    >>> assigned(popsteer.PopParams(), ["gain=0.3"], "pop")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: unknown parameter of pop 'gain'; known: lookahead_gain, \
min_lookahead, steer_span, candidate_count, lookahead_tolerance, window_ahead, grid_spacing, \
wheelbase, reference_offset, max_steer
    """
    known = params.as_dict()
    changes: dict[str, Any] = {}
    for assignment in assignments:
        name, equals, text = (part.strip() for part in assignment.partition("="))
        if not equals:
            raise ConfigError(f"a parameter of {owner}", assignment, "written NAME=VALUE")
        if name not in known:
            raise ConfigError.unknown(f"parameter of {owner}", name, known)
        changes[name] = _value(name, text, known[name])
    return params.replace(**changes) if changes else params


def _value(name: str, text: str, default: object) -> object:
    """Read a value of the kind that the default is of."""
    if isinstance(default, bool):
        if text.lower() not in _TRUTH:
            raise ConfigError(name, text, "true or false")
        return _TRUTH[text.lower()]
    kind = int if isinstance(default, int) else float
    try:
        return kind(text)
    except ValueError:
        raise ConfigError(name, text, "a whole number" if kind is int else "a number") from None


def listed(kind: type[object]) -> str:
    """List the parameters of a class, as its documentation has them.

    Parameters
    ----------
    kind : type
        A class of parameters.

    Returns
    -------
    str
        Two lines for each: name and default, and what it means.

    Examples
    --------
    >>> import popsteer
    >>> print(listed(popsteer.CoupledLongitudinalParams).splitlines()[0])
      cutoff : float, default 0.5
    """
    document = inspect.getdoc(kind) or ""
    _, _, rest = document.partition("Parameters\n----------\n")
    entries = re.split(r"\n\n", rest, maxsplit=1)[0]
    return "\n".join(f"  {line}" for line in entries.splitlines())
