"""Bang-bang: a fixed angle back towards the path, the floor to measure against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range
from popsteer.reference.laws.law import Belief, Decision, Params, Tracked, limit_steer
from popsteer.reference.tracker.state import TrackerState
from popsteer.reference.tracker.step import Tracker

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Located

__all__ = ["BangBang", "BangBangParams", "BangBangState"]


@dataclass(frozen=True, kw_only=True)
class BangBangParams(Params):
    """Parameters of `BangBang`.

    Attributes
    ----------
    amplitude : float
        The angle that is switched [rad]; at most the vehicle's `max_steer` of it is used. The
        published code takes a tenth of its limit.
    deadband : float
        Cross-track errors up to this leave the wheels straight [m].
    search_distance : float or None
        Arc of the path that is searched on each side of the last projection [m], in addition to the
        distance travelled in a step; None is two wheelbases.
    lost_distance : float or None
        Distance from the path beyond which the vehicle is lost and is searched for on the whole
        path [m]; None is ten wheelbases.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> BangBangParams(deadband=0.1).amplitude
    0.122
    """

    amplitude: float = 0.122
    deadband: float = 0.0
    search_distance: float | None = None
    lost_distance: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "amplitude", 0.0, 1.57)
        config_in_range(self, "deadband", 0.0, 1e6)
        super().__post_init__()


@dataclass(frozen=True, kw_only=True)
class BangBangState(TrackerState):
    """What `BangBang` remembers: what a `TrackerState` has.

    Examples
    --------
    >>> BangBangState().steer
    0.0
    """


class BangBang(Tracker[BangBangParams, BangBangState]):
    """A fixed angle back towards the path: -amplitude sign(χ_e) outside the deadband, 0 inside.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> controller = BangBang(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
    >>> controller.steer(0.0, 0.5, 0.0, 5.0, 0.05)  # left of the path: steer right
    -0.122
    """

    TRACKED = Tracked.FRONT_AXLE
    PARAMS = BangBangParams
    STATE = BangBangState

    def decide(self, at: Located, belief: Belief) -> Decision:  # noqa: ARG002 - not needed here
        """Decide the angle for a located vehicle."""
        error = at.closest.cross_track_error()
        if error > self.params.deadband:
            wanted = -self.params.amplitude
        elif error < -self.params.deadband:
            wanted = self.params.amplitude
        else:
            wanted = 0.0
        steer, status = limit_steer(self.vehicle, wanted)
        return Decision(steer, at.closest.point, status)
