//! Small numerical tools: lines and planes through points, bisection, golden sections, extremes,
//! powers of 2^8.

/// The item with the least value of `of`; the first of those that are equal.
pub fn least_by<T>(all: impl IntoIterator<Item = T>, of: impl Fn(&T) -> f64) -> Option<T> {
    all.into_iter().min_by(|a, b| of(a).total_cmp(&of(b)))
}

/// The item with the largest value of `of`; the last of those that are equal.
pub fn largest_by<T>(all: impl IntoIterator<Item = T>, of: impl Fn(&T) -> f64) -> Option<T> {
    all.into_iter().max_by(|a, b| of(a).total_cmp(&of(b)))
}

/// The place of the first of the largest values. Values that a symmetry makes equal differ by
/// roundings, which must choose neither a coordinate nor the sign of a mode.
pub fn leading(mut values: impl Iterator<Item = f64> + Clone) -> Option<usize> {
    let largest = values.clone().fold(0.0, f64::max);
    values.position(|value| value >= (1.0 - 1e-6) * largest)
}

/// The least and the largest of the values; infinity and minus infinity without values.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
    values.into_iter().fold((low, high), |(low, high), value| (low.min(value), high.max(value)))
}

/// `max |y_i|`; NaN entries are left out.
pub fn max_norm(y: impl IntoIterator<Item = f64>) -> f64 {
    y.into_iter().fold(0.0, |largest, value| value.abs().max(largest))
}

/// The least double from which a condition holds, to the last digit, by bisection. The condition
/// does not hold at `first`, a positive number, and begins to hold once above it; `None` if that is
/// beyond the last doubling of `first` that is finite.
///
/// ```
/// use hertzchain_core::numerics::least_above;
/// assert_eq!(least_above(1e-3, |x| x * x >= 2.0), Some(2f64.sqrt()));
/// assert_eq!(least_above(1.0, |_| false), None);
/// ```
pub fn least_above(first: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
    debug_assert!(first > 0.0);
    let (mut low, mut high) = (first, 2.0 * first);
    while !holds(high) {
        (low, high) = (high, 2.0 * high);
        if !high.is_finite() {
            return None;
        }
    }
    loop {
        let middle = low + 0.5 * (high - low);
        if middle <= low || middle >= high {
            return Some(high);
        }
        *(if holds(middle) { &mut high } else { &mut low }) = middle;
    }
}

/// Slope of the least-squares line, and its largest residual; `None` if no abscissas differ.
pub fn fit_line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (sxx, sxy) =
        points.iter().fold((0.0, 0.0), |(xx, xy), p| (xx + (p.0 - mx).powi(2), xy + (p.0 - mx) * (p.1 - my)));
    let slope = (sxx > 0.0).then(|| sxy / sxx)?;
    let residual = points.iter().map(|p| (p.1 - my - slope * (p.0 - mx)).abs()).fold(0.0, f64::max);
    Some((slope, residual))
}

/// `z = c + p x + q y` by least squares, `[c, p, q]` and the largest residual; `None` with fewer
/// than four points, or if they lie on a line.
pub fn fit_plane(points: &[[f64; 3]]) -> Option<([f64; 3], f64)> {
    if points.len() < 4 {
        return None;
    }
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64;
    let means = [mean(0), mean(1), mean(2)];
    let moment =
        |j: usize, k: usize| points.iter().map(|point| (point[j] - means[j]) * (point[k] - means[k])).sum::<f64>();
    let (xx, xy, yy, xz, yz) = (moment(0, 0), moment(0, 1), moment(1, 1), moment(0, 2), moment(1, 2));
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-9 * xx * yy {
        return None;
    }
    let (p, q) = ((xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant);
    let c = means[2] - p * means[0] - q * means[1];
    let off = |&[x, y, z]: &[f64; 3]| (z - c - p * x - q * y).abs();
    Some(([c, p, q], points.iter().map(off).fold(0.0, f64::max)))
}

/// The place and the value with the largest `height` between two places, by golden sections as long
/// as `apart` says so of the distance of the places.
///
/// ```
/// use hertzchain_core::numerics::golden;
/// let parabola = |x: f64| Ok::<_, ()>(x * (2.0 - x));
/// let (x, top) = golden([0.0, 3.0], |apart| apart > 1e-6, parabola, |y| *y)?;
/// assert!((x - 1.0).abs() < 1e-6 && (top - 1.0).abs() < 1e-12);
/// # Ok::<(), ()>(())
/// ```
///
/// # Errors
/// A value that cannot be computed.
pub fn golden<T, E>(
    [mut low, mut high]: [f64; 2],
    mut apart: impl FnMut(f64) -> bool,
    at: impl Fn(f64) -> Result<T, E>,
    height: impl Fn(&T) -> f64,
) -> Result<(f64, T), E> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let seen = |x: f64| Ok((x, at(x)?));
    let mut left = seen(high - GOLDEN * (high - low))?;
    let mut right = seen(low + GOLDEN * (high - low))?;
    while apart(high - low) {
        if height(&left.1) > height(&right.1) {
            (high, right) = (right.0, left);
            left = seen(high - GOLDEN * (high - low))?;
        } else {
            (low, left) = (left.0, right);
            right = seen(low + GOLDEN * (high - low))?;
        }
    }
    Ok(if height(&left.1) > height(&right.1) { left } else { right })
}

/// The power of 2^8 next to a number, such that its inverse is one, too; 1 for a number that is
/// zero or not finite.
pub fn unit(of: f64) -> f64 {
    if of > 0.0 && of.is_finite() { (8.0 * (of.log2() / 8.0).round()).clamp(-1016.0, 1016.0).exp2() } else { 1.0 }
}
