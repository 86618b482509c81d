"""The graph of ROS: who publishes what, and this process's own entry in the list of nodes."""

from __future__ import annotations

import os
import struct
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

_TOPIC = "ros_discovery_info"
# Distributions before Iron: gids of 24 bytes in place of 16, and no type hashes.
_OLD = ("foxy", "galactic", "humble")
_HASH = "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"


class Publication(NamedTuple):
    """A publisher in the domain."""

    topic: str
    kind: str
    """Its type, as ROS has it."""
    latched: bool
    """Whether it sends its last message to who comes later."""
    participant: bytes
    """Whose it is."""
    has_hash: bool
    """Whether it says the hash of its type, as ROS does from Iron on."""


def user_data(text: str) -> Any:  # noqa: ANN401 - cyclonedds is an extra
    """Give the QoS by which ROS tells what DDS does not know of an entity."""
    from cyclonedds.core import Policy, Qos

    return Qos(Policy.Userdata(text.encode()))


class Graph:
    """What a participant of ``cyclonedds`` knows of others, and what it tells them of its node."""

    def __init__(self, participant: Any, node: str, namespace: str) -> None:  # noqa: ANN401
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication

        self.publications: dict[bytes, Publication] = {}
        self._participant = participant
        self._names = namespace, node
        self._looks = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
        self._readers: list[bytes] = []
        self._writers: list[bytes] = []
        self._announced: tuple[int, ...] = ()
        self._writer: Any = None

    def add(self, reader: Any = None, writer: Any = None) -> None:  # noqa: ANN401
        """Take a reader or a writer among the node's own, and announce it."""
        self._readers += [reader.guid.bytes] if reader is not None else []
        self._writers += [writer.guid.bytes] if writer is not None else []
        self.look()

    def look(self) -> None:
        """Take what has been discovered, and announce the node where there is news of it."""
        from cyclonedds.core import InstanceState

        for each in self._looks.take(N=1000):
            if each.sample_info.instance_state != InstanceState.Alive or each.qos is None:
                self.publications.pop(each.key.bytes, None)
                continue
            self.publications[each.key.bytes] = Publication(
                each.topic_name,
                each.type_name.replace("::dds_::", "/").replace("::", "/").removesuffix("_"),
                "TransientLocal" in str(each.qos),
                each.participant_key.bytes,
                "typehash=" in str(each.qos),
            )
        state = self._gid_size(), len(self._readers), len(self._writers)
        if state != self._announced:
            self._announce(state[0], anew=state[:1] != self._announced[:1])
            self._announced = state

    def of(self, topic: str) -> list[Publication]:
        """Give the publishers of a topic of ROS."""
        return [each for each in self.publications.values() if each.topic == f"rt{topic}"]

    def others(self, topic: str) -> int:
        """Count the publishers of a topic of ROS that are not this participant's."""
        own = self._participant.guid.bytes
        return sum(each.participant != own for each in self.of(topic))

    def why_silent(self, topic: str, kind: str, reader: Any) -> str:  # noqa: ANN401 - a `Reader`
        """Say why a reader may have heard nothing on a topic of a type, as far as is known."""
        self.look()
        others = {each.kind for each in self.of(topic)} - {kind}
        if others:
            return f"it is published as {', '.join(sorted(others))}"
        if reader.peers:
            return "its publisher sends nothing"
        if reader.refused:
            return (
                "its publisher has a QoS that does not fit (best effort, where reliable is needed)"
            )
        return "nobody publishes it"

    def _gid_size(self) -> int:
        own = self._participant.guid.bytes
        nodes = [
            each.has_hash
            for each in self.publications.values()
            if each.topic == _TOPIC and each.participant != own
        ]
        is_old = not any(nodes) if nodes else os.environ.get("ROS_DISTRO", "") in _OLD
        return 24 if is_old else 16

    def _announce(self, size: int, *, anew: bool) -> None:
        """Publish the node with its readers and writers, as ``rmw_dds_common`` has it."""
        if anew:
            self._writer = None  # its topic goes first: it has one type at a time
            self._writer = _writer(self._participant, size)

        def gids(all_of: Iterable[bytes]) -> bytes:
            padded = [gid.ljust(size, b"\0") for gid in all_of]
            return struct.pack("<I", len(padded)) + b"".join(padded)

        message = self._participant.guid.bytes.ljust(size, b"\0") + struct.pack("<I", 1)
        for name in self._names:
            text = name.encode() + b"\0"
            message += struct.pack("<I", len(text)) + text
            message += b"\0" * (-len(message) % 4)
        message += gids(self._readers) + gids(self._writers)
        self._writer.write(self._writer.topic.data_type(b"\0\1\0\0" + message))


def _writer(participant: Any, size: int) -> Any:  # noqa: ANN401
    from cyclonedds.core import Policy, Qos
    from cyclonedds.idl import make_idl_struct, types
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic

    from popsteer.adapters.ros2.idl import as_bytes

    def named(name: str, fields: dict[str, Any]) -> Any:  # noqa: ANN401
        return make_idl_struct(f"{name}_", f"rmw_dds_common.msg.dds_.{name}_", fields)

    gid = named("Gid", {"data": types.array[types.uint8, size]})
    gids = types.sequence[gid]
    text = types.bounded_str[256]
    entities = {"node_namespace": text, "node_name": text}
    node = named("NodeEntitiesInfo", {**entities, "reader_gid_seq": gids, "writer_gid_seq": gids})
    info = named("ParticipantEntitiesInfo", {"gid": gid, "nodes": types.sequence[node]})
    qos = Qos(
        Policy.Reliability.Reliable(100_000_000),
        Policy.Durability.TransientLocal,
        Policy.History.KeepLast(1),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        base=user_data(f"typehash={_HASH};" if size == 16 else ""),
    )
    return DataWriter(participant, Topic(participant, _TOPIC, as_bytes(info)), qos=qos)
