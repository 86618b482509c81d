"""A progress bar that shows itself only where one waits."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar

if TYPE_CHECKING:
    from types import TracebackType

    from rich.progress import TaskID
    from typing_extensions import Self

__all__ = ["Progress"]

_PATIENCE = 1.0  # seconds without a bar


class Progress:
    """A bar on stderr, from the first second on, where stderr is a terminal.

    Examples
    --------
    >>> with Progress() as progress:
    ...     progress.update("pop", 0.5)
    """

    def __init__(self) -> None:
        self._begin = time.monotonic()
        self._console = Console(stderr=True)
        self._bar: Bar | None = None
        self._task: TaskID | None = None

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
        """Take note of how far it is.

        Parameters
        ----------
        what : str
            What is being done.
        share : float
            How much of it is done, 0 to 1.
        """
        if self._bar is None:
            waited = time.monotonic() - self._begin
            if waited < _PATIENCE or not self._console.is_terminal:
                return
            self._bar = Bar(
                TextColumn("{task.description}"),
                BarColumn(),
                console=self._console,
                transient=True,
            )
            self._task = self._bar.add_task(what, total=1.0)
            self._bar.start()
        if self._task is not None:
            self._bar.update(self._task, description=what, completed=share)

    def stop(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None
            self._begin = float("inf")  # and do not come back
