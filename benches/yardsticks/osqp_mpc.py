"""The model-predictive controller of `popsteer.lab.baselines`, as the benchmark drives it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.lab.baselines.mpc import Mpc
from popsteer.lab.bench.calls import MPC_SOLVE, MPC_UPDATE
from popsteer.lab.common.timing import Driver

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.lab.common.timing import Drive


def prepare(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of drivers for a drive."""

    def make() -> Driver:
        mpc = Mpc(drive.path, drive.vehicle)
        return Driver(mpc.steer, mpc.reset, {MPC_UPDATE: mpc.update, MPC_SOLVE: mpc.solve})

    return make
