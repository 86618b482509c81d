//! The cost of a prediction: the cost-to-go of a linear model with a quadratic cost.
//!
//! The state has four entries: cross-track error `e` [m], heading error `p` [rad], driven curvature
//! `a` [1/m] and commanded curvature `c` [1/m]. The independent variable is the distance travelled,
//! so the model is the same at any speed; only the steering lag becomes a distance, `lag * speed`:
//!
//! ```text
//! e' = p + offset a,    p' = a - path curvature,    a' = (c - a) / lag distance
//! ```

/// The model over one step of travel, solved exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    step: f64,
    error_by_driven: f64,
    error_by_commanded: f64,
    heading_by_driven: f64,
    heading_by_commanded: f64,
    kept: f64,
    taken: f64,
}

impl Travel {
    /// Over `step` [m], with a first-order lag of the curvature over `lag` [m], of which the share
    /// `kept`, `exp(-step / lag)`, remains; errors at a point `offset` [m] ahead of the no-slip
    /// point.
    #[inline]
    pub fn new(step: f64, lag: f64, kept: f64, offset: f64) -> Self {
        let taken = 1.0 - kept;
        let heading_by_driven = lag * taken;
        let heading_by_commanded = step - heading_by_driven;
        let lagging = lag * heading_by_commanded;
        Self {
            step,
            error_by_driven: lagging + offset * heading_by_driven,
            error_by_commanded: 0.5 * step * step - lagging + offset * heading_by_commanded,
            heading_by_driven,
            heading_by_commanded,
            kept,
            taken,
        }
    }
}

/// A state of the prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelState {
    /// Cross-track error [m].
    pub error: f64,
    /// Heading error [rad].
    pub heading: f64,
    /// Curvature that the vehicle drives [1/m].
    pub driven: f64,
    /// Curvature that is commanded [1/m].
    pub commanded: f64,
}

impl Travel {
    /// The state after this step from `state`, after its move: within the step the path turns by
    /// `turn` [rad], and the vehicle drifts to the left by `drift` [m].
    #[inline]
    pub fn after(&self, state: &ModelState, turn: f64, drift: f64) -> ModelState {
        let moved = drift - 0.5 * self.step * turn;
        let ModelState {
            error,
            heading,
            driven,
            commanded,
        } = *state;
        ModelState {
            error: (error + self.step * heading + moved)
                + (self.error_by_driven * driven + self.error_by_commanded * commanded),
            heading: (heading - turn)
                + (self.heading_by_driven * driven + self.heading_by_commanded * commanded),
            driven: self.kept * driven + self.taken * commanded,
            commanded,
        }
    }
}

impl Travel {
    /// The state after this step from `state`, without the contribution of the curvature commanded
    /// during it.
    #[inline]
    pub(super) fn before_commanded(&self, state: &ModelState, turn: f64, drift: f64) -> ModelState {
        let moved = drift - 0.5 * self.step * turn;
        let ModelState {
            error,
            heading,
            driven,
            commanded,
        } = *state;
        ModelState {
            error: error + (self.step * heading + (self.error_by_driven * driven + moved)),
            heading: (heading - turn) + self.heading_by_driven * driven,
            driven: self.kept * driven,
            commanded,
        }
    }

    /// The contribution of a curvature of 1, commanded during the step before, to
    /// [`before_commanded`](Self::before_commanded).
    #[inline]
    pub(super) fn added(&self) -> ModelState {
        ModelState {
            error: self.error_by_commanded
                + (self.step * self.heading_by_commanded + self.error_by_driven * self.taken),
            heading: self.heading_by_commanded + self.heading_by_driven * self.taken,
            driven: self.kept * self.taken,
            commanded: 0.0,
        }
    }
}

/// The optimal feedback: the next commanded curvature is
/// `remaining * commanded - (e * error + p * heading + a * driven + constant)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "one letter an entry of the state")]
pub struct BestMove {
    pub e: f64,
    pub p: f64,
    pub a: f64,
    pub remaining: f64,
    pub constant: f64,
}

impl BestMove {
    /// The optimal commanded curvature in `state` [1/m].
    #[inline]
    pub fn commanded(&self, state: &ModelState) -> f64 {
        self.remaining * state.commanded - self.pull(state)
    }

    /// The part of it that does not come from the present commanded curvature, negated.
    #[inline]
    pub(super) fn pull(&self, state: &ModelState) -> f64 {
        (self.e * state.error + self.p * state.heading) + (self.a * state.driven + self.constant)
    }

    /// The share of a curvature commanded during the last step that remains in the next command, if
    /// the state lacks its contribution.
    #[inline]
    pub(super) fn remaining_after(&self, travel: &Travel) -> f64 {
        self.remaining
            - ((self.e * travel.error_by_commanded + self.p * travel.heading_by_commanded)
                + self.a * travel.taken)
    }
}

/// A quadratic cost of the state: an entry for each product of two, and twice what goes with each
/// alone. A constant would change no decision.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "one letter an entry of the state")]
pub struct CostToGo {
    pub ee: f64,
    pub ep: f64,
    pub ea: f64,
    pub ec: f64,
    pub pp: f64,
    pub pa: f64,
    pub pc: f64,
    pub aa: f64,
    pub ac: f64,
    pub cc: f64,
    pub e: f64,
    pub p: f64,
    pub a: f64,
    pub c: f64,
}

impl CostToGo {
    /// The cost of one state: `e^2 + (heading_cost (p + offset a))^2`, the second the direction in
    /// which the reference point travels.
    #[inline]
    pub fn stage(heading_cost: f64, offset: f64) -> Self {
        let pp = heading_cost * heading_cost;
        let pa = pp * offset;
        Self {
            ee: 1.0,
            ep: 0.0,
            ea: 0.0,
            ec: 0.0,
            pp,
            pa,
            pc: 0.0,
            aa: pa * offset,
            ac: 0.0,
            cc: 0.0,
            e: 0.0,
            p: 0.0,
            a: 0.0,
            c: 0.0,
        }
    }

    /// This cost of the state after a step of travel, as a cost of the state before it: within the
    /// step the path turns by `turn` [rad], and the vehicle drifts to the left by `drift` [m].
    #[inline]
    pub fn before(&self, travel: &Travel, turn: f64, drift: f64) -> Self {
        let Travel {
            step,
            error_by_driven,
            error_by_commanded,
            heading_by_driven,
            heading_by_commanded,
            kept,
            taken,
        } = *travel;
        // What goes with the state after the step, for a unit of each entry before it ...
        let (pe, pp) = (step * self.ee + self.ep, step * self.ep + self.pp);
        let (ae, ap, aa) = (
            error_by_driven * self.ee + heading_by_driven * self.ep + kept * self.ea,
            error_by_driven * self.ep + heading_by_driven * self.pp + kept * self.pa,
            error_by_driven * self.ea + heading_by_driven * self.pa + kept * self.aa,
        );
        let (ce, cp, ca, cc) = (
            error_by_commanded * self.ee
                + heading_by_commanded * self.ep
                + taken * self.ea
                + self.ec,
            error_by_commanded * self.ep
                + heading_by_commanded * self.pp
                + taken * self.pa
                + self.pc,
            error_by_commanded * self.ea
                + heading_by_commanded * self.pa
                + taken * self.aa
                + self.ac,
            error_by_commanded * self.ec
                + heading_by_commanded * self.pc
                + taken * self.ac
                + self.cc,
        );
        // ... and for what the path and the drift add.
        let moved = drift - 0.5 * step * turn;
        let e = moved * self.ee - turn * self.ep + self.e;
        let p = moved * self.ep - turn * self.pp + self.p;
        let a = moved * self.ea - turn * self.pa + self.a;
        let c = moved * self.ec - turn * self.pc + self.c;
        Self {
            ee: self.ee,
            ep: pe,
            ea: ae,
            ec: ce,
            pp: step * pe + pp,
            pa: step * ae + ap,
            pc: step * ce + cp,
            aa: error_by_driven * ae + heading_by_driven * ap + kept * aa,
            ac: error_by_driven * ce + heading_by_driven * cp + kept * ca,
            cc: error_by_commanded * ce + heading_by_commanded * cp + taken * ca + cc,
            e,
            p: step * e + p,
            a: error_by_driven * e + heading_by_driven * p + kept * a,
            c: error_by_commanded * e + heading_by_commanded * p + taken * a + c,
        }
    }

    /// This cost of one state alone, where it is a [`stage`](Self::stage).
    #[inline]
    pub fn of(&self, state: &ModelState) -> f64 {
        let ModelState {
            error,
            heading,
            driven,
            ..
        } = *state;
        self.ee * error * error
            + (self.pp * heading * heading
                + (2.0 * self.pa * heading * driven + self.aa * driven * driven))
    }

    /// The best move before a state with this cost, where a move costs `move_cost` times its
    /// square.
    #[inline]
    pub fn best_move(&self, move_cost: f64) -> BestMove {
        let share = 1.0 / (move_cost + self.cc);
        BestMove {
            e: share * self.ec,
            p: share * self.pc,
            a: share * self.ac,
            remaining: move_cost * share,
            constant: share * self.c,
        }
    }

    /// This cost, of the state after the wheels were moved by `moved` [1/m], as a cost of the
    /// state before; and `stage` on top.
    #[inline]
    pub fn before_move_by(&self, moved: f64, stage: &Self) -> Self {
        Self {
            ee: self.ee + stage.ee,
            pp: self.pp + stage.pp,
            pa: self.pa + stage.pa,
            aa: self.aa + stage.aa,
            e: self.e + self.ec * moved,
            p: self.p + self.pc * moved,
            a: self.a + self.ac * moved,
            c: self.c + self.cc * moved,
            ..*self
        }
    }

    /// This cost, of the state after the wheels were moved to `curvature` [1/m], as a
    /// cost of the state before the move, which costs `move_cost` times its square; and `stage` on
    /// top.
    #[inline]
    pub fn before_move_to(&self, curvature: f64, move_cost: f64, stage: &Self) -> Self {
        Self {
            ee: self.ee + stage.ee,
            pp: self.pp + stage.pp,
            pa: self.pa + stage.pa,
            aa: self.aa + stage.aa,
            ec: 0.0,
            pc: 0.0,
            ac: 0.0,
            cc: move_cost,
            e: self.e + self.ec * curvature,
            p: self.p + self.pc * curvature,
            a: self.a + self.ac * curvature,
            c: -move_cost * curvature,
            ..*self
        }
    }

    /// This cost, of the state after a move of the wheels, as a cost of the state before the best
    /// move, which costs `move_cost` times its square; and `stage` on top.
    #[inline]
    pub fn before_best_move(&self, move_cost: f64, stage: &Self) -> Self {
        let share = 1.0 / (move_cost + self.cc);
        // What remains of the entries with `c`; written so, no digits cancel.
        let remaining = move_cost * share;
        let (e, p, a) = (share * self.ec, share * self.pc, share * self.ac);
        Self {
            ee: self.ee - e * self.ec + stage.ee,
            ep: self.ep - e * self.pc,
            ea: self.ea - e * self.ac,
            ec: remaining * self.ec,
            pp: self.pp - p * self.pc + stage.pp,
            pa: self.pa - p * self.ac + stage.pa,
            pc: remaining * self.pc,
            aa: self.aa - a * self.ac + stage.aa,
            ac: remaining * self.ac,
            cc: remaining * self.cc,
            e: self.e - e * self.c,
            p: self.p - p * self.c,
            a: self.a - a * self.c,
            c: remaining * self.c,
        }
    }
}
