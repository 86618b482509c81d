from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from popsteer.files import (
    check_files,
    check_folder,
    write_bytes_atomic,
    write_files_atomic,
    write_text_atomic,
)

posix_only = pytest.mark.skipif(os.name != "posix", reason="needs POSIX files")


def test_write_bytes_new_file_holds_them_and_nothing_else_is_left(tmp_path: Path) -> None:
    write_bytes_atomic(tmp_path / "a.bin", b"\x00\r\n\xff")
    assert (tmp_path / "a.bin").read_bytes() == b"\x00\r\n\xff"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.bin"]


def test_write_text_is_utf8_with_line_ends_untouched(tmp_path: Path) -> None:
    write_text_atomic(str(tmp_path / "a.txt"), "δ\r\nε\n")
    assert (tmp_path / "a.txt").read_bytes() == "δ\r\nε\n".encode()


def test_write_text_missing_folders_are_made(tmp_path: Path) -> None:
    write_text_atomic(tmp_path / "a" / "b" / "c.txt", "x")
    assert (tmp_path / "a" / "b" / "c.txt").read_text(encoding="utf-8") == "x"


def test_write_text_bare_name_goes_to_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_text_atomic("bare.txt", "x")
    assert (tmp_path / "bare.txt").is_file()


def test_write_text_existing_file_is_replaced(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("a much longer old content", encoding="utf-8")
    write_text_atomic(file, "new")
    assert file.read_text(encoding="utf-8") == "new"


def test_write_text_that_cannot_be_encoded_leaves_the_old_file(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old", encoding="utf-8")
    with pytest.raises(UnicodeEncodeError):
        write_text_atomic(file, "\ud800")
    assert file.read_text(encoding="utf-8") == "old"


@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_write_bytes_interrupted_leaves_the_old_file_and_no_temporary(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failure: BaseException
) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old", encoding="utf-8")

    def fail(*_: object) -> None:
        raise failure

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(type(failure)):
        write_bytes_atomic(file, b"new")
    assert file.read_text(encoding="utf-8") == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]


def test_write_bytes_failure_names_the_file_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied", "some temporary name")

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(PermissionError, match="Permission denied") as caught:
        write_bytes_atomic(tmp_path / "a.bin", b"")
    assert caught.value.filename == str(tmp_path / "a.bin")


def test_write_bytes_to_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"directory|denied"):
        write_bytes_atomic(tmp_path, b"x")
    assert list(tmp_path.iterdir()) == []


def test_write_bytes_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    with pytest.raises(OSError, match="a"):
        write_bytes_atomic(tmp_path / "a" / "b.txt", b"x")
    assert (tmp_path / "a").read_bytes() == b"old"


@posix_only
@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
def test_write_bytes_permissions_follow_the_umask(tmp_path: Path, umask: int, mode: int) -> None:
    before = os.umask(umask)
    try:
        write_bytes_atomic(tmp_path / "a.bin", b"x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.bin").stat().st_mode) == mode


@posix_only
def test_write_bytes_through_a_link_keeps_the_link(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "there" / "a.bin")
    write_bytes_atomic(link, b"x")
    assert link.is_symlink()
    assert (tmp_path / "there" / "a.bin").read_bytes() == b"x"


@posix_only
@pytest.mark.parametrize("below", ["", "a.bin"])
def test_write_bytes_through_a_loop_of_links_is_refused(tmp_path: Path, below: str) -> None:
    (tmp_path / "one").symlink_to("two")
    (tmp_path / "two").symlink_to("one")
    with pytest.raises(OSError, match=r"one") as caught:
        write_bytes_atomic(tmp_path / "one" / below, b"x")
    assert caught.value.errno == errno.ELOOP
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["one", "two"]


@posix_only
def test_write_bytes_to_a_device_does_not_replace_it() -> None:
    write_bytes_atomic(os.devnull, b"x")
    assert not Path(os.devnull).is_file()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
def test_write_bytes_to_a_full_device_names_it() -> None:
    with pytest.raises(OSError, match="No space left") as caught:
        write_bytes_atomic("/dev/full", b"x")
    assert caught.value.filename == "/dev/full"


def test_write_files_one_refused_writes_none(tmp_path: Path) -> None:
    (tmp_path / "old").write_bytes(b"old")
    (tmp_path / "taken").mkdir()
    files = {tmp_path / "old": b"new", tmp_path / "new": b"new", tmp_path / "taken": b"new"}
    with pytest.raises(IsADirectoryError) as caught:
        write_files_atomic(files)
    assert caught.value.filename == str(tmp_path / "taken")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["old", "taken"]
    assert (tmp_path / "old").read_bytes() == b"old"


@posix_only
def test_write_files_disk_full_at_the_last_writes_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, data: bytes) -> int:
        with (Path("/dev/full") if path.name == "c" else path).open("wb") as stream:
            return stream.write(data)

    (tmp_path / "a").write_bytes(b"old")
    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left on device") as caught:
        write_files_atomic({tmp_path / name: b"new" for name in "abc"})
    assert caught.value.filename == str(tmp_path / "c")
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"old"


def test_write_files_none_is_nothing() -> None:
    write_files_atomic({})


def test_check_of_what_can_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    check_files([tmp_path / "a", tmp_path / "new" / "b", os.devnull])
    check_folder(tmp_path, ["a", "new/b"])
    check_folder(tmp_path / "new" / "newer", ["a"])
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"old"


@posix_only
def test_check_follows_links_that_lead_nowhere_yet(tmp_path: Path) -> None:
    (tmp_path / "taken").write_bytes(b"mine")
    (tmp_path / "good").symlink_to(tmp_path / "there" / "a")
    (tmp_path / "bad").symlink_to(tmp_path / "taken" / "a")
    check_files([tmp_path / "good"])
    check_folder(tmp_path / "good")
    with pytest.raises(NotADirectoryError) as caught:
        check_files([tmp_path / "bad"])
    assert caught.value.filename == str(tmp_path / "bad")
    with pytest.raises(NotADirectoryError):
        check_folder(tmp_path / "bad")
