"""Plants, the closed loop and its measurements.

A run lets a law drive a plant along a path, from the start to the end, and measures it. The plants
are the vehicle identified from the run that the paper's authors recorded in CARLA, and a plain
kinematic bicycle.

Examples
--------
>>> import popsteer
>>> from popsteer import sim, tracks
>>> track = tracks.get("racetrack")
>>> path = popsteer.Path(track.xy, speed=track.speed)
>>> result = sim.run(popsteer.Pop(path))
>>> result.metrics.finished, result.metrics.mean_abs_cross_track_error < 0.5
(True, True)

`run_many` drives many at once, on all cores, and may let the laws see through `Noise`.
"""

from popsteer._core import CarlaIdentified, KinematicBicycle, Noise, Settings, Simulation
from popsteer.sim.geometry import (
    Geometry,
    Plant,
    SteeringModel,
    actuator,
    fitted,
    geometry,
    plant_name,
    plant_names,
    steering_model,
)
from popsteer.sim.many import run_many
from popsteer.sim.metrics import Metrics
from popsteer.sim.run import START_OFFSET, Run, default_start, run
from popsteer.sim.steering import OwnCommand, OwnLaw

__all__ = [
    "START_OFFSET",
    "CarlaIdentified",
    "Geometry",
    "KinematicBicycle",
    "Metrics",
    "Noise",
    "OwnCommand",
    "OwnLaw",
    "Plant",
    "Run",
    "Settings",
    "Simulation",
    "SteeringModel",
    "actuator",
    "default_start",
    "fitted",
    "geometry",
    "plant_name",
    "plant_names",
    "run",
    "run_many",
    "steering_model",
]
