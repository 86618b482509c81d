"""What a controller remembers, as one immutable value."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn, final

if TYPE_CHECKING:
    from typing_extensions import Self

_SEGMENT_OF_PLACE = ("waypoint", "measured_waypoint")
"""What `place.segment` was called up to version 0.3, when measured and predicted vehicle had one
each; still readable."""


@final
class State:
    """What a controller remembers from one step to the next.

    One class for all controllers. The field `controller` names the class of the controller; the
    others are those of the core's struct (`TrackerState`, `SpeedTrackerState` or `SpeedPidState`),
    whose page describes them: ``cargo doc -p popsteer-core``. A struct within it is a `State` too,
    and a sequence is a tuple. ``controller.state = state`` restores it; what is not a state of that
    controller is refused with an `InputError` then, and not before.

    Parameters
    ----------
    **fields
        All fields by name; a mapping becomes a `State`. ``State(**state.as_dict()) == state``.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    >>> pop = popsteer.Pop(path)
    >>> start = pop.state
    >>> steer = pop.steer(0.0, 0.5, 0.0, 5.0, 0.05)
    >>> pop.state.steer == steer == pop.state.law.previous_steer
    True
    >>> pop.state = start.replace(steer=0.1)
    >>> pop.state = start.replace(steer=9.0)
    Traceback (most recent call last):
    popsteer.errors.InputError: steer must be in [-1.22, 1.22], got 9.0
    """

    __slots__ = ("_fields",)
    _fields: dict[str, Any]

    def __init__(self, **fields: object) -> None:
        frozen = {name: _frozen(value) for name, value in fields.items()}
        object.__setattr__(self, "_fields", frozen)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - a number, a tuple, a state or None
        try:
            return self._fields[name]
        except KeyError:
            if name in _SEGMENT_OF_PLACE and "place" in self._fields:
                place = self._fields["place"]
                return None if place is None else place.segment
            text = f"this state has no field {name!r}; it has {', '.join(self._fields)}"
            raise AttributeError(text, name=name, obj=self) from None

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a state is immutable: use replace({name}=...)")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a state is immutable: {name} stays")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name, in a new ``dict``; a `State` among them as a ``dict`` too."""
        return {name: _plain(value) for name, value in self._fields.items()}

    def replace(self, **changes: object) -> Self:
        """Make the same state but for some fields.

        Parameters
        ----------
        **changes
            Fields with their new values.

        Returns
        -------
        State
            A new one.

        Raises
        ------
        TypeError
            If there is no field of that name.

        Examples
        --------
        >>> moved = State(steer=0.1, estimate=State(gain=1.0))
        >>> moved.replace(estimate=moved.estimate.replace(gain=1.2))
        State(steer=0.1, estimate=State(gain=1.2))
        """
        for name in changes.keys() - self._fields.keys():
            raise TypeError(f"this state has no field {name!r}; it has {', '.join(self._fields)}")
        return type(self)(**{**self._fields, **changes})

    def __eq__(self, other: object) -> bool:
        return self._fields == other._fields if isinstance(other, State) else NotImplemented

    def __hash__(self) -> int:
        return hash(frozenset(self._fields.items()))

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={value!r}" for name, value in self._fields.items())
        return f"State({fields})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self._fields,)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, _: object) -> Self:
        return self


def _made(fields: dict[str, Any]) -> State:
    return State(**fields)


def _frozen(value: object) -> object:
    if value is None or isinstance(value, (float, int, str)):
        return value  # as most are: to ask for a `Mapping` takes longer
    if isinstance(value, Mapping):
        return State(**value)
    if isinstance(value, (list, tuple)):
        return tuple(map(_frozen, value))
    return value


def _plain(value: object) -> object:
    if isinstance(value, State):
        return value.as_dict()
    if isinstance(value, tuple):
        return tuple(map(_plain, value))
    return value
