"""The names of all that can be compared, for programs and for people."""

from __future__ import annotations

from popsteer import controllers, own
from popsteer.lab import baselines


def controller_names() -> tuple[str, ...]:
    """Names of all that can be compared: the controllers of popsteer, then the baselines."""
    return (*controllers.names(), *baselines.names())


def title_of(law: str) -> str:
    """Name of a controller as a person reads it; that of one's own is as it is."""
    if law in baselines.names():
        return baselines.get(law).title
    return controllers.get(law).title if law in controllers.names() else own.title(law)
