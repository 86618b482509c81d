"""Thousands of runs that differ: how often a controller succeeds, and where it fails."""

from popsteer.lab.sweep import rows, summary
from popsteer.lab.sweep.job import Job, drive, repeat
from popsteer.lab.sweep.runs import run

__all__ = ["Job", "drive", "repeat", "rows", "run", "summary"]
