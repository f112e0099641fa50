//! Registers of all widths.

use hertzchain_integrators::{Column, Instructions, Vector, real::MOST_LANES, with_registers};

/// All operations on some numbers, at the width of the instructions in use; and this width.
fn all(x: &[f64]) -> (Vec<f64>, usize) {
    with_registers!(V => {
        let n = x.len() / 2;
        let (mut out, mut copy) = (Vec::new(), x.to_vec());
        let column = Column::new(&mut copy);
        for at in (0..n).step_by(V::LANES) {
            // SAFETY: `n` is a multiple of all widths, and the column is twice as long.
            let (a, b): (V, V) = unsafe { (column.load(at), column.load(n + at)) };
            let values = [
                a + b,
                a - b,
                a * b,
                a / b,
                a.fused(b, a - b),
                a.larger(b),
                a.root(),
                (a * V::all(7.3)).floor(),
                a.inverse(),
                a.negative(),
                a.above(0.25, b),
                (a - b).size(),
                V::all((a - b).positive() as f64),
                V::all(a.exceeds(b) as f64),
                V::all(a.at_most(b) as f64),
                a.or(a.at_most(b), b * b),
                a.each(|x| x.powf(1.3)),
                V::all(x[0]),
            ];
            values.into_iter().for_each(|value| append(&mut out, value));
        }
        (out, V::LANES)
    })
}

/// The lanes after `before`, `after`, `first` and `spread`; and the width.
fn moves() -> (Vec<f64>, usize) {
    with_registers!(V => {
        let mut numbers: Vec<f64> = (0..3 * MOST_LANES).map(|k| k as f64).collect();
        let (mut out, column) = (Vec::new(), Column::new(&mut numbers));
        // SAFETY: two registers from the start are within the column.
        let (a, b): (V, V) = unsafe { (column.load(0), column.load(V::LANES)) };
        let spread = (0..V::LANES).map(|lane| b.spread(lane));
        let moved = [a.before(b), b.after(a)].into_iter().chain((0..=V::LANES).map(|n| a.first(n, b)));
        moved.chain(spread).for_each(|value| append(&mut out, value));
        (out, V::LANES)
    })
}

#[inline(always)]
fn append<V: Vector<f64>>(out: &mut Vec<f64>, value: V) {
    let mut lanes = [0.0; MOST_LANES];
    // SAFETY: the array is as long as the largest number of lanes.
    unsafe { value.store(lanes.as_mut_ptr()) };
    out.extend(&lanes[..V::LANES]);
}

#[test]
fn lanes_are_numbers_and_move_by_one() {
    // Truth: the operations of `f64`, one number at a time, to the bit.
    let x: Vec<f64> = (1..=64).map(|k| (k as f64 * 0.618).fract()).collect();
    let used = Instructions::used();
    for set in Instructions::ALL {
        if !set.select() {
            continue;
        }
        let (got, lanes) = all(&x);
        let mut want = Vec::new();
        for at in (0..32).step_by(lanes) {
            let pairs = || (at..at + lanes).map(|k| (x[k], x[32 + k]));
            let positive: u64 = pairs().enumerate().map(|(k, (a, b))| u64::from(a > b) << k).sum();
            let operations: [&dyn Fn(f64, f64) -> f64; 18] = [
                &|a, b| a + b,
                &|a, b| a - b,
                &|a, b| a * b,
                &|a, b| a / b,
                &|a, b| a.mul_add(b, a - b),
                &|a, b| if b > a { b } else { a },
                &|a, _| a.sqrt(),
                &|a, _| (a * 7.3).floor(),
                &|a, _| 1.0 / a,
                &|a, _| -a,
                &|a, b| if a > 0.25 { b } else { 0.0 },
                &|a, b| (a - b).abs(),
                &|_, _| positive as f64,
                &|_, _| positive as f64,
                &|_, _| ((1u64 << lanes) - 1 - positive) as f64,
                &|a, b| if a <= b { a } else { b * b },
                &|a, _| a.powf(1.3),
                &|_, _| 0.618,
            ];
            want.extend(operations.iter().flat_map(|f| pairs().map(|(a, b)| f(a, b))));
        }
        assert_eq!(got, want, "{set}");

        let (got, lanes) = moves();
        let mut want: Vec<f64> = (1..=lanes).chain(lanes - 1..2 * lanes - 1).map(|k| k as f64).collect();
        for n in 0..=lanes {
            want.extend((0..lanes).map(|k| if k < n { k as f64 } else { (lanes + k) as f64 }));
        }
        want.extend((0..lanes * lanes).map(|k| (lanes + k / lanes) as f64));
        assert_eq!(got, want, "{set}");
    }
    assert!(used.select());
}
