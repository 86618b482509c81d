"""The rows of a sweep on the disk: a journal while it runs, one whole file at its end."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from popsteer.errors import ConfigError, PopsteerError
from popsteer.extras import require
from popsteer.files import read_bytes, write_bytes_atomic
from popsteer.lab.common.document import differing
from popsteer.lab.sweep.job import Job, document_of, from_text
from popsteer.sim import Metrics

if TYPE_CHECKING:
    from typing_extensions import Self

_Rows = list[tuple[str, dict[str, Any]]]

_KINDS = (".parquet", ".csv")
_META = b"popsteer"
_CSV = "# popsteer sweep "
_MOST_COLUMNS = 200
# What a row has besides its draws, as `popsteer.lab.sweep.job.drive` gives it; and of what kind.
_OF_METRICS = {each.name: each.type for each in fields(Metrics) if each.name != "faults"}
_FIGURES = (*_OF_METRICS, "faults")
_KINDS_OF: dict[str, type] = {"run": int, "seed": int, "success": bool, "faults": int} | {
    name: {"bool": bool, "int": int}.get(str(kind), float) for name, kind in _OF_METRICS.items()
}


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
        self._file, self._job = file, job

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
        head, _, lines = data[:whole].decode("utf-8", "replace").partition("\n")
        if not whole:
            # Empty, or killed within the first line: there is nothing to lose.
            if not self._job.text.encode().startswith(data):
                raise PopsteerError(f"{self._file}: no sweep of popsteer")
            stream.truncate(0)
            self._write((self._job.text + "\n").encode())
            return
        with _naming(self._file):
            check_same(head, self._job)
            rows = _journalled(lines)
            _check(self._job, rows)
        for _, row in rows:
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
    if file.suffix.lower() == ".csv":
        text = io.StringIO(newline="")
        text.write(f"{_CSV}{job.text}\n")
        writer = csv.DictWriter(text, ordered[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(ordered)
        write_bytes_atomic(file, text.getvalue().encode())
        return
    arrow, parquet = _pyarrow()
    kinds = {"run": arrow.int64(), "seed": arrow.uint64(), "faults": arrow.int64()}
    columns = {
        name: arrow.array([row[name] for row in ordered], type=kinds.get(name))
        for name in ordered[0]
    }
    table = arrow.table(columns).replace_schema_metadata({_META: job.text.encode()})
    stream = io.BytesIO()
    parquet.write_table(table, stream, write_page_checksum=True)
    write_bytes_atomic(file, stream.getvalue())


def read(file: Path, named: Collection[str] = ()) -> tuple[Job, list[dict[str, Any]]]:
    """Read the sweep and its rows from a file that `write` wrote, or from a journal.

    Code of one's own is run only if it is `named`. PopsteerError, which names file and line, where
    it is no sweep, or one of another version, or a row is not as it was written.
    """
    with _naming(file):
        text, rows, whole = _parsed(file)
        job = from_text(text, named)
        _check(job, rows, whole=whole)
    return job, [row for _, row in rows]


def read_row(file: Path, run: int, named: Collection[str] = ()) -> tuple[Job, dict[str, Any]]:
    """Read the sweep and the row of one run, from a file as `read` takes it."""
    job, rows = read(file, named)
    found = next((row for row in rows if row["run"] == run), None)
    if found is None:
        raise ConfigError("--run", f"{file}:{run}", f"one of its {len(rows)} runs")
    return job, found


def read_rows(file: Path, job: Job) -> list[dict[str, Any]]:
    """Read the rows of a sweep that is known; PopsteerError where the file is of another."""
    with _naming(file):
        text, rows, whole = _parsed(file)
        check_same(text, job)
        _check(job, rows, whole=whole)
    return [row for _, row in rows]


@contextmanager
def _naming(file: Path) -> Iterator[None]:
    """Put the file before the words of an error."""
    try:
        yield
    except PopsteerError as error:
        raise PopsteerError(f"{file}: {error}") from None


def _parsed(file: Path) -> tuple[str, _Rows, bool]:
    """Give the sweep's text, its rows, each with where it stands, and whether they are all."""
    data = read_bytes(file)
    if data.startswith(b"PAR1"):
        return *_of_parquet(data), True
    text, _, rest = data.decode("utf-8", "replace").partition("\n")
    if text.startswith(_CSV):
        return text.removeprefix(_CSV), _of_csv(rest), True
    document_of(text)  # refuses what is no sweep before its lines are read
    return text, _journalled(rest[: rest.rfind("\n") + 1]), False


def _of_parquet(data: bytes) -> tuple[str, _Rows]:
    _, parquet = _pyarrow()
    try:
        file = parquet.ParquetFile(io.BytesIO(data), page_checksum_verification=True)
        # The seeds of the runs cannot be compressed: what unpacks to more is none of ours.
        known = file.metadata
        if 8 * known.num_rows > len(data) or known.num_columns > _MOST_COLUMNS:
            raise ValueError(f"{known.num_rows} rows of {known.num_columns} columns")  # noqa: TRY301
        table = file.read()
        text = (table.schema.metadata or {}).get(_META, b"").decode()
        rows = [(f"row {k}", row) for k, row in enumerate(table.to_pylist(), start=1)]
    except Exception as error:  # a damaged file may break pyarrow anywhere
        raise PopsteerError(f"no Parquet file of a sweep: {error}") from error
    return text, rows


def _of_csv(text: str) -> _Rows:
    rows: _Rows = []
    lines = csv.reader(io.StringIO(text, newline=""))
    try:
        names = next(lines, [])
        for cells in lines:
            where = f"line {lines.line_num + 1}"
            if len(cells) != len(names):
                raise PopsteerError(f"{where} has {len(cells)} entries for {len(names)} columns")
            row = zip(names, cells, strict=True)
            rows.append((where, {name: _value(where, name, cell) for name, cell in row}))
    except csv.Error as error:
        raise PopsteerError(f"line {lines.line_num + 1}: {error}") from None
    return rows


def _value(where: str, name: str, text: str) -> Any:
    kind = _KINDS_OF.get(name, float)
    try:
        return {"True": True, "False": False}[text] if kind is bool else kind(text)
    except (KeyError, ValueError):
        raise _no_value(where, name, text) from None


def _no_value(where: str, name: str, value: object) -> PopsteerError:
    kind = {bool: "True or False", int: "a whole number"}.get(_KINDS_OF.get(name, float))
    return PopsteerError(f"{where}: {ConfigError(name, value, kind or 'a number')}")


def _journalled(text: str) -> _Rows:
    rows: _Rows = []
    for number, line in enumerate(text.split("\n")[:-1], start=2):
        try:
            row = json.loads(line)
        except (ValueError, RecursionError):
            row = None
        if not isinstance(row, dict):
            raise PopsteerError(f"line {number} is no row of a sweep")
        rows.append((f"line {number}", row))
    return rows


def _check(job: Job, rows: _Rows, *, whole: bool = False) -> None:
    """Refuse rows that are not of this sweep, or, of a `whole` file, are not all there."""
    names = ["run", "seed", "success", *job.vary, *_FIGURES]
    seen: set[int] = set()
    for due, (where, row) in enumerate(rows):
        if list(row) != names:
            other = next((a for a, b in zip(names, row, strict=False) if a != b), names[-1])
            raise PopsteerError(f"{where}: the columns are not those of its sweep, at {other!r}")
        for name, value in row.items():
            if type(value) is not _KINDS_OF.get(name, float):
                raise _no_value(where, name, value)
        run = row["run"]
        if not 0 <= run < job.runs or run in seen or (whole and run != due):
            wanted = due if whole else f"one of {job.runs}, and only once"
            raise PopsteerError(f"{where}: {ConfigError('run', run, str(wanted))}")
        seen.add(run)
    if whole and len(rows) < job.runs:
        raise PopsteerError(f"{job.runs - len(rows)} of {job.runs} runs are missing at its end")
    for where, row in rows:
        for name, value in {"seed": job.seed_of(row["run"]), **job.drawn(row["run"])}.items():
            if row[name] != value:
                said = ConfigError(name, row[name], f"{value}, as drawn")
                raise PopsteerError(f"{where}: {said}")


def check_same(text: str, job: Job) -> None:
    """Refuse to go on with the rows of another sweep, by saying in what they differ."""
    if text != job.text:
        differs = ", ".join(differing(json.loads(job.text), document_of(text))) or "spelling"
        raise PopsteerError(f"holds another sweep, which differs in {differs}")


def _pyarrow() -> tuple[Any, Any]:
    require("Parquet", "parquet")
    import pyarrow as pa
    from pyarrow import parquet

    return pa, parquet
