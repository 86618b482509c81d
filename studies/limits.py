"""Preview POP behind wheels that turn slowly: the tables and the map of docs/preview_pop.md.

    python -m studies.limits    # draws the map: overshoot over speed and rate, before and after

"Before" plans without limits and cuts the angle afterwards, as 0.1.0 did. The plant of all but the
slalom is a bicycle in plain Python, no part of popsteer.
"""

from __future__ import annotations

import itertools
import math
import os
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import popsteer
from popsteer import plants, sim, tracks, vehicles
from studies.layout import DOCS, line
from studies.limits_straight import Joined, Straight, check, join, sweep

if TYPE_CHECKING:
    from popsteer.plants import PythonPlant

FIGURE = DOCS / "figures" / "limits-map.png"


class Slalom(NamedTuple):
    """A plant on the slalom, from 2.44 m beside it at constant speed."""

    plant: str
    rate: float
    speed: float

    def make(self) -> sim.CarlaIdentified | PythonPlant:
        """Give the plant."""
        if self.plant == "carla-identified":
            given = vehicles.get(self.plant).replace(max_steer_rate=self.rate)
            return sim.CarlaIdentified(given)
        if self.plant == "mujoco-car":
            from popsteer.plants.mujoco_car import MujocoCar
            from popsteer.plants.pedals import MujocoCarParams

            return MujocoCar(MujocoCarParams(steer_rate=self.rate))
        plant = plants.get(self.plant)
        assert plant.vehicle.max_steer_rate == self.rate
        return plant

    def drive(self, controller: str) -> sim.Metrics:
        """Drive it by "preview-pop" or by "mpc"."""
        path = popsteer.Path(tracks.get("slalom").xy)
        plant = self.make()
        if controller == "mpc":
            from popsteer.lab.baselines.mpc import Mpc

            mpc = Mpc(path, plant.vehicle)
            return sim.run(mpc, plant, path=path, constant_speed=self.speed).metrics
        law = popsteer.PreviewPop(path)
        return sim.run(law, plant, path=path, constant_speed=self.speed).metrics


SLALOMS = (
    *(Slalom("commonroad-mb-2", 0.4, speed) for speed in (9.0, 9.5, 10.0, 10.3, 11.0)),
    Slalom("carla-identified", 0.4, 8.0),
    Slalom("carla-identified", 0.2, 8.0),
    Slalom("mujoco-car", 0.2, 8.0),
    Slalom("mujoco-car", 0.15, 8.0),
)
STRAIGHTS = tuple(
    Straight(rate, speed, offset)
    for rate in (0.2, 0.4, 0.8)
    for speed in (3.0, 8.0, 20.0)
    for offset in (1.0, 3.0)
)


def slalom_lines() -> list[str]:
    """Set out mean errors after settling [m], and the rates of the wheels."""
    lines = []
    for case in SLALOMS:
        found = [case.drive(name) for name in ("preview-pop", "mpc")]
        errors = [f"{run.settled_mean_abs_cross_track_error:.3f}" for run in found]
        rates = [f"{math.degrees(run.rms_steer_rate):.1f}" for run in found]
        lines.append(line(case.plant, f"{case.rate:g}", f"{case.speed:g}", *errors, *rates))
    return lines


def straight_lines() -> list[str]:
    """Set out overshoot [m], and time until within 0.1 m [s], before and after."""

    def cell(found: Joined) -> str:
        within = "never" if math.isinf(found.within) else f"{found.within:.1f}"
        return f"{found.overshoot:.2f}, {within}"

    lines = []
    for near, far in zip(STRAIGHTS[::2], STRAIGHTS[1::2], strict=True):
        cells = [join(case, inside=inside) for case in (near, far) for inside in (False, True)]
        lines.append(line(f"{near.rate:g}", f"{near.speed:g}", *map(cell, cells)))
    return lines


def sweep_lines() -> list[str]:
    """Give what the sweep of the straight came to, by wheelbase and speed."""
    lines = []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(check, sweep(), chunksize=16))
    for wheelbase, fast in itertools.product((0.33, 2.7, 6.0), (False, True)):
        runs = [
            each
            for each in found
            if each[0].wheelbase == wheelbase and (each[0].speed > 20.0) is fast
        ]
        scale = wheelbase / 2.7
        speeds = f"{25 * scale:.1f}" if fast else f"{3 * scale:.1f} to {15 * scale:.1f}"
        over = [joined.overshoot - most for _, joined, most in runs if joined.overshoot > most]
        cells = (
            f"{wheelbase:g}",
            speeds,
            str(len(runs)),
            str(len(over)),
            str(sum(each > 0.1 for each in over)),
            str(sum(joined.late > 0.02 for _, joined, _ in runs)),
        )
        lines.append(line(*cells))
    return lines


def draw_map() -> None:
    """Draw overshoot over speed and rate, before and after."""
    from matplotlib import pyplot as plt
    from matplotlib.colors import LogNorm

    rates, speeds = np.linspace(0.15, 1.0, 18), np.linspace(3.0, 25.0, 23)
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.8), sharey=True, layout="constrained")
    titles = "plan without limits, cut afterwards", "limits inside the prediction"
    for axis, title, inside in zip(axes, titles, (False, True), strict=True):
        over = [
            [join(Straight(rate, speed, 1.0), inside=inside).overshoot for speed in speeds]
            for rate in rates
        ]
        mesh = axis.pcolormesh(
            speeds, rates, np.maximum(over, 1e-3), norm=LogNorm(1e-3, 3.0), cmap="viridis"
        )
        axis.set(title=title, xlabel="speed [m/s]")
    axes[0].set_ylabel("rate of the wheels [rad/s]")
    figure.colorbar(mesh, ax=axes, label="overshoot from 1 m beside [m]")
    figure.savefig(FIGURE, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    draw_map()
    print(f"wrote docs/figures/{FIGURE.name}")
