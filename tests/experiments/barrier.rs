//! The barrier between dark breathers.

use hertzchain::{
    breathers::DarkBreather,
    chain::Params,
    dps::Center,
    orbits::{Orbit, Shooting},
    study::{Barrier, BarrierPoint, Invariants},
    sweep::Engine,
};

fn breather(center: Center, omega_b: f64, sites: usize, shooting: &Shooting) -> Orbit {
    let params = Params::new(1.5, 1.0, 1.0 / 3.0).unwrap();
    DarkBreather { params, center, sites, omega_b, c_x: 0.0 }.orbit(shooting).unwrap()
}

// Truth: dE = omega dJ - F dX along a family of periodic orbits of a Hamiltonian system whose
// length is a parameter. Without its second term the two differ by 2.5e-3.
#[test]
fn energy_action_and_length_of_a_family_belong_together() {
    let shooting = Shooting::default();
    for center in [Center::Site, Center::Bond] {
        let at = |omega_b: f64| Invariants::of(&breather(center, omega_b, 11, &shooting), &shooting).unwrap();
        let by = 1e-4;
        let [before, middle, after] = [at(2.04 - by), at(2.04), at(2.04 + by)];
        let energy = after.energy - before.energy;
        let prices = 2.04 * (after.action - before.action) - middle.force * (after.length - before.length);
        println!("{center:?}: {energy:e} {:e}", energy / prices - 1.0);
        assert!((energy / prices - 1.0).abs() < 1e-6);
    }
}

fn barrier(sites: usize, ends: [f64; 2]) -> Vec<BarrierPoint> {
    let mut options = Barrier::of(1.0 / 3.0, ends, 2);
    options.ring.sites = sites;
    options.study(&Engine::threads(), &|_, _| {}).unwrap().points
}

// Truth: another ring.
#[test]
fn the_barrier_does_not_depend_on_the_ring() {
    let [short, long] = [21, 31].map(|sites| barrier(sites, [2.03, 2.06]));
    for (a, b) in short.iter().zip(&long) {
        let pairs = [
            (a.at_frequency(), b.at_frequency()),
            (a.barrier(), b.barrier()),
            (a.kinks[0].kink_energy, b.kinks[0].kink_energy),
            (a.kinks[1].kink_action, b.kinks[1].kink_action),
        ];
        for (a, b) in pairs {
            assert!((a / b - 1.0).abs() < 1e-5, "{a:e} {b:e}");
        }
    }
}

// Truth: the bond-centred orbit that has the action and the length of the site-centred one on the
// same ring, by Newton's method in frequency and centre. The limit of a long ring differs by terms
// that fall like 1/N.
#[test]
fn the_barrier_is_the_difference_at_the_same_action_and_length() {
    let (shooting, omega_b) = (Shooting::default(), 2.05);
    let params = Params::new(1.5, 1.0, 1.0 / 3.0).unwrap();
    let off = [21, 41].map(|sites| {
        let point = &barrier(sites, [omega_b, 2.06])[0];
        let [site, _] = &point.kinks;
        let at = |omega_b: f64, c_x: f64| {
            let orbit = DarkBreather { params, center: Center::Bond, sites, omega_b, c_x }.orbit(&shooting).unwrap();
            Invariants::of(&orbit, &shooting).unwrap()
        };
        let (mut omega, mut c_x) = (omega_b, 0.0);
        for _ in 0..3 {
            let (here, by) = (at(omega, c_x), 1e-5);
            let (up, aside) = (at(omega + by, c_x), at(omega, c_x + by));
            let slopes = [up, aside].map(|one| [(one.action - here.action) / by, (one.length - here.length) / by]);
            let miss = [here.action - site.action, here.length - site.length];
            let [[a, c], [b, d]] = slopes;
            let determinant = a * d - b * c;
            omega -= (d * miss[0] - b * miss[1]) / determinant;
            c_x -= (a * miss[1] - c * miss[0]) / determinant;
        }
        let there = at(omega, c_x);
        assert!((there.action - site.action).abs() < 1e-10 && (there.length - site.length).abs() < 1e-10);
        let exact = there.energy - site.energy;
        println!("{sites}: same action and length {exact:e}, limit {:e}", point.barrier());
        exact / point.barrier() - 1.0
    });
    println!("{off:?}");
    assert!(off[1].abs() < 0.6 * off[0].abs() && off[1].abs() < 0.5, "{off:?}");
}
