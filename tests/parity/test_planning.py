from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from popsteer import ConfigError, Path, Vehicle, reference
from popsteer._core import _path_curvature, _plan_speeds
from popsteer.planning.profile import LIMITS
from popsteer.planning.speeds import table_of
from popsteer.reference.speed import Course, Limits, OverSpeed, path_curvature, plan_speeds
from popsteer.reference.speed.profile import LIMITS as THEIRS
from popsteer.tracks import edges
from tests.parity.strategies import Shape, shapes
from tests.planned import closed_spline, random_course

TABLE = ((0.0, 3.0), (8.0, 2.0), (20.0, 0.5))
RISING = ((1.0, 0.5), (5.0, 3.0), (9.0, 1.0))


def test_limits_have_the_same_numbers() -> None:
    assert LIMITS[: len(THEIRS)] == THEIRS


@given(shape=shapes(), length=st.floats(0.05, 20.0))
def test_path_curvature_matches_reference_random(shape: Shape, length: float) -> None:
    path = shape.build()
    ours = _path_curvature(Path(path.xy, closed=path.closed), length)
    theirs = path_curvature(reference.Path(path.xy, closed=path.closed), length)
    assert np.array_equal(ours, np.array(theirs), equal_nan=True)


@pytest.mark.parametrize("make", [edges.three_point_turn, edges.parallel_parking])
@pytest.mark.parametrize("closed", [False, True])
def test_path_curvature_of_cusps_matches_reference(make: Any, closed: bool) -> None:
    way = make()
    options = {"speed": way.speed.tolist(), "closed": closed}
    ours = _path_curvature(Path(way.xy, **options), 2.0)
    theirs = path_curvature(reference.Path(way.xy.tolist(), **options), 2.0)
    assert ours.tolist() == theirs


@given(
    seed=st.integers(0, 10**6),
    closed=st.booleans(),
    acceleration=st.floats(0.1, 8.0) | st.sampled_from([TABLE, RISING]),
    deceleration=st.floats(0.1, 8.0) | st.sampled_from([TABLE, RISING]),
    exponent=st.sampled_from([1.0, 2.0, math.inf]) | st.floats(1.0, 5.0),
    grip=st.none() | st.floats(0.5, 8.0),
    car=st.fixed_dictionaries(
        {"understeer": st.sampled_from([0.0, 0.004])},
        optional={"max_steer_rate": st.floats(0.05, 1.0), "max_steer": st.floats(0.2, 1.2)},
    ),
    ends=st.tuples(*[st.none() | st.floats(0.0, 9.0)] * 2),
    limited=st.booleans(),
)
def test_plan_speeds_matches_reference_random(  # noqa: PLR0917 - drawn
    seed: int,
    closed: bool,
    acceleration: Any,
    deceleration: Any,
    exponent: float,
    grip: float | None,
    car: dict[str, float],
    ends: tuple[float | None, float | None],
    limited: bool,
) -> None:
    xy = closed_spline(seed, 120) if closed else random_course(seed, 120)
    path = Path(xy, closed=closed)
    bends = _path_curvature(path, 2.0)
    spacing = np.diff(np.append(path.s, path.length) if closed else path.s)
    cusps = np.arange(120) % 50 == 20
    bounds = 5.0 + 4.0 * np.sin(np.arange(120.0)) if limited else None
    tables = table_of(acceleration), table_of(deceleration)
    speed, limit = _plan_speeds(
        bends,
        spacing,
        closed=closed,
        cusps=cusps if limited else None,
        speed_limits=bounds,
        start_speed=ends[0],
        end_speed=ends[1],
        max_speed=20.0,
        max_lateral_acceleration=4.0,
        acceleration=tables[0],
        deceleration=tables[1],
        longitudinal_grip=grip,
        exponent=exponent,
        vehicle=Vehicle(**car),
    )
    lists = [OverSpeed(*(column.tolist() for column in table)) for table in tables]
    course = Course(
        bends.tolist(),
        spacing.tolist(),
        closed,
        cusps.tolist() if limited else None,
        None if bounds is None else bounds.tolist(),
        *ends,
    )
    limits = Limits(20.0, 4.0, lists[0], lists[1], grip, exponent, reference.Vehicle(**car))
    theirs = plan_speeds(course, limits)
    assert speed.tolist() == theirs[0]
    assert limit.tolist() == theirs[1]


@pytest.mark.parametrize(
    "changes",
    [
        {"max_speed": 0.0},
        {"max_lateral_acceleration": math.nan},
        {"acceleration": ([0.0], [0.0])},
        {"acceleration": ([0.0, 0.0], [1.0, 1.0])},
        {"deceleration": ([0.0, -1.0], [1.0, 1.0])},
        {"deceleration": ([], [])},
        {"longitudinal_grip": 0.0},
        {"exponent": 0.99},
    ],
    ids=str,
)
def test_plan_speeds_matches_reference_edges(changes: dict[str, Any]) -> None:
    usual: dict[str, Any] = {
        "max_speed": 20.0,
        "max_lateral_acceleration": 4.0,
        "acceleration": ([0.0], [2.0]),
        "deceleration": ([0.0], [2.0]),
        "longitudinal_grip": None,
        "exponent": 2.0,
    }
    given = usual | changes
    course = Course([0.0, 0.0, 0.0], [1.0, 1.0])
    tables = {name: OverSpeed(*given[name]) for name in ("acceleration", "deceleration")}
    with pytest.raises(ConfigError) as theirs:
        plan_speeds(course, Limits(**(given | tables), vehicle=reference.Vehicle()))
    arrays = {name: tuple(np.array(column) for column in table) for name, table in tables.items()}
    with pytest.raises(ConfigError) as ours:
        _plan_speeds(
            np.zeros(3),
            np.ones(2),
            closed=False,
            cusps=None,
            speed_limits=None,
            start_speed=None,
            end_speed=None,
            vehicle=Vehicle(),
            **(given | arrays),
        )
    assert str(ours.value) == str(theirs.value)
