"""Chromium without a window, driven over a pipe by its DevTools protocol: no package needed."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import signal
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import pytest

with suppress(ImportError):  # not on Windows, where the tests that need it skip
    import fcntl

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from typing_extensions import Self

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_FLAGS = (
    "--headless=new",
    "--no-sandbox",  # root has no other
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-extensions",
    "--disable-background-networking",
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
    "--remote-debugging-pipe",
)
_PATIENCE = 60.0
_KEYS = {
    "Tab": 9,
    "Enter": 13,
    "Escape": 27,
    " ": 32,
    "End": 35,
    "Home": 36,
    "ArrowLeft": 37,
    "ArrowUp": 38,
    "ArrowRight": 39,
    "ArrowDown": 40,
}
_TEXTS = {"Enter": "\r", " ": " "}


class Browser:
    """One page of a browser of its own.

    `said` gathers all that the console says, and what no code has caught; `errors` what of it is
    an error or a warning; `requests` every address that is asked for.
    """

    def __init__(self, profile: Path) -> None:
        if os.name != "posix":
            pytest.skip("the pipe to the browser is POSIX's")
        program = next((found for name in _NAMES if (found := shutil.which(name))), None)
        if program is None:
            pytest.skip(f"no browser at hand: none of {', '.join(_NAMES)}")
        self._program: str = program
        self._profile = profile
        self._rest = b""
        self._count = 0
        self._session: str | None = None
        self.said: list[str] = []
        self.errors: list[str] = []
        self.requests: list[str] = []

    def __enter__(self) -> Self:
        # The browser reads from 3 and writes to 4.
        read_there, write_here = _pipe()
        read_here, write_there = _pipe()
        log = os.open(os.devnull, os.O_RDWR)
        self._pid = os.posix_spawn(
            self._program,
            [self._program, *_FLAGS, f"--user-data-dir={self._profile}", "about:blank"],
            os.environ,
            file_actions=[
                *((os.POSIX_SPAWN_DUP2, log, stream) for stream in (0, 1, 2)),
                (os.POSIX_SPAWN_DUP2, read_there, 3),
                (os.POSIX_SPAWN_DUP2, write_there, 4),
            ],
            setpgroup=0,
        )
        for each in (read_there, write_there, log):
            os.close(each)
        self._in, self._out = write_here, read_here
        try:
            (page,) = (
                each
                for each in self._ask("Target.getTargets", {})["targetInfos"]
                if each["type"] == "page"
            )
            attached = self._ask(
                "Target.attachToTarget", {"targetId": page["targetId"], "flatten": True}
            )
            self._session = attached["sessionId"]
            for domain in ("Page", "Runtime", "Log", "Network"):
                self.ask(f"{domain}.enable")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):
            self._write("Browser.close", {}, None)
        end = time.monotonic() + 5.0
        while time.monotonic() < end:
            if os.waitpid(self._pid, os.WNOHANG) != (0, 0):
                break
            time.sleep(0.02)
        else:
            os.killpg(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)
        with suppress(ProcessLookupError):
            os.killpg(self._pid, signal.SIGKILL)
        os.close(self._in)
        os.close(self._out)

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Send a command to the page, and wait for its answer."""
        return self._ask(method, params)

    def run(self, script: str) -> Any:
        """Give the value of an expression of JavaScript; a promise is waited for."""
        answer = self.ask(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise AssertionError(details.get("exception", {}).get("description", details["text"]))
        return answer["result"].get("value")

    def wait(self, condition: str) -> None:
        """Wait until an expression of JavaScript is true."""
        end = time.monotonic() + _PATIENCE
        while not self.run(f"Boolean({condition})"):
            assert time.monotonic() < end, f"never true: {condition}; {self.errors}"
            time.sleep(0.02)

    def look(
        self,
        width: int,
        height: int,
        *,
        dark: bool = False,
        mobile: bool = False,
        motion: bool = False,
    ) -> None:
        """Set the size of the window, and whether the system is dark, and lets pages move."""
        self.ask(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=mobile,
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        moves = {"name": "prefers-reduced-motion", "value": "" if motion else "reduce"}
        self.ask("Emulation.setEmulatedMedia", features=[scheme, moves])

    def open(self, address: str) -> None:
        """Open a page, and wait until it has loaded."""
        for each in (self.said, self.errors, self.requests):
            each.clear()
        self.ask("Page.navigate", url=address)
        self.wait("document.readyState === 'complete'")

    def press(self, key: str, *, shift: bool = False) -> None:
        """Press a key and let it go."""
        text = {"text": _TEXTS[key]} if key in _TEXTS else {}
        for kind, more in (("keyDown", text), ("keyUp", {})):
            self.ask(
                "Input.dispatchKeyEvent",
                type=kind,
                key=key,
                code="Space" if key == " " else key,
                windowsVirtualKeyCode=_KEYS[key],
                modifiers=8 if shift else 0,
                **more,
            )

    def fill(self, selector: str, text: str) -> None:
        """Put a text into a field in the place of what is there."""
        self.run(f"(field => {{ field.focus(); field.select(); }})({_element(selector)})")
        self.ask("Input.insertText", text=text)

    def point(self, x: float, y: float, *, click: bool = False) -> None:
        """Move the pointer to a place of the window, and click there."""
        self._mouse("mouseMoved", x, y)
        if click:
            self._mouse("mousePressed", x, y, clickCount=1)
            self._mouse("mouseReleased", x, y, clickCount=1)

    def click(self, selector: str) -> None:
        """Click the middle of an element, which must be in sight there."""
        place = self.run(
            f"""(element => {{
              element.scrollIntoView({{block: "nearest", behavior: "instant"}});
              const {{x, y, width, height}} = element.getBoundingClientRect();
              const place = [x + width / 2, y + height / 2];
              return element.contains(document.elementFromPoint(...place)) ? place : null;
            }})({_element(selector)})"""
        )
        assert place, f"not in sight: {selector}"
        self.point(*place, click=True)

    def drag(self, places: Sequence[tuple[float, float]], *, steps: int) -> None:
        """Press the button at the first place, let it go at the last; so many steps to each."""
        x, y = places[0]
        self.point(x, y)
        self._mouse("mousePressed", x, y, clickCount=1)
        for to_x, to_y in places[1:]:
            for share in (step / steps for step in range(1, steps + 1)):
                self._mouse("mouseMoved", x + share * (to_x - x), y + share * (to_y - y), buttons=1)
            x, y = to_x, to_y
        self._mouse("mouseReleased", x, y, clickCount=1)

    def named(self, role: str, name: str) -> str:
        """Give the selector of the element that a screen reader knows by this role and name."""
        root = self.ask("DOM.getDocument", depth=0)["root"]["nodeId"]
        found = self.ask("Accessibility.queryAXTree", nodeId=root, role=role, accessibleName=name)
        numbers = [each["backendDOMNodeId"] for each in found["nodes"] if not each["ignored"]]
        assert len(numbers) == 1, f"{len(numbers)} of role {role} and name {name}"
        given = self.ask("DOM.describeNode", backendNodeId=numbers[0])["node"]["attributes"]
        return f"#{given[given.index('id') + 1]}"

    def screenshot(self, *, whole: bool = False) -> bytes:
        """Take a picture of the window, or of the whole page: a PNG."""
        shot = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        return base64.b64decode(shot["data"])

    def _mouse(self, kind: str, x: float, y: float, **more: int) -> None:
        button = {"button": "left"} if more else {}
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button, **more)

    def _ask(self, method: str, params: dict[str, Any]) -> dict[str, Any]:
        number = self._write(method, params, self._session)
        while True:
            message = self._read()
            if message.get("id") == number:
                assert "error" not in message, f"{method}: {message['error']}"
                result: dict[str, Any] = message["result"]
                return result
            self._note(message)

    def _write(self, method: str, params: dict[str, Any], session: str | None) -> int:
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": method, "params": params}
        if session is not None:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self._in, data) :]
        return self._count

    def _read(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._out], [], [], _PATIENCE)
            assert ready, "the browser does not answer"
            data = os.read(self._out, 1 << 20)
            assert data, "the browser has ended"
            self._rest += data
        line, _, self._rest = self._rest.partition(b"\0")
        message: dict[str, Any] = json.loads(line)
        return message

    def _note(self, message: dict[str, Any]) -> None:
        """Keep what a test wants to know of what the page does by itself."""
        params = message.get("params", {})
        method = message.get("method")
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self._hear("error", details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled":
            said = " ".join(str(each.get("value", each)) for each in params["args"])
            self._hear(params["type"], said)
        elif method == "Log.entryAdded":
            self._hear(params["entry"]["level"], params["entry"]["text"])

    def _hear(self, level: str, text: str) -> None:
        self.said.append(f"{level}: {text}")
        if level in ("error", "warning"):
            self.errors.append(text)


def _element(selector: str) -> str:
    return f"document.querySelector({json.dumps(selector)})"


def _pipe() -> tuple[int, int]:
    """Open a pipe whose ends lie above the numbers that the browser expects."""
    ends = os.pipe()
    high = [fcntl.fcntl(each, fcntl.F_DUPFD_CLOEXEC, 16) for each in ends]
    for each in ends:
        os.close(each)
    return high[0], high[1]
