"""Ctrl-C while the command ``popsteer`` still loads: it ends at once, without a traceback.

Imported first of all; from there on `popsteer.cli.main` handles it.
"""

from __future__ import annotations

import _signal as signal  # type: ignore[import-not-found]  # signal: enum, functools, ... first
import os
import sys


def end(*_: object) -> None:
    """End the process with the status that a shell has for Ctrl-C."""
    os._exit(130)


_came: list[int] = []


def has_come() -> bool:
    """Say whether Ctrl-C came while the command ran, whatever error a library has made of it."""
    return bool(_came)


def _interrupt(number: int, _: object) -> None:
    _came.append(number)
    raise KeyboardInterrupt


def handle_as_usual() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again."""
    if signal.getsignal(signal.SIGINT) is end:
        signal.signal(signal.SIGINT, _interrupt)


# A worker of the command's own has its name, and handles Ctrl-C as its pool does.
_name = "".join(getattr(sys, "argv", [])[:1]).replace("\\", "/").rpartition("/")[2]
if _name.removesuffix(".exe") == "popsteer" and "multiprocessing" not in sys.modules:
    signal.signal(signal.SIGINT, end)
