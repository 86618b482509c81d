"""Controllers that others would use, to compare with; they drive like one of your own.

``mpc``
    A linear time-varying model-predictive controller on osqp. It needs the extra ``mpc``:
    ``pip install "popsteer[mpc]"``.

Examples
--------
>>> from popsteer.lab import baselines
>>> baselines.names()
('mpc',)
>>> baselines.get("mpc").title
'MPC'
"""

from popsteer.lab.baselines.mpc_params import MpcParams
from popsteer.lab.baselines.registry import Baseline, get, is_known, names

__all__ = ["Baseline", "MpcParams", "get", "is_known", "names"]
