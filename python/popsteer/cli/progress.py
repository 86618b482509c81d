"""A progress bar that appears after a second."""

from __future__ import annotations

import sys
import threading
import time
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import TracebackType

    from rich.progress import TaskID
    from typing_extensions import Self

_PATIENCE = 1.0  # seconds without a bar


class Progress:
    """A bar on stderr, from the first second on, where stderr is a terminal."""

    def __init__(self) -> None:
        self._begin = time.monotonic()
        self._console = Console(stderr=True)
        self._lock = threading.Lock()
        self._now = ("", 0.0)
        self._timer: threading.Timer | None = None
        self._bar: Bar | None = None
        self._task: TaskID | None = None
        self._over = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()

    def update(self, what: str, share: float) -> None:
        """Take note of what is being done, and of the share of it that is done, 0 to 1."""
        with self._lock:
            self._now = (what, share)
            if self._bar is not None and self._task is not None:
                self._bar.update(self._task, description=what, completed=share)
            elif self._timer is None and not self._over and self._console.is_terminal:
                # A timer, as what takes longest may say nothing while it lasts.
                wait = self._begin + _PATIENCE - time.monotonic()
                self._timer = threading.Timer(wait, self._show)
                self._timer.daemon = True
                if wait > 0.0:
                    self._timer.start()
                else:
                    self._draw()

    def _show(self) -> None:
        """Show the bar; from then on it draws itself."""
        with self._lock:
            if not self._over:
                self._draw()

    def _draw(self) -> None:
        what, share = self._now
        self._bar = Bar(
            TextColumn("{task.description}"), BarColumn(), console=self._console, transient=True
        )
        self._task = self._bar.add_task(what, total=1.0)
        self._bar.update(self._task, completed=share)
        self._bar.start()

    def stop(self) -> None:
        """Take the bar away; it does not come back."""
        if self._timer is not None:
            self._timer.cancel()
        with self._lock:
            self._over = True
            if self._bar is not None:
                self._bar.stop()
                self._bar = None


@contextmanager
def kept_in(where: object) -> Iterator[None]:
    """Say, where Ctrl-C stops a command, that what is done is kept.

    `where` is the file or the storage that has it; None where it is lost. KeyboardInterrupt goes on
    as it came.
    """
    try:
        yield
    except KeyboardInterrupt:
        if where is not None:
            with suppress(OSError):
                said = f"popsteer: stopped; the same command goes on with what is in {where}"
                print(said, file=sys.stderr)
        raise
