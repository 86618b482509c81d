"""The installed C interface, and programs compiled against it."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.helpers import ROOT

SOURCES = Path(__file__).parent
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
SANITIZED = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
STANDARD = {"gcc": "-std=c11", "g++": "-std=c++17"}


def tool(name: str) -> str:
    """Find a program; skip the test where there is none."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not on the path")
    return found


def run(*command: object, **environment: str) -> str:
    """Run a program that succeeds and says nothing but what it prints."""
    done = subprocess.run(
        [str(each) for each in command],
        cwd=ROOT,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{done.args} ended with {done.returncode}:\n{done.stderr}"
    return done.stdout


def install(prefix: Path, *where: str) -> Path:
    """Install the interface under `prefix`, as its users do; `where` as make takes it."""
    tool("cargo")
    # With the line tables that `benches.instruction_counts` builds with: the core is built once.
    lines = {"CARGO_PROFILE_RELEASE_DEBUG": "line-tables-only"}
    run(tool("make"), "install-c", f"PREFIX={prefix}", *where, **lines)
    return prefix


def compile_program(prefix: Path, compiler: str, source: Path, *flags: str) -> Path:
    """Compile a program against the interface under `prefix`."""
    program = prefix / "bin" / "".join((source.name, *flags))
    program.parent.mkdir(exist_ok=True)
    found = run(
        tool("pkg-config"),
        *("--cflags", "--libs", "popsteer"),
        PKG_CONFIG_PATH=str(prefix / "lib" / "pkgconfig"),
    )
    run(
        *(tool(compiler), STANDARD[compiler], *STRICT, *flags, source, *found.split(), "-lm"),
        *(f"-Wl,-rpath,{prefix / 'lib'}", "-o", program),
    )
    return program
