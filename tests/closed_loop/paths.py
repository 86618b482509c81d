"""Paths that the closed loop is driven on."""

from __future__ import annotations

import numpy as np

import popsteer
from popsteer import tracks
from popsteer.tracks.cusps import parallel_parking, three_point_turn


def track(name: str) -> popsteer.Path:
    shipped = tracks.get(name)
    return popsteer.Path(shipped.xy, speed=shipped.speed, closed=shipped.closed)


def line(length: int = 121) -> popsteer.Path:
    return popsteer.Path([(float(x), 0.0) for x in range(length)])


def shuttle(speed: float = 3.0) -> popsteer.Path:
    """30 m forward along x, 20 m back, and 40 m forward again."""
    x = np.concatenate(
        (np.arange(0.0, 30.0, 0.5), np.arange(30.0, 10.0, -0.5), np.arange(10.0, 50.0, 0.5))
    )
    ahead = np.append(np.diff(x), 0.5)
    return popsteer.Path(np.column_stack((x, np.zeros_like(x))), speed=speed * np.sign(ahead))


def cusps(name: str) -> popsteer.Path:
    """A parking manoeuvre: forward, in reverse, and forward again."""
    xy, speed, closed = {"three-point-turn": three_point_turn, "parking": parallel_parking}[name]()
    return popsteer.Path(xy, speed=speed, closed=closed)
