"""examples/embedded: the core on a Cortex-M4F, its size, and its angles."""

from __future__ import annotations

import math
import os
import shutil
import struct
import subprocess

import pytest

import popsteer
from tests.helpers import ROOT

EXAMPLE = ROOT / "examples" / "embedded"
# The folder of tests/no_std: both compile the same core.
TARGET = ROOT / "target" / "no_std"
THUMB = "thumbv7em-none-eabihf"


def build(*options: str) -> None:
    cargo = shutil.which("cargo")
    if cargo is None:
        pytest.skip("cargo is not on the path")
    built = subprocess.run(
        [cargo, "build", "--release", "--locked", *options],
        cwd=EXAMPLE,
        env=os.environ | {"CARGO_TARGET_DIR": str(TARGET)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr


def build_thumb(*options: str) -> bytes:
    rustc = shutil.which("rustc")
    if rustc is None:
        pytest.skip("rustc is not on the path")
    asked = [rustc, "--print", "target-libdir", "--target", THUMB]
    folder = subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()
    if not os.path.isdir(folder):  # noqa: PTH112 - as rustc printed it
        pytest.skip(f"the target is not installed: rustup target add {THUMB}")
    build("--target", THUMB, *options)
    return (TARGET / THUMB / "release" / "popsteer-embedded").read_bytes()


def on_host() -> list[str]:
    build()
    program = TARGET / "release" / "popsteer-embedded"
    return subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()


def drive(law: type[popsteer.Pop | popsteer.PreviewPop]) -> list[float]:
    path = popsteer.Path([(float(k), 8.0 * math.sin(k / 25.0)) for k in range(200)])
    car = popsteer.Vehicle(wheelbase=2.7, dead_time=0.15, max_steer=0.6, max_steer_rate=0.5)
    controller = law(path, car)
    vehicle = (0.0, 1.0, 0.3, 8.0)
    angles = []
    for _ in range(100):
        angles.append(controller.steer(*vehicle, 0.05))
        vehicle = popsteer.paper.kinematic_bicycle(*vehicle, angles[-1], 0.0, 2.7, 0.05)
    return angles


def loaded(elf: bytes) -> list[tuple[int, int, int]]:
    """Read address, bytes in the file and bytes in memory of what a 32-bit program loads."""
    assert elf[:5] == b"\x7fELF\x01"
    start, size, count = struct.unpack_from("<I", elf, 28) + struct.unpack_from("<HH", elf, 42)
    headers = (struct.unpack_from("<8I", elf, start + k * size) for k in range(count))
    return [(at, stored, used) for kind, _, at, _, stored, used, *_ in headers if kind == 1]


def test_embedded_example_steers_as_the_binding() -> None:
    angles = [struct.unpack(">d", bytes.fromhex(line))[0] for line in on_host()]
    expected = drive(popsteer.Pop) + drive(popsteer.PreviewPop)
    assert max(abs(a - b) for a, b in zip(angles, expected, strict=True)) <= 1e-12
    assert max(expected) - min(expected) > 0.05


def test_embedded_example_fits_a_microcontroller(capsys: pytest.CaptureFixture[str]) -> None:
    # That it links says that nothing in it can panic.
    segments = loaded(build_thumb())
    flash = sum(stored for _, stored, _ in segments)
    ram = sum(used for at, _, used in segments if at >= 0x20000000)
    with capsys.disabled():
        print(f"\n{THUMB}: {flash} bytes of flash, {ram} bytes of RAM beside the stack")  # noqa: T201
    assert 0x8000 < flash < 0x30000
    assert ram < 0x100


def test_embedded_example_steers_on_the_board_as_here() -> None:
    qemu = shutil.which("qemu-system-arm")
    if qemu is None:
        pytest.skip("qemu-system-arm is not on the path")
    build_thumb("--features", "semihosting")
    program = TARGET / THUMB / "release" / "popsteer-embedded"
    board = subprocess.run(
        [qemu, "-M", "mps2-an386", "-nographic", "-semihosting", "-kernel", program],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    assert (board.stdout + board.stderr).split() == on_host()
