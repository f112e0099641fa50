//! Contacts whose force goes through the rows of a table.

use crate::{
    details::{methods_agree, refuses, run},
    numbers::random,
    terms::{balanced, collision, meet},
    variations::{altered, chain},
};
use hertzchain::{
    chain::{Boundary, Chain, Details, Params, State, Table, Term, Variations},
    numerics::fit_line,
    orbits::{Bands, NormalModes},
    run::{Method, Run, Setting},
    scene::Scene,
};
use std::sync::Arc;

/// Rows that no smooth function goes through: slopes differ by factors up to 1000.
const ROUGH: [[f64; 6]; 2] = [[0.0, 0.1, 0.2, 0.25, 0.5, 1.0], [0.0, 1e-3, 0.1, 0.1001, 0.5, 2.0]];

fn table(overlap: impl IntoIterator<Item = f64>, force: impl Fn(f64) -> f64) -> Arc<Table> {
    let overlap: Vec<f64> = overlap.into_iter().collect();
    let force = overlap.iter().map(|&g| force(g)).collect();
    Table::new(overlap, force).unwrap().into()
}

/// `g^2 + g^3` by five rows up to 1.
fn cubic() -> Arc<Table> {
    table([0.0, 0.1, 0.3, 0.6, 1.0], |g| g * g * (1.0 + g))
}

fn rough() -> Arc<Table> {
    Table::new(ROUGH[0].to_vec(), ROUGH[1].to_vec()).unwrap().into()
}

/// Plain beads whose contacts have this table.
fn beads(boundary: Boundary, sites: usize, table: &Arc<Table>, rest: f64) -> Chain<f64> {
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), boundary, sites).unwrap();
    let overlap = vec![rest; chain.touching().len()];
    chain.with(&Details { table: Some(table.clone()), overlap, ..Details::default() }).unwrap()
}

/// Force and energy of a contact by this table, from a bead at a wall.
fn law(table: &Arc<Table>) -> [impl Fn(f64) -> f64 + use<>; 2] {
    let chain = beads(Boundary::RightWall, 1, table, 0.0);
    [0, 1].map(|k| {
        let chain = chain.clone();
        move |g| if k == 0 { chain.bond_force(1, g, 0.0) } else { chain.energy(&[g, 0.0]).contacts }
    })
}

/// Integral by Gauss's rule with three points on `parts` parts.
fn gauss(f: impl Fn(f64) -> f64, (from, to): (f64, f64), parts: u32) -> f64 {
    let (h, root) = ((to - from) / f64::from(parts), 0.6f64.sqrt());
    let part = |k: u32| {
        let middle = from + (f64::from(k) + 0.5) * h;
        h / 18.0 * (5.0 * f(middle - 0.5 * h * root) + 8.0 * f(middle) + 5.0 * f(middle + 0.5 * h * root))
    };
    (0..parts).map(part).sum()
}

#[test]
fn a_table_of_hertz_law_errs_by_the_fourth_power_of_its_rows() {
    // Truth: g^{3/2} and its energy. Near zero, where the second derivative of g^{3/2} has no
    // bound, forces err by the power 3/2 of the distance of rows, and elsewhere by the fourth.
    let points = [40, 80, 160, 320].map(|n| {
        let [force, energy] = law(&table((0..=n).map(|k| f64::from(k) / f64::from(n)), |g| g * g.sqrt()));
        let worst = |from: f64, off: &dyn Fn(f64) -> f64| {
            (0..=5000).map(|k| off(from + (1.0 - from) * f64::from(k) / 5000.0).abs()).fold(0.0, f64::max)
        };
        let near = worst(0.0, &|g| force(g) - g * g.sqrt());
        let far = worst(0.3, &|g| force(g) - g * g.sqrt());
        let work = worst(0.3, &|g| energy(g) - energy(0.3) - 0.4 * (g.powf(2.5) - 0.3f64.powf(2.5)));
        println!("{n} {near:e} {far:e} {work:e}");
        [near, far, work].map(|off| (f64::from(n).ln(), -off.ln()))
    });
    for (k, orders) in [(0, 1.45..1.55), (1, 3.9..4.1), (2, 3.9..4.3)] {
        let (order, _) = fit_line(&points.map(|off| off[k])).unwrap();
        println!("{order}");
        assert!(orders.contains(&order), "{k}: {order}");
    }
}

#[test]
fn a_rough_table_never_falls_and_its_energy_is_the_integral_of_its_force() {
    // Truth: the rows; Gauss's rule, which is exact for cubics.
    let [force, energy] = law(&rough());
    for (g, f) in ROUGH[0].into_iter().zip(ROUGH[1]) {
        assert_eq!(force(g), f);
    }
    let fine: Vec<f64> = (0..=20_000).map(|k| force(f64::from(k) / 16_000.0)).collect();
    assert!(fine.windows(2).all(|pair| pair[0] <= pair[1]));
    // Without the limits a spline through these rows does.
    let spline = hertzchain::chain::Spline::new(ROUGH[0].to_vec(), ROUGH[1].to_vec()).unwrap();
    assert!((0..100).any(|k| spline.at(0.01 * f64::from(k))[1] < -0.1));
    let mut sum = 0.0;
    for pair in ROUGH[0].windows(2).chain([&[1.0, 1.3][..]]) {
        let middle = 0.5 * (pair[0] + pair[1]);
        assert!((energy(middle) - sum - gauss(&force, (pair[0], middle), 1)).abs() < 2e-15);
        sum += gauss(&force, (pair[0], pair[1]), 1);
        assert!((energy(pair[1]) - sum).abs() < 2e-15, "{pair:?}");
    }
    // After the last row the force goes on with its slope there.
    assert!((force(1.3) - 2.0 - 3.0 * (force(1.1) - 2.0)).abs() < 4e-15 && force(1.1) > 2.1);
    assert_eq!([force(0.0), force(-1.0), energy(-1.0)], [0.0; 3]);
}

/// Two beads of which one strikes the other at rest with this speed; the contact begins at `onset`.
fn struck(table: &Arc<Table>, speed: f64, onset: f64) -> (Chain<f64>, State<f64>) {
    let chain = beads(Boundary::Free, 2, table, -onset * speed);
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = speed;
    (chain, state)
}

#[test]
fn two_beads_touch_for_the_time_of_the_quadrature() {
    // Truth: for g^2 + g^3 the integral of `terms.rs`. For rough rows that of the energy, which the
    // test above compares with the force: with g = G (1 - s^2) the integrand 4 G s/g' is bounded.
    let most = 0.9;
    let powers = [(1.0 / 3.0, 6.0), (1.0 / 4.0, 8.0)];
    let [_, energy] = law(&rough());
    let whole = energy(most);
    let term = |s: f64| 4.0 * most * s / (4.0 * (whole - energy(most * (1.0 - s * s)))).sqrt();
    let by_rows = ((4.0 * whole).sqrt(), gauss(term, (0.0, 1.0), 20_000));
    let smooth = (cubic(), collision(powers, most), [2e-12, 6e-12, 1e-10, 2e-9, 1e-9]);
    // Steps across rows have larger errors.
    let rows = (rough(), by_rows, [1e-10, 1e-10, 2e-10, 2e-9, 1e-9]);
    for (table, (speed, duration), bounds) in [smooth, rows] {
        let (chain, _) = struck(&table, speed, 0.1);
        meet(&chain, [0.1, duration, speed, most], bounds);
    }
}

#[test]
fn an_overlap_beyond_the_table_ends_the_run() {
    // Truth: the largest overlap of a collision with relative speed w, V(G) = w^2/4, here 0.9.
    let speed = |most: f64| (4.0 * (most.powi(3) / 3.0 + most.powi(4) / 4.0)).sqrt();
    let shorter = table([0.0, 0.2, 0.5, 0.9], |g| g * g * (1.0 + g));
    for (method, setting) in [
        ("dop853-regularised", Setting::Tolerance(1e-8)),
        ("dop853", Setting::Tolerance(1e-8)),
        ("strang-linear", Setting::Steps(2000)),
        ("srkn14-6", Setting::Steps(60)),
    ] {
        let run = |most: f64| {
            let (chain, state) = struck(&shorter, speed(most), 0.1);
            let run = Run::new(chain, state).until(4.0).unwrap();
            run.method(Method::named(method).unwrap()).setting(setting)
        };
        assert!(run(0.8999).start().unwrap().complete().is_ok(), "{method}");
        let failed = run(0.9001).start().unwrap();
        let said = failed.complete().unwrap_err().to_string();
        println!("{said}");
        assert!(said.starts_with("bond 1 overlaps by 9.00") && said.ends_with("table of its contact law ends at 9e-1"));
        // The stepper of a program and states on demand refuse as well.
        assert!(run(0.9001).at(&[4.0]).unwrap().next().unwrap().is_err());
    }
    // A start beyond the table, from a load that it does not hold.
    let heavy = altered(&beads(Boundary::RightWall, 3, &shorter, 0.0), |details| details.gravity = 0.7);
    let rest = State::equilibrium(&heavy).unwrap();
    let said = Run::new(heavy, rest).until(1.0).unwrap().tolerance(1e-9).unwrap().start().unwrap_err().to_string();
    assert!(said.starts_with("bond 3 overlaps by 1.0") && said.contains("at t = 0"), "{said}");
    // Beads without a contact may overlap by more.
    let none = altered(&beads(Boundary::Free, 2, &shorter, 5.0), |details| details.contact = vec![0.0]);
    let still = Run::new(none.clone(), State::rest(&none)).until(1.0).unwrap().tolerance(1e-9).unwrap();
    assert!(still.start().unwrap().complete().is_ok());
}

#[test]
fn long_runs_keep_energy_and_momentum() {
    // Truth: invariants; the order of Strang's scheme, whose energy error does not grow.
    let chain = beads(Boundary::Ring, 12, &rough(), 0.0);
    let mut state = State::rest(&chain);
    let mut next = random(7);
    state.u_dot_mut().iter_mut().for_each(|velocity| *velocity = 0.2 * next() - 0.1);
    let momentum: f64 = state.u_dot().iter().sum();
    let error = |until: f64, method, setting| {
        let end = run(&chain, &state, until, method, setting);
        assert!((end.state[12..].iter().sum::<f64>() - momentum).abs() < 1e-12);
        (end.energy_error.unwrap(), end.stats.steps)
    };
    let (off, steps) = error(1000.0, "dop853-regularised", Setting::Tolerance(1e-12));
    println!("{off:e} {steps}");
    assert!(off < 1e-11 * steps as f64, "{off:e}");
    let [short, long, fine] = [(100.0, 5000), (1000.0, 50_000), (1000.0, 100_000)]
        .map(|(until, steps)| error(until, "strang-linear", Setting::Steps(steps)).0);
    println!("{short:e} {long:e} {fine:e}");
    assert!(long < 3.0 * short && (3.0..5.5).contains(&(long / fine)), "{short:e} {long:e} {fine:e}");
}

/// Six beads that differ in everything, with a table, times a constant, and a power.
fn summed() -> Chain<f64> {
    altered(&chain(), |details| {
        details.alpha = Vec::new();
        details.table = Some(table((0..=12).map(|k| 0.25 * f64::from(k)), |g| g * g.sqrt() + 0.1 * g * g));
        details.terms = vec![Term { contact: vec![0.5, 0.0, 1.0, 0.3, 2.0, 0.1, 0.7], alpha: 2.5 }];
    })
}

#[test]
fn methods_agree_on_tables() {
    // Truth: each other. Steps that cross a row, where a derivative of the force jumps, have larger
    // errors: in the mean ten times the tolerance of a step.
    let rows = [
        ("dop853-landed", Setting::Tolerance(1e-13), 6e-10),
        ("dop853", Setting::Tolerance(1e-13), 1e-10),
        ("strang-linear", Setting::Steps(100_000), 1e-8),
        ("verlet", Setting::Steps(100_000), 1e-8),
    ];
    methods_agree("table", &summed(), 1e-13, &rows);
}

#[test]
fn beads_at_rest_have_balanced_forces() {
    // Truth: f(g) = g^2 + g^3.
    balanced(|g| g * g * (1.0 + g), |boundary, rest| beads(boundary, 5, &cubic(), rest), 4e-15);
    // A stiffness that jumps where contacts open has no tangent map here.
    let pressed = beads(Boundary::Fixed, 5, &cubic(), 0.2);
    let said = NormalModes::new(&pressed).unwrap_err().to_string();
    assert!(said.contains("that of a table is 1"), "{said}");
    assert!(Bands::new(&pressed).unwrap_err().to_string().contains("table does not belong here"));
    let said = Variations::flow(&pressed, &[0.0; 10], (0.0, 1.0), &[], 1e-9).unwrap_err().to_string();
    assert!(said.contains("that of a table is 1"), "{said}");
    let said = Method::named("collocation").unwrap().runs(&pressed).unwrap_err().to_string();
    assert!(said.contains("a sum or a table: take dop853-regularised"), "{said}");
}

#[test]
fn scenes_have_tables() {
    let text = "[chain]\nsites = 3\nalpha = 1.5\nboundary = \"left-wall\"\n[bonds]\ncontact = [1.0, 2.0, 1.0]\n\
                table = { overlap = [0.0, 0.1, 0.3, 0.6, 1.0], force = [0.0, 0.011, 0.117, 0.576, 2.0] }\n\
                [initial]\nkind = \"single-bead\"\nsite = 0\nvelocity = -1.0\n[span]\nuntil = 5.0\n";
    let scene = Scene::parse(text, "rows").unwrap();
    let details = scene.chain().details().unwrap();
    let rows = Table::new(vec![0.0, 0.1, 0.3, 0.6, 1.0], vec![0.0, 0.011, 0.117, 0.576, 2.0]).unwrap();
    assert_eq!(details.table.as_deref(), Some(&rows));
    assert_eq!(scene.chain().bond_force(1, 0.1, 0.0), 0.022);
    let again = Scene::parse(&scene.file().to_toml(), "rows").unwrap();
    assert_eq!(again.chain().details(), Some(details));
    let plan = scene.plan(false).join("\n");
    assert!(plan.contains("forces of 5 rows up to the overlap 1, times from 1 to 2"), "{plan}");
    let cases = [
        ("0.117", "0.01", "bonds.table.force = 0.01 (entry 2) is not valid"),
        ("0.117", "0.011", "bonds.table.force = 0.011 (entry 2) is not valid"),
        ("0.3,", "0.1,", "bonds.table.overlap = 0.1 (entry 2) is not valid"),
        ("0.117", "nan", "bonds.table.force = NaN (entry 2) is not valid"),
        ("2.0] }", "inf] }", "bonds.table.force = inf (entry 4) is not valid"),
        ("[0.0, 0.1", "[0.01, 0.1", "bonds.table.overlap = 0.01 (entry 0) is not valid"),
        ("[0.0, 0.011", "[1e-9, 0.011", "bonds.table.force = 0.000000001 (entry 0) is not valid"),
        (", 2.0] }", "] }", "bonds.table = 5 overlaps, 4 forces is not valid: at least two rows"),
        ("0.1, 0.3, 0.6, 1.0], force = [0.0, 0.011, 0.117, 0.576, 2.0]", "], force = [0.0]", "1 overlaps, 1 forces"),
        ("0.1, 0.3", "5e-324, 0.3", "bonds.table = rows too near or too far apart"),
        ("2.0] }", "2.0], file = \"a\" }", "unknown field `file`"),
        ("[bonds]\n", "[bonds]\ndashpot = 0.1\n", "bonds.table beside dashpot is not valid"),
        ("[bonds]\n", "[bonds]\nalpha = 1.5\n", "bonds.alpha beside table is not valid"),
    ];
    refuses(text, &cases);
}

#[test]
fn tables_are_in_si_units() {
    // Truth: the rows; a contact of half the force at the wall.
    let text = "[chain]\nsites = 2\nalpha = 1.5\nboundary = \"right-wall\"\n[units]\nsystem = \"SI\"\nradius = 9.525e-3\n\
                density = 8027.0\n[bonds]\nwall = 0.5\ntable = { overlap = [0.0, 1e-5, 3e-5], force = [0.0, 20.0, 90.0] }\n\
                [initial]\nkind = \"single-bead\"\nsite = 0\nvelocity = 0.1\n[span]\nuntil = 1e-4\n";
    let scene = Scene::parse(text, "si").unwrap();
    let units = scene.units().unwrap();
    let force = |bond| scene.chain().bond_force(bond, 1e-5 / units.length_m, 0.0) * units.force_n;
    assert!((force(1) / 20.0 - 1.0).abs() < 1e-13 && (force(2) / 10.0 - 1.0).abs() < 1e-13);
    let plan = scene.plan(false).join("\n");
    assert!(plan.contains("forces of 3 rows up to the overlap 3.000e-5 m, times from 0.5 to 1"), "{plan}");
    let cases = [
        ("1e-5, 3e-5", "4e-5, 3e-5", "bonds.table.overlap = 0.00003 (entry 2)"),
        ("[0.0, 20.0, 90.0]", "[0.0, 20.0, 9.0]", "bonds.table.force = 9 (entry 2)"),
        ("density = 8027.0\n", "density = 8027.0\nstatic_load = 2.0\n", "units.static_load = 2"),
    ];
    refuses(text, &cases);
}
