"""Latitudes and longitudes: from GPX and GeoJSON, and into a local plane."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any
from xml.parsers import expat

import numpy as np

from popsteer.errors import PathError
from popsteer.extras import require
from popsteer.tables.kinds import is_json

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from popsteer.tables.columns import Column
    from popsteer.tables.shown import Floats
    from popsteer.tables.text import Table

_POINTS = ("trkpt", "rtept", "wpt")  # those of a track are waypoints before those of a route


_SIDES = {"lat": ("N", "S"), "lon": ("E", "W")}


def check(
    table: Table,
    places: Mapping[str, Column],
    columns: dict[str, Floats],
    wanted: list[str] | dict[str, str],
) -> None:
    """Turn latitudes and longitudes beside which S and W stand; refuse radians by PathError.

    As degrees these would be at sea, off Africa; but simulators begin at 0, 0, and a unit that is
    asked for is right.
    """
    for key, (place, turned) in _SIDES.items():
        beside = places[key].place + 1 if key in columns and table.head else table.columns
        if beside < table.columns and table.is_text(beside):
            said = [row[0].upper() for _, _, row in table.entries([beside])]
            if set(said) <= {place, turned, ""}:
                columns[key][np.array(said) == turned] *= -1.0
    asked = isinstance(wanted, dict) and "lat" in places and places["lat"].unit is not None
    if asked or not {"lat", "lon"} <= columns.keys():
        return
    far = [float(np.nanmax(np.abs(columns[key]), initial=0.0)) for key in ("lat", "lon")]
    if max(far) > 0.05 and far[0] <= 0.5 * np.pi and far[1] <= np.pi and table.head:
        both = {key: places[key].place for key in ("lat", "lon")}
        by = [table.option(both, dict.fromkeys(both, unit)) for unit in ("rad", "deg")]
        raise PathError(
            f"{table.name}: {places['lat']} and {places['lon']} are radians, as there is no road"
            f" at latitude {far[0]:.3g}, longitude {far[1]:.3g}: {by[0]}; or else {by[1]}"
        )


def before_fix(lat: Floats, lon: Floats) -> NDArray[np.bool_]:
    """Find the rows before a receiver has a position: 0, 0, where others are elsewhere."""
    none = (lat == 0.0) & (lon == 0.0)
    elsewhere = np.abs(lat) + np.abs(lon) > 1.0
    found: NDArray[np.bool_] = none & elsewhere.any()
    return found


def local(
    name: str, degrees: Floats, origin: tuple[float, float] | None
) -> tuple[Floats, tuple[float, float], str]:
    """Turn latitudes and longitudes [deg] into x east and y north of an origin [m], (N, 2).

    Gives these, the origin, which is the first of them by default, and what is said of it.
    The plane is a transverse Mercator projection about the origin on WGS 84: lengths are right to
    1e-6 within 9 km of its meridian.
    """
    require("a file of latitudes and longitudes", "geo")
    from pyproj import Transformer
    from pyproj.exceptions import ProjError

    for values, most, what in ((degrees, 90.0, 0), (degrees, 360.0, 1)):
        wrong = np.flatnonzero(np.abs(values[:, what]) > most)
        if wrong.size:
            said = "latitude" if what == 0 else "longitude"
            value = values[wrong[0], what]
            raise PathError(
                f"{name}: {said} of waypoint {wrong[0]} is {value:g}, which is no degrees:"
                " export it in WGS 84 (EPSG:4326), or as CSV with x and y"
                + "; 1e-7 degrees are read as lat_e7 and lon_e7"
                * int(abs(value) > 1e6),
                int(wrong[0]),
            )
    if origin is None:
        origin = round(float(degrees[0, 0]), 9), round(float(degrees[0, 1]), 9)
    plane = f"+proj=tmerc +lat_0={origin[0]!r} +lon_0={origin[1]!r} +k=1 +ellps=WGS84 +units=m"
    try:
        turned = Transformer.from_crs("EPSG:4326", plane, always_xy=True)
        x, y = turned.transform(degrees[:, 1], degrees[:, 0], errcheck=True)
    except ProjError as error:
        raise PathError(f"{name}: lies too far from the origin: {str(error)[:100]}") from error
    said = f"x and y from the origin {origin[0]:.9f},{origin[1]:.9f} (--origin)"
    return np.column_stack((x, y)), origin, said


def positions(name: str, text: str) -> tuple[Floats, list[str]] | None:
    """Give latitude and longitude [deg] of each point of a GPX or GeoJSON file; None of others.

    Beside them are notes of what was put together.
    """
    if is_json(text) and '"coordinates"' in text:
        return _geojson(name, text)
    if text.lstrip().startswith("<") and "<gpx" in text[:5000]:
        return _gpx(name, text), []
    return None


def _gpx(name: str, text: str) -> Floats:
    found: dict[str, list[tuple[float, float]]] = {kind: [] for kind in _POINTS}

    def start(tag: str, attributes: dict[str, str]) -> None:
        kind = tag.rpartition(":")[2]
        if kind in found:
            found[kind].append((float(attributes["lat"]), float(attributes["lon"])))

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    try:
        parser.Parse(text, True)  # noqa: FBT003 - expat takes it by place
    except (expat.ExpatError, KeyError, ValueError) as error:
        said = " ".join(str(error).split())[:100]
        raise PathError(f"{name}, line {parser.CurrentLineNumber}: is no GPX: {said}") from error
    return _points(name, next((points for points in found.values() if points), []))


def _geojson(name: str, text: str) -> tuple[Floats, list[str]]:
    try:
        lines = _lines(json.loads(text))
        whole = _chained(lines)
        points = [(point[1], point[0]) for point in whole or []]
    except (ValueError, RecursionError, TypeError, AttributeError, LookupError) as error:
        said = " ".join(str(error).split())[:100]
        raise PathError(f"{name}: is no GeoJSON: {said}") from error
    if whole is None:
        raise PathError(
            f"{name}: has {len(lines)} lines, which do not follow one another from end to end: keep"
            " the one that is the path"
        )
    return _points(name, points), [f"{len(lines)} lines, joined"] if len(lines) > 1 else []


def _chained(lines: list[Any]) -> list[Any] | None:
    """Join lines of which each begins where one ends, as a map's ways do; None where they fork."""
    begins = {tuple(line[0][:2]): line for line in lines}
    if len(begins) < len(lines):
        return None
    ends = {tuple(line[-1][:2]) for line in lines}
    first = next((begin for begin in begins if begin not in ends), next(iter(begins), ()))
    joined = list(begins.pop(first, []))
    while begins:
        onward = begins.pop(tuple(joined[-1][:2]), None)
        if onward is None:
            return None
        joined += onward[1:]
    return joined


def _lines(found: Any) -> list[Any]:  # noqa: ANN401 - JSON
    """Give the coordinates of the lines in a GeoJSON object; of points alone, theirs as one."""
    kind = found["type"]
    if kind == "FeatureCollection":
        parts = [each["geometry"] for each in found["features"]]
        if parts and all(part["type"] == "Point" for part in parts):
            return [[part["coordinates"] for part in parts]]
        return [line for part in parts if part["type"] != "Point" for line in _lines(part)]
    if kind == "Feature":
        return _lines(found["geometry"])
    if kind in ("LineString", "MultiPoint"):
        return [found["coordinates"]]
    if kind in ("MultiLineString", "Polygon"):
        return list(found["coordinates"])
    raise ValueError(f"no line, but {str(kind)[:40]}")


def _points(name: str, points: list[tuple[float, float]]) -> Floats:
    try:
        found = np.array(points, dtype=np.float64).reshape(-1, 2)
    except (ValueError, TypeError, OverflowError) as error:
        raise PathError(f"{name}: a position is not two numbers") from error
    if not np.isfinite(found).all():
        raise PathError(f"{name}: a position is not finite")
    return found
