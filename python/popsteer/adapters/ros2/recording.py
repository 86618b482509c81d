"""MCAP files of messages, as Foxglove, Rerun and ``ros2 bag`` read them."""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from popsteer.adapters.ros2 import conversions
from popsteer.adapters.ros2.diagnostics import run_message
from popsteer.adapters.ros2.messages import PATH, TRAJECTORY, encode, store
from popsteer.adapters.ros2.topics import Topics
from popsteer.errors import ConfigError, PopsteerError
from popsteer.files import check_files, write_bytes_atomic

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping

    from typing_extensions import Self

    from popsteer.adapters.ros2.dds import Participant
    from popsteer.sim import Run

_FRAME = "map"
# The records "data end" and "footer", which say that there is no index, and the magic number.
_END = b"\x0f\x04" + bytes(11) + b"\x02\x14" + bytes(27) + b"\x89MCAP0\r\n"
_FLUSH = 1.0  # how often what has been written is given to the system [s]
_PERIOD = 0.01  # how often `tap` looks for messages [s]


class Recording:
    """Writes messages to an MCAP file, which grows second by second.

    If the process is killed, the file has all but its last second.

    Parameters
    ----------
    file : str or os.PathLike
        The file, ``*.mcap``; an existing one is replaced by the first message.

    Raises
    ------
    ConfigError
        The file is not called ``*.mcap``.
    OSError
        Its folder cannot be written to.
    PopsteerError
        The extra ``ros2`` is not installed.

    Examples
    --------
    >>> import tempfile
    >>> from popsteer import logs
    >>> from popsteer.adapters.ros2 import ackermann_message, odometry_message
    >>> folder = tempfile.TemporaryDirectory()
    >>> with Recording(f"{folder.name}/drive.mcap") as recording:
    ...     for k in range(3):
    ...         at = 1_000_000_000 + k * 20_000_000
    ...         recording.add("/odom", odometry_message(0.1 * k, 0.0, 0.0, 5.0, at, "map"), at)
    ...         recording.add("/drive", ackermann_message(0.1, 5.0, 0.0, at, "base_link"), at)
    >>> logs.read(f"{folder.name}/drive.mcap").steer[0].round(6)
    np.float64(0.1)
    >>> folder.cleanup()
    """

    def __init__(self, file: str | os.PathLike[str]) -> None:
        store()  # names the extra where it is missing
        self.file = FilePath(file)
        if self.file.suffix != ".mcap":
            raise ConfigError("recording", str(file), "a file *.mcap")
        check_files([self.file])
        self.file.parent.mkdir(parents=True, exist_ok=True)
        self._writer: Any = None
        self._connections: dict[tuple[str, str], Any] = {}
        self._flushed = 0.0
        self._closed = False
        self.count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        # What failed before anything came in leaves no file.
        self.close(discard=kind is not None and self.count == 0)

    def add(self, topic: str, message: Any, nanoseconds: int) -> None:  # noqa: ANN401
        """Write a message of a topic, sent or received at a time [ns]."""
        self.add_bytes(topic, message.__msgtype__, encode(message), nanoseconds)

    def add_bytes(self, topic: str, kind: str, data: bytes, nanoseconds: int) -> None:
        """Write the bytes of a message of a topic and type, sent or received at a time [ns]."""
        if self._writer is None:
            self._begin()
        if (topic, kind) not in self._connections:
            self._connections[topic, kind] = self._writer.add_connection(
                topic, kind, typestore=store()
            )
        self._writer.write(self._connections[topic, kind], nanoseconds, data)
        self.count += 1
        if time.monotonic() - self._flushed > _FLUSH:
            self._flush()

    def close(self, *, discard: bool = False) -> None:
        """Finish the file; `discard` leaves none."""
        if self._closed or (discard and self._writer is None):
            return
        self._closed = True
        if self._writer is None:
            self._begin()
        with tempfile.TemporaryDirectory() as folder:
            self._writer.metapath = FilePath(folder) / "metadata.yaml"  # which nobody needs
            self._writer.close()
        if discard:
            self.file.unlink()

    def _flush(self) -> None:
        """Give the system what has been written, with an end that the next message replaces."""
        storage = self._writer.storage
        storage.close_chunk()
        end = storage.bio.tell()
        storage.bio.write(_END)
        storage.bio.seek(end)
        self._flushed = time.monotonic()

    def _begin(self) -> None:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.rosbag2.enums import CompressionMode

        self.file.unlink(missing_ok=True)
        folder: Any = _Folder(self.file)
        plugin = StoragePlugin.MCAP
        self._writer = Writer(f"{self.file}.bag", version=9, storage_plugin=plugin)
        # Not `open`, which makes a folder: the file is to be where it stays.
        self._writer.storage = Writer.STORAGE_PLUGINS[plugin](folder, CompressionMode.NONE)
        self._flushed = time.monotonic()


class _Folder:
    """The folder of a bag, as rosbags asks for it, whose only file is a given one."""

    def __init__(self, file: FilePath) -> None:
        self.name = file.stem
        self._file = file

    def __truediv__(self, _: str) -> FilePath:
        return self._file


def record_run(run: Run, file: str | os.PathLike[str]) -> int:
    """Write a simulated run as the messages that a node would have exchanged, whole or not at all.

    Odometry, drive commands, diagnostics and the path, with stamps from 1 s on.

    Parameters
    ----------
    run : Run
        The run.
    file : str or os.PathLike
        The file, ``*.mcap``.

    Returns
    -------
    int
        How many messages were written.

    Raises
    ------
    ConfigError
        The file is not called ``*.mcap``.
    OSError
        It cannot be written.
    PopsteerError
        The extra ``ros2`` is not installed.

    Examples
    --------
    >>> import tempfile
    >>> from popsteer import Path, Stanley, sim
    >>> run = sim.run(Stanley(Path([(0.0, 0.0), (90.0, 0.0)])), constant_speed=8.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     count = record_run(run, f"{folder}/run.mcap")
    >>> count == 3 * len(run.records["time"]) + 1
    True
    """
    topics = Topics()
    records = {name: values.tolist() for name, values in run.records.items()}
    x, y = run.path.x, run.path.y
    steps = list(zip(x[:-1], y[:-1], x[1:], y[1:], strict=True))
    headings = [math.atan2(d - b, c - a) for a, b, c, d in steps]
    named = Recording(file).file  # refuses what cannot be written
    with tempfile.TemporaryDirectory() as folder:
        whole = FilePath(folder) / named.name
        with Recording(whole) as recording:
            course = conversions.path_message(x, y, [*headings, headings[-1]], _time(0.0), _FRAME)
            recording.add(topics.path, course, _time(0.0))
            for k, time in enumerate(records["time"]):
                row = {name: values[k] for name, values in records.items()}
                at = _time(time)
                pose = row["x"], row["y"], row["yaw"], row["speed"]
                recording.add(topics.odometry, conversions.odometry_message(*pose, at, _FRAME), at)
                drive = conversions.ackermann_message(
                    row["steer"], row["speed"], 0.0, at, "base_link"
                )
                recording.add(topics.command, drive, at)
                recording.add(topics.diagnostics, run_message(row, at), at)
        write_bytes_atomic(named, whole.read_bytes())
        return recording.count


def _time(seconds: float) -> int:
    """Give the stamp; 0 would mean that there is none."""
    return 10**9 + round(seconds * 1e9)


def tap(
    participant: Participant,
    topics: Mapping[str, str],
    recording: Recording,
    stopped: Callable[[], bool],
    *,
    timeout: float = 10.0,
    seconds: float = float("inf"),
) -> dict[str, int]:
    """Record topics, given with their types, until it is stopped; gives how many messages of each.

    Waits `timeout` [s] for the first message, else PopsteerError; ends after `seconds`.
    """
    # Only a path may have been published before it matters; the others may be of best effort.
    readers = {
        topic: (participant.latest if kind in (PATH, TRAJECTORY) else participant.reader)(
            topic, kind
        )
        for topic, kind in topics.items()
    }
    counts = dict.fromkeys(topics, 0)
    begun = time.monotonic()
    while not stopped() and time.monotonic() - begun < seconds:
        time.sleep(_PERIOD)
        for topic, kind in topics.items():
            for data in readers[topic].take():
                recording.add_bytes(topic, kind, data, time.time_ns())
                counts[topic] += 1
        participant.graph.look()
        if not any(counts.values()) and time.monotonic() - begun >= timeout:
            why = "; ".join(
                f"{topic}: {participant.graph.why_silent(topic, kind, readers[topic])}"
                for topic, kind in topics.items()
            )
            raise PopsteerError(
                f"no message in domain {participant.domain} within {timeout:g} s: {why}"
            )
    return counts
