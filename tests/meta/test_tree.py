"""A few rules about the tree as a whole."""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
from pathlib import Path

import pytest

import popsteer
from tests.helpers import ROOT, looped

# Doc comments of the binding are the docstrings of the Python classes, and no code to read.
LONGEST = 500
_TOP = """
    .cargo .ci .editorconfig .github .gitignore .pre-commit-config.yaml
    benches docs examples python ros2 rust studies tests
    ARCHITECTURE.md CHANGELOG.md CITATION.cff CONTRIBUTING.md LICENSE README.md
    Cargo.lock Cargo.toml Makefile pyproject.toml rustfmt.toml
"""
_RUST_DOC = re.compile(r"^\s*//[/!]")
_MACHINE = re.compile(
    r"""
      /(?:home|root|Users)/\w            # somebody's folder
    | /(?:work|workspace|builds|mnt)/\w  # a build machine's
    | [A-Z]:\\\\?Users
    | \b(?:10|192\.168|172\.(?:1[6-9]|2\d|3[01]))(?:\.\d{1,3}){2,3}\b
    | \b(?!hypothesis\.)[\w-]+\.(?:internal|local|lan|corp)\b(?!\()
    """,
    re.VERBOSE,
)


def _tracked() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-z"],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    if listed.returncode != 0:
        pytest.skip(f"no git checkout in {ROOT}: {listed.stderr.strip()}")
    files = [ROOT / name for name in listed.stdout.split("\0") if name]
    return [file for file in files if file.is_file()]


def _text(file: Path) -> str | None:
    try:
        return file.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return None


def _version() -> str:
    manifest = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
    found = re.search(
        r'^\[workspace\.package\]\n(?:(?!\[).*\n)*?version = "([^"]+)"', manifest, re.MULTILINE
    )
    assert found, "no version in [workspace.package]"
    return found[1]


def test_top_level_has_what_belongs_there() -> None:
    # What a command of a page writes where it is run is not the project's.
    found = {file.relative_to(ROOT).parts[0] for file in _tracked()}
    assert found - set(_TOP.split()) == set()


def test_tracked_files_name_no_machine() -> None:
    found = []
    read = 0
    for file in _tracked():
        text = _text(file)
        read += text is not None
        for number, line in enumerate((text or "").splitlines(), start=1):
            if _MACHINE.search(line) and file != Path(__file__):
                found.append(f"{file.relative_to(ROOT)}:{number}: {line.strip()}")
    assert read > 50
    assert not found, "\n".join(found)


def test_nothing_promises_popsteer_on_an_index_that_does_not_have_it() -> None:
    """`pip install popsteer` of an index; a wheel, in a file or in a folder of them, is there."""
    named = re.compile(r"pip install(?!.*--find-links)[^`\n]*[\s\"']popsteer(?![-\w]*[-.*])")
    assert named.search('pip install "popsteer[lab]"')
    assert named.search("pip install popsteer highway-env")
    found = [
        f"{file.relative_to(ROOT)}: {line.strip()}"
        for file in _tracked()
        if file != Path(__file__)
        for line in (_text(file) or "").splitlines()
        if named.search(line)
    ]
    assert found == []


@looped(
    "line",
    ["see /home/" + "ann/x", "cd /work/" + "main", "at 192.168" + ".0.7", "ssh box." + "internal"],
)
def test_machine_pattern_sees_paths_and_hosts(line: str) -> None:
    assert _MACHINE.search(line)


@looped(
    "line", ["framework/x", "a /usr/bin/env", "threading.local()", "0.10.2", "hypothesis.internal"]
)
def test_machine_pattern_leaves_others_alone(line: str) -> None:
    assert not _MACHINE.search(line)


def test_source_files_read_in_one_sitting() -> None:
    folders = ("python", "rust", "tests", "benches", "studies")
    files = [file for folder in folders for file in (ROOT / folder).rglob("*.*")]
    sources = [
        file for file in files if file.suffix in (".py", ".rs") and "target" not in file.parts
    ]
    assert len(sources) > 100
    long = {}
    for file in sources:
        lines = (_text(file) or "").splitlines()
        if file.suffix == ".rs":
            lines = [line for line in lines if not _RUST_DOC.match(line)]
        if len(lines) > LONGEST:
            long[str(file.relative_to(ROOT))] = len(lines)
    assert not long


def test_each_test_of_the_core_is_of_one_of_its_two_crates() -> None:
    folder = ROOT / "rust" / "core" / "tests"
    manifests = [
        _text(file) or "" for file in (folder / "Cargo.toml", folder.parent / "Cargo.toml")
    ]
    for file in folder.glob("*.rs"):
        listed = [f'path = "{where}{file.name}"' for where in ("", "tests/")]
        found = [line in text for line, text in zip(listed, manifests, strict=True)]
        assert sum(found) == 1, file.name


def test_versions_agree() -> None:
    version = _version()
    assert popsteer.__version__ == version
    assert importlib.metadata.version("popsteer") == version
    lock = (ROOT / "Cargo.lock").read_text(encoding="utf-8")
    for crate in ("popsteer-core", "popsteer-sim", "popsteer-py", "popsteer-c", "popsteer-wasm"):
        assert f'name = "{crate}"\nversion = "{version}"\n' in lock


def test_changelog_tells_of_the_current_version() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\n## [{_version()}]" in changelog


@pytest.mark.parametrize("file", ["docs/parameters.md", "rust/c/include/popsteer.h"])
def test_defaults_are_told_in_words_and_formulas_not_in_rust(file: str) -> None:
    text = (ROOT / file).read_text(encoding="utf-8")
    assert "`wheelbase / 12.0`" in text
    assert not re.findall(r"unwrap_or|`[^`\n]*\bif [^`\n]*\{|} else", text)
