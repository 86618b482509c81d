"""Logs from MCAP files and ROS 2 bags, read by rosbags without ROS."""

from __future__ import annotations

import math
import os
from functools import partial, reduce
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.errors import unknown
from popsteer.extras import require
from popsteer.files import alike
from popsteer.logs.log import Log, LogError
from popsteer.logs.messages import ODOMETRY, POSES, SPEEDS, STEERING, Steering, typestore
from popsteer.logs.units import factor
from popsteer.tables.quantities import converted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import NDArray
    from typing_extensions import Self

    Floats = NDArray[np.float64]

TOPICS = ("odometry", "steer", "pose", "speed")
"""What topics may be asked for."""
_PARTS = (("pose", POSES), ("speed", SPEEDS))
_SHOWN = 12
_MOST_OF_CHUNK = 1 << 28  # bytes
_MOST_PACKED = 100
"""How many times as large as a packed file it may be; recordings shrink to a tenth."""


def read_bag(
    file: str | os.PathLike[str],
    *,
    topics: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    progress: Callable[[float], object] | None = None,
) -> Log:
    """Read a log from an MCAP file, or from the folder or file of a ROS 2 bag.

    Poses and speeds are those of ``nav_msgs/Odometry``, a row of the log for each; the heading is
    the quaternion's yaw, the speed ``twist.twist.linear.x``. Where another topic has the poses
    (``PoseStamped``, ``PoseWithCovarianceStamped``) or the speeds (``TwistStamped``,
    ``TwistWithCovarianceStamped``, Autoware's ``VelocityReport``), `topics` names it: the rows are
    those of the poses, and the speeds are interpolated. Angles are those of
    ``ackermann_msgs/AckermannDriveStamped`` (or ``AckermannDrive``), or Autoware's ``Control``
    command or ``SteeringReport``, each at its own time. Times are the messages' own stamps; where
    those are empty, the times of recording.

    `popsteer.logs.read` describes the parameters. LogError where the file cannot be read, or has no
    such topic; PopsteerError where the extra ``lab`` is not installed.
    """
    require("a bag or an MCAP file", "lab", "rosbags")
    from rosbags.highlevel import AnyReader, AnyReaderError

    _bound_unpacking()
    path, asked = Path(file), dict(topics or {})
    for key, unit in (units or {}).items():
        factor(key, unit)  # refused before the file is read
    if strange := [key for key in asked if key not in TOPICS]:
        raise LogError(unknown("topic", strange[0], TOPICS))
    if not (path.is_file() or path.is_dir()):  # of a pipe its end would be waited for
        raise LogError(f"{path}: cannot be read: {_no_bag(path)}")
    try:
        with AnyReader([path], default_typestore=typestore()) as reader:
            steer = _choose(path, reader.connections, "steer", STEERING, asked)
            poses, said = _motion(path, reader, asked, progress)
            kind = STEERING[steer[0].msgtype]

            def angle(message: Any) -> tuple[float, ...]:  # noqa: ANN401
                return (float(reduce(getattr, kind.angle, message)),)

            angles = _read(reader, steer, kind.stamp, angle, progress, 0.6)
    except AnyReaderError as error:
        why = f"{path}: is no bag or MCAP file that can be read: {error}"
        if "end magic" in str(error):
            why += " If its recording was cut off, mcap recover mends it."
        raise LogError(why) from error
    except OSError as error:
        why = error.strerror or str(error)
        raise LogError(f"{path}: cannot be read: {why}") from error
    except (LogError, KeyboardInterrupt):
        raise
    except Exception as error:  # a broken file may break rosbags anywhere
        raise LogError(f"{path}: cannot be read as a bag or MCAP file: {error!r}") from error
    said.append(f"steer ({steer[0].topic})")
    return _log(path, poses, angles, kind, dict(units or {}), steer[0].topic, said)


def _no_bag(path: Path) -> str:
    """Word why a path leads to neither a file nor a folder."""
    if path.exists():
        return "is neither a file nor a folder"
    meant = alike(path)
    return f"no such file or folder{f', did you mean {meant}?' if meant else ''}"


class _Bounded:
    """A stream that is read no farther than so many bytes."""

    def __init__(self, stream: Any, most: int) -> None:  # noqa: ANN401 - zstd's, of two modules
        self._stream, self._most, self._left = stream, most, most

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()

    def read(self, size: int) -> bytes:
        """Read up to so many bytes; ValueError where there are more than are allowed."""
        found: bytes = self._stream.read(size)
        self._left -= len(found)
        if self._left < 0:
            raise ValueError(f"it unpacks to more than {self._most:,} bytes")
        return found


def _bound_unpacking() -> None:
    """Let rosbags unpack no chunk of an MCAP file to more than the file says, nor beyond a bound.

    It would unpack whatever there is, and compare the sizes then: 4 MB may become 6 GB. Packed
    messages have the bound of a chunk, packed files (``*.db3.zstd``) that of `_MOST_PACKED`.
    """
    from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]
    from rosbags.rosbag2 import reader, storage_mcap

    def bounded(make: Callable[[], Any]) -> Callable[[bytes, int], bytes]:
        def unpacked(data: bytes, size: int) -> bytes:
            if size > _MOST_OF_CHUNK:
                raise ValueError(f"a chunk of {size:,} bytes, more than {_MOST_OF_CHUNK:,}")
            found: bytes = make().decompress(data, max_length=size + 1)
            return found

        return unpacked

    zstd: Any = storage_mcap.zstd
    storage_mcap.DECOMPRESSORS["zstd"] = bounded(zstd.ZstdDecompressor)
    storage_mcap.DECOMPRESSORS["lz4"] = bounded(LZ4FrameDecompressor)

    def opened(packed: Any, mode: str) -> _Bounded:  # noqa: ANN401 - a file
        size = os.fstat(packed.fileno()).st_size
        return _Bounded(zstd.open(packed, mode), max(_MOST_PACKED * size, _MOST_OF_CHUNK))

    def message(data: bytes) -> bytes:
        found: bytes = zstd.ZstdDecompressor().decompress(data, max_length=_MOST_OF_CHUNK + 1)
        if len(found) > _MOST_OF_CHUNK:
            raise ValueError(f"a message unpacks to more than {_MOST_OF_CHUNK:,} bytes")
        return found

    bounds: Any = SimpleNamespace(open=opened, decompress=message)
    reader.zstd = bounds


def _choose(
    path: Path, connections: list[Any], what: str, types: Iterable[str], asked: dict[str, str]
) -> list[Any]:
    """Choose the connections of a topic, or say which topics there are."""
    there = sorted({(c.topic, c.msgtype) for c in connections})
    listed = ", ".join(f"{topic} ({kind})" for topic, kind in there[:_SHOWN])
    listed += ", ..." if len(there) > _SHOWN else ""
    if what in asked:
        found = [c for c in connections if c.topic == asked[what]]
        if not found:
            raise LogError(f"{path}: no topic {asked[what]!r}; there are: {listed or 'none'}")
        if found[0].msgtype not in types:
            raise LogError(
                f"{path}: {asked[what]} is of type {found[0].msgtype}; {what} must be of"
                f" {' or '.join(types)}"
            )
        return found
    for kind in types:  # in the order of preference
        found = [c for c in connections if c.msgtype == kind and c.msgcount > 0]
        names = sorted({c.topic for c in found})
        if len(names) > 1:
            raise LogError(
                f"{path}: several topics of {kind}: {', '.join(names)}; choose one, as --topic"
                f" {what}={names[0]}"
            )
        if found:
            return found
    parts = {key: [c.topic for c in connections if c.msgtype in kinds] for key, kinds in _PARTS}
    remedy = ""
    if what == "odometry" and all(parts.values()):
        named_so = (f"--topic {key}={names[0]}" for key, names in parts.items())
        remedy = f" ({' '.join(named_so)} takes both from topics of their own)"
    raise LogError(
        f"{path}: no topic of {' or '.join(types)} for {what}; there are: {listed or 'none'}"
        f"{remedy}"
    )


def _read(
    reader: Any,  # noqa: ANN401 - rosbags is an extra
    connections: list[Any],
    stamp: tuple[str, ...] | None,
    values: Callable[[Any], tuple[float, ...]],
    progress: Callable[[float], object] | None,
    begun: float,
) -> Floats:
    """Read the messages of a topic: time of the message, time of recording, values."""
    rows = []
    total = max(1, sum(c.msgcount for c in connections))
    for count, (connection, recorded, data) in enumerate(reader.messages(connections)):
        message = reader.deserialize(data, connection.msgtype)
        own = float("nan")
        if stamp is not None:
            time = reduce(getattr, stamp, message)
            own = time.sec + 1e-9 * time.nanosec if time.sec or time.nanosec else own
        rows.append((own, 1e-9 * recorded, *values(message)))
        if progress is not None and count % 256 == 0:
            progress(begun + 0.5 * count / total)
    return np.array(rows)


def _motion(
    path: Path,
    reader: Any,  # noqa: ANN401 - rosbags is an extra
    asked: dict[str, str],
    progress: Callable[[float], object] | None,
) -> tuple[Floats, list[str]]:
    """Read poses and speeds, of odometry or of topics of their own, and say of which."""

    def read(what: str, kinds: Mapping[str, Any], values: Any, begun: float) -> tuple[Floats, str]:  # noqa: ANN401
        types = kinds if what in asked else {ODOMETRY: kinds[ODOMETRY]}
        key = what if what in asked else "odometry"
        found = _choose(path, reader.connections, key, types, asked)
        part, stamp = kinds[found[0].msgtype]
        rows = _read(reader, found, stamp, partial(values, part), progress, begun)
        return rows, f"{what} ({found[0].topic})"

    if "pose" in asked or "speed" in asked:
        poses, pose = read("pose", POSES, _pose, 0.0)
        speeds, speed = read("speed", SPEEDS, _speed, 0.3)
        return _joined(path, poses, speeds), [pose, speed]

    def both(part: tuple[str, ...], message: Any) -> tuple[float, ...]:  # noqa: ANN401
        return _pose(part, message) + _speed(SPEEDS[ODOMETRY][0], message)

    poses, pose = read("pose", POSES, both, 0.0)
    return poses, [pose.replace("pose", "pose and speed", 1)]


def _pose(part: tuple[str, ...], message: Any) -> tuple[float, ...]:  # noqa: ANN401
    pose = reduce(getattr, part, message)
    place, turn = pose.position, pose.orientation
    yaw = math.atan2(
        2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z)
    )
    return float(place.x), float(place.y), yaw


def _speed(part: tuple[str, ...], message: Any) -> tuple[float, ...]:  # noqa: ANN401
    return (float(reduce(getattr, part, message)),)


def _joined(path: Path, poses: Floats, speeds: Floats) -> Floats:
    """Put the speeds to the poses: interpolated at their times."""
    if not (len(poses) and len(speeds)):
        raise LogError(f"{path}: its index promises messages that are not there")
    clock = 1 if np.isnan(poses[:, 0]).any() or np.isnan(speeds[:, 0]).any() else 0
    order = np.argsort(speeds[:, clock], kind="stable")
    own, values = speeds[order, clock], speeds[order, 2]
    there = np.interp(poses[:, clock], own, values, left=math.nan, right=math.nan)
    if not np.isfinite(there).any():
        raise LogError(f"{path}: poses and speeds have no time in common")
    return np.column_stack((poses, there))


def _log(
    path: Path,
    poses: Floats,
    angles: Floats,
    kind: Steering,
    units: dict[str, str],
    topic: str,
    said: list[str],
) -> Log:
    """Put all topics on one clock."""
    if not (len(poses) and len(angles)):
        raise LogError(f"{path}: its index promises messages that are not there")
    remarks = []
    stamped = not (np.isnan(poses[:, 0]).any() or np.isnan(angles[:, 0]).any())
    clock = 0 if stamped else 1
    if not stamped:
        remarks.append("messages without stamps: their times of recording are taken")
    start = poses[0, clock]
    t, given = poses[:, clock] - start, angles[:, clock] - start
    order = np.argsort(given, kind="stable")
    given, steer = given[order], angles[order, 2]
    steer = converted("steer", units.get("steer", "rad"), steer)
    finite = np.isfinite(steer)
    given, steer = given[finite], steer[finite]
    # A row has the command that holds at its time; before the first that one.
    held = np.clip(np.searchsorted(given, t, side="right") - 1, 0, None)
    if not len(given) or given[-1] < t.min() or given[0] > t.max():
        raise LogError(f"{path}: the angles of {topic} and the odometry have no time in common")
    if not kind.commanded:
        remarks.append(
            f"{topic} has measured angles: dead time and lag are those from the wheels on, not from"
            " the command"
        )
    if not np.ptp(poses[:, 2:4], axis=0).any():
        remarks.append(f"{said[0]}: the position never changes")
    scaled: dict[str, Any] = {
        key: converted(key, units.get(key, "1"), poses[:, k])
        for k, key in enumerate(("x", "y", "yaw", "speed"), start=2)
    }
    return Log(
        t,
        **scaled,
        steer=steer[held],
        name=path.name,
        remarks=tuple(remarks),
        commands=(given, steer),
        source=f"{path.name}: {len(t)} rows of {', '.join(said)}",
    )
