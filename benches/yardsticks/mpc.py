"""The model-predictive controller of popsteer.lab, as the benchmark drives it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from benches.latency.calls import DAQP_SOLVE, DAQP_UPDATE
from benches.latency.timing import Drive, Driver

if TYPE_CHECKING:
    from collections.abc import Callable


def daqp(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of drivers of the one of `popsteer.lab.opponents`."""
    from popsteer.lab.opponents.mpc import Mpc, Weights

    def make() -> Driver:
        mpc = Mpc(drive.path, drive.vehicle, Weights())
        return Driver(mpc.step, mpc.reset, {DAQP_UPDATE: mpc.update, DAQP_SOLVE: mpc.solve})

    return make
