"""A page: its parts, and what made it, put together into one file that needs nothing else."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from html import escape
from importlib import resources
from typing import Any

from popsteer import controllers, params_file, vehicle_file
from popsteer._core import Settings, Vehicle, __version__
from popsteer.errors import PopsteerError
from popsteer.lab.common.names import differences
from popsteer.lab.report.colours import named, style
from popsteer.lab.report.markup import block, json_for_script, paragraphs
from popsteer.lab.report.scene import Pack, Scene, deflated
from popsteer.toml_file import table

LARGEST = 2_500_000
"""Bytes of a page, at most."""
_ASSETS = (
    *("numbers", "theme", "interpolate", "map", "panels"),
    *("readout", "player", "figures", "main"),
)
_MOST_POINTS = 250_000  # of a scene: more take seconds to draw
_STRIDES = tuple(2**k for k in range(16))
_ROLES = ("background", "text", "faint", "grid", "path", "speed", "pid")


@dataclass(frozen=True)
class Section:
    """A part of a page under a heading of its own."""

    name: str
    title: str
    body: str
    """Its content, HTML."""


@dataclass(frozen=True)
class Page:
    """What a page shows."""

    title: str
    lead: str
    """With what, in a line."""
    command: str
    """How to repeat it on the command line; empty where it was not from there."""
    results: str
    """Tables and notes, HTML."""
    scenes: Sequence[Scene] = ()
    """What drives on the map; one of them is shown at a time. Without any there is no map."""
    figures: Sequence[dict[str, Any]] = ()
    """Figures for plotly: `title`, `traces`, `layout`; ``@name`` stands for a colour of `roles`."""
    roles: dict[str, list[str]] = field(default_factory=dict)
    """Colours by name, on light and on dark."""
    below: str = ""
    """Tables that belong to the figures, HTML."""
    sections: Sequence[Section] = ()
    """What made it: vehicles, parameters."""
    choice: str = "Run"
    """What the scenes are."""
    left_out: str = ""
    """What was left out so that it fits."""

    def content(self) -> bytes:
        """Put the page together, HTML in UTF-8, of at most `LARGEST` bytes.

        Samples are thinned to fit; where that is not enough the last runs are left out, then the
        figures, and the page says so.
        """
        from plotly.offline import get_plotlyjs

        plotly = deflated(str(get_plotlyjs()).encode())
        points = max((scene.points for scene in self.scenes), default=0)
        strides = [k for k in _STRIDES[:-1] if points <= _MOST_POINTS * k] + [_STRIDES[-1]]

        @cache
        def made(stride: int) -> bytes:
            # The name of a file may hold bytes that are no text.
            return _assembled(self, plotly, stride).encode("utf-8", "replace")

        def fits(stride: int) -> bool:
            return len(made(stride)) <= LARGEST

        # A larger stride never makes a page larger.
        place = 0 if fits(strides[0]) else bisect_left(strides, x=True, key=fits)
        if place < len(strides):
            return made(strides[place])
        fewer = self.scenes[: len(self.scenes) // 2]
        if fewer or (self.scenes and not self.figures):
            return replace(self, scenes=fewer, left_out=_without(self, fewer)).content()
        if self.figures:
            said = f"{self.left_out} Left out are the figures."
            return replace(self, figures=(), left_out=said).content()
        least = len(made(strides[-1]))
        raise PopsteerError(f"a report of {least} bytes, where at most {LARGEST} are allowed")


def _without(page: Page, fewer: Sequence[Scene]) -> str:
    whole = re.search(r"of (\d+) drives", page.left_out)
    count = int(whole[1]) if whole else len(page.scenes)
    return f" Left out, so that the page fits, are the last {count - len(fewer)} of {count} drives."


def _assembled(page: Page, plotly: str, stride: int) -> str:
    pack = Pack()
    scenes = [scene.document(pack, stride) for scene in page.scenes]
    document = {
        "scenes": scenes,
        "figures": list(page.figures),
        "roles": {role: named(role) for role in _ROLES} | page.roles,
        "numbers": pack.text(),
    }
    samples = max((scene.samples for scene in page.scenes), default=0)
    precision = "Drawn are positions to 1 mm, errors to 0.1 mm, angles to 0.001°."
    if stride > 1:
        precision += (
            f" Of {samples} samples one in {stride} is drawn, and besides those with the largest"
            " values and with a change of status; tables and figures count all."
        )
    again = "The command that repeats this"
    values = {
        "title": escape(page.title),
        "lead": escape(page.lead),
        "version": escape(__version__),
        "style": style() + _asset("page.css"),
        "links": _links(page),
        "command": page.command and block(again, page.command, is_open=True, wraps=True),
        "results": page.results,
        "choice": _choice(page),
        "driven": "" if page.scenes else " hidden",
        "precision": precision + page.left_out,
        "below": page.below,
        "sections": "".join(
            f'<section id="{escape(each.name)}"><h2>{escape(each.title)}</h2>{each.body}</section>'
            for each in page.sections
        ),
        "plotly": plotly,
        "data": json_for_script(document),
        "code": "".join(_asset(f"{name}.js") for name in _ASSETS),
    }
    # In one pass, so that marks within the inserted texts stay as they are.
    return re.sub(r"{{([a-z]+)}}", lambda found: values[found[1]], _asset("page.html"))


def _links(page: Page) -> str:
    links = [("results", "Results"), *([("drive", "Drive")] if page.scenes else [])]
    if page.figures or any(scene.figures for scene in page.scenes):
        links.append(("figures", "Figures"))
    links += [(each.name, each.title) for each in page.sections]
    return "".join(f'<a href="#{escape(name)}">{escape(title)}</a>' for name, title in links)


def _choice(page: Page) -> str:
    hidden = "" if len(page.scenes) > 1 else " hidden"
    options = "".join(
        f'<option value="{place}">{escape(scene.title)}</option>'
        for place, scene in enumerate(page.scenes)
    )
    return f'<label{hidden}>{escape(page.choice)} <select id="scene">{options}</select></label>'


def _asset(name: str) -> str:
    return (resources.files(__package__) / "assets" / name).read_text(encoding="utf-8")


@dataclass(frozen=True)
class Origin:
    """What the command was, and what the runs do not say themselves."""

    command: str = ""
    """The command line."""
    params: Mapping[str, Any] = field(default_factory=dict)
    """Parameters of the controllers by name."""
    adapt: Any = "auto"
    """How they adapt: AdaptParams, ``"auto"`` or None."""
    plants: Mapping[str, Any] = field(default_factory=dict)
    """The plants by what they are called."""
    monitor: Any = "auto"
    """How they watch for faults: MonitorParams, ``"auto"`` or None."""


NOWHERE = Origin()
"""Of what no command made."""


def vehicles(*cars: tuple[str, Vehicle, Vehicle]) -> Section:
    """Show each plant's vehicle, and where it differs what the controllers were given of it."""
    blocks = []
    for name, vehicle, given in {each[0]: each for each in cars}.values():
        blocks.append(block(f"{name}: the vehicle", vehicle_file.as_toml(vehicle)))
        if given != vehicle:
            said = differences(given, vehicle).removeprefix(", believed ")
            title = f"{name}: the vehicle that the controllers were given ({said})"
            blocks.append(block(title, vehicle_file.as_toml(given)))
    return Section("vehicle", "Vehicle", "".join(blocks))


def tuning(origin: Origin, *others: str) -> Section:
    """Show what the controllers and plants were made with, and other blocks after that."""
    blocks = []
    for name, params in origin.params.items():
        own = name in controllers.names()
        text = params_file.as_toml(params) if own else table(name, params.as_dict())
        blocks.append(block(f"{name}: parameters", text))
    if origin.adapt is None:
        blocks.append(paragraphs(["The controllers estimated nothing (--no-adapt)."]))
    for title, name in (("adapt", "adapt"), ("watch for faults", "monitor")):
        if hasattr(each := getattr(origin, name), "as_dict"):
            blocks.append(block(f"How the controllers {title}", table(name, each.as_dict())))
    for name, plant in origin.plants.items():
        owner = getattr(plant, "params", plant)
        values = owner.as_dict() if hasattr(owner, "as_dict") else {}
        if values := {key: value for key, value in values.items() if key != "vehicle"}:
            blocks.append(block(f"{name}: parameters of the plant", table(name, values)))
    return Section("parameters", "Parameters", "".join([*blocks, *others]))


def settings_block(settings: Settings) -> str:
    """Show the settings of the runs."""
    values = settings.as_dict()
    values.pop("keep_records", None)
    return block("The run: settings, as --set-run takes them", table("run", values))
