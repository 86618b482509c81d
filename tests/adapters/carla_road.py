"""A road with bends, written as OpenDRIVE and read by CARLA's own client."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree as ET

import carla
from scenariogeneration import xodr

# Curvature of each bend [1/m], the angle it turns by [rad], the straight before it [m].
_BENDS = ((1 / 30, math.pi / 2, 60.0), (-1 / 20, 0.8, 30.0), (1 / 25, 1.6, 20.0))
_TRANSITION = 15.0  # of each clothoid [m]


def opendrive(sign: float = 1.0) -> str:
    """A road of bends joined by clothoids; mirrored with `sign` −1."""
    geometry: list[Any] = []
    for curvature, angle, straight in _BENDS:
        bend = sign * curvature
        length = angle / abs(curvature) - _TRANSITION
        geometry += [
            xodr.Line(straight),
            xodr.Spiral(0.0, bend, _TRANSITION),
            xodr.Arc(bend, length=length),
            xodr.Spiral(bend, 0.0, _TRANSITION),
        ]
    geometry.append(xodr.Line(40.0))
    # The lane is as wide on either side, so that a mirrored road's left lane is the mirror image.
    road = xodr.create_road(geometry, id=1, left_lanes=1, right_lanes=1, lane_width=4)
    drive = xodr.OpenDrive("bends", geo_reference="+proj=tmerc +lat_0=0 +lon_0=0")
    drive.add_road(road)
    drive.adjust_roads_and_lanes()
    return ET.tostring(drive.get_element(), encoding="unicode")


def road(sign: float = 1.0) -> carla.Map:
    return carla.Map("bends", opendrive(sign))


def route(lane_map: carla.Map, spacing: float = 1.0) -> list[carla.Waypoint]:
    """The right lane from its begin to its end."""
    waypoints = [lane_map.get_waypoint_xodr(1, -1, 0.0)]
    while following := waypoints[-1].next(spacing):
        waypoints.append(following[0])
    return waypoints
