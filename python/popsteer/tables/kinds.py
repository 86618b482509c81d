"""Files that are no tables, recognised by how they begin; and what to export instead."""

from __future__ import annotations

import re

_CSV = "export it as CSV with the columns x and y"
_MAGIC = (
    *((bytes((0x80, version)), "pickle", _CSV) for version in range(2, 6)),
    (b"\x93NUMPY", "numpy array", "numpy.savetxt writes it as text, with header= for the names"),
    (b"PK\x03\x04", "zip archive (Excel, KMZ and npz are)", _CSV),
    (b"\x1f\x8b", "gzip archive", "unpack it"),
    (b"SQLite format 3", "SQLite database", "popsteer reads it as a log if it is named *.db3"),
    (b"\x89MCAP", "MCAP file", "popsteer reads it as a log if it is named *.mcap"),
    (b"#ROSBAG", "ROS 1 bag", "popsteer reads it as a log if it is named *.bag"),
    (b"PAR1", "Parquet file", _CSV),
    (b"\x89HDF", "HDF5 file", _CSV),
    (b"MATLAB 5.0", "MATLAB file", "writematrix or writetable writes it as text"),
    (b"%PDF", "PDF", _CSV),
    (b"\x89PNG", "picture", _CSV),
)
_XML = (
    ("<html", "HTML"),
    ("<kml", "KML"),
    ("<osm", "OSM or lanelet2"),
    ("<OpenDRIVE", "OpenDRIVE"),
    ("<gpx", "GPX"),
)
_MARKS = (
    (
        "version https://git-lfs",
        "is a pointer to a file of Git LFS, no table: 'git lfs pull' fetches that",
    ),
    *((each, f"is NMEA, no table: {_CSV}, or as GPX") for each in ("$GP", "$GN", "$PS")),
    (
        "LabVIEW Measurement",
        "has LabVIEW's preamble: leave out what stands above X_Value, and Comment behind the names",
    ),
    *(
        (each, "is a Python list, no table: numpy.savetxt writes it as text")
        for each in ("(", "[(")
    ),
    ("$", "has a section's title of AgOpenGPS above the numbers: leave out what stands there"),
    ("QGC WPL", "is a mission of ArduPilot or PX4, no table: export it as CSV with lat and lon"),
)
# But pandas calls an index "Unnamed: 0".
_YAML = re.compile(
    r"(?:[^\S\n]*(?:#.*)?\n)*(?:---|\s*- [\[{]|\s*(?:- )?(?!Unnamed: \d)[A-Za-z_][\w ]*:(?:\s|$))"
)
# What `ros2 topic echo --csv` writes of types with a header, without names, by their number.
_POSE = "x y z qx qy qz qw"
_COVARIANCE = " covariance" * 36
_ECHOED = {
    3 + 7: f"sec nanosec frame_id {_POSE}",
    3 + 7 + 36: f"sec nanosec frame_id {_POSE}{_COVARIANCE}",
    4 + 2 * 36 + 7 + 6: f"sec nanosec frame_id child_frame_id {_POSE}{_COVARIANCE}"
    f" linear_x linear_y linear_z angular_x angular_y angular_z{_COVARIANCE}",
    3 + 5: "sec nanosec frame_id steering_angle steering_angle_velocity speed acceleration jerk",
}
_WKT = re.compile(r'[^\n]*\n[^\n]*"?(?:POINT|(?:MULTI)?LINESTRING)\b[ ZM]*\(')


def echoed(row: list[str]) -> list[str]:
    """Give the names of what ROS 2 echoes as CSV, which begins with a stamp and a frame."""
    names = _ECHOED.get(len(row), "").split()
    texts = [k for k, name in enumerate(names) if name.endswith("frame_id")]
    stamped = names and row[0].isdecimal() and row[1].isdecimal() and int(row[1]) < 10**9
    framed = all(re.match(r"[/A-Za-z_]", row[k]) for k in texts)
    return names if stamped and framed else []


def is_json(text: str) -> bool:
    """Whether a text begins as JSON does."""
    return re.match(r"\s*(?:\{|\[\s*(?:[\[{\"\]\d-]|$))", text) is not None


def refusal(data: bytes) -> str | None:
    """Say of bytes that are no text what they are, and what to do; None where it is not known."""
    for magic, kind, remedy in _MAGIC:
        if data.startswith(magic):
            return f"is a {kind}, no table: {remedy}"
    return None


def text_refusal(text: str) -> str | None:
    """Say the same of a text: of JSON, XML, YAML and what only holds or names a table."""
    if is_json(text):
        return f"is JSON, no table: {_CSV}, or as GeoJSON with a LineString"
    if text.lstrip().startswith("<"):
        kind = next((kind for mark, kind in _XML if mark in text[:5000]), "XML")
        return f"is {kind}, no table: {_CSV}, or as GPX"
    for mark, said in _MARKS:
        if text.startswith(mark):
            return said
    if _WKT.match(text[:5000]):
        return "has its positions as WKT: export it as CSV with GEOMETRY=AS_XY, or as GeoJSON"
    if _YAML.match(text[:5000]):
        return f"is YAML, no table: {_CSV}"
    return None
