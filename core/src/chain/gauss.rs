//! The rule of Gauss and Legendre with twelve points.

use hertzchain_integrators::Real;

/// Order of the rule.
pub(super) const ORDER: u32 = 24;

/// Positive nodes, and their weights, on `[-1, 1]`.
const POINTS: [(f64, f64); 6] = [
    (0.125_233_408_511_468_9, 0.249_147_045_813_402_77),
    (0.367_831_498_998_180_2, 0.233_492_536_538_354_8),
    (0.587_317_954_286_617_5, 0.203_167_426_723_065_92),
    (0.769_902_674_194_304_7, 0.160_078_328_543_346_22),
    (0.904_117_256_370_474_9, 0.106_939_325_995_318_43),
    (0.981_560_634_246_719_2, 0.047_175_336_386_511_83),
];

/// Number of nodes.
pub(super) const NODES: usize = 2 * POINTS.len();

/// Nodes on `[a, b]` with their weights, in pairs about the middle.
pub(super) fn nodes<R: Real>(a: R, b: R) -> [(R, R); NODES] {
    let (middle, half) = (R::of(0.5) * (a + b), R::of(0.5) * (b - a));
    std::array::from_fn(|k| {
        let (x, weight) = POINTS[k / 2];
        let x = if k % 2 == 0 { -x } else { x };
        (middle + half * R::of(x), half * R::of(weight))
    })
}

/// `int_a^b f ds`, for several functions at once.
pub fn gauss<R: Real, const K: usize>(f: impl Fn(R) -> [R; K], a: R, b: R) -> [R; K] {
    let mut sums = [R::zero(); K];
    for pair in nodes(a, b).chunks_exact(2) {
        let (below, above) = (f(pair[0].0), f(pair[1].0));
        for (sum, (below, above)) in sums.iter_mut().zip(below.into_iter().zip(above)) {
            *sum += pair[0].1 * (below + above);
        }
    }
    sums
}
