"""The rows of a sweep on the disk: a journal while it runs, one whole file at its end."""

from __future__ import annotations

import csv
import io
import json
import os
from typing import IO, TYPE_CHECKING, Any

from popsteer.errors import ConfigError, PopsteerError
from popsteer.extras import require
from popsteer.files import write_bytes_atomic
from popsteer.lab.sweep.job import Job, from_text

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from typing_extensions import Self

_KINDS = (".parquet", ".csv")
_META = b"popsteer"
_CSV = "# popsteer sweep "


def journal_of(file: Path) -> Path:
    """Name the journal beside a sweep's file; ConfigError if that is no Parquet or CSV."""
    if file.suffix.lower() not in _KINDS:
        raise ConfigError("--out", str(file), "a file *.parquet or *.csv")
    if file.suffix.lower() == ".parquet":
        _pyarrow()
    return file.with_name(f"{file.name}.part")


class Journal:
    """Rows as they come, a line each after the sweep's; half a line at its end is cut off.

    PopsteerError where the file is of another sweep or another process writes it, OSError where it
    cannot be written.
    """

    def __init__(self, file: Path, job: Job) -> None:
        self.rows: dict[int, dict[str, Any]] = {}
        self._file = file
        self._job = job

    def __enter__(self) -> Self:
        file = self._file
        file.parent.mkdir(parents=True, exist_ok=True)
        if file.exists() and not file.is_file():  # reading a device might never end
            raise PopsteerError(f"{file}: is no regular file")
        self._stream: IO[bytes] = file.open("a+b", buffering=0)
        try:
            self._resume(self._stream)
        except BaseException:
            self._stream.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()

    def add(self, rows: Iterable[dict[str, Any]]) -> None:
        """Write new rows to the disk; OSError where they cannot be written, rows before stand."""
        new = {row["run"]: row for row in rows if row["run"] not in self.rows}
        lines = "".join(json.dumps(row, separators=(",", ":")) + "\n" for row in new.values())
        self._write(lines.encode())
        self.rows |= new

    def _resume(self, stream: IO[bytes]) -> None:
        from filelock import lock_descriptor

        if not lock_descriptor(stream.fileno(), blocking=False):
            raise PopsteerError(f"{self._file}: another process is writing it")
        stream.seek(0)
        data = stream.read()
        whole = data.rfind(b"\n") + 1
        head, *lines = data[:whole].decode("utf-8", "replace").splitlines() or [""]
        if not data or not whole:
            # Empty, or killed within the first line: there is nothing to lose.
            if data and not self._job.text.encode().startswith(data):
                raise PopsteerError(f"{self._file}: no sweep of popsteer")
            stream.truncate(0)
            self._write((self._job.text + "\n").encode())
            return
        check_same(self._file, head, self._job)
        for line in lines:
            row = json.loads(line)
            self.rows.setdefault(row["run"], row)
        stream.truncate(whole)

    def _write(self, data: bytes) -> None:
        view = memoryview(data)
        try:
            while view:
                view = view[self._stream.write(view) :]
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise OSError(error.errno, error.strerror, os.fspath(self._file)) from error


def write(file: Path, job: Job, rows: Iterable[dict[str, Any]]) -> None:
    """Write Parquet or CSV by the file's name, whole or not at all, in the order of the runs."""
    ordered = sorted(rows, key=lambda row: int(row["run"]))
    columns = {name: [row[name] for row in ordered] for name in ordered[0]}
    if file.suffix.lower() == ".csv":
        text = io.StringIO(newline="")
        text.write(f"{_CSV}{job.text}\n")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        write_bytes_atomic(file, text.getvalue().encode())
        return
    arrow, parquet = _pyarrow()
    kinds = {"run": arrow.int64(), "seed": arrow.uint64(), "faults": arrow.int64()}
    table = arrow.table(
        {name: arrow.array(values, type=kinds.get(name)) for name, values in columns.items()}
    ).replace_schema_metadata({_META: job.text.encode()})
    stream = io.BytesIO()
    parquet.write_table(table, stream)
    write_bytes_atomic(file, stream.getvalue())


def read(file: Path) -> tuple[Job, list[dict[str, Any]]]:
    """Read the sweep and its rows from a file that `write` wrote, or from a journal.

    PopsteerError, which names the file, where it is no sweep or one of another version.
    """
    try:
        text, rows = _parsed(file)
        return from_text(text), rows
    except PopsteerError as error:
        raise PopsteerError(f"{file}: {error}") from None


def read_row(file: Path, run: int) -> tuple[Job, dict[str, Any]]:
    """Read the sweep and the row of one run, from a file as `read` takes it."""
    job, rows = read(file)
    found = next((row for row in rows if row["run"] == run), None)
    if found is None:
        raise ConfigError("--run", f"{file}:{run}", f"one of its {len(rows)} runs")
    return job, found


def _parsed(file: Path) -> tuple[str, list[dict[str, Any]]]:
    data = file.read_bytes()
    if data.startswith(b"PAR1"):
        _, parquet = _pyarrow()
        try:
            table = parquet.read_table(io.BytesIO(data))
        except ValueError as error:  # what pyarrow's errors are
            raise PopsteerError(f"no Parquet file: {error}") from None
        return (table.schema.metadata or {}).get(_META, b"").decode(), table.to_pylist()
    text = data.decode("utf-8", "replace")
    first, _, rest = text.partition("\n")
    if not first.startswith(_CSV):
        lines = rest[: rest.rfind("\n") + 1].splitlines()
        from_text(first)  # refuses what is no sweep before its lines are read
        return first, [json.loads(line) for line in lines]
    rows = [{k: _value(v) for k, v in row.items()} for row in csv.DictReader(io.StringIO(rest))]
    return first.removeprefix(_CSV), rows


def _value(text: str) -> Any:  # noqa: ANN401 - as the column is
    if text in ("True", "False"):
        return text == "True"
    try:
        return int(text)
    except ValueError:
        return float(text)


def check_same(file: Path, text: str, job: Job) -> None:
    """Refuse to go on with the rows of another sweep, by saying in what they differ."""
    if text == job.text:
        return
    try:
        other = json.loads(from_text(text).text)
    except PopsteerError as error:
        raise PopsteerError(f"{file}: {error}") from None
    mine = json.loads(job.text)
    differs = ", ".join(name for name in mine if mine[name] != other.get(name))
    raise PopsteerError(f"{file}: holds another sweep, which differs in {differs}")


def _pyarrow() -> tuple[Any, Any]:
    require("Parquet", "parquet")
    import pyarrow as pa
    from pyarrow import parquet

    return pa, parquet
