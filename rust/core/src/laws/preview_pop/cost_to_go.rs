//! The cost of a prediction: the cost-to-go of a linear model with a quadratic cost.
//!
//! # Model
//!
//! The state is `x = (e, p, a, c)`: cross-track error `e` [m], heading error `p` [rad], driven
//! curvature `a` [1/m] and commanded curvature `c` [1/m], all positive to the left. The independent
//! variable is the distance travelled, so the model is the same at any speed; only the steering lag
//! becomes a distance, its time times the speed:
//!
//! ```text
//! e' = p + offset a,    p' = a - path curvature,    a' = (c - a) / lag distance,    c' = 0
//! ```
//!
//! At the beginning of a step the commanded curvature makes a move `u`; then the vehicle travels
//! the distance `h` ([`Travel`]), over which the equations above are solved exactly, for a path whose
//! curvature is constant within the step:
//!
//! ```text
//! x⁺ = F (x + b u) + g
//!
//!     ⎡ 1  h  F_ea  F_ec ⎤        ⎡ 0 ⎤        ⎡ - h turn / 2 ⎤
//! F = ⎢ 0  1  F_pa  F_pc ⎥    b = ⎢ 0 ⎥    g = ⎢    - turn    ⎥
//!     ⎢ 0  0  F_aa  F_ac ⎥        ⎢ 0 ⎥        ⎢      0       ⎥
//!     ⎣ 0  0   0     1   ⎦        ⎣ 1 ⎦        ⎣      0       ⎦
//! ```
//!
//! The path turns by `turn` in the step. Assumed: small angles, and the same `h` and lag in all steps.
//!
//! # Cost
//!
//! A step costs `R u² + x⁺ᵀ Q x⁺` [m²], where `x⁺ᵀ Q x⁺ = e² + (heading_cost (p + offset a))²`, with
//! `R > 0` [m⁴] and `heading_cost` [m]. The cost of all steps that remain is quadratic in the state,
//! too. [`CostToGo`] holds such a cost, less a constant, which changes no decision:
//!
//! ```text
//! xᵀ P x + 2 qᵀ x        P symmetric: ee ... cc are P_ee ... P_cc;  e ... c are q_e ... q_c
//! ```
//!
//! # Recursion
//!
//! At the end of the horizon `P = Q`, `q = 0`. Each step, from the last to the first, is taken back:
//! first its travel, then its move. P of the state `x_k` contains `x_kᵀ Q x_k`, although step `k - 1`
//! pays for it; at `k = 0` that is a constant. Let P, q be the cost-to-go after the step:
//!
//! ```text
//! S = Fᵀ P F,    s = Fᵀ (P g + q)        the cost before its travel         before
//! u = -(S_c x + s_c) / (R + S_cc)        its best move                      best_move
//! P = Q + S - S_cᵀ S_c / (R + S_cc)      the cost before the best move:     before_best_move
//! q = s - S_cᵀ s_c / (R + S_cc)          both P and q
//! ```
//!
//! with the row `S_c = bᵀ S = (S_ec, S_pc, S_ac, S_cc)` and the entry `s_c` of s: the discrete Riccati
//! recursion (Bertsekas, *Dynamic Programming and Optimal Control*, volume I, fourth edition, section
//! 3.1, there without `g`). A move that a limit dictates has no choice, so the minimum is left out:
//! `before_move_by`, `before_move_to`.
//!
//! # Scalars
//!
//! Each entry is a plain scalar, because most entries of F, Q and b are 0 or 1, and P is symmetric.
//! With nalgebra's fixed matrices this file would be a third shorter, and a step of preview POP would
//! take 1.30 to 1.44 times the instructions. The reference in Python has the recursion in matrices;
//! tests compare the two. P is symmetric as it is stored; nothing makes it positive again after
//! rounding: a horizon has at most 20 steps.

/// The model over one step of travel: the entries of F that are not 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// `h` = `F_ep`, the distance travelled [m].
    step: f64,
    /// `F_ea` [m²].
    error_by_driven: f64,
    /// `F_ec` [m²].
    error_by_commanded: f64,
    /// `F_pa` [m].
    heading_by_driven: f64,
    /// `F_pc` [m].
    heading_by_commanded: f64,
    /// `F_aa`, the share of the driven curvature that remains.
    kept: f64,
    /// `F_ac` = 1 - `F_aa`.
    taken: f64,
}

impl Travel {
    /// Travel over `step` = h [m] with a first-order lag of the curvature over `lag` [m], finite, where
    /// `kept` is `exp(-step / lag)`; the errors are those of a point `offset` [m] ahead of the
    /// no-slip point.
    ///
    /// With a constant `c` the solution is `a = c + (a_0 - c) exp(-distance / lag)`. Its integral
    /// over the step gives `F_pa` and `F_pc`. The integral of `p + offset a`, without what the path
    /// turns by, gives `F_ea` and `F_ec`:
    ///
    /// ```text
    /// F_pa = lag (1 - kept)                    F_pc = h - F_pa
    /// F_ea = lag F_pc + offset F_pa            F_ec = h² / 2 - lag F_pc + offset F_pc
    /// ```
    ///
    /// With a lag far longer than the step, `F_pc` and `F_ec` are differences of nearly equal numbers.
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

/// The state `x` of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelState {
    /// Cross-track error `e` [m].
    pub error: f64,
    /// Heading error `p` [rad].
    pub heading: f64,
    /// Curvature that the vehicle drives, `a` [1/m].
    pub driven: f64,
    /// Curvature that is commanded, `c` [1/m].
    pub commanded: f64,
}

impl ModelState {
    /// `e`, `p`, `a`, `c`.
    #[inline]
    fn entries(&self) -> (f64, f64, f64, f64) {
        (self.error, self.heading, self.driven, self.commanded)
    }
}

impl Travel {
    /// `F x + g`: the state after this step of travel from `state`, whose move is made. Within the
    /// step the path turns by `turn` [rad].
    #[inline]
    pub fn after(&self, state: &ModelState, turn: f64) -> ModelState {
        let shifted = -0.5 * self.step * turn;
        let (e, p, a, c) = state.entries();
        ModelState {
            error: (e + self.step * p + shifted)
                + (self.error_by_driven * a + self.error_by_commanded * c),
            heading: (p - turn) + (self.heading_by_driven * a + self.heading_by_commanded * c),
            driven: self.kept * a + self.taken * c,
            commanded: c,
        }
    }

    /// `F_0 x + g`, where `F_0` is F with zeros for `F_ec`, `F_pc` and `F_ac`: the state after this
    /// step without the contribution of the curvature that is commanded during it. That curvature
    /// is known last, so the processor can compute this while it computes that one. `commanded` is
    /// passed on as it is: it is the last one, and not to be read.
    #[inline]
    pub(super) fn without_commanded(&self, state: &ModelState, turn: f64) -> ModelState {
        let shifted = -0.5 * self.step * turn;
        let (e, p, a, c) = state.entries();
        ModelState {
            error: e + (self.step * p + (self.error_by_driven * a + shifted)),
            heading: (p - turn) + self.heading_by_driven * a,
            driven: self.kept * a,
            commanded: c,
        }
    }

    /// `F_0 (F_ec, F_pc, F_ac, 0)ᵀ`: what a curvature of 1, commanded during the step before, adds
    /// to [`without_commanded`](Self::without_commanded) if the state lacks its contribution.
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

/// The optimal feedback `u = -K x - k`, with `K = S_c / (R + S_cc)` and `k = s_c / (R + S_cc)`,
/// written for the curvature that is commanded after the move:
///
/// ```text
/// c + u = remaining c - (K_e e + K_p p + K_a a + k),    remaining = 1 - K_c = R / (R + S_cc)
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BestMove {
    /// `K_e` [1/m²].
    pub e: f64,
    /// `K_p` [1/m].
    pub p: f64,
    /// `K_a`.
    pub a: f64,
    /// 1 - `K_c`.
    pub remaining: f64,
    /// `k` [1/m].
    pub constant: f64,
}

impl BestMove {
    /// The optimal commanded curvature in `state`, `c + u` [1/m].
    #[inline]
    pub fn commanded(&self, state: &ModelState) -> f64 {
        self.remaining * state.commanded - self.pull(state)
    }

    /// `K_e e + K_p p + K_a a + k`, the part of the feedback without the commanded curvature [1/m].
    #[inline]
    pub(super) fn pull(&self, state: &ModelState) -> f64 {
        (self.e * state.error + self.p * state.heading) + (self.a * state.driven + self.constant)
    }

    /// `remaining - K (F_ec, F_pc, F_ac, 0)ᵀ`: the share of a curvature commanded during the last
    /// step that remains in the next command, if the state lacks its contribution
    /// ([`Travel::without_commanded`]).
    #[inline]
    pub(super) fn remaining_after(&self, travel: &Travel) -> f64 {
        self.remaining
            - ((self.e * travel.error_by_commanded + self.p * travel.heading_by_commanded)
                + self.a * travel.taken)
    }
}

/// A quadratic cost of the state, `xᵀ P x + 2 qᵀ x`: `ee` ... `cc` are the entries of P, `e` ... `c`
/// those of q. P is symmetric: `ep` stands for `P_ep` and `P_pe`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "each field is named by its entry")]
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
    /// Q, the cost of one state: `e² + (heading_cost (p + offset a))²`, where `p + offset a` is the
    /// direction in which the reference point travels.
    ///
    /// ```text
    /// Q_ee = 1,    Q_pp = heading_cost²,    Q_pa = Q_pp offset,    Q_aa = Q_pp offset²
    /// ```
    #[inline]
    pub fn stage(heading_cost: f64, offset: f64) -> Self {
        let pp = heading_cost * heading_cost;
        let pa = pp * offset;
        Self {
            ee: 1.0,
            pp,
            pa,
            aa: pa * offset,
            ..Self::default()
        }
    }

    /// `S = Fᵀ P F`, `s = Fᵀ (P g + q)`: this cost P, q of the state after a step of travel, as a
    /// cost of the state before it. Within the step the path turns by `turn` [rad].
    #[inline]
    pub fn before(&self, travel: &Travel, turn: f64) -> Self {
        let Travel {
            step,
            error_by_driven,
            error_by_commanded,
            heading_by_driven,
            heading_by_commanded,
            kept,
            taken,
        } = *travel;
        // Columns p, a and c of P F, as far as S needs them: `ae` is (P F)_ea, not P_ae. Column e is
        // that of P.
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
        // P g + q.
        let shifted = -0.5 * step * turn;
        let e = shifted * self.ee - turn * self.ep + self.e;
        let p = shifted * self.ep - turn * self.pp + self.p;
        let a = shifted * self.ea - turn * self.pa + self.a;
        let c = shifted * self.ec - turn * self.pc + self.c;
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

    /// `xᵀ Q x`: this cost in one state, where it is a [`stage`](Self::stage): the entries that a stage
    /// has as 0 are left out.
    #[inline]
    pub fn stage_cost(&self, state: &ModelState) -> f64 {
        let (e, p, a, _) = state.entries();
        self.ee * e * e + (self.pp * p * p + (2.0 * self.pa * p * a + self.aa * a * a))
    }

    /// The best move where this cost is S, s, of the state after the move; `move_cost` is R.
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

    /// `P = Q + S`, `q = s + S b u`: this cost S, s, of the state after the given move `u`, `moved`
    /// [1/m], as a cost of the state before the move; `stage` is Q. What the move itself costs is a
    /// constant.
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

    /// This cost S, s, of the state after a move to the given commanded `curvature` = κ [1/m], as a
    /// cost of the state before the move; `move_cost` is R and `stage` is Q.
    ///
    /// The state after the move does not depend on the commanded curvature before it. S and s with
    /// `c = κ`, and `R (κ - c)²`, give
    ///
    /// ```text
    /// P_cc = R,    q_c = -R κ,    P_ec = P_pc = P_ac = 0,    q_i = s_i + S_ic κ  for i = e, p, a
    /// ```
    ///
    /// and `P_ij = Q_ij + S_ij` elsewhere: the other entries are those of
    /// [`before_move_by`](Self::before_move_by) with `u = κ`.
    #[inline]
    pub fn before_move_to(&self, curvature: f64, move_cost: f64, stage: &Self) -> Self {
        Self {
            ec: 0.0,
            pc: 0.0,
            ac: 0.0,
            cc: move_cost,
            c: -move_cost * curvature,
            ..self.before_move_by(curvature, stage)
        }
    }

    /// `P = Q + S - S_cᵀ S_c / (R + S_cc)`, `q = s - S_cᵀ s_c / (R + S_cc)`: this cost S, s, of the
    /// state after a move, as a cost of the state before the best move; `move_cost` is R and
    /// `stage` is Q.
    #[inline]
    pub fn before_best_move(&self, move_cost: f64, stage: &Self) -> Self {
        let share = 1.0 / (move_cost + self.cc);
        // In the entries with c, `S_ic - S_ic S_cc / (R + S_cc)` is `S_ic R / (R + S_cc)`: written
        // so, no digits cancel. The others are differences, as in the textbook.
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
