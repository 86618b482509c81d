"""The wire: topics of a DDS domain as ROS 2 names them, with the QoS that its nodes have."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any
from weakref import WeakMethod, finalize

from popsteer.adapters.ros2.discovery import configuration, domain_of
from popsteer.adapters.ros2.graph import Graph, user_data
from popsteer.adapters.ros2.idl import wire_type
from popsteer.adapters.ros2.messages import encode, hash_of, make
from popsteer.adapters.ros2.names import check_name, check_namespace, check_node
from popsteer.errors import PopsteerError
from popsteer.extras import require

if TYPE_CHECKING:
    from collections.abc import Callable

_BATCH = 256
_FATAL = 1  # DDS_LC_FATAL
# How long the last message of a publisher that keeps it is waited for [s].
_KEPT = 2.0

# As long as the process lives: with its configuration a domain would lose all of its members.
_CONFIGURED: dict[int, Any] = {}


class Participant:
    """A member of a domain, which makes readers and writers.

    Parameters
    ----------
    domain : int, optional
        The domain, 0 to 232; by default that of ``ROS_DOMAIN_ID``.
    local : bool, optional
        Whether to stay on this machine; by default as ROS is told.
    node : str, default "popsteer"
        The name of the node that ROS sees.
    namespace : str, default "/"
        The namespace that the node is in.

    Raises
    ------
    ConfigError
        A name or an environment variable is none that ROS takes.
    PopsteerError
        The extra ``ros2`` is not installed, or there is no network to use.

    Examples
    --------
    >>> from popsteer.adapters.ros2 import messages
    >>> participant = Participant(77, local=True)
    >>> reader = participant.reader("/clock", messages.CLOCK)
    >>> reader.take(), reader.peers
    ([], 0)
    """

    def __init__(
        self,
        domain: int | None = None,
        *,
        local: bool | None = None,
        node: str = "popsteer",
        namespace: str = "/",
    ) -> None:
        require("ROS 2", "ros2", "cyclonedds", "rosbags")
        from cyclonedds.core import DDSException
        from cyclonedds.domain import Domain, DomainParticipant

        self.domain = domain_of(domain)
        self.node, self.namespace = check_node(node), check_namespace(namespace)
        self._topics: dict[tuple[str, str], Any] = {}
        config = configuration(local=local)
        if config and self.domain not in _CONFIGURED:
            with suppress(DDSException):  # where this process is in the domain already
                _CONFIGURED[self.domain] = Domain(self.domain, config)
        try:
            self._participant = DomainParticipant(self.domain, qos=user_data("enclave=/;"))
        except DDSException as error:
            raise PopsteerError(
                f"domain {self.domain} cannot be joined: no such network interface, too many"
                " participants on it, or a CYCLONEDDS_URI that is none"
            ) from error
        _be_quiet()
        _leave_at_end(self._participant)
        self.graph = Graph(self._participant, node, namespace)
        self.graph.look()

    def reader(
        self,
        topic: str,
        kind: str,
        *,
        reliable: bool = False,
        latched: bool = False,
        prefix: str = "rt",
        listed: bool = True,
    ) -> Reader:
        """Subscribe to a topic of a type.

        `reliable` readers lose nothing, and hear reliable publishers alone; the others hear both
        kinds. `latched` ones are sent what was published before, and hear publishers alone that
        keep it ("transient local"). `listed` says whether it is the node's to ROS.
        """
        from cyclonedds.sub import DataReader

        qos = _qos(kind, reliable=reliable or latched, latched=latched, depth=10)
        found = DataReader(self._participant, self._topic(topic, kind, prefix), qos=qos)
        if listed:
            self.graph.add(reader=found)
        return Reader(found)

    def latest(self, topic: str, kind: str) -> Latest:
        """Subscribe to all reliable publishers of a topic, those that keep their messages, too."""
        return Latest(self, topic, kind)

    def service(self, name: str, do: Callable[[], str]) -> Service:
        """Offer a service of the type ``std_srvs/srv/Trigger``; `do` says what it answers."""
        return Service(self, check_name("service", name), do)

    def writer(
        self, topic: str, kind: str, *, latched: bool = False, depth: int = 1, prefix: str = "rt"
    ) -> Writer:
        """Publish on a topic of a type, reliably.

        `latched` publishers send who comes later their last message, too; `depth` messages are kept
        for who is slow.
        """
        from cyclonedds.pub import DataWriter

        qos = _qos(kind, reliable=True, latched=latched, depth=depth)
        found = DataWriter(self._participant, self._topic(topic, kind, prefix), qos=qos)
        self.graph.add(writer=found)
        return Writer(found, kind)

    def _topic(self, name: str, kind: str, prefix: str = "rt") -> Any:  # noqa: ANN401
        from cyclonedds.topic import Topic

        full = prefix + check_name("topic", name)
        if (full, kind) not in self._topics:
            self._topics[full, kind] = Topic(self._participant, full, wire_type(kind))
        return self._topics[full, kind]


def _be_quiet() -> None:
    """Let Cyclone DDS print no line for each datagram that is none: they may fill a disk.

    What it is asked to trace, by ``CYCLONEDDS_URI``, goes to its file all the same.
    """
    from cyclonedds import internal

    internal.DDS._dll_handle.dds_set_log_mask(_FATAL)  # noqa: SLF001 - the package has no name for it


def _leave_at_end(participant: Any) -> None:  # noqa: ANN401 - cyclonedds is an extra
    """Let a participant leave its domain where it is in a circle that the collector finds, too.

    The package looks an entity up among weak references, which the collector has cleared by then.
    """
    from cyclonedds import internal

    leaves = internal.DDS._dll_handle.dds_delete  # noqa: SLF001 - as above
    finalize(participant, leaves, participant._ref).atexit = False  # noqa: SLF001


class Reader:
    """A subscription; `Participant.reader` makes it."""

    def __init__(self, reader: Any) -> None:  # noqa: ANN401
        self.entity = reader
        self._waits: Any = None

    def take(self) -> list[bytes]:
        """Take the messages that have come in since the last call, the oldest first."""
        return [data for data, _ in self.take_stamped()]

    def take_stamped(self) -> list[tuple[bytes, int]]:
        """Take what has come in, each with the time at which it was sent [ns]."""
        from cyclonedds.core import DDSException

        try:
            found = self.entity.take(N=_BATCH)
        except DDSException:
            return []
        return [
            (each.data, each.sample_info.source_timestamp)
            for each in found
            if hasattr(each, "data")
        ]

    def wait(self, seconds: float) -> bool:
        """Wait until something comes in, `seconds` at most; says whether something has."""
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet

        if self._waits is None:
            anything = ViewState.Any | InstanceState.Any | SampleState.NotRead
            self._waits = WaitSet(self.entity.participant)
            self._waits.attach(ReadCondition(self.entity, anything))
        return bool(self._waits.wait(int(seconds * 1e9)) > 0)

    @property
    def peers(self) -> int:
        """How many publishers it hears."""
        return len(self.entity.get_matched_publications())

    @property
    def refused(self) -> int:
        """How many publishers it does not hear, because their QoS does not fit."""
        return int(self.entity.get_requested_incompatible_qos_status().total_count)


class Latest(Reader):
    """A subscription that hears every reliable publisher; `Participant.latest` makes it.

    One that asks for kept messages would not hear publishers that keep none, and each side would
    warn of the other. So a second one is there for a moment only, where all publishers keep theirs.
    """

    def __init__(self, participant: Participant, topic: str, kind: str) -> None:
        super().__init__(participant.reader(topic, kind, reliable=True).entity)
        self._of = participant, topic, kind
        self._asked: set[bytes] = set()
        self._kept: Reader | None = None
        self._until = 0.0
        self._newest = 0

    def take_stamped(self) -> list[tuple[bytes, int]]:
        """Take what has come in, and what was kept, where that is newer than all before."""
        found = super().take_stamped()
        self._newest = max([self._newest, *(at for _, at in found)])
        kept = self._ask()
        if kept and kept[-1][1] > self._newest:
            self._newest = kept[-1][1]
            found.append(kept[-1])
        return found

    def _ask(self) -> list[tuple[bytes, int]]:
        participant, topic, kind = self._of
        if self._kept is None:
            graph = participant.graph
            there = {key for key, each in graph.publications.items() if each.topic == f"rt{topic}"}
            asks = there - self._asked and all(graph.publications[key].latched for key in there)
            self._asked = there
            if asks:
                self._kept = participant.reader(topic, kind, latched=True, listed=False)
                self._until = time.monotonic() + _KEPT
            return []
        kept = self._kept.take_stamped()
        if kept or time.monotonic() > self._until:
            self._kept = None
        return kept


class Service:
    """A service of the type ``std_srvs/srv/Trigger``; `Participant.service` makes it.

    The header of requests is that of ``rmw_cyclonedds_cpp``, whose clients alone hear the answers.
    """

    def __init__(self, participant: Participant, name: str, do: Callable[[], str]) -> None:
        self._do = WeakMethod(do)  # the node's, which has this: no circle keeps both alive
        kind = "std_srvs/srv/Trigger"
        request, answer = f"{kind}_Request", f"{kind}_Response"
        self._requests = participant.reader(f"{name}Request", request, reliable=True, prefix="rq")
        self._answers = participant.writer(f"{name}Reply", answer, depth=10, prefix="rr")

    def take(self) -> None:
        """Answer the requests that have come in, with success."""
        for data in self._requests.take():
            if data[:2] == b"\0\1" and (do := self._do()) is not None:
                body = encode(make("std_srvs/srv/Trigger_Response", success=True, message=do()))
                self._answers.write(body[:4] + data[4:20] + body[4:])


class Writer:
    """A publisher; `Participant.writer` makes it."""

    def __init__(self, writer: Any, kind: str) -> None:  # noqa: ANN401
        self._writer = writer
        self._wire = wire_type(kind)

    def write(self, data: bytes) -> None:
        """Publish the bytes of a message; raises ValueError where they are none of its type."""
        from cyclonedds.core import DDSException

        try:
            self._writer.write(self._wire(data))
        except DDSException as error:
            raise ValueError(str(error)) from error

    @property
    def peers(self) -> int:
        """How many subscribers hear it."""
        return len(self._writer.get_matched_subscriptions())


def _qos(kind: str, *, reliable: bool, latched: bool, depth: int) -> Any:  # noqa: ANN401
    from cyclonedds.core import Policy, Qos

    # A control loop does not wait for who is slow; only the last messages count.
    sure = Policy.Reliability.Reliable(10_000_000)
    return Qos(
        sure if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        # The encoding of ROS 2; newer ones have other bytes.
        Policy.DataRepresentation(use_cdrv0_representation=True),
        base=user_data(f"typehash={hash_of(kind)};"),
    )
