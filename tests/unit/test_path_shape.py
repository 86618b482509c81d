"""Headings and curvatures of a planner's own: given, read from files, pickled, refused."""

from __future__ import annotations

import copy
import pickle
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from tests.trust.car import bends

if TYPE_CHECKING:
    from pathlib import Path

XY = bends(2.0)
ALONG = np.gradient(XY, axis=0)
YAW = np.arctan2(ALONG[:, 1], ALONG[:, 0])
CURVATURE = np.gradient(YAW) / np.hypot(*ALONG.T)


def test_path_gives_back_its_own_shape_also_of_a_copy() -> None:
    for shape in ({"yaw": YAW, "curvature": CURVATURE}, {"yaw": YAW}, {"curvature": CURVATURE}):
        path = popsteer.Path(XY, **shape)
        for each in (path, pickle.loads(pickle.dumps(path)), copy.deepcopy(path)):
            assert each.yaw == pytest.approx(YAW, abs=0.1)
            assert (each.curvature is None) == ("curvature" not in shape)
    spline = popsteer.Path(XY, yaw="spline")
    again = pickle.loads(pickle.dumps(spline))
    assert again.yaw is not None
    assert np.array_equal(again.yaw, np.asarray(spline.yaw))
    assert np.array_equal(np.asarray(again.curvature), np.asarray(spline.curvature))
    assert popsteer.Path(XY).yaw is None


def test_path_shape_is_read_by_the_names_of_columns(tmp_path: Path) -> None:
    file = tmp_path / "planned.csv"
    rows = np.column_stack((CURVATURE, XY, YAW))
    text = "kappa,x,y,yaw_rad\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())
    file.write_text(text, encoding="utf-8")
    path = popsteer.Path.from_csv(file)
    assert np.array_equal(np.asarray(path.yaw), YAW)
    assert np.array_equal(np.asarray(path.curvature), CURVATURE)
    assert path.speed is None
    file.write_text(text.replace("kappa", "k").replace("yaw_rad", "way"), encoding="utf-8")
    assert popsteer.Path.from_csv(file).yaw is None


def test_path_shape_that_contradicts_names_waypoint_and_value() -> None:
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"yaw": np.degrees(YAW)}, "yaw of waypoint 0 is 21"),
        ({"yaw": YAW, "curvature": -CURVATURE}, "curvature of waypoint"),
        ({"yaw": YAW[1:]}, "yaw has"),
        ({"yaw": "clothoid"}, "yaw must be an array"),
        ({"yaw": [*YAW.tolist()[:-1], np.nan]}, "yaw of waypoint"),
    ]
    for shape, message in wrong:
        with pytest.raises(popsteer.PathError, match=message):
            popsteer.Path(XY, **shape)


def test_speed_is_planned_with_the_paths_own_curvature() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, max_lateral_acceleration=4.0, max_speed=30.0)
    coarse = popsteer.planning.speed_profile(popsteer.Path(XY), vehicle=car)
    own = popsteer.planning.speed_profile(popsteer.Path(XY, curvature=CURVATURE), vehicle=car)
    middle = np.abs(CURVATURE) > 0.035
    lateral = own.speed[middle] ** 2 * np.abs(CURVATURE[middle])
    assert lateral.max() <= 4.0 + 1e-9
    assert not np.array_equal(own.speed, coarse.speed)
