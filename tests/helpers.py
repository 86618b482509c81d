"""What tests of several folders share."""

from __future__ import annotations

import functools
import inspect
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import settings

from popsteer import State
from studies.layout import AUTHORS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

ROOT = Path(__file__).resolve().parents[1]
# After so long [s] what is awaited is taken for hung. It is no bound on how long anything may take.
PATIENCE = 300.0


def authors_data() -> Path:
    """The folder with the run that the paper's authors recorded; the test skips without it."""
    if not AUTHORS.is_dir():
        pytest.skip(f"the authors' recorded run is not at hand in {AUTHORS}")
    return AUTHORS


def named(field: str) -> str:
    """What to look for in a TypeError about `field`: Python 3.10 takes no notes with a name."""
    return field if sys.version_info >= (3, 11) else "."


def placed(segment: int, lost: bool = False) -> State:
    """The place of a controller's state: on this segment of a path, somewhere."""
    return State(segment=segment, point=(3.0, 0.5), lost=lost)


def long_drives() -> settings:
    """How often to draw a property that drives for hundreds of steps in the reference.

    Fewer times than the others, since each drive has as many steps as they have examples; a
    thorough run draws all.
    """
    asked = settings().max_examples
    return settings(max_examples=40 if asked == 100 else asked)


def looped(
    names: str | tuple[str, ...], cases: Iterable[Any]
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a test each case in turn, as one item: as `parametrize`, where ids would tell nothing.

    A failure begins with the case that it is of. Not for tests that skip single cases.
    """
    keys = names.replace(" ", "").split(",") if isinstance(names, str) else list(names)
    rows = [dict(zip(keys, case if len(keys) > 1 else (case,), strict=True)) for case in cases]
    assert rows, "no case to test"

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def loop(**fixtures: Any) -> None:
            for row in rows:
                try:
                    test(**fixtures, **row)
                except (Exception, pytest.fail.Exception) as error:  # noqa: PERF203 - names it
                    raise AssertionError(f"case {row!r}") from error

        signature = inspect.signature(test)
        others = [each for name, each in signature.parameters.items() if name not in keys]
        assert len(others) == len(signature.parameters) - len(keys), f"{test} takes no {keys}"
        vars(loop)["__signature__"] = signature.replace(parameters=others)
        return loop

    return decorate
