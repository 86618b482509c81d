"""Message packages that have no wheel, built of their texts by ROS's own generators and a compiler.

What colcon does for such a package takes CMake; this takes the same generators, which come with the
wheels of rclpy, and calls gcc and g++. Packages are kept from one run to the next.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import hashlib
import io
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import warnings
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from popsteer import logs
from popsteer.adapters.ros2 import messages
from tests.adapters.ros2_domain import domain_kept
from tests.helpers import ROOT

if TYPE_CHECKING:
    from collections.abc import Mapping

_CODES = """\
uint16 NONE=0
uint16 UNKNOWN=100
uint16 INVALID_CONTROLLER=101
uint16 TF_ERROR=102
uint16 INVALID_PATH=103
uint16 PATIENCE_EXCEEDED=104
uint16 FAILED_TO_MAKE_PROGRESS=105
uint16 NO_VALID_CONTROL=106
"""
_LATER = f"{_CODES}uint16 CONTROLLER_TIMED_OUT=107\n"
_NEWEST = f"uint16 GOAL_REJECTED=1\nuint16 SEND_GOAL_FAILURE=2\n{_LATER}uint16 TIMEOUT=108\n"
_GOAL = "nav_msgs/Path path\nstring controller_id\nstring goal_checker_id\n"
_PROGRESS = f"{_GOAL}string progress_checker_id\n"
_CODE = "std_msgs/Empty result\nuint16 error_code\n"
_SAID = f"{_CODE}string error_msg\n"
_NEARER = "float32 distance_to_goal\nfloat32 speed\n"
_TRACKING = """\
std_msgs/Header header
float32 position_tracking_error
float32 heading_tracking_error
uint32 current_path_index
geometry_msgs/PoseStamped robot_pose
float32 distance_to_goal
float32 speed
float32 remaining_path_length
"""
_JAZZY = f"{_PROGRESS}---\n{_LATER}{_SAID}---\n{_NEARER}"
FOLLOW_PATH = {
    "humble": f"{_GOAL}---\nstd_msgs/Empty result\n---\n{_NEARER}",
    "iron": f"{_CODES}{_PROGRESS}---\n{_CODE}---\n{_NEARER}",
    "jazzy": _JAZZY,
    "kilted": _JAZZY,
    "lyrical": (
        f"{_PROGRESS}string path_handler_id\n---\n{_NEWEST}{_SAID}---\n"
        "nav2_lyrical_msgs/TrackingFeedback tracking_feedback\n"
    ),
}
"""Nav2's action by the distribution: Jazzy's in `nav2_msgs`, others in `nav2_humble_msgs`, say."""

TEXTS = {
    "nav2_msgs/action/FollowPath": _JAZZY,
    "nav2_msgs/msg/SpeedLimit": ("std_msgs/Header header\nbool percentage\nfloat64 speed_limit\n"),
    "bond/msg/Status": (
        "std_msgs/Header header\nstring id\nstring instance_id\nbool active\n"
        "float32 heartbeat_timeout\nfloat32 heartbeat_period\n"
    ),
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    **{
        f"nav2_{name}_msgs/action/FollowPath": text
        for name, text in FOLLOW_PATH.items()
        if text != _JAZZY
    },
    "nav2_lyrical_msgs/msg/TrackingFeedback": _TRACKING,
    **{
        name: text
        for name, text in (logs.messages.DEFINITIONS | messages.DEFINITIONS).items()
        if not name.startswith("autoware_auto")
    },
}


def prepare() -> str:
    """Make rclpy and all that popsteer_ros uses importable; says why that cannot be.

    In a ROS installation that is all there; with the wheels of rclpy, messages are built and
    tf2_ros has a stand-in. Each process gets a domain of its own.
    """
    if find_spec("rclpy") is None:
        return 'no rclpy: neither is ROS sourced nor has the group "ros" wheels for this Python'
    if find_spec("cyclonedds") is None or find_spec("rosbags") is None:
        return 'the extra "ros2" is not installed'
    with warnings.catch_warnings():  # of a parser that the messages are loaded by
        warnings.simplefilter("ignore")
        import rosidl_generator_py  # noqa: F401
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if find_spec("nav2_msgs") is not None:
        return ""
    if why := missing():
        return why
    installed()
    os.environ["ROS_DOMAIN_ID"] = str(domain_kept())
    package, stand_ins = ROOT / "ros2" / "popsteer_ros", Path(__file__).parent / "stand_ins"
    sys.path += [str(package), str(stand_ins)]
    # For the processes that tests start.
    paths = [str(package), os.environ["PYTHONPATH"], str(stand_ins)]
    os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    return ""


def installed() -> Path:
    """Build the packages of `TEXTS` that are not built yet; give their folder, ready to import."""
    folder = build(TEXTS)
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
        for library in sorted(folder.glob("lib*.so")):  # which typesupport looks for by its name
            ctypes.CDLL(str(library))
        # For the processes that tests start.
        for name in ("LD_LIBRARY_PATH", "PYTHONPATH"):
            os.environ[name] = f"{folder}{os.pathsep}{os.environ.get(name, '')}".rstrip(os.pathsep)
    return folder


def build(texts: Mapping[str, str]) -> Path:
    """Build packages of definitions, by their full names; gives the folder to import them from."""
    said = "\0".join((sys.version, version("ros-rclpy"), version("numpy"), *texts, *texts.values()))
    name = hashlib.sha256(said.encode() + Path(__file__).read_bytes()).hexdigest()[:16]
    base = Path(tempfile.gettempdir()) / "popsteer-interfaces"
    base.mkdir(exist_ok=True)
    folder = base / name
    with (base / "lock").open("w") as lock:  # several workers of the tests may ask at once
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            with tempfile.TemporaryDirectory(dir=base) as made:
                where = Path(made) / "packages"
                where.mkdir()
                for package in sorted({each.split("/")[0] for each in texts}):
                    _build(package, texts, where, folder)
                where.rename(folder)
    return folder


def _build(package: str, texts: Mapping[str, str], out: Path, stays: Path) -> None:
    from rosidl_adapter.action import convert_action_to_idl
    from rosidl_adapter.msg import convert_msg_to_idl

    convert = {"msg": convert_msg_to_idl, "action": convert_action_to_idl}
    share, files = out / "share" / package, []
    with contextlib.redirect_stdout(io.StringIO()):
        for name, text in texts.items():
            where, kind, what = name.split("/")
            if where == package:
                source = Path(kind) / f"{what}.{kind}"
                (share / kind).mkdir(parents=True, exist_ok=True)
                (share / source).write_text(text, encoding="utf-8")
                convert[kind](share, package, source, share / kind)
                files.append(f"{share}:{source.with_suffix('.idl')}")
    _generate(package, files, out)
    _compile(package, out, stays)


def _generate(package: str, files: list[str], out: Path) -> None:
    before = os.environ.get("AMENT_PREFIX_PATH")
    os.environ["AMENT_PREFIX_PATH"] = sys.prefix  # where the generators find their templates
    from rosidl_generator_c.cli import GenerateC
    from rosidl_generator_py.cli import GeneratePython
    from rosidl_typesupport_c.cli import GenerateCTypesupport
    from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
    from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

    include = [str(Path(sys.prefix) / "share"), str(out / "share")]
    names = [f"rosidl_typesupport_{each}_c" for each in ("fastrtps", "introspection")]
    python = GeneratePython("py", typesupport_implementations=["rosidl_typesupport_c"])
    dispatch = GenerateCTypesupport("c", typesupport_implementations=names)
    generators = GenerateC("c"), python, GenerateFastRTPSCTypesupport("fastrtps_c"), dispatch
    quiet = contextlib.redirect_stderr(io.StringIO())
    with contextlib.redirect_stdout(io.StringIO()), quiet:
        for each in generators:
            each.generate(package, files, include, out / package)
        # A file of it has the name of another of the C generator.
        introspection = GenerateIntrospectionCTypesupport("introspection_c")
        introspection.generate(package, files, include, out / "introspection" / package)
    if before is None:
        del os.environ["AMENT_PREFIX_PATH"]
    else:
        os.environ["AMENT_PREFIX_PATH"] = before


def _compile(package: str, out: Path, stays: Path) -> None:
    root = Path(sys.prefix)
    headers = [out, out / "introspection", Path(sysconfig.get_path("include")), root / "include"]
    headers += [Path(np.get_include()), *sorted((root / "include").iterdir())]
    found: list[Path] = []
    sources = [*(out / package).rglob("*.c*"), *(out / "introspection" / package).rglob("*.c")]
    for source in sorted(each for each in sources if each.suffix in (".c", ".cpp")):
        found.append(source.with_suffix(f"{source.suffix}.o"))
        compiler = ["gcc", "-std=gnu11"] if source.suffix == ".c" else ["g++", "-std=c++17"]
        given = ["-O0", "-w", "-fPIC", *(f"-I{each}" for each in headers)]
        subprocess.run([*compiler, *given, "-c", source, "-o", found[-1]], check=True)
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    name = f"{package}_s__rosidl_typesupport_c{suffix}"
    runtime = [f"-l:{each.name}" for each in sorted((root / "lib").glob("lib*.so"))]
    runtime = [
        each for each in runtime if "__" not in each or "generator" in each or "_c.so" in each
    ]
    search = [f"-L{root / 'lib'}", f"-Wl,-rpath,{root / 'lib'}", "-Wl,--as-needed"]
    extension = out / package / name
    subprocess.run(["g++", "-shared", "-o", extension, *found, *search, *runtime], check=True)
    for kind in ("fastrtps", "introspection"):  # the names that are looked for, which lead there
        library = out / f"lib{package}__rosidl_typesupport_{kind}_c.so"
        named = [f"-Wl,-soname,{library.name}", "-Wl,--no-as-needed", f"-L{extension.parent}"]
        named += [f"-l:{name}", f"-Wl,-rpath,{stays / package}"]
        subprocess.run(["gcc", "-shared", "-o", library, *named], check=True)
    for each in found:
        each.unlink()


def missing() -> str:
    """Say why nothing can be built here; empty where it can."""
    if not all(map(shutil.which, ("gcc", "g++"))):
        return "no gcc and g++, which build the messages that have no wheel"
    header = Path(sysconfig.get_path("include")) / "Python.h"
    return "" if header.exists() else f"no {header}"
