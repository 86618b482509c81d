"""The command ``popsteer``. ``main`` names the extra that a command lacks."""

from popsteer.cli.entry import main

__all__ = ["main"]
