"""Names of nodes, topics and services by ROS's rules, and its remapping of them."""

from __future__ import annotations

import re

from popsteer.errors import ConfigError

_WORD = "[A-Za-z_][A-Za-z0-9_]*"
_NAME = re.compile(f"(/{_WORD})+")
_LONGEST = 247
_RULE = "words of letters, digits and _ that begin with no digit, each after one /"


def check_name(what: str, name: str) -> str:
    """Give the full name of a topic or of a service, where it is one; else raise ConfigError."""
    if not _NAME.fullmatch(name) or len(name) > _LONGEST:
        raise ConfigError(what, name, _RULE)
    return name


def check_namespace(name: str) -> str:
    """Give a namespace, ``/`` or like a topic, where it is one; else raise ConfigError."""
    return name if name == "/" else check_name("namespace", name)


def check_node(name: str) -> str:
    """Give the name of a node, where it is one; else raise ConfigError."""
    if not re.fullmatch(_WORD, name):
        raise ConfigError("node name", name, "letters, digits and _, with no digit first")
    return name


def expanded(name: str, node: str = "popsteer", namespace: str = "/") -> str:
    """Give the full name: relative ones are in the namespace, ``~`` is the node's own.

    Examples
    --------
    >>> expanded("plan", namespace="/car"), expanded("~/reset"), expanded("/odom")
    ('/car/plan', '/popsteer/reset', '/odom')
    """
    within = "" if namespace == "/" else namespace
    if name == "~" or name.startswith("~/"):
        return f"{within}/{node}{name[1:]}"
    return name if name.startswith("/") else f"{within}/{name}"
