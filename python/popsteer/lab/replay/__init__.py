"""Controllers in shadow mode along a log: the run, its table, its figure and its files."""

from popsteer.lab.replay.runs import Replay, Shadow, own_path, run
from popsteer.lab.replay.table import caption, replay_csv, replay_table, summary_csv

__all__ = [
    "Replay",
    "Shadow",
    "caption",
    "own_path",
    "replay_csv",
    "replay_table",
    "run",
    "summary_csv",
]
