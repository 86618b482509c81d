from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from popsteer.files import write_bytes_atomic, write_text_atomic

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
