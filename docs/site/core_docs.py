"""Docstrings as the site shows them: read by griffe, which makes the pages of the API."""

from __future__ import annotations

import copy
import inspect
import re
from typing import Any

import griffe

from popsteer import _core

MODULE = f"{_core.__name__}."
# An example, with what it prints, up to the next empty line.
_DOCTEST = re.compile(r"^>>> .*(?:\n.+)*", re.MULTILINE)


# The type variables of the stub's private bases, in their order.
_VARIABLES = ("_ParamsT", "_StateT")


class CoreDocs(griffe.Extension):
    """Takes signatures from the stub of the compiled module and docstrings from the module."""

    def on_class_members(self, *, cls: griffe.Class, **__: Any) -> None:  # noqa: ANN401 - griffe's
        """Give a class of the stub what its private bases say: at run time it has that itself."""
        if not cls.path.startswith(MODULE) or cls.parent is None:
            return
        for base in cls.bases:
            name, _, given = str(base).rstrip("]").partition("[")
            types = dict(zip(_VARIABLES, given.split(", "), strict=False)) if given else {}
            source = cls.parent.members.get(name) if name.startswith("_") else None
            for member in source.members.values() if source is not None else ():
                if member.name not in cls.members:
                    made = _of_class(member, types)
                    cls.set_member(member.name, made)
                    self.on_object(obj=made)

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:  # noqa: ANN401 - griffe's
        """Give an object of the stub the docstring that `help()` shows; fence bare examples."""
        if obj.docstring is None and obj.path.startswith(MODULE):
            thing: Any = _core
            for name in obj.path.removeprefix(MODULE).split("."):
                thing = getattr(thing, name, None)
            # What an attribute's type says of itself is no documentation of the attribute.
            said = None if thing is None else thing.__doc__
            if said is not None and said != type(thing).__doc__:
                obj.docstring = griffe.Docstring(inspect.cleandoc(said), parent=obj)
        # Under "Examples" griffe finds them by itself; elsewhere they would be quotations.
        if obj.docstring is not None and "\n--------" not in obj.docstring.value:
            obj.docstring.value = _DOCTEST.sub(r"```pycon\n\g<0>\n```", obj.docstring.value)


def _of_class(member: Any, types: dict[str, str]) -> Any:  # noqa: ANN401 - a griffe object
    """Copy a member of a private base, with the types that the class gives it."""

    def named(annotation: object) -> str | None:
        if annotation is None:
            return None
        text = str(annotation)
        for variable, kind in types.items():
            text = text.replace(variable, kind)
        return text

    made = copy.copy(member)
    made.docstring = None
    if made.is_function:
        made.parameters = griffe.Parameters(*(copy.copy(each) for each in member.parameters))
        for each in made.parameters:
            each.annotation = named(each.annotation)
        made.returns = named(member.returns)
    elif made.is_attribute:
        made.annotation = named(member.annotation)
    return made
