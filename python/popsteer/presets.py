"""Named parameter sets: where the paper and its authors' published code differ, both are here.

=================  =============================================================================
preset             what it is
=================  =============================================================================
``default``        What the parameter classes hold: the paper's Table 1, read so that the result
                   depends on neither the step size nor a standstill.
``paper``          The paper's Table 1 and equations, literally.
``published-code`` What the authors' published program computes.
``reproduction``   For each law the one of these readings that comes out closest to the paper's
                   table of results on the plant identified from the authors' run.
=================  =============================================================================

Law by law:

`bang-bang`
    The paper runs none. All presets switch 0.122 rad (7 degrees).
`pid`
    The paper's integral (Equation 1) sums errors without Δt, so its weight grows with the control
    rate; the published code multiplies by Δt, and so do ``default`` and ``reproduction``. The gains
    are 0.25, 0.01 and 0.2 in Table 1, but 0.12, 0.01 and 0.48 in the code. No reading reproduces
    the paper's PID row: with the table's gains and Δt it tracks as closely as POP.
`pure-pursuit`
    The lookahead is k_v v in the paper (Equation 2), which vanishes at rest, and max(10 m, 0.9 v)
    in the code, which also takes the bearing from an arc cosine. ``default`` has the code's least
    lookahead and the exact bearing; ``reproduction`` is the code's.
`stanley`
    The code compares the heading with the segment behind the nearest waypoint, the paper's
    Equation 3 with the path beside the axle. ``reproduction`` is the code's.
`pop`
    ld_min is not given in the paper; 6 m is the code's.
`preview-pop`
    Not in the paper. All four are the same.

`pop` and `pure-pursuit` search for their lookahead point: ``default`` takes the path's first
crossing of the lookahead circle, the others the paper's threshold search on the re-discretised
path (``exact_lookahead=False``).

The wheelbase and the reference point are the vehicle's, not the law's, so no preset sets them: see
`popsteer.sim.fitted`.

Examples
--------
>>> from popsteer import presets
>>> presets.get("pid", "published-code").kd
0.48
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer import laws
from popsteer._core import (
    BangBangParams,
    PidParams,
    PopParams,
    PreviewPopParams,
    PurePursuitParams,
    StanleyParams,
)
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from popsteer.laws import Params

__all__ = ["REPRODUCTION", "get", "names"]

REPRODUCTION = "reproduction"
"""The preset that comparisons with the paper use unless told otherwise."""

_CODE_STANLEY = StanleyParams(heading_behind=True)
_CODE_PURE_PURSUIT = PurePursuitParams(
    lookahead_gain=0.9, min_lookahead=10.0, alpha_by_arccos=True, exact_lookahead=False
)
_PAPER_POP = PopParams(exact_lookahead=False)

_PRESETS: dict[str, dict[str, Params]] = {
    "bang-bang": {
        "default": BangBangParams(),
        "paper": BangBangParams(),
        "published-code": BangBangParams(amplitude=0.122),
        REPRODUCTION: BangBangParams(),
    },
    "pid": {
        "default": PidParams(),
        "paper": PidParams(kp=0.25, ki=0.01, kd=0.2, integral_with_dt=False),
        "published-code": PidParams(kp=0.12, ki=0.01, kd=0.48, integral_with_dt=True),
        REPRODUCTION: PidParams(),
    },
    "pure-pursuit": {
        "default": PurePursuitParams(),
        "paper": PurePursuitParams(lookahead_gain=0.9, min_lookahead=0.0, exact_lookahead=False),
        "published-code": _CODE_PURE_PURSUIT,
        REPRODUCTION: _CODE_PURE_PURSUIT,
    },
    "stanley": {
        "default": StanleyParams(),
        "paper": StanleyParams(cross_track_gain=1.5, speed_gain=1.3, softening=1e-5),
        "published-code": _CODE_STANLEY,
        REPRODUCTION: _CODE_STANLEY,
    },
    "pop": {
        "default": PopParams(),
        "paper": _PAPER_POP,
        "published-code": _PAPER_POP,
        REPRODUCTION: _PAPER_POP,
    },
    "preview-pop": {
        "default": PreviewPopParams(),
        "paper": PreviewPopParams(),
        "published-code": PreviewPopParams(),
        REPRODUCTION: PreviewPopParams(),
    },
}


def names(law: str) -> tuple[str, ...]:
    """Names of the presets of a law.

    Parameters
    ----------
    law : str
        A name that `popsteer.laws.names` gives.

    Returns
    -------
    tuple of str
        The names that `get` knows for this law; the same for all laws of popsteer.

    Raises
    ------
    ConfigError
        No law has this name.

    Examples
    --------
    >>> names("pid")
    ('default', 'paper', 'published-code', 'reproduction')
    """
    return tuple(_PRESETS[laws.get(law).name])


def get(law: str, name: str) -> Params:
    """Give the parameters that a preset holds for a law.

    Parameters
    ----------
    law : str
        A name that `popsteer.laws.names` gives.
    name : str
        One of `names(law)`.

    Returns
    -------
    PopParams or PreviewPopParams or PidParams or PurePursuitParams or StanleyParams \
or BangBangParams
        The parameters, which cannot be changed; their ``replace`` gives a changed copy.

    Raises
    ------
    ConfigError
        No law, or no preset of the law, has this name.

    Examples
    --------
    >>> get("pure-pursuit", "paper").min_lookahead
    0.0
    >>> get("pop", "tuned")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: unknown preset 'tuned'; known: default, paper, published-code, \
reproduction
    """
    if name not in names(law):
        raise ConfigError.unknown("preset", name, names(law))
    return _PRESETS[law][name]
