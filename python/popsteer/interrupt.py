"""Ctrl-C while the command ``popsteer`` still loads: it ends at once, without a traceback.

Imported first of all; from there on `popsteer.cli.main` handles it. Once it has come the command
ends for certain: what swallows a KeyboardInterrupt, as an extension may that loads, gets another
one, and what still goes on after some seconds is left.
"""

from __future__ import annotations

import _signal as signal  # type: ignore[import-not-found]  # signal: enum, functools, ... first
import _thread
import os
import sys
import time

_AGAIN = 3.0  # s that a KeyboardInterrupt has to reach the end of the command
_TIMES = 3  # how often it is raised again
_LEAVING = 2.0  # s for what others have registered to be done at the end


def end(*_: object) -> None:
    """End the process with the status that a shell has for Ctrl-C."""
    os._exit(130)


_came: list[int] = []


def has_come() -> bool:
    """Say whether Ctrl-C came while the command ran, whatever error a library has made of it."""
    return bool(_came)


def _interrupt(number: int, _: object) -> None:
    if not _came:
        # By no lock: this one may have interrupted who holds it.
        _thread.start_new_thread(_insist, (_thread.get_ident(),))
    _came.append(number)
    raise KeyboardInterrupt


def _insist(thread: int) -> None:
    """Raise KeyboardInterrupt again in a thread that goes on, and end the process in the end."""
    for _ in range(_TIMES):
        time.sleep(_AGAIN)
        raising = getattr(signal, "pthread_kill", None)
        if raising is not None:  # not on Windows; wakes what waits, too
            raising(thread, signal.SIGINT)
        else:
            _thread.interrupt_main()
    end()


def _end_after(seconds: float) -> None:
    time.sleep(seconds)
    end()


def leave() -> None:
    """End the process after Ctrl-C: all is written, and nothing that still goes on is waited for.

    To take down the modules of a cluster would take up to a second more.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _thread.start_new_thread(_end_after, (_LEAVING,))
    if (processes := sys.modules.get("multiprocessing")) is not None:
        for each in processes.active_children():
            each.kill()  # or else they are joined below
    if (registered := sys.modules.get("atexit")) is not None:
        registered._run_exitfuncs()  # noqa: SLF001 - without it pools leave semaphores
    sys.stderr.flush()
    end()


def handle_as_usual() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again."""
    if signal.getsignal(signal.SIGINT) is end:
        signal.signal(signal.SIGINT, _interrupt)


# A worker of the command's own has its name, and handles Ctrl-C as its pool does.
_name = "".join(getattr(sys, "argv", [])[:1]).replace("\\", "/").rpartition("/")[2]
if _name.removesuffix(".exe") == "popsteer" and "multiprocessing" not in sys.modules:
    signal.signal(signal.SIGINT, end)
