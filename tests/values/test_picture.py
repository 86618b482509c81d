"""The picture of an episode, pixel by pixel, against a plain loop over discs and boxes."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer

if TYPE_CHECKING:
    from numpy.typing import NDArray

pytest.importorskip("gymnasium", reason='the extra "gym" is not installed')

from popsteer.adapters.gymnasium.picture import Picture, _box, _dots

SIZE = 400
COLOURS = {
    "ground": (236, 238, 240),
    "lane": (208, 212, 218),
    "line": (96, 104, 116),
    "driven": (214, 92, 46),
    "body": (40, 96, 168),
    "wheel": (20, 20, 24),
    "preview": (24, 140, 90),
}


def test_disc_is_every_pixel_within_its_radius_of_a_point() -> None:
    points = np.array([(0.0, 0.0), (30.4, 17.6), (-199.6, 199.0), (-205.0, 0.0), (203.0, 0.0)])
    points = np.concatenate((points, [(700.0, 3.0), (3.0, -900.0), (199.0, -199.4)]))
    rows, columns = np.mgrid[:SIZE, :SIZE]
    for radius in (0.0, 1.0, 1.5, 2.5, 6.9):
        image = np.zeros((SIZE, SIZE, 3), dtype=np.uint8)
        _dots(image, points, radius, (1, 2, 3))
        wanted = np.zeros((SIZE, SIZE), dtype=bool)
        for x, y in points:
            # Points beyond the picture are left out if their centre is beyond the disc's reach.
            across, up = columns - np.rint(200.0 + x), rows - np.rint(200.0 - y)
            wanted |= across**2 + up**2 <= radius**2
        assert np.array_equal(image[..., 0] == 1, wanted), radius
        assert np.array_equal(image[..., 2] == 3, wanted)


def test_box_is_every_pixel_within_its_half_sides() -> None:
    rows, columns = np.mgrid[:SIZE, :SIZE]
    half = np.array([31.0, 9.5])
    for at, yaw in (((0.0, 0.0), 0.0), ((40.0, -70.5), 0.6), ((-150.0, 30.0), -2.0)):
        image = np.zeros((SIZE, SIZE, 3), dtype=np.uint8)
        _box(image, np.array(at), yaw, half, (9, 9, 9))
        place = (columns - 200.0 - at[0]) + 1j * (200.0 - rows - at[1])
        own = place * np.exp(-1j * yaw)
        wanted = (np.abs(own.real) <= half[0]) & (np.abs(own.imag) <= half[1])
        # But for the rim, where it is a matter of rounding.
        sure = (np.abs(np.abs(own.real) - half[0]) > 1e-6) & (
            np.abs(np.abs(own.imag) - half[1]) > 1e-6
        )
        assert np.array_equal((image[..., 0] == 9)[sure], wanted[sure]), at


def _colour(image: NDArray[np.uint8], middle: float, x: float, y: float) -> str:
    """Name the colour at a place of the world [m, with a car of 3 m]."""
    pixel = image[round(200.0 - 8.0 * y), round(200.0 + 8.0 * (x - middle))].tolist()
    return next(name for name, colour in COLOURS.items() if list(colour) == pixel)


def test_picture_has_road_car_wheels_and_preview_where_they_are() -> None:
    path = popsteer.Path([(-40.0, 0.0), (40.0, 0.0)])
    for scale, rear in ((1.0, 0.0), (0.1, -0.15)):
        car = popsteer.Vehicle(wheelbase=3.0 * scale, rear_axle=rear)
        road = popsteer.Path(np.column_stack((path.x, path.y)) * scale)
        picture = Picture(road, car.wheelbase)
        observation = np.zeros(11, dtype=np.float32)
        observation[4] = 0.5 * math.pi
        # Ahead and to the left of the rear axle, in the vehicle's frame.
        observation[7:] = np.array([12.0, 2.5, 6.0, -4.0]) * scale
        for x in (0.0, 2.0):
            info = np.array([scale * x, 0.0, 0.0, 0.0])
            image = picture.draw(car, info, observation)
            assert image.shape == (SIZE, SIZE, 3)
            middle = scale * x + rear + 0.5 * car.wheelbase

            at = partial(_colour, image, middle / scale)
            axle = middle / scale - 1.5
            assert at(axle - 8.0, 0.0) == at(axle + 20.0, 0.0) == "line"
            assert at(axle + 20.0, 1.6) == at(axle + 20.0, -1.6) == "lane"
            assert at(axle + 20.0, 1.9) == at(axle + 20.0, -1.9) == "ground"
            assert at(axle + 12.0, 2.5) == at(axle + 6.0, -4.0) == "preview"
            assert at(axle + 12.0, -2.5) == at(axle + 6.0, 4.0) == "ground"
            # The body reaches 0.75 m beyond the axles, and 0.9 m to each side.
            assert at(axle - 0.65, 0.0) == at(axle + 3.65, 0.0) == "body"
            assert at(axle - 1.0, 0.3) == at(axle + 4.0, 0.3) == "lane"
            assert at(axle + 1.5, 0.8) == at(axle + 1.5, -0.8) == "body"
            assert at(axle + 1.5, 1.0) == at(axle + 1.5, -1.0) == "lane"
            # The rear wheels lie along the car, and the front ones, turned, across.
            for side in (0.75, -0.75):
                assert at(axle + 0.25, side) == at(axle, side) == "wheel"
                assert at(axle + 0.25, side + 0.2) != "wheel"
                assert at(axle + 3.0, side + 0.25) == at(axle + 3.0, side - 0.25) == "wheel"
                assert at(axle + 3.25, side) == "body"
        picture.clear()
        assert len(picture._driven) == 0
        picture.draw(car, np.array([0.0, 0.0, 0.0]), observation)
        assert picture._driven[0] == pytest.approx((rear, 0.0))


def test_line_of_the_road_is_dense_and_a_lap_is_closed() -> None:
    square = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    for closed, length in ((False, 30.0), (True, 40.0)):
        line = Picture(popsteer.Path(square, closed=closed))._line
        steps = np.hypot(*np.diff(line, axis=0).T)
        assert len(line) == round(length / 0.1)
        assert steps.sum() == pytest.approx(length, abs=0.3)
        assert tuple(line[-1]) == ((0.0, 0.0) if closed else (0.0, 10.0))
    assert len(Picture(popsteer.Path([(0.0, 0.0), (9000.0, 0.0)]))._line) == 20_000
    assert len(Picture(popsteer.Path([(0.0, 0.0), (0.01, 0.0)]))._line) == 2


def test_picture_of_a_turned_world_is_the_turned_picture() -> None:
    x = np.arange(-30.0, 60.0, 1.0)
    xy = np.column_stack((x, 6.0 * np.sin(x / 10.0)))
    car = popsteer.Vehicle(wheelbase=3.0, rear_axle=-1.35)
    observation = np.zeros(11, dtype=np.float32)
    observation[4], observation[7:] = 0.4, (12.0, 2.5, 6.0, -4.0)
    images = []
    for quarter in range(4):
        angle = 0.5 * math.pi * quarter
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        picture = Picture(popsteer.Path(xy @ turn.T))
        for at, yaw in (((0.0, 0.3), 0.5), ((3.0, 2.0), 0.7)):
            info = np.array([*(turn @ np.array(at)), yaw + angle, 0.0])
            image = picture.draw(car, info, observation)
        # About the pixel in the middle, so without the first row and column.
        images.append(np.rot90(image[1:, 1:], -quarter))
    for image in images[1:]:
        assert (image != images[0]).any(axis=2).mean() < 2e-3
    # Two wheels and the body about the car's middle, at the heading of 0.7 rad.
    for along, across, colour in ((1.5, 0.75, "wheel"), (-1.5, -0.75, "wheel"), (0.5, 0.0, "body")):
        right = along * math.cos(0.7) - across * math.sin(0.7)
        up = along * math.sin(0.7) + across * math.cos(0.7)
        found = images[0][round(199.0 - 8.0 * up), round(199.0 + 8.0 * right)]
        assert found.tolist() == list(COLOURS[colour]), along
