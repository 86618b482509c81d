"""The one stand-in: an actor and its world, which no server moves but a plant of popsteer.

All else is CARLA's client: maps, waypoints, transforms, controls. The conversions below are written
anew from CARLA's documentation, not taken from the adapter.
"""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree as ET

import carla
import numpy as np
from scenariogeneration import xodr

import popsteer
from popsteer import sim

WHEELBASE, REAR, TRACK = 2.8, -1.3, 1.6  # of the wheels about the actor's point [m]
LOCK_DEG = 60.0
CURVE = ((0.0, 1.0), (20.0, 0.9), (60.0, 0.7))  # factor of the steering by speed [km/h]
CAR = popsteer.Vehicle(
    wheelbase=WHEELBASE, rear_axle=REAR, max_steer=math.radians(LOCK_DEG), steer_lag=0.1
)


class _Stamp:
    def __init__(self, elapsed_seconds: float) -> None:
        self.elapsed_seconds = elapsed_seconds


class _Snapshot:
    def __init__(self, elapsed_seconds: float) -> None:
        self.timestamp = _Stamp(elapsed_seconds)


class _Actors:
    def filter(self, pattern: str) -> list[Any]:
        return []


class _Debug:
    def __init__(self) -> None:
        self.points: list[carla.Location] = []

    def draw_point(self, location: carla.Location, **options: Any) -> None:
        self.points.append(location)


class World:
    """What a planner and an agent ask of a world."""

    def __init__(self, lane_map: carla.Map) -> None:
        self.map, self.time, self.debug = lane_map, 0.0, _Debug()

    def get_map(self) -> carla.Map:
        return self.map

    def get_snapshot(self) -> _Snapshot:
        return _Snapshot(self.time)

    def get_actors(self) -> _Actors:
        return _Actors()


class Actor:
    """A vehicle that is told nothing but `carla.VehicleControl`."""

    id = 1

    def __init__(self, lane_map: carla.Map, simulation: sim.Simulation) -> None:
        self.world, self.simulation = World(lane_map), simulation
        self.control = carla.VehicleControl()
        self.speed_limit = 30.0
        extent = carla.Vector3D(x=2.3, y=0.9, z=0.8)
        self.bounding_box = carla.BoundingBox(carla.Location(), extent)

    def get_world(self) -> World:
        return self.world

    def get_transform(self) -> carla.Transform:
        x, y, yaw, _ = self.simulation.state
        return carla.Transform(carla.Location(x, -y, 0.0), carla.Rotation(yaw=-math.degrees(yaw)))

    def get_location(self) -> carla.Location:
        return self.get_transform().location

    def get_velocity(self) -> carla.Vector3D:
        _, _, yaw, speed = self.simulation.state
        return carla.Vector3D(speed * math.cos(yaw), -speed * math.sin(yaw), 0.0)

    def get_speed_limit(self) -> float:
        return self.speed_limit

    def get_control(self) -> carla.VehicleControl:
        return self.control

    def get_physics_control(self) -> carla.VehiclePhysicsControl:
        """As a server of 0.9 gives it: wheels in the world, in centimetres."""
        transform = self.get_transform()
        wheels = []
        for ahead, lock in ((REAR + WHEELBASE, LOCK_DEG), (REAR, 0.0)):
            for right in (-0.5 * TRACK, 0.5 * TRACK):
                place = transform.transform(carla.Location(ahead, right, 0.0))
                wheel = carla.WheelPhysicsControl(max_steer_angle=lock)
                wheel.position = carla.Vector3D(100 * place.x, 100 * place.y, 100 * place.z)
                wheels.append(wheel)
        curve = [carla.Vector2D(speed, factor) for speed, factor in CURVE]
        return carla.VehiclePhysicsControl(wheels=wheels, steering_curve=curve)

    def apply_control(self, control: carla.VehicleControl) -> None:
        self.control = control

    def tick(self) -> None:
        """Move on by a control period, as the server would."""
        speed = self.simulation.state[3]
        knots, factors = zip(*CURVE, strict=True)
        factor = float(np.interp(3.6 * abs(speed), knots, factors))
        to_the_right = float(np.clip(self.control.steer, -1.0, 1.0)) * factor * LOCK_DEG
        self.simulation.step(math.radians(-to_the_right), self.control.throttle, self.control.brake)
        self.world.time += self.simulation.settings.dt


# Curvature of each bend [1/m], the angle it turns by [rad], the straight before it [m].
_BENDS = ((1 / 30, math.pi / 2, 60.0), (-1 / 20, 0.8, 30.0), (1 / 25, 1.6, 20.0))
_TRANSITION = 15.0  # of each clothoid [m]


def bends(sign: float = 1.0) -> list[list[Any]]:
    """The geometry of bends joined by clothoids, each behind a straight; mirrored with −1."""
    geometry: list[list[Any]] = []
    for curvature, angle, straight in _BENDS:
        bend = sign * curvature
        length = angle / abs(curvature) - _TRANSITION
        geometry.append(
            [
                xodr.Line(straight),
                xodr.Spiral(0.0, bend, _TRANSITION),
                xodr.Arc(bend, length=length),
                xodr.Spiral(bend, 0.0, _TRANSITION),
            ]
        )
    geometry[-1].append(xodr.Line(40.0))
    return geometry


def opendrive(sign: float = 1.0) -> str:
    """A road of all bends; mirrored with `sign` −1."""
    geometry = [piece for bend in bends(sign) for piece in bend]
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
