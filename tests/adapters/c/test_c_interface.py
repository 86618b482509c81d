"""The C and C++ interface: compiled as its users compile, and held against Python bit by bit."""

from __future__ import annotations

import ctypes
import math
import os
import random
import re
import shutil
from typing import TYPE_CHECKING

import pytest

import popsteer
from benches import instruction_counts
from studies.chain import Chain
from tests.adapters.c.programs import SANITIZED, SOURCES, compile_program, install, run, tool
from tests.adapters.c.recorder import Recorder, Waypoints, bits, words
from tests.helpers import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

PAGE = ROOT / "docs" / "c.md"
DT = 0.05
LATE = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    understeer=0.002,
    steer_offset=0.01,
    dead_time=0.12,
    max_steer=0.6,
    max_steer_rate=0.5,
)
LAWS = ("Pop", "PreviewPop", "Pid", "PurePursuit", "Stanley")


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    tool("gcc")
    return install(tmp_path_factory.mktemp("prefix"))


@pytest.fixture(scope="module")
def replay(prefix: Path) -> Path:
    return compile_program(prefix, "gcc", SOURCES / "replay.c", *SANITIZED)


def ring(aside: float) -> Waypoints:
    """Go round a bumpy ring of about 63 m in radius, `aside` [m] inside of it."""
    points = []
    for k in range(400):
        bearing = 2.0 * math.pi * k / 400
        radius = 63.0 + 3.0 * math.sin(6.0 * bearing) - aside
        points.append((radius * math.cos(bearing), radius * math.sin(bearing), 8.0 + k % 3))
    return points


def shuttle() -> Waypoints:
    """Go forward along a bend, and back to its begin."""
    forth = [(k, 10.0 * math.cos(k / 30.0), 5.0) for k in range(60)]
    return [*forth, *((x, y, -3.0) for x, y, _ in reversed(forth[:-1]))]


def drive(recorder: Recorder, start: tuple[float, float, float], seed: int) -> Iterator[int]:
    """Drive a lap by the recorded controller, with all that a real loop brings along."""
    noise = random.Random(seed)
    car = Chain(LATE, start, 8.0, DT)
    applied = 0.0
    for step in range(1100):
        yield step
        pose = (car.x + noise.gauss(0.0, 0.01), car.y, car.yaw + noise.gauss(0.0, 1e-3))
        if step % 97 == 41:
            command = recorder.lose(DT, step % 2)
        elif 500 <= step < 650:
            command = recorder.step_reported(pose, 8.0, DT, applied, 0.1 * (step % 2))
        else:
            command = recorder.step(pose, 8.0, DT)
        applied = command.steer
        car.advance(applied)


@pytest.mark.parametrize("law", LAWS)
def test_c_lap_is_that_of_python_bit_for_bit(law: str, replay: Path, tmp_path: Path) -> None:
    recorder = Recorder(law, LATE, [(ring(0.0), True), (ring(1.5), True), (shuttle(), False)])
    for step in drive(recorder, (64.0, 0.0, 0.5 * math.pi), seed=LAWS.index(law)):
        if step in (300, 400):
            recorder.set_path(step // 100 % 2)
        if step in (100, 700):
            recorder.predict(21, DT)
            recorder.estimate()
        if step == 800:
            recorder.relocalise((0.0, 60.0, 3.1))
        if step == 900:
            recorder.reset(0.1)
    recorder.reset()
    recorder.set_path(2)
    for k in range(100):
        heading = 0.2 if k < 60 else -0.1
        recorder.step((min(k, 118 - k), 9.5, heading), 5.0 if k < 60 else -3.0, 0.2)
    script = tmp_path / "script"
    script.write_text("\n".join(recorder.script) + "\n", encoding="utf-8")

    said = run(replay, law, script).splitlines()
    assert len(said) == len(recorder.answers) > 1200
    for number, (here, there) in enumerate(zip(recorder.answers, said, strict=True)):
        assert bits(here) == bits(there), f"answer {number}"
    angles = {here.split()[0] for here in recorder.answers}
    assert len(angles) > 300


def test_c_speeds_are_those_of_python_bit_for_bit(prefix: Path, tmp_path: Path) -> None:
    """There and back over a hill, by the vehicle's file: plan, and each step of the tracker."""
    program = compile_program(prefix, "gcc", SOURCES / "paced.c", *SANITIZED)
    car = LATE.replace(max_speed=9.0, drive_lag=0.3, max_deceleration=2.0)
    file, script = tmp_path / "car.toml", tmp_path / "script"
    car.save(file)
    rows = []
    for k in range(100):
        slope, bend = 0.2 * math.cos(k / 25.0), -0.008 * math.sin(k / 25.0)
        shape = math.atan(slope), bend / (1.0 + slope * slope) ** 1.5
        there = 7.0 if k < 99 else -3.0
        rows.append((k, 5.0 * math.sin(k / 25.0), there, 0.05 * math.sin(k / 20.0), *shape))
    rows += [(x, y, -3.0, *others) for x, y, _, *others in reversed(rows[:-1])]
    x, y, speeds, grade, yaw, curvature = zip(*rows, strict=True)
    xy = list(zip(x, y, strict=True))
    path = popsteer.Path(xy, speed=speeds, grade=grade, yaw=yaw, curvature=curvature)
    tracker, steering = popsteer.SpeedTracker(path, car), popsteer.PreviewPop(path, car)
    answers = [words(each) for each in tracker.plan]
    lines = [str(len(rows)), *(words(*row) for row in rows)]
    at, v, drive = [1.0, 0.5, 0.2], 0.0, 0.0
    stood = cannot = False
    for step in range(1700):
        pose = (*at, v, DT)
        lines.append(words(*pose))
        pace = tracker.step(*pose)
        answers.append(
            f"{words(pace.acceleration, pace.reference_speed, pace.distance_to_stop)} "
            f"{int(pace.reverse)} {int(pace.standing)} {int(pace.cannot_stop)}"
        )
        if step == 200:
            lines.append(words(*pose[:4], 0.0))
            tracker.set_path(path)
        stood, cannot = stood or pace.standing, cannot or pace.cannot_stop
        drive += (pace.acceleration - drive) * DT / 0.3
        v += (-drive if pace.reverse else drive) * DT
        v = min(v, 0.0) if pace.reverse else max(v, 0.0)
        if not cannot and not pace.reverse and pace.distance_to_stop < 12.0:
            v = 14.0  # faster than the brakes can stop before the cusp
        turn = math.tan(steering.step(*pose).steer) / car.wheelbase
        at = [
            at[0] + v * DT * math.cos(at[2]),
            at[1] + v * DT * math.sin(at[2]),
            at[2] + v * DT * turn,
        ]
    script.write_text("\n".join(lines) + "\n", encoding="utf-8")
    said = run(program, file, script).splitlines()
    assert stood
    assert cannot
    assert [bits(line) for line in said] == [bits(line) for line in answers]


def test_c_driver_is_that_of_python_bit_for_bit(prefix: Path, tmp_path: Path) -> None:
    """A drive with gaps, an operator's stop, a fresh path, a lost localisation and its release."""
    program = compile_program(prefix, "gcc", SOURCES / "driver.c", *SANITIZED)
    car = LATE.replace(steer_offset=0.01, dead_time=0.15)
    paths = [
        popsteer.Path([(float(k), 8.0 * math.sin(k / 25.0) + aside) for k in range(300)])
        for aside in (0.0, 0.05)
    ]
    driver, plant = popsteer.Driver(paths[0], car), Chain(car, (0.0, 0.5, 0.3), 0.0, DT)
    lines, answers, faults = [], [], set()
    for step in range(900):
        pose = [plant.x, plant.y, plant.yaw, plant.speed]
        lost = step % 60 == 50 or 500 <= step < 600
        sensed = [math.nan] * 4 if lost else pose
        word = {150: 2, 250: 3, 300: 5, 640: 4}.get(step, -1)
        released = None
        if word == 2:
            driver.hold()
        elif word == 3:
            driver.go()
        elif word == 4:
            released = driver.release()
        elif word == 5:
            driver.set_path(paths[1])
        dt, age = (0.0 if step % 70 == 60 else DT), 0.05 * (step % 3 == 0)
        lines.append(words(*sensed, dt, age, word))
        x, y, yaw, speed = sensed
        drive = driver.step(x, y, yaw, speed, dt, pose_age=age)
        numbers = drive.steer, drive.acceleration, drive.cross_track_error, drive.distance_to_stop
        flags = f"{int(drive.status)} {int(drive.reverse)} {int(drive.hold)}"
        estimate, ahead = driver.estimate, driver.predict(0.5, DT)
        more = words(estimate.gain, estimate.dead_time, ahead.x[-1], ahead.steer[-1])
        names = f"{drive.fault or 'none'} {released or 'none'}"
        answers.append(f"{words(*numbers)} {flags} {more} {names}")
        faults.add(drive.fault)
        plant.speed = max(plant.speed + DT * drive.acceleration, 0.0)
        plant.advance(drive.steer)
    script = tmp_path / "script"
    script.write_text("\n".join(lines) + "\n", encoding="utf-8")
    said = run(program, script).splitlines()
    apart = [[line.rsplit(maxsplit=2) for line in each] for each in (said, answers)]
    for (numbers, *names), (wanted, *wanted_names) in zip(*apart, strict=True):
        assert (bits(numbers), names) == (bits(wanted), wanted_names)
    assert faults == {None, "input"}


def test_c_vehicle_file_is_read_as_by_python(prefix: Path, tmp_path: Path) -> None:
    program = compile_program(prefix, "gcc", SOURCES / "paced.c", *SANITIZED)
    file, script = tmp_path / "car.toml", tmp_path / "script"
    script.write_text("2 0 0 5 0 0 0 30 0 9 0 0 0", encoding="utf-8")
    for text in ("", "max_speed = inf", "wheelbase = 2\nmax_speed = 3", "steers_at_rest = true"):
        file.write_text(text, encoding="utf-8")
        path = popsteer.Path([(0.0, 0.0), (30.0, 0.0)], speed=[5.0, 9.0])
        plan = popsteer.SpeedTracker(path, popsteer.Vehicle.load(file)).plan
        assert [bits(line) for line in run(program, file, script).splitlines()] == [
            bits(words(each)) for each in plan
        ], text
    for text, words_of_it in (
        ("wheelbase = -1", "wheelbase must be in [0.001, 1000.0], got -1.0"),
        ("max_speed = nan", "max_speed must be in [0.001, 10000.0], got "),
        ("max_acceleration = inf", "max_acceleration must be in [0.001, 1000.0], got inf"),
        ("wheelbase = '2'", "wheelbase must be a number, got "),
        ("wheelbase = true", "wheelbase must be a number, got "),
        ("steers_at_rest = 1", "steers_at_rest must be true or false, got 1"),
        ("tyres = 4", "unknown key 'tyres'; known: wheelbase, width, rear_axle, "),
        ("max_stear = 4", "unknown key 'max_stear', did you mean max_steer? Known: wheelbase, "),
        ("wheel_base = 4", "unknown key 'wheel_base', did you mean wheelbase? Known: wheelbase, "),
        ("wheelbase = = 2", "not TOML: "),
    ):
        file.write_text(text, encoding="utf-8")
        said = run(program, file, script)
        assert said.startswith(f"{file}: {words_of_it}"), said
        with pytest.raises(popsteer.ConfigError) as refused:
            popsteer.Vehicle.load(file)
        assert str(refused.value).startswith(f"{file}: {words_of_it}".replace(".0]", "]")), text
    assert "No such file" in run(program, tmp_path / "missing.toml", script)


@pytest.mark.parametrize("flags", [SANITIZED, ("-O2",)], ids=["sanitized", "optimized"])
def test_c_refuses_null_wrong_handles_and_bad_numbers(prefix: Path, flags: tuple[str]) -> None:
    program = compile_program(prefix, "gcc", SOURCES / "refusals.c", *flags)
    assert run(program) == "all refused\n"


def test_c_steps_allocate_nothing(prefix: Path) -> None:
    if not hasattr(ctypes.CDLL(None), "__libc_malloc"):
        pytest.skip("this C library's allocator cannot be counted")
    assert run(compile_program(prefix, "gcc", SOURCES / "allocations.c", "-O2")) == "0\n"


@pytest.mark.parametrize(
    "flags",
    [SANITIZED, ("-fno-exceptions", "-fno-rtti", "-O2")],
    ids=["sanitized", "no-exceptions"],
)
def test_cpp_owns_throws_and_drives_as_c(prefix: Path, flags: tuple[str]) -> None:
    assert run(compile_program(prefix, "g++", SOURCES / "lap.cpp", *flags)) == "all checked\n"


@pytest.mark.parametrize("law", ["pop", "preview-pop", "stanley"])
def test_c_step_takes_at_most_a_fifth_more_instructions_than_rusts(
    prefix: Path, law: str, capsys: pytest.CaptureFixture[str]
) -> None:
    tool("valgrind")
    program = compile_program(prefix, "gcc", SOURCES / "steps.c", "-O2")
    here = instruction_counts.total(instruction_counts.count(program, f"{law} step"))
    rust = instruction_counts.total(
        instruction_counts.count(instruction_counts.build(), f"{law} step")
    )
    with capsys.disabled():
        print(f"\n{law}: {here} instructions from C, {rust} from Rust: {here / rust:.3f}")  # noqa: T201
    assert here <= 1.2 * rust


@pytest.mark.parametrize(("compiler", "language"), [("gcc", "c"), ("g++", "cpp")])
def test_c_page_programs_print_what_it_shows(prefix: Path, compiler: str, language: str) -> None:
    page = PAGE.read_text(encoding="utf-8")
    (source,) = re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)
    (shown,) = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    (car,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (prefix / "car.toml").write_text(car, encoding="utf-8")
    file = prefix / f"drive.{language}"
    file.write_text(source, encoding="utf-8")
    tool(compiler)
    if language == "c":
        lines = re.findall(r"^    (export|cc) (.*)$", page, re.MULTILINE)
        script = "; ".join(" ".join(line) for line in lines)
        said = run("sh", "-euc", f"prefix={prefix}; cd {prefix}; {script}", PKG_CONFIG_PATH="")
        assert len(lines) == 2
    else:
        # Not as strict: the page's programs are to be read.
        flags = ("-Wno-conversion", "-Wno-sign-conversion")
        program = compile_program(prefix, compiler, file, *flags)
        said = run("sh", "-euc", f"cd {prefix}; {program}")
    assert said == shown


def test_libraries_go_where_the_system_has_them_and_away_again(
    prefix: Path, tmp_path: Path
) -> None:
    del prefix  # has built it
    libdir, other = "lib/x86_64-linux-gnu", tmp_path / "usr"
    install(other, f"LIBDIR={libdir}")
    where = {"PKG_CONFIG_PATH": str(other / libdir / "pkgconfig")}
    found = run(tool("pkg-config"), "--variable=libdir", "popsteer", **where).strip()
    assert os.path.realpath(found) == str(other / libdir)
    if shutil.which("cmake"):
        cmake_uses(other, tmp_path, "0.1...99", f"-Dpopsteer_DIR={other / libdir}/cmake/popsteer")
    mine = other / "include" / "mine.h"
    mine.touch()
    run(tool("make"), "uninstall-c", f"PREFIX={other}", f"LIBDIR={libdir}")
    assert [file for file in other.rglob("*") if not file.is_dir()] == [mine]


def cmake_uses(
    prefix: Path, folder: Path, version: str, *options: str, target: str = "popsteer"
) -> None:
    """Build a program with CMake, and run it; CMake fails where the version does not do."""
    cmake, major = tool("cmake"), 15 if "..." not in version else 19
    shutil.copy(SOURCES / "lap.cpp", folder)
    (folder / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.{major})\n"
        "project(lap CXX)\n"
        f"find_package(popsteer {version} REQUIRED)\n"
        "add_executable(lap lap.cpp)\n"
        "target_compile_features(lap PRIVATE cxx_std_17)\n"
        f"target_link_libraries(lap PRIVATE popsteer::{target})\n",
        encoding="utf-8",
    )
    out = folder / f"out-{target}"
    run(cmake, "-S", folder, "-B", out, f"-DCMAKE_PREFIX_PATH={prefix}", *options)
    run(cmake, "--build", out)
    assert run(out / "lap") == "all checked\n"


@pytest.mark.parametrize("target", ["popsteer", "static"])
def test_cmake_finds_the_package_and_links_it(prefix: Path, tmp_path: Path, target: str) -> None:
    cmake_uses(prefix, tmp_path, popsteer.__version__, target=target)


def test_cmake_takes_versions_that_it_asks_for(prefix: Path) -> None:
    cmake = tool("cmake")
    major, minor = map(int, popsteer.__version__.split(".")[:2])
    here, above = f"{major}.{minor}", f"{major}.{minor + 1}"
    (file,) = (prefix / "lib" / "cmake" / "popsteer").glob("*version.cmake")
    script = f"""
set(PACKAGE_FIND_VERSION_RANGE yes)
set(PACKAGE_FIND_VERSION_RANGE_MAX ${{BOUND}})
set(PACKAGE_FIND_VERSION_MIN ${{LOW}})
set(PACKAGE_FIND_VERSION_MAX ${{HIGH}})
set(PACKAGE_FIND_VERSION ${{LOW}})
include({file})
message(STATUS "${{PACKAGE_VERSION_COMPATIBLE}}")
"""
    program = prefix / "range.cmake"
    program.write_text(script, encoding="utf-8")
    for low, high, bound, taken in (
        ("0.1", above, "INCLUDE", True),
        ("0.1", popsteer.__version__, "INCLUDE", True),
        ("0.1", popsteer.__version__, "EXCLUDE", False),
        (above, "99", "INCLUDE", False),
        ("0.1", here if here != popsteer.__version__ else "0.2", "EXCLUDE", False),
    ):
        given = (f"-DLOW={low}", f"-DHIGH={high}", f"-DBOUND={bound}")
        said = run(cmake, *given, "-P", program)
        assert ("TRUE" in said) == taken, (low, high, bound)


def test_static_library_links_without_the_shared_one(prefix: Path, tmp_path: Path) -> None:
    system = run(
        *(tool("pkg-config"), "--static", "--libs-only-l", "popsteer"),
        PKG_CONFIG_PATH=str(prefix / "lib" / "pkgconfig"),
    ).split()
    program = tmp_path / "refusals"
    run(
        *(tool("gcc"), "-std=c11", f"-I{prefix / 'include'}", SOURCES / "refusals.c"),
        *(prefix / "lib" / "libpopsteer.a", *(each for each in system if "popsteer" not in each)),
        *("-o", program),
    )
    assert run(program) == "all refused\n"


def test_library_shows_the_interface_and_its_version_alone(prefix: Path) -> None:
    header = (prefix / "include" / "popsteer.h").read_text(encoding="utf-8")
    (abi,) = re.findall(r"#define POPSTEER_ABI_VERSION (\d+)", header)
    (shared,) = (prefix / "lib").glob(f"libpopsteer.*{abi}*")
    code = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    declared = set(re.findall(r"\b(popsteer_\w+)\(", code))
    assert len(declared) > 35
    symbols = run(tool("nm"), "--dynamic", "--defined-only", shared).split()[2::3]
    shown = {name for name in symbols if not name.startswith("_")}
    assert shown == declared
    version = ctypes.CDLL(str(shared)).popsteer_version
    version.restype = ctypes.c_char_p
    assert version().decode() == popsteer.__version__


def test_shared_library_is_named_by_its_abi(prefix: Path) -> None:
    program = compile_program(prefix, "gcc", SOURCES / "refusals.c", "-O2")
    header = (prefix / "include" / "popsteer.h").read_text(encoding="utf-8")
    (version,) = re.findall(r"#define POPSTEER_ABI_VERSION (\d+)", header)
    assert f"libpopsteer.so.{version}" in run(tool("readelf"), "-d", program)
