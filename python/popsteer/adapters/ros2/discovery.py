"""Which domain a node is in and whom it looks for there: the environment variables of ROS 2."""

from __future__ import annotations

import os
import socket
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from popsteer.errors import ConfigError
from popsteer.ranges import check_known

if TYPE_CHECKING:
    from collections.abc import Mapping

_DOMAINS = 232
_RANGES = ("SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT")


def domain_of(domain: int | None, environment: Mapping[str, str] = os.environ) -> int:
    """Give the domain to be in: `domain`, or else that of ``ROS_DOMAIN_ID``, or else 0.

    Raises ConfigError where it is no number from 0 to 232.

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


def configuration(*, local: bool | None = None, environment: Mapping[str, str] = os.environ) -> str:
    """Give Cyclone DDS's configuration, put together as ``rmw_cyclonedds_cpp`` 2.2 does.

    `local` is LOCALHOST where it is true, SUBNET where it is false. ``CYCLONEDDS_URI`` is appended
    and has the last word. ConfigError where the environment's discovery range is none.

    Examples
    --------
    >>> configuration(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT"})
    ''
    >>> "<AllowMulticast>false" in configuration(environment={"ROS_LOCALHOST_ONLY": "1"})
    True
    """
    name = "ROS_AUTOMATIC_DISCOVERY_RANGE"
    scope = environment.get(name, "") or "SUBNET"
    if local is not None:
        scope = "LOCALHOST" if local else "SUBNET"
    elif environment.get("ROS_LOCALHOST_ONLY") == "1":
        scope = "LOCALHOST"
    check_known(name, scope, _RANGES)
    uri = environment.get("CYCLONEDDS_URI", "")
    if scope == "SYSTEM_DEFAULT":
        return uri
    peers = ["localhost"] if scope == "LOCALHOST" else []
    given = environment.get("ROS_STATIC_PEERS", "").split(";") if scope != "OFF" else []
    peers += [peer.strip() for peer in given if peer.strip()]
    if any(set(peer) & set('<>"&') for peer in peers):
        raise ConfigError("ROS_STATIC_PEERS", ";".join(peers), "addresses, separated by semicolons")
    index = "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32"
    index += "</MaxAutoParticipantIndex>"
    if scope == "OFF":
        index = "<ParticipantIndex>none</ParticipantIndex>"
        index += f"<Tag>ros_discovery_off_{os.getpid()}</Tag>"
    general = "" if scope == "SUBNET" else "<AllowMulticast>false</AllowMulticast>"
    told = uri
    if uri.startswith("file:"):
        with suppress(OSError):  # where there is none, Cyclone DDS says so
            told = Path(uri.removeprefix("file:").removeprefix("//")).read_text(encoding="utf-8")
    if scope == "LOCALHOST" and "NetworkInterface" not in told:
        # Cyclone DDS 0.10, which Jazzy has, reaches the loopback from any interface, 11 does not.
        # From the loopback it reaches nothing else: for static peers it is the way to the first.
        own = next((own for peer in peers[1:] if (own := _own_address(peer))), "")
        loopback = "lo0" if sys.platform == "darwin" else "lo"
        one = f'address="{own}"' if own else f'name="{loopback}"'
        general = f"<Interfaces><NetworkInterface {one}/></Interfaces>{general}"
    general = f"<General>{general}</General>" if general else ""
    listed = "".join(f'<Peer address="{peer}"/>' for peer in peers)
    found = f"<Discovery>{index}<Peers>{listed}</Peers></Discovery>"
    return f"<CycloneDDS><Domain>{general}{found}</Domain></CycloneDDS>,{uri}"


def _own_address(peer: str) -> str:
    """Give the address from which this machine sends to a peer; empty where it cannot."""
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as there:
        there.connect((peer, 1))  # sends nothing
        return str(there.getsockname()[0])
    return ""
