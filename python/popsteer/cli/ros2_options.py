"""What ``popsteer ros2`` and ``popsteer record`` have in common."""

from __future__ import annotations

import re
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from popsteer.cli.assignments import pairs
from popsteer.cli.options import Text, Texts, flag, optional, valued
from popsteer.errors import ConfigError
from popsteer.extras import require
from popsteer.files import read_bytes
from popsteer.ranges import check_known

if TYPE_CHECKING:
    from collections.abc import Mapping

    from popsteer.adapters.ros2.topics import Topics

_LEVELS = ("debug", "info", "warn", "error", "fatal")
_FLAGS = ("closed", "use_sim_time")
_PARAMETERS = ("rate", "stale", "hold", "keep_path", "timeout", "max_speed", *_FLAGS)

Domain = Annotated[int | None, optional("ID", "DDS domain; by default that of ROS_DOMAIN_ID.")]
Localhost = Annotated[bool, flag("--localhost", "Stay on this machine.")]
Autoware = Annotated[bool, flag("--autoware", "Autoware's messages and names of topics.")]
PathType = Annotated[Text, optional("path|trajectory", "Type: nav_msgs/Path or a Trajectory.")]
CommandType = Annotated[
    Text, optional("TYPE", "Command: ackermann, control, twist or twist-stamped.")
]
Topic = Annotated[Texts, optional("NAME=TOPIC", "Another topic for odometry, path, command, ...")]
RosArgs = Annotated[bool, flag("--ros-args", "What follows is as ROS's launch files write it.")]
_REMAP = "Another name, as ROS has it: of a topic, __node, __ns."
Remap = Annotated[Texts, optional("FROM:=TO", _REMAP, "-r", "--remap")]
_PARAM = "A ROS parameter, such as rate or max_speed."
Param = Annotated[Texts, optional("NAME:=VALUE", _PARAM, "-p", "--param")]
ParamsFile = Annotated[Texts, optional("FILE", "A YAML file of ROS parameters.", "--params-file")]
LogLevel = Annotated[
    Text, optional("LEVEL", "Print debug, info, warn, error or fatal.", "--log-level")
]
Timeout = Annotated[float, valued("SECONDS", "Wait so long for the first messages.")]


class Names(NamedTuple):
    """What ``-r`` says: the node's name, its namespace, and other names for topics."""

    node: str = "popsteer"
    namespace: str = "/"
    rules: Mapping[str, str] = MappingProxyType({})


def names_of(remaps: list[str] | None) -> Names:
    """Give the names that ``FROM:=TO`` each ask for."""
    from popsteer.adapters.ros2.names import check_namespace, check_node

    rules = _assigned("--remap", remaps)
    name = rules.pop("__name", "popsteer")
    node, namespace = rules.pop("__node", name), rules.pop("__ns", "/")
    return Names(check_node(node), check_namespace(namespace), rules)


def parameters_of(
    given: list[str] | None, files: list[str] | None, names: Names
) -> dict[str, float | bool]:
    """Give the ROS parameters of the node: those of the files, and over them those given."""
    if not given and not files:
        return {}
    require("a file of ROS parameters", "ros2", "rosbags")
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    yaml = YAML(typ="safe")
    full = f"{names.namespace.rstrip('/')}/{names.node}"
    found: dict[str, Any] = {}
    for file in files or []:
        text = read_bytes(file)
        try:
            for who, what in (yaml.load(text.decode()) or {}).items():
                if not _is_meant(who, full):
                    continue
                given_here = (what or {}).get("ros__parameters") or {}
                # What is written for other nodes, too, may have parameters of theirs.
                known = set(_PARAMETERS) if "*" in who else given_here.keys()
                found |= {name: given_here[name] for name in given_here.keys() & known}
        except (YAMLError, AttributeError, TypeError, UnicodeDecodeError) as error:
            raise ConfigError("--params-file", file, "a YAML file of ROS parameters") from error
    found |= {name: yaml.load(text) for name, text in _assigned("--param", given).items()}
    for name, value in found.items():
        check_known("parameter", name, _PARAMETERS)
        if isinstance(value, bool) != (name in _FLAGS) or not isinstance(value, int | float):
            wanted = "a bool" if name in _FLAGS else "a number"
            raise ConfigError(f"parameter {name}", value, wanted)
    return found


def _is_meant(pattern: str, node: str) -> bool:
    """Say whether the name of nodes in a file is a node's: ``*`` is one word, ``**`` are any."""
    words = f"/{pattern.lstrip('/')}".replace("/**", "(/[^/]+)*")
    return re.fullmatch(re.sub(r"(?<!\))\*", "[^/]+", words), node) is not None


def least(level: str | None) -> int:
    """Give the least of the node's levels that is printed at a level of ROS's logging."""
    if level is None:
        return 0
    word = level.rpartition(":=")[2].lower()
    check_known("--log-level", word, _LEVELS)
    return max(_LEVELS.index(word) - _LEVELS.index("info"), 0)


def _assigned(option: str, given: list[str] | None) -> dict[str, str]:
    """Split ``NAME:=VALUE`` each; the last one of a name counts."""
    found = {}
    for each in given or []:
        name, sign, value = each.partition(":=")
        if not (name and sign and value):
            raise ConfigError(option, each, "written NAME:=VALUE")
        found[name] = value
    return found


def topics_of(
    renamed: list[str] | None,
    path_type: str | None,
    command_type: str | None,
    *,
    autoware: bool,
    names: Names | None = None,
) -> Topics:
    """Give the topics of `renamed`, ``NAME=TOPIC`` each; other names may be Autoware's."""
    # Here, so that the other commands do not load the adapter.
    from popsteer.adapters.ros2.messages import PATH, TRAJECTORY
    from popsteer.adapters.ros2.topics import COMMANDS, Topics

    paths = {"path": PATH, "trajectory": TRAJECTORY}
    commands = {name.replace("_", "-"): kind for name, kind in COMMANDS.items()}
    topics = Topics.of_autoware() if autoware else Topics()
    asked = [each.partition("=")[0] for each in renamed or []]
    if twice := [name for name in asked if asked.count(name) > 1]:
        raise ConfigError("--topic", twice[0], "given once")
    for name, word, known in (("path", path_type, paths), ("command", command_type, commands)):
        if word is not None:
            check_known(f"--{name}-type", word, known)
            topics = replace(topics, **{f"{name}_type": known[word]})
    return topics.renamed(dict(pairs("--topic", renamed, whole=True)), *(names or Names()))
