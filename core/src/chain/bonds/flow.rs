//! The flow as contact-corrected splitting moves it: kicks, drifts, evaluations, corrections.

use super::{
    CorrectedSplit, LANES,
    forces::{Forces, Modified, PAD, WORD},
    fused::Fused,
    tan_ratio,
};
use hertzchain_integrators::{
    DoubleDouble, SplitFlow,
    splitting::corrected::{BondFlow, BondPath, BondView, Correction, Side},
};

impl SplitFlow<f64> for CorrectedSplit {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn load(&mut self, y: &[f64]) {
        self.wake();
        self.flow.load(y);
    }

    fn store(&self, y: &mut [f64]) {
        self.flow.store(y);
    }

    fn duplicate(&self) -> Self {
        let mut copy = Self::new(self.flow.duplicate());
        copy.copy_from(self);
        copy
    }

    fn copy_from(&mut self, other: &Self) {
        self.wake();
        self.flow.copy_from(&other.flow);
        (self.tan_ratio, self.reach) = (other.tan_ratio, other.reach);
        for (to, from) in [
            (&mut self.q, &other.q),
            (&mut *self.overlap, &*other.overlap),
            (&mut self.force, &other.force),
            (&mut self.slope, &other.slope),
            (&mut self.force_before, &other.force_before),
        ] {
            to.copy_from_slice(from);
        }
        self.closed.copy_from_slice(&other.closed);
        self.told.copy_from_slice(&other.told);
    }

    fn drift(&mut self, dt: DoubleDouble<f64>) {
        self.flow.drift(dt);
    }

    fn kick_drift(&mut self, kick: f64, drift: DoubleDouble<f64>) {
        self.evaluate();
        self.kick(kick, 0.0);
        self.drift(drift);
    }
}

impl BondFlow for CorrectedSplit {
    fn prepare(&mut self, h: f64, reach: f64) {
        (self.tan_ratio, self.reach) = ((h, tan_ratio(self.flow.response().2, h)), reach);
    }

    fn exponent(&self) -> f64 {
        self.chain().law().alpha()
    }

    fn bonds(&self) -> usize {
        self.chain().touching().len()
    }

    fn evaluate(&mut self) {
        self.wake();
        self.keep(1);
        let Self { flow, q, overlap, overlaps_before: [latest, first], force, slope, closed, turning, reach, .. } =
            self;
        flow.evaluate(Forces {
            reach: *reach,
            q: q.column(),
            overlap: overlap.column(),
            force: force.column(),
            slope: slope.column(),
            before: [latest.column(), first.column()],
            closed,
            turning,
        });
        self.finish();
    }

    #[inline]
    fn kicks_and_evaluations(&mut self, pairs: &[(f64, DoubleDouble<f64>)], c: f64, watched: bool) -> usize {
        if !watched {
            self.wake();
        } else if self.awake.left == 0 {
            self.look_ahead(pairs[0].1.value());
        }
        let pairs = if watched { &pairs[..pairs.len().min(self.awake.left)] } else { pairs };
        let Self { flow, q, overlap, overlaps_before: [latest, first], closed, turning, told, awake, .. } = self;
        let made = flow.push_and_evaluate(
            pairs,
            Fused {
                c,
                reach: self.reach,
                watched,
                awake: &awake.ranges,
                q: q.column(),
                overlaps: [overlap.column(), latest.column(), first.column()],
                forces: [self.force.column(), self.force_before.column()],
                slope: self.slope.column(),
                modified: self.modified.column(),
                closed,
                turning,
                told,
            },
        );
        self.awake.left = self.awake.left.saturating_sub(made);
        self.keep(made);
        self.join();
        self.finish();
        made
    }

    #[inline]
    fn changed(&mut self, out: &mut Vec<(usize, bool)>) {
        let first = self.chain().touching().start;
        for word in 0..self.closed.len() {
            let now = self.closed[word];
            let mut changes = now ^ std::mem::replace(&mut self.told[word], now);
            while changes != 0 {
                let k = changes.trailing_zeros() as usize;
                changes &= changes - 1;
                out.push((word * WORD + k - first, now >> k & 1 == 1));
                self.rouse(word * WORD + k);
            }
        }
    }

    #[inline]
    fn turned(&self, out: &mut Vec<(usize, bool)>) {
        let (touching, latest) = (self.chain().touching(), &self.overlaps_before[0]);
        for (word, &bits) in self.turning.iter().enumerate() {
            let mut bits = bits;
            while bits != 0 {
                let b = word * WORD + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                if touching.contains(&b) {
                    out.push((b - touching.start, latest[b] > 0.0));
                }
            }
        }
    }

    fn force(&self, bond: usize) -> (f64, f64) {
        let b = self.bond(bond);
        let (mobility, force) = (self.chain().topology().mobility(b), self.force[PAD + b]);
        (force, self.pull(b, &self.force) - mobility * force)
    }

    fn path(&self, bond: usize) -> BondPath {
        let b = self.bond(bond);
        self.path_of(b, [self.pull(b, &self.force); 2], 0.0)
    }

    #[inline(always)]
    fn view(&self, bond: usize, h: f64) -> BondView {
        let b = self.bond(bond);
        let pull = [self.pull(b, &self.force_before), self.pull(b, &self.force)];
        BondView { path: self.path_of(b, pull, h), mobility: self.chain().topology().mobility(b), pull }
    }

    #[inline(always)]
    fn correct<'a>(&mut self, given: impl Iterator<Item = (usize, &'a Correction)>) {
        self.moved.clear();
        for (bond, correction) in given {
            let b = self.bond(bond);
            self.rouse(b);
            let (shift, beads) = (self.flow.shift(correction), self.chain().topology().pushed(b));
            self.flow.give(&beads, correction);
            for &(site, weight) in beads.iter() {
                self.q[PAD + site] += weight * shift;
            }
            let [before, behind] = self.chain().topology().beside(b);
            for b in [before, Some(b), behind].into_iter().flatten() {
                let register = b / LANES * LANES;
                // Those of the last bond.
                if !self.moved.iter().rev().take(3).any(|&moved| moved == register) {
                    self.moved.push(register);
                }
            }
        }
        if self.ring() {
            // For the first bond and its copy.
            self.join_positions();
        }
        self.refresh();
        self.join();
        self.close();
    }

    fn kick(&mut self, kick: f64, c: f64) {
        let Self { flow, force, slope, .. } = self;
        flow.push(kick, Modified { c, force: force.column(), slope: slope.column() });
    }

    fn jet(&mut self, sides: &[Side]) -> Vec<[f64; 2]> {
        let n = self.sites;
        self.evaluate();
        let first = self.chain().touching().start;
        let mut rates = vec![0.0; n + 1];
        for (index, side) in sides.iter().enumerate() {
            if *side != Side::Near {
                let b = first + index;
                rates[b] = self.slope[PAD + b] * self.chain().across(b, |i| self.flow.bead(i).1);
            }
        }
        if self.ring() {
            rates[n] = rates[0];
        }
        let topology = self.chain().topology();
        let of = |bonds: &[f64], i: usize| topology.push(i, |b| [bonds[b]])[0];
        (0..n).map(|i| [of(&self.force[PAD..], i), of(&rates, i)]).collect()
    }

    fn shift(&mut self, share: f64, jet: &[[f64; 2]]) {
        for (i, &[a, da]) in jet.iter().enumerate() {
            let (impulse, displacement) = (-share * da, share * a);
            let now = Correction { impulse, displacement, at: 0.0, rate: 0.0, turn: [0.0, 1.0] };
            self.flow.give(&[(i, 1.0)], &now);
        }
    }

    fn back(&self, y: &mut [f64], by: f64) {
        self.chain().back(y, by);
    }
}
