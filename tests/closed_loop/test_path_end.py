"""The last metres of a path, and those beyond it: as quiet as the rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from studies.layout import course, table
from studies.path_end import CUT, angles_by_arc, controller, end_lines, shortened
from tests.helpers import authors_data

if TYPE_CHECKING:
    from numpy.typing import NDArray

    import popsteer
    from popsteer.sim import Pose

LAWS = ("pop", "pure-pursuit", "stanley", "pid", "preview-pop")


def courses(name: str) -> tuple[popsteer.Path, Pose | None]:
    if name == "authors":
        authors_data()
    return course(name)


def in_the_last_over_rms_before(
    arc: NDArray[np.float64], steer: NDArray[np.float64], end: float
) -> float:
    """Largest angle in the last 10 m before `end` [m] and beyond, over the rms before."""
    last = arc > end - 10.0
    assert last.sum() > 10
    return float(np.abs(steer[last]).max() / np.sqrt(np.mean(steer[~last] ** 2)))


@pytest.mark.parametrize("place", ["authors", "racetrack", "slalom", "double-lane-change"])
@pytest.mark.parametrize("name", LAWS)
def test_angle_in_the_last_10_m_keeps_within_twice_its_rms(name: str, place: str) -> None:
    path, start = courses(place)
    arc, steer = angles_by_arc(controller(name, path, "default"), path, start)
    assert in_the_last_over_rms_before(arc, steer, path.length) <= 2.0


@pytest.mark.parametrize("place", ["authors", "racetrack"])
@pytest.mark.parametrize("name", LAWS)
def test_angle_past_the_end_keeps_within_twice_its_rms(name: str, place: str) -> None:
    path, start = courses(place)
    arc, steer = angles_by_arc(shortened(name, path, "default"), path, start)
    assert arc[-1] > path.length - 0.5 * CUT
    assert in_the_last_over_rms_before(arc, steer, path.length - CUT) <= 2.0


def test_page_table_of_the_end_is_what_is_driven() -> None:
    assert table("edges.md", "end") == end_lines()


@pytest.mark.parametrize("place", ["authors", "racetrack"])
def test_angle_of_the_published_pure_pursuit_swings_at_the_end(place: str) -> None:
    """The search stops at the last waypoint; its bearing runs through 90° as that is passed."""
    path, start = courses(place)
    arc, steer = angles_by_arc(controller("pure-pursuit", path, "published-code"), path, start)
    assert in_the_last_over_rms_before(arc, steer, path.length) > 5.0
    assert np.degrees(np.abs(steer[arc > path.length - 10.0]).max()) == pytest.approx(22.0, abs=0.5)
