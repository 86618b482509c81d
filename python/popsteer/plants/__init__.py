"""Plants from elsewhere, behind the protocol that `popsteer.sim` drives its own by.

They need the extra ``plants``.

``commonroad-MODEL-VEHICLE``
    The vehicle models of CommonRoad: MODEL is ``st`` (single-track, linear tyres), ``std``
    (single-track with tyres that saturate) or ``mb`` (multi-body, 29 states); VEHICLE is 1 (Ford
    Escort), 2 (BMW 320i) or 3 (VW Vanagon).
``mujoco-car``
    A four-wheeled car with Ackermann steering in MuJoCo; its model file comes with popsteer.

Each describes itself in its `vehicle`, by published numbers as far as there are any. Each model has
limits of its own. A run that reaches a limit ends there, and names the limit (`PlantLimit`).
Results beyond a limit, and numbers that are not finite, are never shown.

Examples
--------
>>> from popsteer import plants
>>> plants.names()[:3]
('commonroad-st-1', 'commonroad-st-2', 'commonroad-st-3')

A plant of your own is any object that has what `PythonPlant` lists:

>>> import math, popsteer
>>> from popsteer import sim
>>> class Unicycle:
...     name, vehicle, reverses = "unicycle", popsteer.Vehicle(wheelbase=2.0, steer_lag=0.0), True
...     def reset(self, x, y, yaw, speed):
...         self.state = x, y, yaw, speed
...     def advance(self, steer, throttle, brake, dt, substeps, reverse):
...         x, y, yaw, speed = self.state
...         for _ in range(substeps):
...             x, y = x + speed * math.cos(yaw) * dt, y + speed * math.sin(yaw) * dt
...             yaw += speed * math.tan(steer) / 2.0 * dt
...         self.state = x, y, yaw, speed
...         return plants.PlantState(*self.state, speed * math.tan(steer) / 2.0, steer)
>>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
>>> sim.run(popsteer.Pop(path), Unicycle(), speed=5.0).ending
'finished'
"""

from popsteer.errors import PlantLimit
from popsteer.plants.protocol import PlantState, PythonPlant
from popsteer.plants.registry import get, is_known, names

__all__ = ["PlantLimit", "PlantState", "PythonPlant", "get", "is_known", "names"]
