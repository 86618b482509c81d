"""What ROS nodes see of the node: its names, its types, and whom it can find."""

from __future__ import annotations

import gc
import itertools
import struct
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from tests.helpers import PATIENCE, looped

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')

from popsteer.adapters import ros2
from popsteer.adapters.ros2 import messages, paths
from popsteer.adapters.ros2.dds import Participant
from popsteer.adapters.ros2.discovery import configuration
from popsteer.adapters.ros2.node import Node, Options
from popsteer.adapters.ros2.pacing import Pace, spin
from popsteer.adapters.ros2.paths import path_of, points_of_bytes
from tests.adapters.ros2_domain import domain

if TYPE_CHECKING:
    from collections.abc import Callable


def until(holds: Callable[[], Any], seconds: float = PATIENCE) -> Any:
    end = time.monotonic() + seconds
    while not (found := holds()) and time.monotonic() < end:
        time.sleep(0.01)
    return found


class Info:
    """A reader of `ros_discovery_info`, as a ROS of the given size of gids has it."""

    def __init__(self, member: Participant, size: int) -> None:
        from cyclonedds.core import Policy, Qos
        from cyclonedds.sub import DataReader

        from popsteer.adapters.ros2.graph import _writer

        self.size = size
        self.writer = _writer(member._participant, size)  # whose topic is also the reader's
        qos = Qos(
            Policy.Reliability.Reliable(10**8),
            Policy.Durability.TransientLocal,
            Policy.History.KeepLast(100),
        )
        self.reader = DataReader(member._participant, self.writer.topic, qos=qos)

    def nodes(self) -> list[tuple[bytes, str, str, list[bytes], list[bytes]]]:
        """Of each message: the participant, its node's namespace and name, readers, writers."""
        return [self._parsed(each.data) for each in self.reader.read(N=100)]

    def _parsed(self, data: bytes) -> tuple[bytes, str, str, list[bytes], list[bytes]]:
        at = 4

        def number() -> int:
            nonlocal at
            at += -at % 4
            at += 4
            return int(struct.unpack_from("<I", data, at - 4)[0])

        def taken(count: int) -> bytes:
            nonlocal at
            at += count
            return data[at - count : at]

        def gids() -> list[bytes]:
            return [taken(self.size) for _ in range(number())]

        who = taken(self.size)
        assert number() == 1
        namespace, name = (taken(number())[:-1].decode() for _ in range(2))
        found = who, namespace, name, gids(), gids()
        assert at == len(data)
        return found


def announced(info: Info, name: str) -> Any:
    """The last message about a node."""
    return next((each for each in reversed(info.nodes()) if each[2] == name), None)


@pytest.mark.parametrize(("distribution", "size"), [("jazzy", 16), ("humble", 24)])
def test_node_is_announced_with_its_readers_and_writers(
    monkeypatch: pytest.MonkeyPatch, distribution: str, size: int
) -> None:
    monkeypatch.setenv("ROS_DISTRO", distribution)
    number = domain()
    info = Info(Participant(number, local=True, node="other"), size)
    member = Participant(number, local=True, node="steer", namespace="/car")
    node = Node(member, popsteer.Driver)
    assert until(lambda: (found := announced(info, "steer")) and len(found[4]) == 4)
    who, namespace, _, readers, writers = announced(info, "steer")
    assert namespace == "/car"
    assert who[:16] == member._participant.guid.bytes
    topics = node.options.topics
    assert len(readers) == 5  # odometry, path, ~/release, speed_limit, requests of ~/reset
    there = member.graph.publications
    named = {there[gid[:16]].topic for gid in writers}
    assert named == {
        *(f"rt{name}" for name in (topics.command, topics.predicted, topics.diagnostics)),
        "rr/car/steer/resetReply",
    }


def test_gids_are_those_of_the_nodes_that_are_there() -> None:
    number = domain()
    other = Participant(number, local=True, node="other")
    old = Info(other, 24)
    old.writer.topic  # noqa: B018 - a Humble node: it announces itself without a type hash
    other.graph._announced = (24, 0, 0)
    other.graph._writer = None
    member = Participant(number, local=True, node="steer")
    member.reader("/odom", messages.ODOMETRY)

    def heard() -> Any:
        member.graph.look()
        return announced(old, "steer")

    assert until(heard)


def test_member_of_a_circle_leaves_the_domain_with_it() -> None:
    number = domain()
    heard = Participant(number, local=True).reader("/odom", messages.ODOMETRY)
    circle: list[Any] = [Participant(number, local=True).writer("/odom", messages.ODOMETRY)]
    circle.append(circle)
    assert until(lambda: heard.peers == 1)
    del circle
    gc.collect()
    assert until(lambda: heard.peers == 0)


def test_every_endpoint_tells_its_type_hash_and_the_participant_its_enclave() -> None:
    from cyclonedds.builtin import (
        BuiltinDataReader,
        BuiltinTopicDcpsParticipant,
        BuiltinTopicDcpsPublication,
        BuiltinTopicDcpsSubscription,
    )

    number = domain()
    other = Participant(number, local=True)._participant
    node = Node(Participant(number, local=True), popsteer.Driver)
    own = node._participant._participant.guid
    endpoints = [
        BuiltinDataReader(other, BuiltinTopicDcpsPublication),
        BuiltinDataReader(other, BuiltinTopicDcpsSubscription),
    ]

    def seen() -> list[Any]:
        found = [each for reader in endpoints for each in reader.read(N=100)]
        there = [each for each in found if each.participant_key == own]
        return [each for each in there if not each.topic_name.startswith("DCPS")]  # DDS's own

    assert until(lambda: len(seen()) == 10)
    for each in seen():
        assert b"typehash=RIHS01_" in _user_data(each.qos), each.topic_name
    (path,) = [each for each in seen() if each.topic_name == "rt/path"]
    hashed = "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b"
    assert _user_data(path.qos) == f"typehash=RIHS01_{hashed};".encode()
    members = BuiltinDataReader(other, BuiltinTopicDcpsParticipant).read(N=100)
    assert {_user_data(each.qos) for each in members} == {b"enclave=/;"}


def _user_data(qos: Any) -> bytes:
    from cyclonedds.core import Policy

    return next((each.data for each in qos if isinstance(each, Policy.Userdata)), b"")


@pytest.mark.parametrize("latched", [False, True])
def test_path_reader_fits_planners_that_keep_their_paths_and_those_that_do_not(
    latched: bool,
) -> None:
    number = domain()
    planner = Participant(number, local=True).writer("/path", messages.PATH, latched=latched)
    first = ros2.path_message([0.0, 5.0], [0.0, 0.0], [0.0, 0.0], 1, "map")
    planner.write(messages.encode(first))
    node = Node(Participant(number, local=True), popsteer.Driver)
    at = itertools.count(10**9, 10**8)

    def newest() -> float:
        node.cycle(next(at), 0.02)
        return 0.0 if node.intake.course is None else node.intake.course.path.length

    def publish(length: float) -> None:
        message = ros2.path_message([0.0, length], [0.0, 0.0], [0.0, 0.0], 1, "map")
        planner.write(messages.encode(message))

    assert until(lambda: planner.peers > 0)
    assert until(newest, PATIENCE if latched else 0.1) == (5.0 if latched else 0.0)
    for length in (6.0, 7.0, 8.0):
        publish(length)
        assert until(lambda length=length: newest() == length)  # type: ignore[misc]
        assert newest() == length
    refusing = planner._writer.get_offered_incompatible_qos_status()
    assert (refusing.total_count, node.path_reader.refused) == (0, 0)


@looped(
    ("environment", "local", "wanted"),
    [
        ({}, None, ["<MaxAutoParticipantIndex>32<", "<Peers></Peers>"]),
        (
            {"ROS_STATIC_PEERS": "one; two"},
            None,
            ['address="one"/><Peer address="two"'],
        ),
        ({"ROS_LOCALHOST_ONLY": "1", "CYCLONEDDS_URI": "<a/>"}, None, ['"localhost"', ",<a/>"]),
        ({"CYCLONEDDS_URI": "file:///x.xml"}, True, ["Multicast>false", ",file:///x.xml"]),
        ({"ROS_LOCALHOST_ONLY": "1", "ROS_STATIC_PEERS": "host"}, None, ['"localhost"', '"host"']),
        (
            {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF", "ROS_STATIC_PEERS": "host"},
            None,
            ["<ParticipantIndex>none<", "<Tag>ros_discovery_off_", "<Peers></Peers>"],
        ),
    ],
)
def test_configuration_is_that_of_ros(
    environment: dict[str, str], local: bool | None, wanted: list[str]
) -> None:
    found = configuration(local=local, environment=environment)
    assert all(each in found for each in wanted), found
    assert found.startswith("<CycloneDDS><Domain>")
    assert ("AllowMulticast" in found) == (len(environment) == 2 or local is True)


def test_loopback_is_named_where_a_file_of_configuration_names_no_interface(tmp_path: Any) -> None:
    file = tmp_path / "cyclonedds.xml"
    for text, named in (("<Tag>mine</Tag>", True), ('<NetworkInterface name="eth0"/>', False)):
        file.write_text(text)
        for uri in (f"file://{file}", f"file:{file}"):
            found = configuration(local=True, environment={"CYCLONEDDS_URI": uri})
            assert ('NetworkInterface name="lo' in found) == named, uri


def test_static_peers_are_reached_from_an_address_that_is_not_the_loopback_alone() -> None:
    scope = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    for peers, named in (
        ("", 'NetworkInterface name="lo'),
        ("::1;", 'NetworkInterface name="lo'),  # no address of IPv4: no way to it
        ("::1; 127.0.0.7", 'NetworkInterface address="127.0.0.1"'),
    ):
        found = configuration(environment={**scope, "ROS_STATIC_PEERS": peers})
        assert named in found, peers


HEARS = """
import time
from popsteer.adapters.ros2.dds import Participant
reader = Participant({number}).reader("/clock", "rosgraph_msgs/msg/Clock")
until = time.monotonic() + {patience}
while not reader.peers and time.monotonic() < until:
    time.sleep(0.01)
print(reader.peers)
"""


def test_nodes_with_static_peers_find_each_other_on_this_machine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    # Of a net for documentation; where this machine has a way out, it is not the loopback.
    monkeypatch.setenv("ROS_STATIC_PEERS", "192.0.2.1")
    number = domain()
    writer = Participant(number).writer("/clock", messages.CLOCK)
    assert writer.peers == 0
    code = HEARS.format(number=number, patience=PATIENCE)
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == "1", other.stderr


@looped(
    ("environment", "said"),
    [
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "HOUSE"}, "unknown ROS_AUTOMATIC_DISCOVERY_RANGE"),
        ({"ROS_STATIC_PEERS": 'a"/>'}, "ROS_STATIC_PEERS must be addresses"),
    ],
)
def test_environment_that_cannot_be_is_refused(environment: dict[str, str], said: str) -> None:
    with pytest.raises(popsteer.ConfigError, match=said):
        configuration(environment=environment)


def long_path(count: int, frame: str = "map") -> Any:
    xs = [0.5 * k for k in range(count)]
    return ros2.path_message(xs, [0.0] * count, [0.0] * count, 7, frame)


def test_points_are_decoded_as_rosbags_does_at_any_alignment() -> None:
    messages_of = [long_path(count, "m" * letters) for letters in range(9) for count in (2, 3, 9)]
    uneven = long_path(5)
    uneven.poses[3].header = messages.make("std_msgs/msg/Header", frame_id="another")
    for message in (*messages_of, uneven):
        data = messages.encode(message)
        for each in (data, data[:-1]):
            try:
                wanted, frame = path_of(messages.decode(messages.PATH, each))
            except Exception:  # noqa: BLE001 - whatever rosbags stumbles over
                with pytest.raises(Exception):  # noqa: B017, PT011
                    points_of_bytes(messages.PATH, each).path()
                continue
            found = points_of_bytes(messages.PATH, each)
            assert (found.path().x.tolist(), found.frame) == (wanted.x.tolist(), frame)


def test_command_follows_each_odometry_between_ticks_of_the_timer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # When it steps, to the nanosecond, is in test_ros2_pacing.py; here the clock is the machine's.
    number = domain()
    member = Participant(number, local=True)
    node = Node(Participant(number, local=True), popsteer.Driver, Options(rate=50.0))
    cycle, by_odometry = Pace.cycle, []

    def noted(pace: Pace, node: Node, now: int, wall: int, *, came: bool) -> bool:
        done = cycle(pace, node, now, wall, came=came)
        by_odometry.extend([came] if done else [])
        return done

    monkeypatch.setattr(Pace, "cycle", noted)
    ended = threading.Event()
    thread = threading.Thread(target=spin, args=(node, node._participant, ended.is_set))
    odometry = member.writer("/odom", messages.ODOMETRY)
    path = member.writer("/path", messages.PATH, latched=True)
    drive = member.reader("/drive", messages.ACKERMANN, reliable=True)
    path.write(messages.encode(long_path(100)))
    thread.start()

    def answered() -> bool:
        """Whether a pose was answered by a command, and forty have been by a step of their own."""
        message = ros2.odometry_message(1.0, 0.0, 0.0, 0.0, time.time_ns(), "map")
        drive.take()
        odometry.write(messages.encode(message))
        return bool(drive.wait(1.0) and drive.take()) and sum(by_odometry) >= 40

    try:
        assert until(answered)
    finally:
        ended.set()
        thread.join()


GARBAGE = """
import random, socket, sys, time
from popsteer.adapters.ros2.dds import Participant
domain = int(sys.argv[1])
member = Participant(domain, local=True)
reader = member.reader("/odom", "nav_msgs/msg/Odometry")
sends, chance = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), random.Random(0)
for k in range(2000):
    data = b"RTPS\\2\\1\\1\\x10" + chance.randbytes(12) + bytes([chance.choice((9, 21)), 1])
    for port in (10, 11):
        sends.sendto(data + chance.randbytes(60), ("127.0.0.1", 7400 + 250 * domain + port))
    time.sleep(0.0001)
time.sleep(0.3)
other = Participant(domain, local=True).writer("/odom", "nav_msgs/msg/Odometry")
until = time.monotonic() + float(sys.argv[2])
while not reader.peers and time.monotonic() < until:
    time.sleep(0.01)
print(reader.peers)
"""


def test_datagrams_that_are_none_are_printed_nowhere_and_stop_nothing() -> None:
    found = subprocess.run(
        [sys.executable, "-c", GARBAGE, str(domain()), str(PATIENCE)],
        capture_output=True,
        text=True,
        check=True,
    )
    assert (found.stdout, found.stderr) == ("1\n", "")


@pytest.mark.parametrize("frames", [("map",), ("map", "another_map")])
def test_long_path_is_read_by_its_bytes_whatever_its_frames(
    monkeypatch: pytest.MonkeyPatch, frames: tuple[str, ...]
) -> None:
    # rosbags would take a second for it, where a cycle of 50 Hz is 20 ms.
    monkeypatch.setattr(paths, "decode", None)
    message = long_path(10_000)
    for k, each in enumerate(message.poses):
        frame = frames[k % len(frames)]
        each.header = messages.make("std_msgs/msg/Header", frame_id=frame)
    found = points_of_bytes(messages.PATH, messages.encode(message))
    assert found.xy[:, 0].tolist() == [0.5 * k for k in range(10_000)]
