"""The command ``popsteer``. It needs the extra ``lab``; ``main`` says so where it is missing."""

from popsteer.cli.entry import main

__all__ = ["main"]
