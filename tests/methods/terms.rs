//! Contacts whose force is a sum of powers of the overlap.

use crate::{
    details::{methods_agree, refuses, run},
    heterogeneous::of,
    numbers::{distance, error},
    variations::{altered, chain, monodromy, start},
};
use hertzchain::{
    chain::{Boundary, Chain, Details, Parameter, Params, State, Term, Variations},
    integrators::Real,
    orbits::{Bands, NormalModes},
    run::{Method, Run, Setting},
    scene::Scene,
};

/// Plain beads whose contacts have these further powers, each a constant and an exponent.
fn beads(boundary: Boundary, sites: usize, terms: &[(f64, f64)], rest: f64) -> Chain<f64> {
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), boundary, sites).unwrap();
    let bonds = chain.touching().len();
    let terms = terms.iter().map(|&(contact, alpha)| Term { contact: vec![contact; bonds], alpha });
    chain.with(&Details { terms: terms.collect(), overlap: vec![rest; bonds], ..Details::default() }).unwrap()
}

/// The contact of two beads of mass 1 whose energy is a sum of powers, each a factor and twice the
/// exponent, and that overlap by at most `most`: relative speed before it, and duration.
///
/// The overlap has `g'^2 = 4 (V(G) - V(g))`. With
/// `g = G (1 - x^2)^2` the time `2 int_0^G dg/g'` is the integral of a smooth function of `x`
/// from 0 to 1, by Gauss's rule with three points on 100 parts.
pub(crate) fn collision(powers: [(f64, f64); 2], most: f64) -> (f64, f64) {
    let left = |x: f64| -> f64 {
        // V(G) - V(g) without a difference of close numbers.
        let of = |(by, twice): (f64, f64)| -by * most.powf(0.5 * twice) * (twice * (-x * x).ln_1p()).exp_m1();
        powers.into_iter().map(of).sum()
    };
    let term = |x: f64| 8.0 * most * x * (1.0 - x * x) / (4.0 * left(x)).sqrt();
    let (parts, root) = (100, 0.6f64.sqrt());
    let h = 1.0 / f64::from(parts);
    let part = |k: i32| {
        let middle = (f64::from(k) + 0.5) * h;
        h / 18.0 * (5.0 * term(middle - 0.5 * h * root) + 8.0 * term(middle) + 5.0 * term(middle + 0.5 * h * root))
    };
    ((4.0 * left(1.0)).sqrt(), (0..parts).map(part).sum())
}

/// Lets a bead strike another one at rest with the given speed: onset, duration and largest overlap
/// of their contact, its impulse, and velocities at the end, to a bound for each method.
pub(crate) fn meet(chain: &Chain<f64>, [onset, duration, speed, most]: [f64; 4], bounds: [f64; 5]) {
    let mut state = State::rest(chain);
    state.u_dot_mut()[0] = speed;
    let methods = [
        ("dop853-regularised", Setting::Tolerance(1e-13)),
        ("dop853-landed", Setting::Tolerance(1e-13)),
        ("dop853", Setting::Tolerance(1e-13)),
        ("strang-linear", Setting::Steps(100_000)),
        ("verlet", Setting::Steps(100_000)),
    ];
    for ((method, setting), bound) in methods.into_iter().zip(bounds) {
        let run = Run::new(chain.clone(), state.clone()).until(onset + duration + 1.0).unwrap().contacts();
        let run = run.method(Method::named(method).unwrap()).setting(setting);
        let got = run.start().unwrap().complete().unwrap();
        let [contact] = got.contacts.as_deref().unwrap() else { panic!("{method}: {:?}", got.contacts) };
        let [begins, ends] = [contact.onset, contact.release].map(Option::unwrap);
        let off = [
            (begins - onset) / duration,
            (ends - begins) / duration - 1.0,
            contact.largest_overlap / most - 1.0,
            contact.impulse / speed - 1.0,
            got.state[2] / speed,
            got.state[3] / speed - 1.0,
            got.energy_error.unwrap(),
        ];
        println!("{method}: {off:?}");
        assert!(off.iter().all(|off| off.abs() < bound), "{most} {method}: {off:?}");
    }
}

#[test]
fn two_beads_touch_for_the_time_of_the_quadrature() {
    // Truth: the integral above; equal beads exchange their speeds.
    // Without the second power the time is Hertz's, (4/5) pi^{1/2} Gamma(2/5)/Gamma(9/10) G/w.
    let powers = |c: f64| [(2.0 / 5.0, 5.0), (2.0 / 7.0 * c, 7.0)];
    let (speed, duration) = collision(powers(0.0), 0.7);
    assert!((duration * speed / 0.7 - 2.943_275_184_324_704_7).abs() < 1e-13, "{duration}");
    for (c, most) in [(0.7, 1.3), (20.0, 0.3), (1e3, 1e-3)] {
        let (speed, duration) = collision(powers(c), most);
        let chain = beads(Boundary::Free, 2, &[(c, 2.5)], -0.1 * most);
        meet(&chain, [0.1 * most / speed, duration, speed, most], [2e-12, 6e-12, 1e-10, 2e-9, 1e-9]);
    }
}

/// Six beads that differ in everything, with three powers in each contact but one.
pub(crate) fn summed<R: Real>() -> Chain<R> {
    altered(&chain(), |details| {
        let second = Term { contact: vec![0.5, 0.0, 1.0, 0.3, 2.0, 0.1, 0.7], alpha: 2.5 };
        let third = Term { contact: vec![0.2, 0.0, 0.4, 0.1, 0.0, 0.3, 0.2], alpha: 2.0 };
        details.terms = vec![second, third];
    })
}

#[test]
fn equal_powers_are_one_power() {
    // Truth: the chain with the sum of the constants.
    let whole: Chain<f64> = altered(&chain(), |details| details.alpha = vec![1.5; 7]);
    let parts = altered(&whole, |details| {
        details.terms = [0.3, 0.2].map(|by| Term { contact: vec![by; 7], alpha: 1.5 }).to_vec();
        details.contact.iter_mut().for_each(|constant| *constant -= 0.5);
    });
    let y = start(&whole);
    assert!((whole.energy(&y).total() - parts.energy(&y).total()).abs() < 1e-15);
    assert!(distance(&whole.site_energies(&y), &parts.site_energies(&y)) < 1e-15);
    let [one, sum] = [&whole, &parts].map(|chain| monodromy(chain, &y, 9.0, 1e-12));
    let off = error(sum.as_slice(), one.as_slice());
    assert!(off < 1e-14, "monodromy {off:e}");
    // Without a first power there is no contact.
    let none = altered(&parts, |details| details.contact = vec![0.0; 7]);
    assert_eq!(none.energy(&y).contacts, 0.0);
}

#[test]
fn methods_agree_on_sums_of_powers() {
    // Truth: each other.
    let rows = [
        ("dop853-landed", Setting::Tolerance(1e-13), 1e-10),
        ("dop853", Setting::Tolerance(1e-13), 2e-9),
        ("strang-linear", Setting::Steps(100_000), 1e-8),
        ("verlet", Setting::Steps(100_000), 1e-8),
    ];
    let chain = summed();
    methods_agree("powers", &chain, 1e-14, &rows);
    let motion = of(&chain, &start(&chain), 9.0);
    let end = |tol| run(&chain, motion.initial(), 9.0, "dop853-regularised", Setting::Tolerance(tol)).state;
    let off = distance(&end(1e-8), &end(1e-14));
    assert!(off < 4e-8, "{off:e}");
}

/// Holds the forces of five beads at rest: in a column each contact holds the weights above it, to
/// this share; between walls, which are returned, all overlaps add up to the static ones, and
/// forces differ by the weights.
pub(crate) fn balanced(force: fn(f64) -> f64, beads: impl Fn(Boundary, f64) -> Chain<f64>, bound: f64) -> Chain<f64> {
    let with = |boundary, rest, g| altered(&beads(boundary, rest), |details| details.gravity = g);
    let column = with(Boundary::RightWall, 0.0, 0.3);
    let overlaps = column.overlaps(&column.equilibrium().unwrap());
    for (bond, &g) in overlaps.iter().enumerate().skip(1) {
        assert!((force(g) / (0.3 * bond as f64) - 1.0).abs() < bound, "{bond}: {g}");
    }
    let held = with(Boundary::Fixed, 0.2, 0.01);
    let overlaps = held.overlaps(&held.equilibrium().unwrap());
    assert!((overlaps.iter().sum::<f64>() - 1.2).abs() < 1e-14, "{overlaps:?}");
    for pair in overlaps.windows(2) {
        assert!((force(pair[1]) - force(pair[0]) - 0.01).abs() < 1e-14, "{overlaps:?}");
    }
    held
}

#[test]
fn beads_at_rest_have_balanced_forces() {
    // Truth: f(g) = g^{3/2} + 2 g^{5/2} + 0.1 g.
    let force = |g: f64| g * g.sqrt() * (1.0 + 2.0 * g) + 0.1 * g;
    let held = balanced(force, |boundary, rest| beads(boundary, 5, &[(2.0, 2.5), (0.1, 1.0)], rest), 2e-15);
    // It stays there.
    let rest = State::equilibrium(&held).unwrap();
    let end = run(&held, &rest, 10.0, "dop853-regularised", Setting::Tolerance(1e-12));
    assert!(distance(&end.state[..5], &rest.as_slice()[..5]) < 1e-13);
    // Truth: omega_j = 2 F'(g)^(1/2) sin(j pi/12) of a chain pressed by g.
    let pressed = beads(Boundary::Fixed, 5, &[(2.0, 2.5)], 0.2);
    let slope = 1.5 * 0.2f64.sqrt() + 5.0 * 0.2f64.powf(1.5);
    for (j, mode) in NormalModes::new(&pressed).unwrap().linear().iter().enumerate() {
        let want = 2.0 * slope.sqrt() * (std::f64::consts::PI * (j + 1) as f64 / 12.0).sin();
        assert!((mode.omega - want).abs() < 1e-14, "{j}: {} {want}", mode.omega);
    }
}

#[test]
fn what_cannot_follow_sums_names_what_can() {
    let chain = beads(Boundary::Fixed, 4, &[(0.5, 2.5)], 0.0);
    for (method, what) in [
        ("collocation", "one power of the overlap, not of a sum or a table: take dop853-regularised"),
        ("corrected", "contacts of one exponent"),
        ("discrete-gradient", "take dop853-regularised"),
    ] {
        let said = Method::named(method).unwrap().runs(&chain).unwrap_err().to_string();
        assert!(said.contains(what), "{said}");
    }
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    let run = Run::new(chain.clone(), state.clone()).until(2.0).unwrap();
    assert_eq!(run.tolerance(1e-9).unwrap().choice().unwrap().0.name(), "dop853-regularised");
    assert!(chain.monodromy(state.as_slice(), (0.0, 1.0), crate::windows(4, 8)).is_err());
    let said = Bands::new(&chain).unwrap_err().to_string();
    assert!(said.contains("one power"), "{said}");
    let columns = vec![0.0; 8];
    let said = Variations::flow_by(&chain, state.as_slice(), (0.0, 1.0), (&columns, &[Parameter::Alpha]), 1e-9);
    assert!(said.unwrap_err().to_string().contains("exponents of their own"));
}

#[test]
fn scenes_have_sums_of_powers() {
    let text = "[chain]\nsites = 3\nalpha = 1.5\nboundary = \"left-wall\"\n[bonds]\ncontact = [1.0, 2.0, 1.0]\n\
                [[bonds.terms]]\ncontact = { pattern = [0.5, 0.25] }\nalpha = 2.5\n[[bonds.terms]]\ncontact = 3\nalpha = 2\n\
                [initial]\nkind = \"single-bead\"\nsite = 0\nvelocity = -1.0\n[span]\nuntil = 5.0\n";
    let scene = Scene::parse(text, "sum").unwrap();
    let details = scene.chain().details().unwrap();
    let want = [Term { contact: vec![0.5, 0.25, 0.25], alpha: 2.5 }, Term { contact: vec![3.0; 3], alpha: 2.0 }];
    assert_eq!(details.terms, want);
    let again = Scene::parse(&scene.file().to_toml(), "sum").unwrap();
    assert_eq!(again.chain().details(), Some(details));
    let plan = scene.plan(false).join("\n");
    assert!(plan.contains("terms with contact constants from 0.25 to 0.5 and exponent 2.5"), "{plan}");
    let cases = [
        ("contact = 3\n", "contact = [1.0, -3.0, 1.0]\n", "bonds.terms.contact = -3 (entry 1) is not valid"),
        ("contact = 3\n", "contact = 1e201\n", "is from 0 to 1e200"),
        ("contact = [1.0, 2.0, 1.0]", "contact = [1.0, 2e200, 1.0]", "bonds.contact = 2e200 (entry 1) is not valid"),
        ("contact = 3\n", "contact = [1.0, 1.0]\n", "bonds.terms.contact = 2 numbers for 3"),
        ("alpha = 2\n", "alpha = -2\n", "bonds.terms.alpha = -2"),
        ("alpha = 2\n", "alpha = nan\n", "bonds.terms.alpha = NaN"),
        ("alpha = 2\n", "", "missing field `alpha`"),
        ("alpha = 2\n", "alpha = 2\nbeta = 1\n", "unknown field `beta`"),
        ("[bonds]\n", "[bonds]\ndashpot = 0.1\n", "bonds.terms beside dashpot is not valid"),
    ];
    refuses(text, &cases);
}

#[test]
fn sums_of_powers_are_in_si_units() {
    // Truth: the force at an overlap in both units; static loads name what to give.
    let text = "[chain]\nsites = 2\nalpha = 1.5\nboundary = \"free\"\n[units]\nsystem = \"SI\"\nradius = 9.525e-3\n\
                density = 8027.0\nyoung = 193e9\npoisson = 0.3\n[bonds]\nterms = [{ contact = 4e13, alpha = 2.5 }]\n\
                [initial]\nkind = \"single-bead\"\nsite = 0\nvelocity = 1.0\n[span]\nuntil = 1e-4\n";
    let scene = Scene::parse(text, "si").unwrap();
    let (units, g) = (scene.units().unwrap(), 1e-5f64);
    let hertz = 4.0 / 3.0 * 193e9 / (2.0 * (1.0 - 0.09)) * (0.5f64 * 9.525e-3).sqrt();
    let force = scene.chain().bond_force(1, g / units.length_m, 0.0) * units.force_n;
    assert!((force / (hertz * g.powf(1.5) + 4e13 * g.powf(2.5)) - 1.0).abs() < 1e-13, "{force}");
    let plan = scene.plan(false).join("\n");
    assert!(plan.contains("terms with contact constants 4.000e13 N/m^α and exponent 2.5"), "{plan}");
    let cases = [
        (
            "contact = 4e13",
            "contact = -4e13",
            "line 12: `bonds.terms.0.contact`: bonds.terms.contact = -40000000000000 (entry 0)",
        ),
        ("poisson = 0.3\n", "poisson = 0.3\nstatic_load = 2.0\n", "units.static_load = 2"),
        ("alpha = 2.5", "alpha = 0.0", "bonds.terms.alpha = 0"),
    ];
    refuses(text, &cases);
}
