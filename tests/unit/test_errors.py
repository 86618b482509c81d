from __future__ import annotations

import copy
import pickle
from typing import TYPE_CHECKING

from popsteer.errors import ConfigError, InputError, PathError, PopsteerError, in_range
from tests.helpers import looped

if TYPE_CHECKING:
    from collections.abc import Callable

ERRORS: list[PopsteerError] = [
    PopsteerError("anything"),
    ConfigError("max_steer", -0.5, "positive"),
    ConfigError.unknown("law", "foo", ["pid", "stanley"]),
    InputError("speed", float("inf"), "finite"),
    PathError("too short"),
    PathError("waypoints 3 and 4 coincide", index=4),
]


def _pickled(error: PopsteerError, protocol: int) -> PopsteerError:
    restored = pickle.loads(pickle.dumps(error, protocol))
    assert isinstance(restored, PopsteerError)
    return restored


@looped("kind", [ConfigError, InputError, PathError])
def test_errors_of_each_kind_are_popsteer_and_value_errors(kind: type[Exception]) -> None:
    assert issubclass(kind, PopsteerError)
    assert issubclass(kind, ValueError)


@looped("kind", [ConfigError, InputError])
def test_field_error_names_field_requirement_and_value(
    kind: type[ConfigError | InputError],
) -> None:
    error = kind("dt", 0.0, "positive")
    assert str(error) == "dt must be positive, got 0.0"
    assert (error.field, error.value, error.requirement) == ("dt", 0.0, "positive")


def test_config_error_for_unknown_name_lists_known_ones_in_their_order() -> None:
    error = ConfigError.unknown("law", "foo", (name for name in ("pop", "pid")))
    assert str(error) == "unknown law 'foo'; known: pop, pid"
    assert (error.field, error.value, error.requirement) == ("law", "foo", "one of pop, pid")


@looped("index", [None, 0, 7])
def test_path_error_keeps_message_and_index(index: int | None) -> None:
    error = PathError("no path", index)
    assert (str(error), error.index) == ("no path", index)


def test_path_error_without_index_has_none() -> None:
    assert PathError("no path").index is None


@looped("error", ERRORS)
@looped(
    "duplicate",
    [copy.copy, copy.deepcopy]
    + [lambda e, p=p: _pickled(e, p) for p in range(pickle.HIGHEST_PROTOCOL + 1)],
)
def test_error_copied_or_pickled_is_the_same(
    error: PopsteerError, duplicate: Callable[[PopsteerError], PopsteerError]
) -> None:
    twin = duplicate(error)
    assert type(twin) is type(error)
    assert str(twin) == str(error)
    assert twin.args == error.args
    assert repr(vars(twin)) == repr(vars(error))
    assert twin is not error


@looped(
    ("low", "high", "expected"),
    [
        (0.001, 1000.0, "in [0.001, 1000]"),
        (-1.5, 1.5, "in [-1.5, 1.5]"),
        (0, 1e9, "in [0, 1e+09]"),
    ],
)
def test_in_range_words_both_ends_shortly(low: float, high: float, expected: str) -> None:
    assert in_range(low, high) == expected
