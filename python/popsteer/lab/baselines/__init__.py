"""Controllers that others would use, to compare with; they drive like one of your own.

``mpc``
    The model-predictive controller `popsteer.lab.opponents.mpc.Mpc`, on daqp. It needs the extra
    ``mpc``.

Examples
--------
>>> from popsteer.lab import baselines
>>> baselines.names()
('mpc',)
>>> baselines.get("mpc").title
'MPC'
"""

from popsteer.lab.baselines.registry import Baseline, get, names

__all__ = ["Baseline", "get", "names"]
