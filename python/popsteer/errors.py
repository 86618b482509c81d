"""The exceptions of popsteer: one base, and one class for each place where input can be wrong.

The Rust core and the pure-Python reference raise these same classes with the same arguments,
so the wording of a message has one home, here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable


_LONGEST = 200  # characters of a name or a value in a message


def in_range(low: float, high: float) -> str:
    """Word the requirement that a number lies in a closed range."""
    return f"in [{low:g}, {high:g}]"


def count_in_range(low: int, high: int) -> str:
    """Word the requirement that a count lies in a closed range.

    Examples
    --------
    >>> count_in_range(1, 1000)
    'a count in [1, 1000]'
    """
    return f"a count in [{low}, {high}]"


def odd_in_range(low: int, high: int) -> str:
    """Word the requirement that a count is odd and lies in a closed range.

    Examples
    --------
    >>> odd_in_range(3, 100001)
    'odd and in [3, 100001]'
    """
    return f"odd and in [{low}, {high}]"


def below(count: int) -> str:
    """Word the requirement that an index is below a count."""
    return f"below {count}"


def short(text: str) -> str:
    """Cut what would flood a terminal, such as the key of a file that is no text."""
    cut = f"{text[:_LONGEST]}... ({len(text)} characters)"
    return text if len(text) <= len(cut) else cut


def unknown(what: str, name: object, known: Iterable[str]) -> str:
    """Word that a name is not among the known ones, and which of them is nearest.

    Examples
    --------
    >>> unknown("column", "sped", ["yaw", "speed"])
    "unknown column 'sped', did you mean speed? Known: yaw, speed"
    """
    import difflib

    known = list(known)
    near = difflib.get_close_matches(str(name)[:_LONGEST], known, 1)
    said = f", did you mean {near[0]}? Known" if near else "; known"
    return f"unknown {what} {short(repr(name))}{said}: {', '.join(known)}"


def printable(text: str) -> str:
    r"""Escape what a terminal would not print: control characters of the name of a file, say.

    Examples
    --------
    >>> print(printable("a\x1b[31m.csv"))
    a\x1b[31m.csv
    """
    return "".join(each if each.isprintable() else ascii(each)[1:-1] for each in text)


class PopsteerError(Exception):
    """Base of all errors that popsteer raises on purpose.

    Examples
    --------
    >>> issubclass(ConfigError, PopsteerError) and issubclass(ConfigError, ValueError)
    True
    """

    def __reduce__(self) -> tuple[Any, ...]:
        # The default would call the class with `args`, the finished message alone, which the
        # constructors below do not take. Restoring past them keeps message, attributes and notes.
        return _restore, (type(self), *self.args), self.__dict__.copy()


def _restore(kind: type[PopsteerError], *args: object) -> PopsteerError:
    """Make an error from its message; its attributes follow as the pickled state."""
    return kind.__new__(kind, *args)


class _FieldError(PopsteerError, ValueError):
    """A named value that breaks a requirement: what `ConfigError` and `InputError` share."""

    field: str
    value: object
    requirement: str

    def __init__(self, field: str, value: object, requirement: str) -> None:
        super().__init__(f"{short(field)} must be {requirement}, got {short(repr(value))}")
        self.field = field
        self.value = value
        self.requirement = requirement


class ConfigError(_FieldError):
    """A parameter that a constructor refuses, or a name that is not known.

    Parameters
    ----------
    field : str
        Name of the parameter.
    value : object
        The value that was given.
    requirement : str
        What the value must be, worded to follow "must be".

    Attributes
    ----------
    field, value, requirement
        The arguments, as given.

    Examples
    --------
    >>> raise ConfigError("max_steer", -0.5, in_range(0.001, 1.5))
    Traceback (most recent call last):
    popsteer.errors.ConfigError: max_steer must be in [0.001, 1.5], got -0.5
    """

    @classmethod
    def unknown(cls, what: str, name: object, known: Iterable[str]) -> ConfigError:
        """Make the error for a name that is not among the known ones.

        Parameters
        ----------
        what : str
            What is named, such as "controller", "plant" or "track"; becomes `field`.
        name : object
            The name that was given; becomes `value`.
        known : iterable of str
            The names that would have been accepted, in the order to list them.

        Returns
        -------
        ConfigError
            To be raised by the caller.

        Examples
        --------
        >>> print(ConfigError.unknown("controller", "foo", ["pid", "stanley"]))
        unknown controller 'foo'; known: pid, stanley
        >>> print(ConfigError.unknown("controller", "stanly", ["pid", "stanley"]))
        unknown controller 'stanly', did you mean stanley? Known: pid, stanley
        """
        known = list(known)
        error = cls(what, name, f"one of {', '.join(known)}")
        error.args = (unknown(what, name, known),)
        return error


class InputError(_FieldError):
    """An argument of a control step that a controller refuses; its state is unchanged.

    Parameters
    ----------
    field : str
        Name of the argument.
    value : object
        The value that was given.
    requirement : str
        What the value must be, worded to follow "must be".

    Attributes
    ----------
    field, value, requirement
        The arguments, as given.

    Examples
    --------
    >>> raise InputError("speed", float("nan"), "finite")
    Traceback (most recent call last):
    popsteer.errors.InputError: speed must be finite, got nan
    """


class PathError(PopsteerError, ValueError):
    """Waypoints, or a file of waypoints, that make no path.

    Parameters
    ----------
    message : str
        What is wrong, and where.
    index : int, optional
        The waypoint concerned, counted from 0; None where it is not a single one.

    Attributes
    ----------
    index : int or None
        The argument, as given.

    Examples
    --------
    >>> error = PathError("waypoints 3 and 4 coincide", index=4)
    >>> str(error), error.index
    ('waypoints 3 and 4 coincide', 4)
    """

    index: int | None

    def __init__(self, message: str, index: int | None = None) -> None:
        super().__init__(message)
        self.index = index

    @classmethod
    def too_few_waypoints(cls, count: int, least: int) -> PathError:
        """Make the error for a path of `count` waypoints that needs `least`."""
        return cls(f"a path needs at least {least} waypoints, got {count}")

    @classmethod
    def length_mismatch(cls, field: str, length: int, waypoints: int) -> PathError:
        """Make the error for `field` with `length` entries beside `waypoints` waypoints."""
        return cls(f"{field} has {length} entries for {waypoints} waypoints")

    @classmethod
    def out_of_range(cls, field: str, index: int, value: float, requirement: str) -> PathError:
        """Make the error for a number of waypoint `index` that breaks a requirement."""
        return cls(f"{field} of waypoint {index} must be {requirement}, got {value!r}", index)

    @classmethod
    def coinciding(cls, index: int, following: int) -> PathError:
        """Make the error for neighbours at one place."""
        return cls(f"waypoints {index} and {following} coincide", index)

    @classmethod
    def grid_too_large(cls, points: int, most: int) -> PathError:
        """Make the error for a grid of `points` points where `most` are made."""
        return cls(f"the grid would have {points} points, more than {most}")


class PlantLimit(PopsteerError):  # noqa: N818 - no error of a program: a run ends there
    """A limit of a vehicle's model: what it says of the vehicle beyond would not be true.

    `popsteer.sim` ends the run there and keeps what was measured until then.

    Parameters
    ----------
    limit : str
        Which limit, with the numbers.

    Attributes
    ----------
    limit
        The argument, as given.

    Examples
    --------
    >>> raise PlantLimit("speed 0.80 m/s is below 1 m/s")
    Traceback (most recent call last):
    popsteer.errors.PlantLimit: speed 0.80 m/s is below 1 m/s
    """

    limit: str

    def __init__(self, limit: str) -> None:
        super().__init__(limit)
        self.limit = limit
