"""Docstrings as the site shows them: read by griffe, which makes the pages of the API."""

from __future__ import annotations

import inspect
import re
from typing import Any

import griffe

from popsteer import _core

MODULE = f"{_core.__name__}."
# An example, with what it prints, up to the next empty line.
_DOCTEST = re.compile(r"^>>> .*(?:\n.+)*", re.MULTILINE)


class CoreDocs(griffe.Extension):
    """Takes signatures from the stub of the compiled module and docstrings from the module."""

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
