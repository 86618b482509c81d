"""The model-predictive controller of `popsteer.baselines`, as the benchmark drives it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.baselines.mpc import Mpc
from popsteer.baselines.mpc_params import MpcParams
from popsteer.bench.laws import MPC_SOLVE, MPC_UPDATE, Driver

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.bench.states import Drive


def prepare(drive: Drive) -> Callable[[], Driver]:
    """Give a maker of drivers for a drive."""
    # Both drives that there are, the recorded and the embedded one, are of the identified vehicle.
    params = MpcParams.for_plant("carla-identified")

    def make() -> Driver:
        mpc = Mpc(drive.path, params.replace(reference_offset=drive.front_offset))
        return Driver(mpc.steer, mpc.reset, {MPC_UPDATE: mpc.update, MPC_SOLVE: mpc.solve})

    return make
