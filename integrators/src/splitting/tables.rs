//! The coefficients of the splitting schemes.
//!
//! Sources print 15 to 40 digits. Each table is the solution of its order conditions nearest to the
//! printed one, to 40 digits. Where solutions form a family, the digits beyond the printed ones
//! only keep the table on the family.

use super::scheme::{Coefficients, Scheme};

/// Strang's splitting: velocity Verlet when the drift is the kinetic energy and the kick comes
/// first.
pub const STRANG: Scheme = Scheme {
    name: "strang",
    order: 2,
    source: "Strang 1968; Verlet 1967",
    coefficients: Coefficients::Composition(&[]),
};

/// The triple jump of Yoshida, Forest and Ruth: `gamma_1 = 1/(2 - 2^(1/3))`.
pub const YOSHIDA4: Scheme = Scheme {
    name: "yoshida4",
    order: 4,
    source: "Yoshida 1990, Phys. Lett. A 150, 262: the triple jump, 1/(2 - 2^(1/3)); Forest and Ruth 1990",
    coefficients: Coefficients::Composition(&["1.351207191959657634047687808971460826922"]),
};

/// Suzuki's fractal: five Strang steps, `gamma_1 = gamma_2 = 1/(4 - 4^(1/3))`.
pub const SUZUKI4: Scheme = Scheme {
    name: "suzuki4",
    order: 4,
    source: "Suzuki 1990, Phys. Lett. A 146, 319: the fractal with p = 1/(4 - 4^(1/3))",
    coefficients: Coefficients::Composition(&[
        "0.4144907717943757371423540628607614957118",
        "0.4144907717943757371423540628607614957118",
    ]),
};

/// Blanes and Moan's fourth-order Nyström scheme with six stages. It is of order 4 for any two
/// flows.
pub const SRKN6_4: Scheme = Scheme {
    name: "srkn6-4",
    order: 4,
    source: "Blanes and Moan 2002, J. Comput. Appl. Math. 142, 313: SRKN_6^b, Table 3",
    coefficients: Coefficients::KickFirst {
        drifts: &["0.2452989571842711626039324260014008804072", "0.6048726657110799749608926976430762452210"],
        kicks: &[
            "0.08298440641740501883834747894225011249475",
            "0.3963098014983680770949115282636867393961",
            "-0.03905630492234843517086529076537924228761",
        ],
    },
};

/// Generalised order (8, 6, 4): a kick of size `eps` leaves an error
/// `eps h^8 + eps^2 h^6 + eps^3 h^4`.
pub const ABA864: Scheme = Scheme {
    name: "aba864",
    order: 4,
    source: "Blanes, Casas, Farrés, Laskar, Makazaga and Murua 2013, Appl. Numer. Math. 68, 58: ABA(8,6,4)",
    coefficients: Coefficients::DriftFirst {
        drifts: &[
            "0.07113342649822311777793873000615499641740",
            "0.2411534279566400987364877953262896496178",
            "0.5214117617728147892121360780679942299914",
        ],
        kicks: &[
            "0.1830836874721972219617037571664302910726",
            "0.3107828598985748695075222910542627963752",
            "-0.02656461851195880069721213791649875926633",
        ],
    },
};

/// Generalised order (10, 6, 4): as [`ABA864`], with `eps h^10`.
pub const ABA1064: Scheme = Scheme {
    name: "aba1064",
    order: 4,
    source: "Blanes, Casas, Farrés, Laskar, Makazaga and Murua 2013, Appl. Numer. Math. 68, 58: ABA(10,6,4)",
    coefficients: Coefficients::DriftFirst {
        drifts: &[
            "0.03809449742241219545697532230863756534066",
            "0.1452987161169137492940200726606637497443",
            "0.2076276957255412507162056113249882065158",
            "0.4359097036515261592231548624010651844007",
        ],
        kicks: &[
            "0.09585888083707521061077150377145884776934",
            "0.2044461531429987806805077839164344779763",
            "0.2170703479789911017143385924306336714530",
        ],
    },
};

/// Yoshida's sixth-order composition with seven stages, solution A.
pub const YOSHIDA6: Scheme = Scheme {
    name: "yoshida6",
    order: 6,
    source: "Yoshida 1990, Phys. Lett. A 150, 262: Table 1, solution A",
    coefficients: Coefficients::Composition(&[
        "0.7845136104775572638194976338663498757768",
        "0.2355732133593581336847931829785346016865",
        "-1.177679984178871006946415680964315734639",
    ]),
};

/// Kahan and Li's sixth-order composition with nine stages.
pub const KAHAN_LI6: Scheme = Scheme {
    name: "kahan-li6",
    order: 6,
    source: "Kahan and Li 1997, Math. Comp. 66, 1089: s9odr6a; Hairer, Lubich and Wanner 2006, V.3.2",
    coefficients: Coefficients::Composition(&[
        "0.3921614440073141392792505574226714038049",
        "0.3325991367893594385997486375000496468816",
        "-0.7062461725576393598099648195492564593955",
        "0.08221359629355080023149044810205633110329",
    ]),
};

/// Blanes and Moan's sixth-order Nyström scheme with eleven stages, kick first.
///
/// Of order 6 only because the kinetic energy is quadratic: `[B, [B, [B, A]]] = 0`.
pub const SRKN11_6: Scheme = Scheme {
    name: "srkn11-6",
    order: 6,
    source: "Blanes and Moan 2002, J. Comput. Appl. Math. 142, 313: SRKN_11^b, Table 3",
    coefficients: Coefficients::KickFirst {
        drifts: &[
            "0.1232297759462711515610863803333667525905",
            "0.2905537977995582703664141693279161833302",
            "-0.1270492126254169156625050538274859344730",
            "-0.2463317610620754041949734891040628625960",
            "0.3572088727959277526198603496193104628369",
        ],
        kicks: &[
            "0.04146499851826284329877813391470493672394",
            "0.1981286719180665411367264731814969606125",
            "-0.04000619210415268688882836353594483937569",
            "0.07525398430158034112787887852704275554175",
            "-0.01151138742068777006244320150128919955259",
        ],
    },
};

/// Blanes and Moan's sixth-order Nyström scheme with fourteen stages, drift first; order 6 as in
/// [`SRKN11_6`].
pub const SRKN14_6: Scheme = Scheme {
    name: "srkn14-6",
    order: 6,
    source: "Blanes and Moan 2002, J. Comput. Appl. Math. 142, 313: SRKN_14^a, Table 3",
    coefficients: Coefficients::DriftFirst {
        drifts: &[
            "0.03785931984061094144702117903801110403198",
            "0.1026356331024365528470822509403380612759",
            "-0.02586788826655833316394696035936533855913",
            "0.3142414030714464341471425357032840110789",
            "-0.1301444595174151138496150785400285161721",
            "0.1064177003695413680222801392853834569480",
            "-0.008794243128510204394069428427659903032337",
        ],
        kicks: &[
            "0.09171915262446201798118322826486834024983",
            "0.1839831700050048984914765646763433380067",
            "-0.05653436583288910439527704484808994928962",
            "0.004914688774711885640205616455015724404119",
            "0.1437611271683616823873745299867722104871",
            "0.3285676937468041402004812576270353400948",
        ],
    },
};

/// Yoshida's eighth-order composition with fifteen stages, solution D, which has the smallest error
/// of his five.
pub const YOSHIDA8: Scheme = Scheme {
    name: "yoshida8",
    order: 8,
    source: "Yoshida 1990, Phys. Lett. A 150, 262: Table 2, solution D",
    coefficients: Coefficients::Composition(&[
        "0.9148442462297915667487934898475096045181",
        "0.2536933365662113541461460206899420760977",
        "-1.444852236860605157694730657537390354956",
        "-0.1582406353680501752040667767597542477554",
        "1.938139137622525986579186487443641760954",
        "-1.960610232975310807607633376399663640792",
        "0.1027998493917964406981151316012258629110",
    ]),
};

/// Kahan and Li's eighth-order composition with seventeen stages.
pub const KAHAN_LI8: Scheme = Scheme {
    name: "kahan-li8",
    order: 8,
    source: "Kahan and Li 1997, Math. Comp. 66, 1089: s17odr8a; Hairer, Lubich and Wanner 2006, V.3.2",
    coefficients: Coefficients::Composition(&[
        "0.1302024830888900808788176320967005223572",
        "0.5611629817751083845619644077001505672662",
        "-0.3894749626448472864080785982352483888361",
        "0.1588419065551556008962107457071524814121",
        "-0.3959038941332375773362315393479389360268",
        "0.1845396409783157070918325415333754628190",
        "0.2583743876863220472939791099949394718131",
        "0.2950117236093102988709662402182281129765",
    ]),
};

/// All schemes, by order and then by stages.
pub const ALL: &[Scheme] = &[
    STRANG, YOSHIDA4, SUZUKI4, SRKN6_4, ABA864, ABA1064, YOSHIDA6, KAHAN_LI6, SRKN11_6, SRKN14_6, YOSHIDA8, KAHAN_LI8,
];
