"""What is observed and what is done, as Gymnasium's spaces."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np
from gymnasium.spaces import Box

from popsteer._core import Episodes
from popsteer.errors import InputError

if TYPE_CHECKING:
    from gymnasium.spaces import Space
    from numpy.typing import ArrayLike, NDArray

    from popsteer.adapters.gymnasium.task import Task

INFO = tuple(Episodes.info_names())
"""The names of what is reported in addition to an observation."""


def observation_names(task: Task) -> list[str]:
    """Name the entries of an observation, in order."""
    heads = [name for name in Episodes.figures() if name != "preview"]
    points = range(len(task.preview))
    return heads + [f"preview_{axis}[{k}]" for k in points for axis in "xy"]


def observation_space(task: Task) -> Space[NDArray[np.float32]]:
    """Give the space of observations."""
    bounds = dict(Episodes.figures())
    preview = bounds.pop("preview")
    high = np.array([*bounds.values(), *[preview] * (2 * len(task.preview))], dtype=np.float32)
    return cast("Space[NDArray[np.float32]]", Box(-high, high, dtype=np.float32))


def action_space(task: Task) -> Space[NDArray[np.float32]]:
    """Give the space of actions."""
    count = 1 if task.actions == "steer" else 2
    return cast("Space[NDArray[np.float32]]", Box(-1.0, 1.0, (count,), np.float32))


def actions_of(actions: ArrayLike, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    """Give actions as floats of this shape; refuse what has another.

    Raises
    ------
    InputError
        They are no numbers, or of another shape.
    """
    try:
        array = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(name, actions, "numbers") from error
    wanted = shape if name == "actions" else shape[1:]
    if array.shape != wanted:
        raise InputError(f"shape of {name}", array.shape, f"{wanted}")
    return array.reshape(shape)
