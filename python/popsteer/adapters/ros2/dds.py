"""The wire: topics of a DDS domain as ROS 2 names them, with the QoS that its nodes have."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from popsteer.adapters.ros2.idl import wire_type
from popsteer.errors import ConfigError, PopsteerError
from popsteer.extras import require

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Participant", "Reader", "Writer", "domain_of", "is_local"]

_DOMAINS = 232
_BATCH = 256
# Only this machine, also where its network has no multicast.
_LOCAL = """\
<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="{name}"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>
<Peers><Peer address="localhost"/></Peers></Discovery></Domain></CycloneDDS>"""

# As long as the process lives: with its configuration a domain would lose all of its members.
_CONFIGURED: dict[int, Any] = {}


def domain_of(domain: int | None, environment: Mapping[str, str] = os.environ) -> int:
    """Give the domain to be in.

    Parameters
    ----------
    domain : int or None
        The domain; None for that of ``ROS_DOMAIN_ID``.
    environment : mapping, optional
        The environment variables.

    Returns
    -------
    int
        The domain, 0 where nothing says another.

    Raises
    ------
    ConfigError
        It is no number from 0 to 232.

    Examples
    --------
    >>> domain_of(None, {"ROS_DOMAIN_ID": "7"}), domain_of(3, {"ROS_DOMAIN_ID": "7"})
    (7, 3)
    """
    name, given = "domain", str(domain)
    if domain is None:
        name, given = "ROS_DOMAIN_ID", environment.get("ROS_DOMAIN_ID", "") or "0"
    if not given.isdecimal() or int(given) > _DOMAINS:
        raise ConfigError(name, given, f"a whole number from 0 to {_DOMAINS}")
    return int(given)


def is_local(environment: Mapping[str, str] = os.environ) -> bool:
    """Say whether ROS is told to stay on this machine.

    Parameters
    ----------
    environment : mapping, optional
        The environment variables: ``ROS_AUTOMATIC_DISCOVERY_RANGE`` and ``ROS_LOCALHOST_ONLY``.

    Returns
    -------
    bool
        Whether it is.

    Examples
    --------
    >>> is_local({"ROS_LOCALHOST_ONLY": "1"}), is_local({})
    (True, False)
    """
    told = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").upper() == "LOCALHOST"
    return told or environment.get("ROS_LOCALHOST_ONLY") == "1"


class Participant:
    """A member of a domain, which makes readers and writers.

    Parameters
    ----------
    domain : int, optional
        The domain, 0 to 232; by default that of ``ROS_DOMAIN_ID``.
    local : bool, optional
        Whether to stay on this machine; by default as ROS is told.

    Raises
    ------
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

    def __init__(self, domain: int | None = None, *, local: bool | None = None) -> None:
        require("ROS 2", "ros2", "cyclonedds", "rosbags")
        from cyclonedds.core import DDSException
        from cyclonedds.domain import Domain, DomainParticipant

        self.domain = domain_of(domain)
        self._topics: dict[tuple[str, str], Any] = {}
        if (is_local() if local is None else local) and self.domain not in _CONFIGURED:
            loopback = "lo0" if sys.platform == "darwin" else "lo"
            with suppress(DDSException):  # where this process is in the domain already
                _CONFIGURED[self.domain] = Domain(self.domain, _LOCAL.format(name=loopback))
        try:
            self._participant = DomainParticipant(self.domain)
        except DDSException as error:
            raise PopsteerError(
                f"domain {self.domain} cannot be joined: no such network interface, too many"
                " participants on it, or a CYCLONEDDS_URI that is none"
            ) from error

    def reader(
        self, topic: str, kind: str, *, reliable: bool = False, latched: bool = False
    ) -> Reader:
        """Subscribe to a topic.

        Parameters
        ----------
        topic : str
            Its name, as ROS has it: ``/odom``.
        kind : str
            Its type.
        reliable : bool, default False
            Whether nothing may be lost; it then hears reliable publishers alone. Otherwise it hears
            both kinds.
        latched : bool, default False
            Whether to be sent what was published before; it then hears publishers alone that keep
            it ("transient local").

        Returns
        -------
        Reader
            The subscription.
        """
        from cyclonedds.sub import DataReader

        qos = _qos(reliable=reliable or latched, latched=latched, depth=10)
        return Reader(DataReader(self._participant, self._topic(topic, kind), qos=qos))

    def writer(self, topic: str, kind: str, *, latched: bool = False, depth: int = 1) -> Writer:
        """Publish on a topic, reliably.

        Parameters
        ----------
        topic : str
            Its name.
        kind : str
            Its type.
        latched : bool, default False
            Whether who comes later is sent the last message, too.
        depth : int, default 1
            How many messages are kept for who is slow.

        Returns
        -------
        Writer
            The publisher.
        """
        from cyclonedds.pub import DataWriter

        qos = _qos(reliable=True, latched=latched, depth=depth)
        return Writer(DataWriter(self._participant, self._topic(topic, kind), qos=qos), kind)

    def types_of(self, topic: str) -> set[str]:
        """Give the types that a topic is published with, as far as that is known by now.

        Parameters
        ----------
        topic : str
            Its name.

        Returns
        -------
        set of str
            The types, as ROS has them.
        """
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication

        found = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication).take(N=1000)
        return {
            each.type_name.replace("::dds_::", "/").replace("::", "/").removesuffix("_")
            for each in found
            if getattr(each, "topic_name", None) == f"rt{topic}"
        }

    def _topic(self, name: str, kind: str) -> Any:  # noqa: ANN401 - cyclonedds is an extra
        from cyclonedds.topic import Topic

        if not name.startswith("/") or not name.strip("/"):
            raise ConfigError("topic", name, "a name that begins with /")
        if (name, kind) not in self._topics:
            self._topics[name, kind] = Topic(self._participant, f"rt{name}", wire_type(kind))
        return self._topics[name, kind]


class Reader:
    """A subscription; `Participant.reader` makes it."""

    def __init__(self, reader: Any) -> None:  # noqa: ANN401
        self._reader = reader
        self._waits: Any = None

    def take(self) -> list[bytes]:
        """Take what has come in.

        Returns
        -------
        list of bytes
            The messages since the last call, the oldest first.
        """
        from cyclonedds.core import DDSException

        try:
            found = self._reader.take(N=_BATCH)
        except DDSException:
            return []
        return [each.data for each in found if hasattr(each, "data")]

    def wait(self, seconds: float) -> bool:
        """Wait until something comes in.

        Parameters
        ----------
        seconds : float
            How long at most [s].

        Returns
        -------
        bool
            Whether something has.
        """
        from cyclonedds.core import (
            InstanceState,
            ReadCondition,
            SampleState,
            ViewState,
            WaitSet,
        )

        if self._waits is None:
            anything = ViewState.Any | InstanceState.Any | SampleState.NotRead
            waits = WaitSet(self._reader.participant)
            waits.attach(ReadCondition(self._reader, anything))
            self._waits = waits
        return bool(self._waits.wait(int(seconds * 1e9)) > 0)

    @property
    def peers(self) -> int:
        """How many publishers it hears.

        Returns
        -------
        int
            The number.
        """
        return len(self._reader.get_matched_publications())

    @property
    def refused(self) -> int:
        """How many publishers it does not hear, because their QoS does not fit.

        Returns
        -------
        int
            The number.
        """
        status = self._reader.get_requested_incompatible_qos_status()
        return int(status.total_count)


class Writer:
    """A publisher; `Participant.writer` makes it."""

    def __init__(self, writer: Any, kind: str) -> None:  # noqa: ANN401
        self._writer = writer
        self._wire = wire_type(kind)

    def write(self, data: bytes) -> None:
        """Publish a message.

        Parameters
        ----------
        data : bytes
            The message.

        Raises
        ------
        ValueError
            The bytes are no message of the topic's type.
        """
        from cyclonedds.core import DDSException

        try:
            self._writer.write(self._wire(data))
        except DDSException as error:
            raise ValueError(str(error)) from error

    @property
    def peers(self) -> int:
        """How many subscribers hear it.

        Returns
        -------
        int
            The number.
        """
        return len(self._writer.get_matched_subscriptions())


def _qos(*, reliable: bool, latched: bool, depth: int) -> Any:  # noqa: ANN401
    from cyclonedds.core import Policy, Qos

    # A control loop does not wait for who is slow; only the last messages count.
    sure = Policy.Reliability.Reliable(10_000_000)
    return Qos(
        sure if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        # The encoding of ROS 2; newer ones have other bytes.
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )
