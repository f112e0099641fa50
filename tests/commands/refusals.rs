//! What a command line cannot say, of all commands: the value, the rule and what would be right.
//! Ranges that the help of a flag states are held by `tolerances.rs`, numbers that no flag can take
//! by `bad_files.rs`, whole messages by the golden net.

use super::program::{json, refusals, refused};
use std::fs;

#[test]
fn a_number_of_three_hundred_digits_is_said_in_a_few() {
    let digits = format!("1{}.0", "0".repeat(300));
    for (scene, set) in [
        ("impact", format!("initial.velocity={digits}")),
        ("impact", format!("chain.alpha=-{digits}")),
        ("impact", format!("beads.mass=-{digits}")),
        ("granular-crystal", format!("beads.tau=-{digits}")),
        ("granular-crystal", format!("bonds.contact=-{digits}")),
        ("end-driven", format!("drive=[{{site=0, kind=\"moved\", band=[{digits}, 1], amplitude=1}}]")),
    ] {
        let said = refused(&["run", scene, "--set", &set], 2);
        assert!(said.len() < 400 && said.contains("1e300"), "{set}: {said}");
    }
    let run = json(&["study", "bands", "granular-crystal", "--set", "units.radius=1e30"]);
    let doubt = run["warnings"][0].as_str().unwrap();
    assert!(doubt.contains("units.radius = 1e30 m: more than 1 m; if it is in mm, write 1e27"), "{doubt}");
}

#[test]
fn what_does_not_depend_on_the_initial_state_does_not_ask_for_it() {
    // Truth: the same with an initial state.
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, initial: &str| {
        let text = format!(
            "[chain]\nsites = 6\nalpha = 1.5\nboundary = \"fixed\"\nprecompression = 0.1\n{initial}[span]\nuntil = 1.0\n"
        );
        let path = folder.path().join(name).display().to_string();
        fs::write(&path, text).unwrap();
        path
    };
    let with = file("a.toml", "[initial]\nkind = \"single-bead\"\nsite = 3\nvelocity = 0.1\n");
    let without = file("b.toml", "");
    for (study, key) in [("bands", "bands"), ("modes", "linear"), ("response", "rows")] {
        let [a, b] = [&with, &without].map(|path| json(&["study", study, path])[key].clone());
        assert!(a == b && a.is_array(), "{study}: {a}");
    }
    assert!(refused(&["run", &without], 2).contains("missing field `initial`"));
    let set = ["study", "modes", &without, "--set", "initial.kind=single-bead", "--set", "initial.site=9"];
    assert!(refused(&set, 2).contains("site = 9 is not valid"));
}

#[test]
fn what_a_command_line_cannot_say_is_refused_by_value_and_rule() {
    refusals(
        2,
        &[
            ("run", "required"),
            ("run tw-q51", "did you mean \"tw-q15\"?"),
            ("run impact --set chain.rho=.3", "--set chain.rho=.3: TOML writes this number 0.3\n"),
            ("run impact --set chain.sites=007", "--set chain.sites=007: TOML writes this number 7\n"),
            (
                "run end-driven --set drive[0].amplitude=.3",
                "an entry of a list has its number after a dot, as in drive.0",
            ),
            ("dps dark --omega-b 1e308", "--omega-b = 1e308 is not valid: so near omega"),
            ("breather dark --omega-b 1e308", "--omega-b = 1e308 is not valid: so near omega"),
            ("breather bright --epsilon 1e308", "--epsilon = 1e308 is not valid: from 1e-100 to 1e100"),
            ("wave solitary --kappa 1e308", "--kappa = 1e308 is not valid: from 1e-100 to 1e100"),
            ("study response --to 1e308", "--to = 1e308 is not valid: from 1e-100 to 1e100"),
            ("run tw-q15 --step 0", "step = 0 is not valid"),
            ("run tw-q15 --step 1e-30", "at most 1e15 steps"),
            ("run tw-q15 --until inf", "until = inf is not valid"),
            ("run impact --until 1e-310", "until = 1e-310 is not valid"),
            ("run impact --set span.until=1e-310", "until = 1e-310 is not valid"),
            ("run impact --set span.until=1e300", "until = 1e300 is not valid"),
            ("run impact --until=-1", "error: --until = -1 is not valid: the end of a run is from 1e-100 to 1e100\n"),
            ("run impact --steps-per-period 0", "error: --steps-per-period = 0 is not valid: finite and positive\n"),
            ("run tw-q15 --windows-per-period 0", "windows-per-period = 0 is not valid: finite and positive"),
            ("run tw-q15 --windows-per-period 1e18", "windows = 1e20 is not valid: at most 1e15 windows"),
            ("run tw-q15 --integrator verlet --tol 1e-9", "a method with equal steps takes"),
            ("run tw-q15 --integrator verlet --windows-per-period 10", "only collocation takes windows"),
            ("run tw-q15 --integrator dop853 --windows-per-period 5", "windows-per-period = 5 "),
            ("run tw-q15 --windows-per-period 10 --nodes 7", "nodes = 7"),
            ("run tw-q15 --windows-per-period 10 --nodes 18", "4, 8 or 12"),
            ("run tw-q15 --windows-per-period 10 --nodes 1e3", "invalid value '1e3' for '--nodes"),
            ("run tw-q15 --nodes 8", "--windows-per-period"),
            ("run tw-q15 --tol 1e-6 --nodes 8 --json", "--nodes"),
            ("run tw-q15 --plan --windows-per-period 5 --nodes 18", "nodes = 18"),
            ("run tw-q15 --plan --tol 5", "tol = 5"),
            ("run cradle --plan --maxima 2", "from 2.3e-13 to 0.5"),
            ("run trivial-breather --stop u[0]>1", "--stop = u[0]>1 is not valid: an exact solution has no log"),
            ("run impact --stop u[0]", "error: --stop = u[0] is not valid: a quantity, its place, a sign"),
            ("run impact --stop u[0]>nan", "a quantity, its place, a sign and a number"),
            ("run impact --stop w[0]>1", "unknown quantity \"w\""),
            ("run impact --crossings u[999]>1", "--crossings = u[999]>1 of sites 0 to 99 is not valid"),
            (
                "run impact --crossings overlap[0]=0",
                "--crossings = overlap[0]=0 of bonds 1 to 99 is not valid: there is no",
            ),
            ("run impact --stop overlap[18446744073709551615]=0", "of bonds 1 to 99 is not valid"),
            ("run impact --set chain.sites=1 --stop overlap[0]=0", "no bond can touch here"),
            ("run impact --plan --stop u[100]>1", "of sites 0 to 99 is not valid"),
            ("run impact --set chain.rho=inf --crossings v[0]=0", "no resonator moves there"),
            ("run impact --stop u[0]>1 --checkpoint 1 --out x", "--checkpoint"),
            ("run cradle --checkpoint 1", "--out"),
            ("run trivial-breather --maxima 1e-6", "an exact solution has no log"),
            (
                "run tw-q15 --set chain.boundary=free",
                "`chain.boundary`: boundary = free is not valid: a travelling wave",
            ),
            (
                "run trivial-breather --set chain.boundary=fixed",
                "boundary = fixed is not valid: a trivial breather has free",
            ),
            ("run impact --samples 1000001", "samples = 1000001 is not valid: at most 10^6"),
            ("run impact --samples -1", "not a whole number, at least zero"),
            ("run impact --samples 1.5", "not a whole number, at least zero"),
            ("run granular-crystal --si", "unexpected argument '--si'"),
            ("run --resume x --set chain.rho=3", "cannot be used with"),
            ("run end-driven --set bonds.viscoelastic=0.1 --until 20 --integrator verlet", "take dop853-regularised"),
            ("compare end-driven --set bonds.viscoelastic=0.1 --integrators verlet", "know no velocities"),
            ("compare end-driven --integrators corrected", "without damping, moved beads"),
            ("compare tw-q15 --integrators verlet,strang", "unknown integrator \"strang\""),
            ("study drift --integrators colocation", "did you mean \"collocation\"?"),
            ("study drift bright-breather-61", "did you mean \"bright-breather-16\"?"),
            ("study stability --charts lihgt", "did you mean \"light\"?"),
            (
                "study stability --charts lite",
                "error: unknown chart \"lite\"; one of light, stiffness, alpha, length, time",
            ),
            ("study stability --set chain.rho=3", "it changes a scene: name one"),
            ("study theorem --seed 3", "seed = 3 is not valid: a seed needs something random"),
            (
                "study theorem --rho-law eps^-3",
                "error: --rho-law = eps^-3 is not valid: the laws are eps^-2(alpha-1), eps^",
            ),
            ("study theorem --rho-law -1", "rho-law = -1"),
            ("study lifetimes --rhos inf", "rhos = inf is not valid: finite and positive"),
            ("study lifetimes --until 1e9", "at most 10^6 periods"),
            ("wave impact", "scene = impact is not valid: a scene whose initial state is of kind travelling-wave"),
            ("wave tw-q15 --zeta -0.1", "zeta = -0.1 is not valid"),
            ("wave tw-q15 --zeta 1", "zeta = 1 is not valid"),
            ("wave tw-q15 --zeta 0.1 --seeds 0", "seeds = 0 is not valid: from 1 to 10000"),
            ("wave tw-q15 --seeds 3", "seeds = 3 is not valid: an ensemble needs a perturbation"),
            ("wave tw-q15 --zeta 0 --seeds 3", "an ensemble needs a perturbation"),
            ("wave tw-q15 --seed 3", "seed = 3 is not valid: a seed needs a perturbation"),
            ("wave tw-q15 --zeta 0.1 --seed 18446744073709551615 --seeds 2", "below 2^64"),
            ("wave tw-q15 --until -1", "until = -1 is not valid"),
            ("wave tw-q15 --until 1e9", "at most 2^27 strains are kept"),
            (
                "wave tw-q15 --integrator verlet",
                "integrator = verlet is not valid: an adaptive method: collocation or a dop",
            ),
            ("wave modulation --q-over-pi 0.31", "a whole number of waves"),
            ("wave modulation --b 2", "b = 2 is not valid"),
            ("wave modulation --a -1", "a = -1 is not valid"),
            ("wave modulation --kappa 0", "kappa = 0 is not valid: finite and positive"),
            ("wave modulation --rho inf", "b = 1 is not valid"),
            ("wave modulation --rho inf --b 0 --chart", "rho = inf is not valid"),
            ("wave modulation --sites 2000 --measure", "sites = 2000 is not valid"),
            ("wave modulation --measure --epsilon 1e-12", "10^5 periods"),
            ("wave modulation cradle", "scene = cradle is not valid"),
            ("wave modulation tw-q15 --rho 3", "cannot be used with"),
            ("wave modulation --modes 3", "--measure"),
            ("wave modulation --set chain.rho=3", "it changes a scene: name one"),
            ("breather bright --until 1e300", "the end of a run is from 1e-100 to 1e100"),
            ("breather bright --integrator xx", "; one of verlet, yoshida4, "),
            ("breather bright --rho 0", "rho = 0 is not valid: a bright breather needs resonators"),
            ("breather bright --sites 4", "sites = 4 is not valid: the chain holds the breather"),
            ("breather bright --center bead", "invalid value 'bead'"),
            ("breather bright --boundary strain-ring", "invalid value 'strain-ring'"),
            ("breather dark --sites 40", "sites = 40"),
            ("breather dark --sites 257", "--sites = 257 is not valid: from 3 to 255"),
            ("breather dark --sites 3", "--sites = 3 is not valid: a breather about a site needs 5 sites"),
            ("breather dark --omega-b 2", "--omega-b = 2"),
            (
                "breather dark --rho inf",
                "rho = inf is not valid: finite and at least 0: no dark breather has resonators at rest (inf)",
            ),
            ("breather doubled --most 2.02 --step 0.01", "no period doubling"),
            ("breather continue --parameter omega", "did you mean \"omega_b\""),
            ("breather continue --parameter rho", "--from"),
            ("breather continue --omega-b 2.05", "--from"),
            ("breather continue --from 2.05 --to 2.05", "to = 2.05"),
            ("breather continue --to 1.9", "to = 1.9"),
            ("breather continue --multipliers=false --bifurcations", "they need --multipliers"),
            ("wave continue", "--to is missing: a branch needs a value at which it ends"),
            ("dps integrals --b 0 --r -1", "r = -1 is not valid: finite and at least 0"),
            ("dps integrals --b 0 --r inf", "r = inf"),
            (
                "dps dark --sites 40",
                "error: --sites = 40 is not valid: a ring with one kink has an odd number of sites",
            ),
            ("dps dark --omega-b 2", "error: --omega-b = 2 is not valid: a dark breather is faster"),
            ("dps dark --rho inf", "error: --rho = inf is not valid"),
            (
                "paper verify --section 9",
                "section = 9 is not valid: a section of the paper that has items: 2, 3, 4, 5, 6, 7",
            ),
            ("paper verify --section 4.1", "invalid value '4.1'"),
            ("paper verify --section 4294967296", "larger than any whole number here, 2^32"),
            ("paper figures --only foo", "unknown figure \"foo\"; one of theorem-bounds, tw-q15,"),
        ],
    );
    let said = [
        (
            "run rosas-2007 --set bonds.overlap=0.1",
            "bonds.overlap = positive, boundary = \"free\" is not valid: only two walls",
        ),
        ("run rosas-2007 --integrator corrected", "contacts that do not dissipate: take dop853-regularised\n"),
        (
            "breather barrier --precompression 1 --rho 0 --from 2.43 --to 2.435",
            "the barrier is that of chains with resonators\n",
        ),
        (
            "orbit mode cradle --linear-mode 3 --to 0.1",
            "breathers of beads that just touch are in the middle of the chain\n",
        ),
        ("orbit driven chong-2014 --amplitude 0", "amplitude = 0 is not valid: finite, and not zero\n"),
        (
            "orbit continue chong-2014 --vary omega --omega=-1 --to 4e4",
            "omega = -1 is not valid: finite and positive\n",
        ),
        ("breather barrier --precompression 1", "under a precompression a range needs --from and --to\n"),
        ("breather barrier --precompression 1", "--from is missing: "),
        (
            "breather continue --vary c_x --precompression 0.1 --from -0.1 --to -0.2",
            "precompression = 0.1 is not valid: it is the parameter that varies: give --from and --to\n",
        ),
        ("breather continue --vary rho --from 1 --to 2 --prove", "in its frequency only: without --prove\n"),
        (
            "run chong-2014 --set drive.1.omega=-1",
            "chong-2014: --set drive.1.omega=-1: `drive.1.omega`: drive.omega = -1 ",
        ),
        ("run end-driven --integrator corrected", "take dop853-regularised, or strang-linear for equal steps\n"),
        (
            "wave tw-q15 --zeta=-1",
            "error: --zeta = -1 is not valid: the share of a perturbation is from 0 (none) to below 1\n",
        ),
        (
            "study bands hong-1999",
            "gravity = 1 is not valid: bands are those of a periodic chain: under gravity no two",
        ),
        ("study bands granular-crystal --set chain.gravity=9.81 --set chain.tilt=-30", "gravity = 9.81 is not valid"),
        ("study modes defect --set chain.sites=300", "sites = 300 is not valid: at most 256 sites, whose stiffnesses"),
        (
            "study response defect --set chain.alpha=1",
            "alpha = 1 is not valid: above 1 (that of a table is 1): else the stiffness",
        ),
        (
            "run hong-1999 --set chain.kappa=1 --set chain.rho=inf --set chain.sites=300",
            "sites = 300 is not valid: at most 256 sites, whose",
        ),
    ];
    refusals(2, &said);
    refusals(1, &[("run --resume /proc/none", "error: /proc/none: No such file or directory (os error 2)\n")]);
    let beyond = "error: b = -1e300, r = 1e300: g is no number that a double holds\n";
    refusals(1, &[("dps integrals --b -1e300 --r 1e300", beyond)]);
}
