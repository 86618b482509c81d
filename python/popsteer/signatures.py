"""Signatures that show the defaults: those that the extension module computes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from inspect import Signature


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

    The extension module writes down a default only where it is a literal; what a value is made of
    is told by one that was made of nothing. The `as_dict` of a class has its parameters in order:
    ``vehicle`` first where there is one, and everything else by name alone.
    """
    for kind in classes:
        kind.__signature__ = _Shown()
