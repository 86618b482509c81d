"""Path trackers of others, from their formulas, to measure against: each is one of your own.

``popsteer.lab.opponents.lqr:Lqr`` names one where a command asks for a controller, as
`popsteer.own` has it:

=============================================  =================================================
`mpc.Mpc <popsteer.lab.opponents.mpc.Mpc>`     model-predictive, condensed, on daqp
`lqr.Lqr`                                      linear-quadratic, with the curvature fed forward
`rear_wheel.RearWheelFeedback`                 feedback at the rear axle, after Samson
`pure_pursuit.AutowarePurePursuit`             pure pursuit with Autoware's lookahead distance
`pure_pursuit.AccelerationPursuit`             pure pursuit of a lateral acceleration
=============================================  =================================================

All see the vehicle through the same `Observer`: popsteer's own prediction and estimates, so that
what differs is the law.
"""

from popsteer.lab.opponents.observer import Observer, Seen

__all__ = ["Observer", "Seen", "names"]

_NAMES = (
    *("mpc:Mpc", "lqr:Lqr", "rear_wheel:RearWheelFeedback"),
    *("pure_pursuit:AutowarePurePursuit", "pure_pursuit:AccelerationPursuit"),
)


def names() -> tuple[str, ...]:
    """Name them, as `popsteer.own` takes them.

    Examples
    --------
    >>> names()[1]
    'popsteer.lab.opponents.lqr:Lqr'
    """
    return tuple(f"{__name__}.{each}" for each in _NAMES)
