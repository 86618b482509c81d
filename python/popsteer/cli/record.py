"""``popsteer record``: what a node and its surroundings exchange, as an MCAP file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from popsteer.cli import ros2_options
from popsteer.cli.options import optional
from popsteer.errors import printable

HELP = """\
Record the topics of "popsteer ros2" as MCAP, without ROS: odometry, path, commands, the intended
trajectory, diagnostics and the clock.

Foxglove, Rerun and "ros2 bag" read the file; "popsteer identify" and "popsteer replay" take it as
their log. Ctrl-C ends the recording; so does --seconds. If nothing is received within --timeout, it
ends with one line and exit status 2.

\b
Examples:
  popsteer record drive.mcap
  popsteer record drive.mcap --topic odometry=/ego/odom --seconds 60
  popsteer record drive.mcap --autoware --domain 7
"""


def record(
    *,
    file: Annotated[
        Path, typer.Argument(metavar="FILE.mcap", help="The file to write.", show_default=False)
    ],
    topic: ros2_options.Topic = None,
    path_type: ros2_options.PathType = None,
    command_type: ros2_options.CommandType = None,
    autoware: ros2_options.Autoware = False,
    seconds: Annotated[float | None, optional("S", "Record for so long.")] = None,
    domain: ros2_options.Domain = None,
    localhost: ros2_options.Localhost = False,
    timeout: ros2_options.Timeout = 10.0,
) -> None:
    """Record the topics of the ROS 2 node."""
    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.pacing import stop_on_signals
    from popsteer.adapters.ros2.recording import Recording, tap

    topics = ros2_options.topics_of(topic, path_type, command_type, autoware=autoware)
    stopped = stop_on_signals()
    participant = Participant(domain, local=localhost or None, node="popsteer_record")
    ends = {"timeout": timeout, "seconds": float("inf") if seconds is None else seconds}
    with Recording(file) as recording:
        counts = tap(participant, topics.types(), recording, stopped, **ends)
    for name, count in counts.items():
        print(f"{count:7d}  {name}")
    print(f"Written to {printable(str(file))}")
