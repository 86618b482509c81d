"""The names of all that can be compared, and what vehicles differ in, in words."""

from __future__ import annotations

from collections.abc import Iterable

from popsteer import controllers, own
from popsteer._core import Vehicle
from popsteer.lab import baselines
from popsteer.ranges import check_known


def controller_names() -> tuple[str, ...]:
    """Names of all that can be compared: the controllers of popsteer, then the baselines."""
    return (*controllers.names(), *baselines.names())


def law_of(name: str) -> controllers.Law | baselines.Baseline:
    """Give a controller of popsteer, a baseline or one of your own; ConfigError for no other."""
    if name in controllers.names():
        return controllers.get(name)
    if not own.is_named("controller", name):
        check_known("controller", name, controller_names())
    return baselines.get(name)


def title_of(law: str, among: Iterable[str] = ()) -> str:
    """Name of a controller as a person reads it; of one's own that of its class, if it is free.

    It is not where a shipped one has it, or another of those `among` which it is shown.
    """
    shipped = {name: law_of(name).title for name in controller_names()}
    title = own.title(law)
    taken = {*shipped.values(), *(own.title(each) for each in among if each != law)}
    return shipped.get(law, law if title in taken else title)


def differences(believed: Vehicle, vehicle: Vehicle) -> str:
    """Say, behind the name of a plant, in what the vehicle believed differs from the real one."""
    is_so = vehicle.as_dict()
    different = [
        f"{name} {'none' if value is None else format(value, 'g')}"
        for name, value in believed.as_dict().items()
        if value != is_so[name]
    ]
    return f", believed {' and '.join(different)}" if different else ""


def where_they_differ(said: Iterable[tuple[tuple[str, ...], str]]) -> list[str]:
    """Give the sentences of several places, each once; with its places where not all say the same.

    A place has parts, such as plant and track; one part is named where it tells the sentence alone.

    Examples
    --------
    >>> where_they_differ([(("slalom",), "Starts at rest."), (("circle",), "Starts at rest.")])
    ['Starts at rest.']
    >>> where_they_differ([(("car", "slalom"), "At 2 m/s."), (("car", "circle"), "At 3 m/s.")])
    ['On slalom: at 2 m/s.', 'On circle: at 3 m/s.']
    """
    rows = list(said)
    whole = tuple(range(max((len(place) for place, _ in rows), default=0)))
    for parts in ((), *((part,) for part in whole), whole):
        told = dict.fromkeys((", ".join(place[k] for k in parts), each) for place, each in rows)
        if len({place for place, _ in told}) == len(told):
            break
    if not parts:
        return [sentence for _, sentence in told]
    places: dict[str, list[str]] = {}
    for place, sentence in told:
        places.setdefault(sentence, []).append(place)
    return [
        f"On {'; '.join(own)}: {sentence[0].lower()}{sentence[1:]}"
        for sentence, own in places.items()
    ]


def counted(number: int, what: str) -> str:
    """Say how many there are of something."""
    return f"{number} {what}{'' if number == 1 else 's'}"
