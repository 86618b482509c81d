"""The model-predictive controller of `popsteer.baselines`, as the benchmark drives it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.baselines.mpc import Mpc
from popsteer.bench.laws import MPC_SOLVE, MPC_UPDATE, Driver

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.bench.states import Drive


def prepare(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of drivers for a drive."""

    def make() -> Driver:
        mpc = Mpc(drive.path, drive.vehicle)
        return Driver(mpc.steer, mpc.reset, {MPC_UPDATE: mpc.update, MPC_SOLVE: mpc.solve})

    return make
