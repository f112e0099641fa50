//! The accuracy that a window must reach.

use super::{
    super::{
        chain::{ContactChain, Path},
        goal::{Cuts, Goal, StepControl},
        link::Links,
    },
    nodes::analytic,
};

/// A window whose share of the tolerance is `e` may have last terms of a series up to
/// `(TAIL e)^POWER`: local errors go with the power `1/POWER` of the last terms. Fitted to runs of
/// waves, impacts and random chains; `methods
/// the_error_is_no_more_than_was_asked_for_over_six_decades` and
/// `random_chains_agree_with_the_regularised_run` measure what it gives. Where contacts are
/// dashpots the power is 1: struck chains have errors of 5 tolerances with `POWER`.
const TAIL: f64 = 4e3;
const POWER: f64 = 0.8;
/// Largest last terms where the terms fall slowly: `SLOW_TAIL e`. For a contact that nearly opens,
/// held by `methods contacts_that_nearly_open_or_do_for_a_moment`; where a force is not analytic in
/// the panels' variable, by `methods random_chains_that_dissipate_keep_their_tolerance` and, without
/// dissipation, by `methods a_contact_with_a_small_exponent_keeps_its_tolerance`.
const SLOW_TAIL: f64 = 2e2;
/// Largest distance from a panel to an event that is the origin of its variable, in lengths of the
/// panel. The second value is for a tolerance and forces that are all analytic in the panels'
/// variable, where halvings resolve events farther away; the first for all other runs. Chosen; with
/// 0.25 in place of the first `methods contacts_that_graze_agree` fails.
const NEAR: [f64; 2] = [0.75, 0.5];
/// Largest change by a further sweep, as a share of a window's tolerance. Chosen, not measured.
const UNDONE: f64 = 1e-2;
/// Least value of this change and of the errors of events, relative to velocities. It is far below
/// a rounding, since these errors have one sign and add up over windows, unlike roundings. Held by
/// `methods energy_is_kept_over_a_long_time`.
const BIAS: f64 = 1e-18;
/// Changes of impulses, and last terms of series, that are rounding, relative to velocities.
/// Chosen; held by `methods the_error_is_no_more_than_was_asked_for_over_six_decades`.
const ROUNDING: f64 = 1e-15;
const ROUNDED_TAIL: f64 = 1e-14;
/// The largest `f'(g) h^2/m` of a window, for a tolerance of at least `LOOSE` and for a finer one.
/// A longer window may hold whole contacts, which few nodes take for something else with no sign of
/// it in their last terms; the looser the tolerance, the less the last terms say. Windows that are
/// chosen for their cost stay below 0.25. Chosen; held by
/// `methods chains_at_rest_keep_loose_tolerances`.
const STIFFEST: [f64; 2] = [0.5, 1.5];
const LOOSE: f64 = 1e-4;
/// The least share of the tolerance that a window gets, however short it is. Chosen, not measured.
const LEAST_SHARE: f64 = 1e-6;

/// Computes the goal of a window from the tolerance of the run.
///
/// The tolerance is for the sum over the run, relative to the size of velocities; a window gets the
/// share that its length is of the span. Without a tolerance a window is solved as well as sweeps
/// can, on one panel for each smooth part of a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accuracy {
    step_control: StepControl,
    span: f64,
    /// Size of velocities: the largest of those at the start, those to which overlaps at the start
    /// would drive a bead, and those that drives make; 1 if all are zero.
    size: f64,
    contacts: Contacts,
}

/// Bounds over all contacts of a chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contacts {
    /// The smallest and the largest exponent.
    alphas: [f64; 2],
    /// If contacts dissipate, the smallest power of time with which the force of one begins.
    abrupt: Option<f64>,
    /// The largest parts of a resistance, see [`BondLaw::resistance_parts`]: a time, and the
    /// acceleration at unit overlap and unit rate.
    ///
    /// [`BondLaw::resistance_parts`]: crate::law::BondLaw::resistance_parts
    resistances: [f64; 2],
    /// Whether all exponents, those of resistances too, are whole or half numbers.
    pub(super) analytic: bool,
    /// The largest acceleration by a unit overlap.
    strongest: f64,
}

impl Contacts {
    pub(super) fn of<const S: usize>(links: &Links<S>) -> Self {
        let alphas: Vec<f64> = links.each().map(|link| link.law.alpha()).collect();
        let losses: Vec<f64> = links.each().filter_map(|link| link.law.power_of_resistance()).collect();
        let mut resistances = [0.0f64; 2];
        for link in links.each() {
            let [by_stiffness, constant] = link.law.resistance_parts();
            resistances[0] = resistances[0].max(by_stiffness);
            resistances[1] = resistances[1].max(constant * link.lightest());
        }
        Self {
            resistances,
            abrupt: losses.iter().copied().min_by(f64::total_cmp),
            alphas: [alphas.iter().copied().fold(f64::INFINITY, f64::min), alphas.iter().copied().fold(0.0, f64::max)],
            analytic: alphas.iter().chain(&losses).all(|&power| analytic(power)),
            strongest: links.each().fold(0.0, |most, link| most.max(link.constant() * link.lightest())),
        }
    }

    /// The smallest value of a monotonic function of the exponent.
    fn least(&self, of: impl Fn(f64) -> f64) -> f64 {
        let [a, b] = self.alphas;
        if a == b { of(a) } else { of(a).min(of(b)) }
    }
}

impl Accuracy {
    pub(super) fn new<const S: usize, C: ContactChain<S>>(
        (chain, links): (&C, &Links<S>),
        start: &dyn Fn(usize) -> Path,
        step_control: StepControl,
        span: f64,
    ) -> Self {
        let mut size = 0.0f64;
        for i in 0..chain.sites() {
            let ([_, v, c, s], omega) = (start(i), chain.response(i).omega.value());
            size = size.max(v.abs() + omega * c.hypot(s));
        }
        for b in 0..chain.bonds() {
            let mut now = chain.bond(b).rest;
            for [r, _, c, _] in chain.across(b, start) {
                now = now + r + c;
            }
            if now > 0.0 {
                let link = links.link(b);
                size = size.max((2.0 * link.elastic_force(now) * now * link.lightest()).sqrt());
            }
        }
        for drive in links.open.iter().flat_map(|open| &open.drives) {
            size = size.max(drive.speed);
        }
        Self { step_control, span, size: if size > 0.0 { size } else { 1.0 }, contacts: Contacts::of(links) }
    }

    pub(super) fn contacts(&self) -> &Contacts {
        &self.contacts
    }

    pub(super) fn span(&self) -> f64 {
        self.span
    }

    pub(super) fn goal(&self, h: f64) -> Goal {
        let (share, change, tail, slow) = match self.step_control {
            // Sweeps go on until changes are rounding.
            StepControl::Windows { .. } => (f64::INFINITY, 0.0, f64::INFINITY, 1.0),
            StepControl::Tolerance(tol) => {
                let share = tol * (h / self.span).max(LEAST_SHARE);
                let tail = match self.contacts {
                    Contacts { analytic: false, .. } => SLOW_TAIL * share,
                    Contacts { abrupt: Some(0.0), .. } => TAIL * share,
                    _ => (TAIL * share).powf(POWER),
                };
                let tail = tail.max(ROUNDED_TAIL);
                (share, UNDONE * share, tail, (tail / (SLOW_TAIL * share)).max(1.0))
            }
        };
        let least = change.max(if let StepControl::Windows { .. } = self.step_control { 0.1 * ROUNDING } else { BIAS });
        // A force that begins with the power p of time adds to a neighbour's overlap a power p + 2,
        // and to its rate p + 1; a panel that is cut off the event has an error of the impulse of
        // one power more.
        let mut lost = self.contacts.least(|alpha| h * least.powf(1.0 / (alpha + 3.0)));
        if let Some(power) = self.contacts.abrupt {
            lost = lost.min(h * least.powf(1.0 / (power + 2.0)));
        }
        // An overlap that rises to `g` in the window makes the impulses `F(g) h` and `int c dg`.
        let [viscous, dashpots] = self.contacts.resistances;
        let negligible = 0.1 * least * self.size;
        let acceleration = negligible / (h + viscous) / self.contacts.strongest;
        // The least `beta` is the power of the most abrupt force.
        let resisted = (negligible / dashpots).powf(1.0 / (1.0 + self.contacts.abrupt.unwrap_or(0.0)));
        Goal {
            change: change.max(BIAS) * self.size,
            rounded: 0.1 * ROUNDING * self.size,
            tail: tail * self.size,
            slow,
            least_impulse: share * self.size,
            stiffest: match self.step_control {
                StepControl::Windows { .. } => f64::INFINITY,
                StepControl::Tolerance(tol) => STIFFEST[usize::from(tol < LOOSE)],
            },
            cuts: Cuts {
                neighbours: !matches!(self.step_control, StepControl::Windows { neighbours: false, .. }),
                merge: lost,
                near: match self.step_control {
                    StepControl::Tolerance(_) if self.contacts.analytic => NEAR[1],
                    _ => NEAR[0],
                },
                event_impulse: 0.1 * least * self.size,
                least_overlap: self.contacts.least(|alpha| acceleration.powf(1.0 / alpha)).min(resisted),
            },
        }
    }
}
