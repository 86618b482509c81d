"""Named parameter sets: where the paper and its authors' published code differ, both are here.

=================  =============================================================================
preset             what it is
=================  =============================================================================
``default``        What the parameter classes hold: the paper's Table 1, read so that the result
                   depends on neither the step size nor a standstill. Lengths, speeds and gains
                   per metre scale with the vehicle.
``paper``          The paper's Table 1 and equations, literally.
``published-code`` What the authors' published program computes.
``reproduction``   For each controller but the PID the one of these readings that comes closest to
                   the paper's table of results on the plant identified from the authors' run.
=================  =============================================================================

All but ``default`` are absolute numbers, those of the paper's car, whatever the vehicle; those of
the two controllers that the paper does not have scale with it.

Controller by controller:

`pid`
    The paper's integral (Equation 1) sums errors without Δt, so its weight grows with the control
    rate; the published code multiplies by Δt, and so do ``default`` and ``reproduction``. The gains
    are 0.25, 0.01 and 0.2 in Table 1, but 0.12, 0.01 and 0.48 in the code. The paper's PID row
    could not be reproduced: with the table's gains and Δt it tracks as closely as POP. ``default``
    takes the derivative across the path's heading over two wheelbases (``smoothing_length``), the
    others that of the error.
`pure-pursuit`
    The lookahead is k_v v in the paper (Equation 2), which vanishes at rest, and max(10 m, 0.9 v)
    in the code, which also takes the bearing from an arc cosine. ``default`` has the code's least
    lookahead and the exact bearing; ``reproduction`` is the code's.
`stanley`
    The code compares the heading with the segment behind the nearest waypoint, the paper's
    Equation 3 with the path beside the axle. ``reproduction`` is the code's. ``default`` takes the
    path's heading over a wheelbase of it (``smoothing_length``), so noise of the waypoints is not
    steered.
`pop`
    ld_min is not given in the paper; 6 m is the code's.
`preview-pop`
    Not in the paper. All four are the same.

`pop` and `pure-pursuit` search for their lookahead point: ``default`` takes the path's first
crossing of the lookahead circle, the others the paper's threshold search on the re-discretised
path (``exact_lookahead=False``).

The vehicle's parameters are in a `popsteer.Vehicle`; no preset sets it, see
`popsteer.vehicles`.

Examples
--------
>>> from popsteer import presets
>>> presets.get("pid", "published-code").kd
0.48
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from popsteer import _core, controllers
from popsteer.ranges import check_known

if TYPE_CHECKING:
    from popsteer.controllers import Params

__all__ = ["REPRODUCTION", "get", "names"]

REPRODUCTION = "reproduction"
"""The preset of the paper's experiment, `popsteer.lab.compare.paper.run`."""

# The published code's numbers for a car of 3 m wheelbase, where the paper has none.
_SEARCH: dict[str, Any] = {
    "exact_lookahead": False,
    "lookahead_tolerance": 0.01,
    "window_ahead": 20.0,
    "grid_spacing": 0.01,
}
_PLACE: dict[str, Any] = {"search_distance": 6.0, "lost_distance": 30.0}

_PID = _core.PidParams(
    kp=0.25,
    ki=0.01,
    kd=0.2,
    buffer_length=500,
    integral_with_dt=True,
    smoothing_length=0.0,
    derivative_filter=0.0,
    **_PLACE,
)
_PURE_PURSUIT = _core.PurePursuitParams(
    lookahead_gain=0.9, min_lookahead=10.0, alpha_by_arccos=True, **_SEARCH, **_PLACE
)
_STANLEY = _core.StanleyParams(
    cross_track_gain=1.5,
    speed_gain=1.3,
    softening=1e-5,
    heading_behind=True,
    smoothing_length=0.0,
    **_PLACE,
)
_POP = _core.PopParams(
    lookahead_gain=0.2,
    min_lookahead=6.0,
    steer_span=math.radians(3.0),
    candidate_count=21,
    **_SEARCH,
    **_PLACE,
)

_NAMES = ("default", "paper", "published-code", REPRODUCTION)
# Of each controller in the order of the names.
_PRESETS: dict[str, tuple[Params, ...]] = {
    "pid": (
        _core.PidParams(),
        _PID.replace(integral_with_dt=False),
        _PID.replace(kp=0.12, kd=0.48),
        _PID,
    ),
    "pure-pursuit": (
        _core.PurePursuitParams(),
        _PURE_PURSUIT.replace(min_lookahead=0.0, alpha_by_arccos=False),
        _PURE_PURSUIT,
        _PURE_PURSUIT,
    ),
    "stanley": (_core.StanleyParams(), _STANLEY.replace(heading_behind=False), _STANLEY, _STANLEY),
    "pop": (_core.PopParams(), _POP, _POP, _POP),
    "preview-pop": (_core.PreviewPopParams(),) * 4,
}


def names(law: str) -> tuple[str, ...]:
    """Names of the presets of a controller.

    Parameters
    ----------
    law : str
        A name that `popsteer.controllers.names` gives.

    Returns
    -------
    tuple of str
        The names that `get` knows for this controller; the same for all of popsteer.

    Raises
    ------
    ConfigError
        No controller has this name.

    Examples
    --------
    >>> names("pid")
    ('default', 'paper', 'published-code', 'reproduction')
    """
    controllers.get(law)
    return _NAMES


def get(law: str, name: str) -> Params:
    """Give the parameters that a preset holds for a controller.

    Parameters
    ----------
    law : str
        A name that `popsteer.controllers.names` gives.
    name : str
        One of `names(law)`.

    Returns
    -------
    PopParams or PreviewPopParams or PidParams or PurePursuitParams or StanleyParams
        The parameters, which cannot be changed; their ``replace`` gives a changed copy.

    Raises
    ------
    ConfigError
        No controller, or no preset of it, has this name.

    Examples
    --------
    >>> get("pure-pursuit", "paper").min_lookahead
    0.0
    >>> get("pop", "tuned")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: unknown preset 'tuned'; known: default, paper, published-code, \
reproduction
    """
    check_known("preset", name, names(law))
    return _PRESETS[law][_NAMES.index(name)]
