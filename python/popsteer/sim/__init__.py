"""Plants, the closed loop and its measurements.

A run lets a controller drive a plant along a path, from the start to the end, and measures it. The
plants are the vehicle identified from the run that the paper's authors recorded in CARLA, and a
kinematic bicycle that does what its `popsteer.Vehicle` says. What a plant is and what a controller
believes are two values of that one type; a controller that was given none takes the plant's.

Examples
--------
>>> import popsteer
>>> from popsteer import sim, tracks
>>> track = tracks.get("racetrack")
>>> path = popsteer.Path(track.xy, speed=track.speed)
>>> result = sim.run(popsteer.Pop(path))
>>> result.metrics.finished, result.metrics.mean_abs_cross_track_error < 0.5
(True, True)

A car that is made from a vehicle, and a controller that is told a lag too short:

>>> car = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.2)
>>> pop = popsteer.Pop(path, car.replace(steer_lag=0.1))
>>> sim.run(pop, sim.KinematicBicycle(car), constant_speed=6.0).metrics.finished
True

`run_many` drives many at once, on all cores. Both may let the controllers see through `Noise`.
"""

from popsteer._core import CarlaIdentified, KinematicBicycle, Noise, Settings, Simulation
from popsteer.sim.closed_loop import Run, default_start, run
from popsteer.sim.geometry import Plant, Pose, StartAt, plant_name, plant_names, vehicle_of
from popsteer.sim.many import run_many
from popsteer.sim.metrics import Metrics
from popsteer.sim.pedals import PedalMap
from popsteer.sim.steering import OwnCommand, OwnController, OwnLaw, OwnReversingLaw

__all__ = [
    "CarlaIdentified",
    "KinematicBicycle",
    "Metrics",
    "Noise",
    "OwnCommand",
    "OwnController",
    "OwnLaw",
    "OwnReversingLaw",
    "PedalMap",
    "Plant",
    "Pose",
    "Run",
    "Settings",
    "Simulation",
    "StartAt",
    "default_start",
    "plant_name",
    "plant_names",
    "run",
    "run_many",
    "vehicle_of",
]
