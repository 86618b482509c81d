"""A picture of a vehicle on its path from above, drawn with numpy alone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer import Path, Vehicle

    Floats = NDArray[np.float64]
    Image = NDArray[np.uint8]
    Colour = tuple[int, int, int]

_SIZE = 400  # pixels
_METRES = 50.0  # that the picture shows, for a car of the paper's wheelbase
_SCALE = _SIZE / _METRES
_GROUND, _LANE, _LINE = (236, 238, 240), (208, 212, 218), (96, 104, 116)
_DRIVEN, _BODY, _WHEEL = (214, 92, 46), (40, 96, 168), (20, 20, 24)
_PREVIEW = (24, 140, 90)
_LANE_WIDTH = 3.5  # m
_FIGURES = 7  # of an observation, before its preview
_STEER = 4  # the wheels' angle among them


class Picture:
    """The vehicle in the middle, north up: the path in its lane, where it drove, what it sees."""

    def __init__(self, path: Path, wheelbase: float = 3.0) -> None:
        self._line = _dense(path, wheelbase / 30.0)
        self._driven: list[tuple[float, float]] = []

    def clear(self) -> None:
        """Forget where the vehicle drove."""
        self._driven.clear()

    def draw(self, vehicle: Vehicle, info: Floats, observation: NDArray[np.float32]) -> Image:
        """Draw the vehicle where it is, an image of shape (400, 400, 3)."""
        x, y, yaw = (float(number) for number in info[:3])
        ahead = vehicle.rear_axle + 0.5 * vehicle.wheelbase
        centre = np.array([x + ahead * math.cos(yaw), y + ahead * math.sin(yaw)])
        rear = x + vehicle.rear_axle * math.cos(yaw), y + vehicle.rear_axle * math.sin(yaw)
        # A car of the paper's wheelbase, 3 m, is drawn in 50 m; a small one as large.
        zoom = _SCALE * 3.0 / vehicle.wheelbase
        self._driven.append(rear)
        image = np.empty((_SIZE, _SIZE, 3), dtype=np.uint8)
        image[:] = _GROUND
        near = self._line[np.abs(self._line - centre).max(axis=1) < _SIZE / zoom]
        lane = _LANE_WIDTH / 3.0 * vehicle.wheelbase * zoom / 2
        _dots(image, (near - centre) * zoom, lane, _LANE)
        _dots(image, (near - centre) * zoom, 1.0, _LINE)
        _dots(image, (np.array(self._driven) - centre) * zoom, 1.5, _DRIVEN)
        seen = observation[_FIGURES:].reshape(-1, 2).astype(np.float64)
        _dots(image, (seen @ _turn(yaw).T + rear - centre) * zoom, 2.5, _PREVIEW)
        half = np.array([0.75, 0.3]) * vehicle.wheelbase * zoom
        _box(image, np.zeros(2), yaw, half, _BODY)
        wheel = np.array([0.12, 0.05]) * vehicle.wheelbase * zoom
        steer = float(observation[_STEER])
        for axle, angle in ((-0.5, 0.0), (0.5, steer)):
            for side in (-0.25, 0.25):
                at = _turn(yaw) @ np.array([axle, side]) * vehicle.wheelbase * zoom
                _box(image, at, yaw + angle, wheel, _WHEEL)
        return image


def _dense(path: Path, spacing: float) -> Floats:
    """Points of the path close enough to be a line on the picture, 20,000 at most."""
    x, y, s = np.asarray(path.x), np.asarray(path.y), np.asarray(path.s)
    if path.closed:
        x, y, s = np.append(x, x[0]), np.append(y, y[0]), np.append(s, path.length)
    count = int(min(20_000, max(2.0, path.length / spacing)))
    arc = np.linspace(0.0, path.length, count)
    return np.column_stack((np.interp(arc, s, x), np.interp(arc, s, y)))


def _turn(yaw: float) -> Floats:
    return np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])


def _dots(image: Image, points: Floats, radius: float, colour: Colour) -> None:
    """Draw a disc around each point, in pixels from the middle, y up."""
    columns = np.rint(_SIZE / 2 + points[:, 0]).astype(np.int64)
    rows = np.rint(_SIZE / 2 - points[:, 1]).astype(np.int64)
    reach = int(radius)
    centres = np.zeros((_SIZE + 2 * reach, _SIZE + 2 * reach), dtype=np.bool_)
    rows, columns = rows + reach, columns + reach
    edge = centres.shape[0]
    inside = (rows >= 0) & (rows < edge) & (columns >= 0) & (columns < edge)
    centres[rows[inside], columns[inside]] = True
    drawn = np.zeros((_SIZE, _SIZE), dtype=np.bool_)
    for up in range(-reach, reach + 1):
        wide = int(math.sqrt(max(0.0, radius * radius - up * up)))
        rows_of = centres[reach + up : reach + up + _SIZE]
        for aside in range(reach - wide, reach + wide + 1):
            drawn |= rows_of[:, aside : aside + _SIZE]
    image[drawn] = colour


def _box(image: Image, at: Floats, yaw: float, half: Floats, colour: Colour) -> None:
    """Fill a rectangle about a point, in pixels from the middle, y up."""
    x = np.arange(_SIZE) - _SIZE / 2 - at[0]
    y = _SIZE / 2 - np.arange(_SIZE) - at[1]
    along = x[None, :] * math.cos(yaw) + y[:, None] * math.sin(yaw)
    across = y[:, None] * math.cos(yaw) - x[None, :] * math.sin(yaw)
    image[(np.abs(along) <= half[0]) & (np.abs(across) <= half[1])] = colour
