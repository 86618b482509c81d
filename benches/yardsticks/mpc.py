"""The model-predictive controllers of popsteer.lab, as the benchmark drives them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.lab.bench.calls import DAQP_SOLVE, DAQP_UPDATE, MPC_SOLVE, MPC_UPDATE
from popsteer.lab.common.timing import Drive, Driver

if TYPE_CHECKING:
    from collections.abc import Callable


def osqp(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of drivers of the one of `popsteer.lab.baselines`."""
    from popsteer.lab.baselines.mpc import Mpc

    def make() -> Driver:
        mpc = Mpc(drive.path, drive.vehicle)
        return Driver(mpc.steer, mpc.reset, {MPC_UPDATE: mpc.update, MPC_SOLVE: mpc.solve})

    return make


def daqp(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of drivers of the one of `popsteer.lab.opponents`."""
    from popsteer.lab.opponents.mpc import Mpc, Weights

    def make() -> Driver:
        mpc = Mpc(drive.path, drive.vehicle, Weights())
        return Driver(mpc.step, mpc.reset, {DAQP_UPDATE: mpc.update, DAQP_SOLVE: mpc.solve})

    return make
