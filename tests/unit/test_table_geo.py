"""Latitudes and longitudes become a plane about the first waypoint, or about an origin."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from popsteer import ConfigError, Path, PathError, logs
from tests.helpers import looped
from tests.unit.test_table_kinds import ONE, N, X, Y, _rows, _write

if TYPE_CHECKING:
    from collections.abc import Callable

LAT, LON = 47.3, 8.5  # a sphere of WGS 84's larger radius is wrong by 0.4 % to the north


def _degrees() -> tuple[Any, Any]:
    east = 111319.49 * math.cos(math.radians(LAT))
    return LAT + Y / 111319.49, LON + X / east


def _flat(path: Path) -> None:
    assert np.hypot(np.diff(path.x), np.diff(path.y)) == pytest.approx(
        np.hypot(np.diff(X), np.diff(Y)), rel=6e-3
    )


@pytest.fixture
def geo() -> None:
    pytest.importorskip("pyproj")


def _gpx(lat: Any, lon: Any) -> str:
    points = "".join(f'<trkpt lat="{a!r}" lon="{b!r}"/>' for a, b in zip(lat, lon, strict=True))
    return f"<?xml version='1.0'?>\n<gpx><trk><trkseg>{points}</trkseg></trk></gpx>"


def _geojson(lat: Any, lon: Any) -> str:
    line = {"type": "LineString", "coordinates": np.column_stack((lon, lat)).tolist()}
    return json.dumps({"type": "Feature", "properties": {}, "geometry": line})


@pytest.mark.parametrize(
    "made",
    [
        lambda a, b: "latitude,longitude\n" + _rows((a, b), ",", "%.10f"),
        lambda a, b: "lon [deg],lat [deg]\n" + _rows((b, a), ",", "%.10f"),
        _gpx,
        _geojson,
    ],
)
def test_latitudes_and_longitudes_become_a_local_plane(
    tmp_path: Any, geo: None, made: Callable[[Any, Any], str]
) -> None:
    lat, lon = _degrees()
    file = _write(tmp_path, made(lat.tolist(), lon.tolist()))
    path = Path.from_csv(file)
    _flat(path)
    assert (path.x[0], path.y[0]) == pytest.approx((0.0, 0.0), abs=1e-3)
    assert f"origin {lat[0]:.6f}" in str(path.source)
    kept = Path.from_csv(file, origin=(LAT, LON))
    if file.read_text(encoding="utf-8").startswith(("<", "{")):
        with pytest.raises(ConfigError, match="is no table"):
            Path.from_csv(file, columns="x,y")
    assert (kept.x[0], kept.y[0]) == pytest.approx((X[0], Y[0]), rel=6e-3)


def _ways(*parts: slice) -> str:
    lat, lon = _degrees()
    rows = [[b, a, 41.5] for a, b in zip(lat, lon, strict=True)]
    lines = [{"type": "LineString", "coordinates": rows[part]} for part in parts]
    return json.dumps(
        {
            "type": "FeatureCollection",
            "features": [{"geometry": line, "type": "Feature"} for line in lines],
        }
    )


def test_ways_of_a_map_that_follow_one_another_are_one_path(geo: None, tmp_path: Any) -> None:
    cut = slice(0, 18), slice(17, 20), slice(19, N)
    whole = Path.from_csv(_write(tmp_path, _ways(slice(0, N))))
    for order in ((0, 1, 2), (2, 0, 1), (1, 2, 0)):
        path = Path.from_csv(_write(tmp_path, _ways(*(cut[k] for k in order))), origin=(LAT, LON))
        _flat(path)
        assert (path.x[0], path.y[0]) == pytest.approx((X[0], Y[0]), rel=6e-3)
        assert "latitude, longitude; 3 lines, joined; x and y" in str(path.source)
    assert "joined" not in str(whole.source)
    back, gap, again = slice(19, 16, -1), slice(20, N), slice(17, 30)
    for parts in (
        (cut[0], back, cut[2]),
        (cut[0], gap),
        (*cut, again),  # forks
        (cut[0], slice(17, None), slice(0, 3)),  # forks where it begins
    ):
        with pytest.raises(PathError, match=r"has \d lines, which do not follow one another"):
            Path.from_csv(_write(tmp_path, _ways(*parts)))


def test_metres_in_geojson_are_refused_with_what_to_export(tmp_path: Any) -> None:
    pytest.importorskip("pyproj")
    line = {"type": "LineString", "coordinates": [[690123.0, 5330456.0], [690125.0, 5330456.5]]}
    file = tmp_path / "path.geojson"
    file.write_text(json.dumps(line), encoding="utf-8")
    with pytest.raises(PathError, match="which is no degrees: export it in WGS 84"):
        Path.from_csv(file)


@looped(
    ("head", "columns"),
    [("X,Y,id\n", "lon=X,lat=Y"), ("", "lon,lat")],
)
def test_degrees_without_a_name_are_refused_and_read_as_they_are_called(
    tmp_path: Any, head: str, columns: str
) -> None:
    pytest.importorskip("pyproj")
    lat, lon = _degrees()
    more = (np.arange(N) * ONE,) if head else ()
    file = _write(tmp_path, head + _rows((lon, lat, *more), ",", "%.10f"))
    with pytest.raises(PathError, match="are degrees"):
        Path.from_csv(file)
    _flat(Path.from_csv(file, columns=columns))


def test_degrees_without_names_are_read_where_only_one_order_is_possible(
    geo: None, tmp_path: Any
) -> None:
    # No latitude is beyond 90 degrees; below, either may be one.
    lat, east = 36.1 + Y / 111319.49, 139.98 + X / (111319.49 * math.cos(math.radians(36.1)))
    yaw = np.arctan2(np.gradient(Y), np.gradient(X))
    for columns, said in (
        ((lat, east), "latitude, longitude"),
        ((east, lat), "longitude, latitude"),
        ((lat, east - 270.0, yaw), "latitude, longitude"),
    ):
        path = Path.from_csv(_write(tmp_path, _rows(columns)))
        _flat(path)
        assert np.asarray(path.x) == pytest.approx(X - X[0], abs=0.1)
        assert f"of {said} (columns 1, 2)" in str(path.source)
        assert (path.yaw is not None) == (len(columns) == 3)
    file = _write(tmp_path, _rows((lat, east, 5.0 + np.sin(X))))
    with pytest.raises(PathError, match=r"column 3 .* --columns lat,lon,speed, .* lat,lon,-$"):
        Path.from_csv(file)
    _flat(Path.from_csv(file, columns="lat,lon,-"))
    with pytest.raises(PathError, match="say which is which"):
        Path.from_csv(_write(tmp_path, _rows((LAT + Y / 111319.49, LON + X / 75000.0))))


@pytest.mark.usefixtures("geo")
def test_degrees_that_are_radians_are_refused_with_the_unit(tmp_path: Any) -> None:
    for names in ("Latitude,Longitude", "Lat (deg),Lon (deg)"):
        text = f"{names}\n" + _rows(tuple(map(np.radians, _degrees())), style="%.12f")
        lat, lon = names.split(",")
        both = f"lat={lat} [rad],lon={lon} [rad]"
        with pytest.raises(PathError, match="are radians, as there is no road") as refused:
            Path.from_csv(_write(tmp_path, text))
        assert f"--columns '{both}'" in str(refused.value)
        _flat(Path.from_csv(_write(tmp_path, text), columns=both))
    # Those of a simulator begin near 0, 0.
    near = _write(tmp_path, "lat,lon\n0.001,0.002\n0.0011,0.002\n0.0012,0.002\n")
    assert np.asarray(Path.from_csv(near).y) == pytest.approx([0.0, 11.06, 22.11], abs=0.01)


@pytest.mark.usefixtures("geo")
def test_hemispheres_and_parts_of_degrees_are_those_of_the_columns(tmp_path: Any) -> None:
    lat, lon = _degrees()
    for south, west in (("N", "E"), ("S", "W")):
        text = "lat,N/S,lon,E/W\n" + _rows((lat, [south] * N, lon, [west] * N))
        path = Path.from_csv(_write(tmp_path, text))
        sign = 1.0 if south == "N" else -1.0
        assert f"origin {sign * lat[0]:.9f},{sign * lon[0]:.9f}" in str(path.source)
        assert path.x[-1] == pytest.approx(sign * (X[-1] - X[0]), rel=0.01)
    _flat(Path.from_csv(_write(tmp_path, "lat_e7,lon_e7\n" + _rows((1e7 * lat, 1e7 * lon)))))
    with pytest.raises(PathError, match=r"no degrees: .*; 1e-7 degrees are read as lat_e7"):
        Path.from_csv(_write(tmp_path, "lat,lon\n" + _rows((1e7 * lat, 1e7 * lon))))


@pytest.mark.usefixtures("geo")
def test_rows_before_a_receiver_has_a_position_are_refused_or_skipped(tmp_path: Any) -> None:
    lat, lon = _degrees()
    text = "lat,lon\n0,0\n0,0\n" + _rows((lat, lon))
    with pytest.raises(PathError, match=r"path.csv, line 2: latitude and longitude are 0, as befo"):
        Path.from_csv(_write(tmp_path, text))
    rows = _rows((0.1 * np.arange(N) + 0.1, lat, lon, 0.0 * ONE, 0.0 * ONE, 0.0 * ONE))
    log = logs.read(_write(tmp_path, f"t,lat,lon,yaw,speed,steer\n0,0,0,0,0,0\n{rows}"))
    assert len(log) == N
    assert "1 row with a number that is not finite: skipped" in log.remarks
    assert abs(log.x[0]) < 1e-6
