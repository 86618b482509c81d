"""What a prediction comes to: the cost-to-go of a linear model with a quadratic cost.

The state of the prediction has four entries: the cross-track error e [m], the heading error p
[rad], the curvature that the vehicle drives, a [1/m], and the curvature that its wheels are told,
c [1/m]. Everything is counted along the way travelled, so the model is the same at any speed; the
steering lag alone becomes a distance, lag times speed::

    e' = p + offset a,    p' = a - path curvature,    a' = (c - a) / lag distance
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

__all__ = ["BestMove", "CostToGo", "Predicted", "Travel"]


@dataclass(frozen=True)
class Travel:
    """The model over one step of travel, solved exactly.

    Attributes
    ----------
    step : float
        Way travelled [m].
    error_by_driven, error_by_told : float
        What a unit of a, and of c, adds to e [m²].
    heading_by_driven, heading_by_told : float
        What a unit of a, and of c, adds to p [m].
    kept, taken : float
        Shares of a, and of c, in a after the step.
    """

    step: float
    error_by_driven: float
    error_by_commanded: float
    heading_by_driven: float
    heading_by_commanded: float
    kept: float
    taken: float

    @classmethod
    def over(cls, step: float, lag: float, kept: float, offset: float) -> Travel:
        """Solve the model over `step` [m].

        The curvature follows over `lag` [m], of which the share `kept`, exp(-step / lag), remains;
        errors are those of a point `offset` [m] ahead of the one that does not slip.

        Examples
        --------
        >>> Travel.over(0.5, 0.0, 0.0, 0.0).error_by_commanded  # a circle: curvature * step² / 2
        0.125
        """
        taken = 1.0 - kept
        heading_by_driven = lag * taken
        heading_by_commanded = step - heading_by_driven
        lagging = lag * heading_by_commanded
        return cls(
            step=step,
            error_by_driven=lagging + offset * heading_by_driven,
            error_by_commanded=0.5 * step * step - lagging + offset * heading_by_commanded,
            heading_by_driven=heading_by_driven,
            heading_by_commanded=heading_by_commanded,
            kept=kept,
            taken=taken,
        )

    def after(self, state: Predicted, turn: float, drift: float) -> Predicted:
        """Return the state after this step from `state`, whose wheels were just moved.

        The path turns by `turn` [rad] on the way, the vehicle drifts to the left by `drift` [m].

        Examples
        --------
        >>> Travel.over(0.5, 0.0, 0.0, 0.0).after(Predicted(0.0, 0.0, 0.0, 0.2), 0.0, 0.0)
        Predicted(error=0.025, heading=0.1, driven=0.2, commanded=0.2)
        """
        moved = drift - 0.5 * self.step * turn
        error, heading, driven, commanded = state
        return Predicted(
            error=(error + self.step * heading + moved)
            + (self.error_by_driven * driven + self.error_by_commanded * commanded),
            heading=(heading - turn)
            + (self.heading_by_driven * driven + self.heading_by_commanded * commanded),
            driven=self.kept * driven + self.taken * commanded,
            commanded=commanded,
        )

    def before_commanded(self, state: Predicted, turn: float, drift: float) -> Predicted:
        """Return the state after this step, without what the curvature commanded on it adds."""
        moved = drift - 0.5 * self.step * turn
        return Predicted(
            state.error
            + (self.step * state.heading + (self.error_by_driven * state.driven + moved)),
            (state.heading - turn) + self.heading_by_driven * state.driven,
            self.kept * state.driven,
            state.commanded,
        )

    def added(self) -> Predicted:
        """Return what a curvature of 1, commanded on the step before, adds to that."""
        return Predicted(
            self.error_by_commanded
            + (self.step * self.heading_by_commanded + self.error_by_driven * self.taken),
            self.heading_by_commanded + self.heading_by_driven * self.taken,
            self.kept * self.taken,
            0.0,
        )


class Predicted(NamedTuple):
    """A state of the prediction."""

    error: float
    """Cross-track error [m]."""
    heading: float
    """Heading error [rad]."""
    driven: float
    """Curvature that the vehicle drives [1/m]."""
    commanded: float
    """Curvature that is commanded [1/m]."""


class BestMove(NamedTuple):
    """The best move of the wheels in a state.

    The curvature that is commanded next is
    left · commanded − (e · error + p · heading + a · driven + constant).
    """

    e: float
    p: float
    a: float
    remaining: float
    constant: float

    def commanded(self, state: Predicted) -> float:
        """Return the curvature that is best commanded in `state` [1/m]."""
        return self.remaining * state.commanded - self.pull(state)

    def pull(self, state: Predicted) -> float:
        """Return what of it is not of the curvature commanded already, with the sign changed."""
        return (self.e * state.error + self.p * state.heading) + (
            self.a * state.driven + self.constant
        )

    def remaining_after(self, travel: Travel) -> float:
        """Return what of a curvature commanded on the last step is left in the next one.

        Where the state does not hold what it has added.
        """
        return self.remaining - (
            (self.e * travel.error_by_commanded + self.p * travel.heading_by_commanded)
            + self.a * travel.taken
        )


@dataclass(frozen=True)
class CostToGo:
    """A quadratic cost of the state.

    An entry for each product of two of e, p, a and c, and twice what goes with each alone. A
    constant would change no decision.
    """

    ee: float
    ep: float
    ea: float
    ec: float
    pp: float
    pa: float
    pc: float
    aa: float
    ac: float
    cc: float
    e: float
    p: float
    a: float
    c: float

    @classmethod
    def stage(cls, heading_cost: float, offset: float) -> CostToGo:
        """Cost of one state: e² + (heading_cost (p + offset a))².

        The second is the direction in which the reference point travels.

        Examples
        --------
        >>> CostToGo.stage(3.0, 0.0).pp
        9.0
        """
        pp = heading_cost * heading_cost
        pa = pp * offset
        return cls(
            ee=1.0,
            ep=0.0,
            ea=0.0,
            ec=0.0,
            pp=pp,
            pa=pa,
            pc=0.0,
            aa=pa * offset,
            ac=0.0,
            cc=0.0,
            e=0.0,
            p=0.0,
            a=0.0,
            c=0.0,
        )

    def before(self, travel: Travel, turn: float, drift: float) -> CostToGo:
        """Carry this cost, of where a step of travel leads to, back to where it starts.

        The path turns by `turn` [rad] on the way, the vehicle drifts to the left by `drift` [m].

        Examples
        --------
        >>> CostToGo.stage(3.0, 0.0).before(Travel.over(0.5, 0.0, 0.0, 0.0), 0.0, 0.0).pp
        9.25
        """
        step = travel.step
        error_by_driven, error_by_commanded = travel.error_by_driven, travel.error_by_commanded
        heading_by_driven, heading_by_commanded = (
            travel.heading_by_driven,
            travel.heading_by_commanded,
        )
        kept, taken = travel.kept, travel.taken
        # What goes with the state after the step, for a unit of each entry before it ...
        pe, pp = step * self.ee + self.ep, step * self.ep + self.pp
        ae = error_by_driven * self.ee + heading_by_driven * self.ep + kept * self.ea
        ap = error_by_driven * self.ep + heading_by_driven * self.pp + kept * self.pa
        aa = error_by_driven * self.ea + heading_by_driven * self.pa + kept * self.aa
        ce = (
            error_by_commanded * self.ee
            + heading_by_commanded * self.ep
            + taken * self.ea
            + self.ec
        )
        cp = (
            error_by_commanded * self.ep
            + heading_by_commanded * self.pp
            + taken * self.pa
            + self.pc
        )
        ca = (
            error_by_commanded * self.ea
            + heading_by_commanded * self.pa
            + taken * self.aa
            + self.ac
        )
        cc = (
            error_by_commanded * self.ec
            + heading_by_commanded * self.pc
            + taken * self.ac
            + self.cc
        )
        # ... and for what the path and the drift add.
        moved = drift - 0.5 * step * turn
        e = moved * self.ee - turn * self.ep + self.e
        p = moved * self.ep - turn * self.pp + self.p
        a = moved * self.ea - turn * self.pa + self.a
        c = moved * self.ec - turn * self.pc + self.c
        return CostToGo(
            ee=self.ee,
            ep=pe,
            ea=ae,
            ec=ce,
            pp=step * pe + pp,
            pa=step * ae + ap,
            pc=step * ce + cp,
            aa=error_by_driven * ae + heading_by_driven * ap + kept * aa,
            ac=error_by_driven * ce + heading_by_driven * cp + kept * ca,
            cc=error_by_commanded * ce + heading_by_commanded * cp + taken * ca + cc,
            e=e,
            p=step * e + p,
            a=error_by_driven * e + heading_by_driven * p + kept * a,
            c=error_by_commanded * e + heading_by_commanded * p + taken * a + c,
        )

    def of(self, state: Predicted) -> float:
        """Return this cost of one state alone, where it is a `stage`."""
        error, heading, driven, _ = state
        return self.ee * error * error + (
            self.pp * heading * heading
            + (2.0 * self.pa * heading * driven + self.aa * driven * driven)
        )

    def best_move(self, move_cost: float) -> BestMove:
        """Return the best move before a state with this cost.

        A move costs `move_cost` times its square.
        """
        share = 1.0 / (move_cost + self.cc)
        return BestMove(
            e=share * self.ec,
            p=share * self.pc,
            a=share * self.ac,
            remaining=move_cost * share,
            constant=share * self.c,
        )

    def before_move_by(self, moved: float, stage: CostToGo) -> CostToGo:
        """Carry this cost back to before the wheels were moved by `moved` [1/m].

        `stage` comes on top.
        """
        return replace(
            self,
            ee=self.ee + stage.ee,
            pp=self.pp + stage.pp,
            pa=self.pa + stage.pa,
            aa=self.aa + stage.aa,
            e=self.e + self.ec * moved,
            p=self.p + self.pc * moved,
            a=self.a + self.ac * moved,
            c=self.c + self.cc * moved,
        )

    def before_move_to(self, curvature: float, move_cost: float, stage: CostToGo) -> CostToGo:
        """Carry this cost back to before the wheels were moved to `curvature` [1/m].

        The move costs `move_cost` times its square; `stage` comes on top.
        """
        return replace(
            self,
            ee=self.ee + stage.ee,
            pp=self.pp + stage.pp,
            pa=self.pa + stage.pa,
            aa=self.aa + stage.aa,
            ec=0.0,
            pc=0.0,
            ac=0.0,
            cc=move_cost,
            e=self.e + self.ec * curvature,
            p=self.p + self.pc * curvature,
            a=self.a + self.ac * curvature,
            c=-move_cost * curvature,
        )

    def before_best_move(self, move_cost: float, stage: CostToGo) -> CostToGo:
        """Carry this cost, of the state after a move of the wheels, back to before the best move.

        The move costs `move_cost` times its square; `stage` comes on top.

        Examples
        --------
        >>> after = CostToGo.stage(3.0, 0.0).before(Travel.over(0.5, 0.0, 0.0, 0.0), 0.0, 0.0)
        >>> after.before_best_move(1e9, CostToGo.stage(0.0, 0.0)).pp == after.pp  # a move
        False
        >>> round(after.before_best_move(1e9, CostToGo.stage(0.0, 0.0)).pp, 6)  # too dear to make
        9.25
        """
        share = 1.0 / (move_cost + self.cc)
        # What remains of the entries with c; written so, no digits cancel.
        remaining = move_cost * share
        e, p, a = share * self.ec, share * self.pc, share * self.ac
        return CostToGo(
            ee=self.ee - e * self.ec + stage.ee,
            ep=self.ep - e * self.pc,
            ea=self.ea - e * self.ac,
            ec=remaining * self.ec,
            pp=self.pp - p * self.pc + stage.pp,
            pa=self.pa - p * self.ac + stage.pa,
            pc=remaining * self.pc,
            aa=self.aa - a * self.ac + stage.aa,
            ac=remaining * self.ac,
            cc=remaining * self.cc,
            e=self.e - e * self.c,
            p=self.p - p * self.c,
            a=self.a - a * self.c,
            c=remaining * self.c,
        )
