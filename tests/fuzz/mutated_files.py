"""Files of waypoints and logs with faults: each is read, or refused in one line.

``python -m tests.fuzz.mutated_files 10000`` tries as many, of all kinds, and says how many were
read, how long the slowest took and how much memory all of them did.
"""

from __future__ import annotations

import json
import random
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from popsteer import Path as Course
from popsteer import logs
from popsteer.errors import PopsteerError
from popsteer.extras import MissingExtra, missing

YAW = 0.1 * np.arange(60)
X, Y = 20.0 * np.sin(YAW), 20.0 * (1.0 - np.cos(YAW))


def kinds() -> dict[str, bytes]:
    """Give a file of each kind."""
    one, t, c, n = np.ones(60), 0.05 * np.arange(60), np.cos(YAW), np.sin(YAW)
    lat, lon = 48.0 + Y / 111000.0, 11.0 + X / 74000.0
    points = "".join(f'<trkpt lat="{a}" lon="{b}"/>' for a, b in zip(lat, lon, strict=True))
    line = {"type": "LineString", "coordinates": np.column_stack((lon, lat)).tolist()}
    motec = '"Format","MoTeC CSV File"\n"Venue","oval"\n\n"Time","Ground Speed","Steering Angle",'
    motec += '"Car Coord X","Car Coord Y","Heading"\n"s","km/h","rad","m","m","deg"\n\n'
    vbox = "File created on 01/05/2024\n\n[header]\ntime\n\n[column names]\nsats time lat long"
    vbox += " velocity heading steer\n\n[data]\n"
    minutes = (12 * one, 120000 + t, 60 * lat, -60 * lon, 18 * one, 90 - np.degrees(YAW), 0.1 * one)
    stamps = 1650775094781591296 + (50_000_000 * np.arange(60))
    exported = [",".join(map(str, row)) for row in zip(stamps, X, Y, 0 * X, one, YAW, strict=True)]
    head = "%time,field.pose.position.x,field.pose.position.y,q.z,q.w,delta\n"
    found = {
        "plain": _table((X, Y), ","),
        "head": "x,y,speed\n" + _table((X, Y, 5 * one), ","),
        "tum": "# 17b4\n# s_m; x_m; y_m; psi_rad; vx_mps\n"
        + _table((20 * YAW, X, Y, YAW - 1.5708, 5 * one), "; "),
        "logger": _table((X, Y, YAW, 5 * one), ", "),
        "commas": "x;y;v\n" + _table((X, Y, 5 * one), ";").replace(".", ","),
        "spaces": _table((X, Y, 20 * YAW, -np.sin(YAW), np.cos(YAW)), " "),
        "poses": _table((t, X, Y, one, 0 * c, 0 * c, np.sin(YAW / 2), np.cos(YAW / 2)), " "),
        "kitti": _table((c, 0 * c, -n, -Y, 0 * c, one, 0 * c, one, n, 0 * c, c, X), " "),
        "sides": "x,y,type\n" + _table((X, Y), ",").replace("\n", ",left\n"),
        "coarse": _table((np.arange(60) % 20, (np.arange(60) // 9) ** 2), "\t"),
        "gpx": f"<?xml version='1.0'?><gpx><trk><trkseg>{points}</trkseg></trk></gpx>",
        "geojson": json.dumps({"type": "Feature", "geometry": line}),
        "json": json.dumps({"x": X.tolist()}),
        "yaml": "waypoints:\n" + "".join(f"- x: {x}\n" for x in X),
        "log": "t,x,y,yaw,speed,steer\n" + _table((t, X, Y, YAW, 5 * one, 0.1 * one), ","),
        "quaternion": "s,ns,x,y,qz,qw,V,delta\n"
        + "".join(f"1650775094,{5 * 10**7 * k},{X[k]},{Y[k]},0,1,5,0.1\n" for k in range(20)),
        "rostopic": head + "\n".join(exported),
        "motec": motec + _table((t, 18 * one, 0.1 * one, X, Y, np.degrees(YAW)), ","),
        "vbox": vbox + _table(minutes, " "),
        "iso": "time,x,y,yaw,v,steer\n"
        + "".join(f"2024-05-01T12:00:{0.05 * k:09.6f},{X[k]},{Y[k]},0,5,0\n" for k in range(60)),
    }
    return {kind: text.encode() for kind, text in found.items()}


def _table(columns: tuple[Any, ...], separator: str) -> str:
    rows = np.column_stack(columns).tolist()
    return "".join(separator.join(f"{each:.6f}" for each in row) + "\n" for row in rows)


_INSERTED: tuple[bytes, ...] = (
    b"",
    b",",
    b";",
    b"\t",
    b"\n",
    b"#",
    b'"',
    b"\0",
    b"nan",
    b"1e999",
    b"\xff",
    b"[",
    b"{",
)
_INSERTED += (b"<", b"9" * 400, b"x", b"-", b"%", b"\xef\xbb\xbf", b"x,y\n", "\u2028".encode())


def mutated(data: bytes, draw: random.Random) -> bytes:
    """Damage a file: cut, repeat, swap, insert, or make much of a part of it."""
    for _ in range(draw.randint(1, 4)):
        size = len(data)
        first, last = sorted(draw.randint(0, size) for _ in range(2))
        last = min(last, first + draw.choice((1, 3, 40, size)))
        part = draw.choice(_INSERTED)
        change = draw.randint(0, 5)
        if change == 0:
            data = data[:first] + data[last:]
        elif change == 1:
            data = data[:first] + part + data[first:]
        elif change == 2:
            data = data[:first] + part + data[last:]
        elif change == 3:
            data = data[:last] + data[first:last] + data[last:]
        elif change == 4 and size:
            place = draw.randrange(size)
            data = data[:place] + bytes([draw.randrange(256)]) + data[place + 1 :]
        elif draw.random() < 0.02:  # 10 MB at most
            data = data[:first] + data[first:last] * (10_000_000 // max(1, last - first))
            data = data[:10_000_000]
    return data


def check(data: bytes, file: Path) -> bool:
    """Read a file as waypoints and as a log; whether one of them was read."""
    file.write_bytes(data)
    read = 0
    for reader in (Course.from_csv, logs.read_csv):
        try:
            found: Any = reader(file)
        except MissingExtra:
            continue
        except PopsteerError as error:
            said = str(error)
        else:
            source = found.source if isinstance(found.source, str) else found.source()
            said, read = source, read + 1
        assert "\n" not in said, said
        assert len(said) < 2000, said[:2000]
    return read > 0


def run(count: int, seed: int) -> tuple[int, float]:
    """Try mutated files of all kinds in turn; how many were read, and the longest time [s]."""
    draw, files, longest, read = random.Random(seed), list(kinds().values()), 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mutated.csv"
        for k in range(count):
            data = mutated(files[k % len(files)], draw)
            begun = time.process_time()
            read += check(data, file)
            longest = max(longest, time.process_time() - begun)
    return read, longest


def main() -> None:
    """Try as many as the command line says."""
    count = int(sys.argv[1])
    read, longest = run(count, 1)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    geo = "" if not missing("pyproj") else ", without pyproj"
    print(f"{count} files: {read} read, {longest:.1f} s the slowest, {most:.0f} MB at most{geo}")


if __name__ == "__main__":
    main()
