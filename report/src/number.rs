//! Numbers read from text, and written for people.

/// The double nearest to a decimal: infinite only for `inf`, and zero only for a decimal of zero.
///
/// # Errors
/// No number, or a number that a double cannot hold.
pub fn double(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
    if value.is_infinite() && mantissa.contains(|c: char| c.is_ascii_digit()) {
        return Err("larger than any double, 1.8e308; infinity is written inf".to_owned());
    }
    if value == 0.0 && mantissa.contains(|c: char| ('1'..='9').contains(&c)) {
        return Err("smaller than any double, 4.9e-324; zero is written 0".to_owned());
    }
    Ok(value)
}

/// A number to fifteen digits, without the rounding of a conversion of units.
pub fn rounded(x: f64) -> f64 {
    format!("{x:.14e}").parse().unwrap_or(x)
}

/// A parameter as a person writes it: all its digits if they are few; else as a fraction with a
/// denominator up to 12 if it is one (`1/3`); else to four digits.
pub fn format_parameter(x: f64) -> String {
    const FEW: usize = 8;
    let exact = x.to_string().replace("inf", "∞");
    if exact.len() <= FEW {
        return exact;
    }
    let fraction = (2..=12).map(f64::from).find_map(|q| {
        let p = (x * q).round();
        (p != 0.0 && p.abs() < 100.0 && p / q == x).then(|| format!("{p}/{q}"))
    });
    fraction.unwrap_or_else(|| format_short(x))
}

/// An angle as a multiple of pi: a fraction if it is one to rounding (`4π/5`), else a decimal
/// (`0.3183 π`).
pub fn of_pi(angle: f64) -> String {
    let share = angle / std::f64::consts::PI;
    let fraction = (1..=12).map(f64::from).find_map(|q| {
        let p = (share * q).round();
        ((p / q - share).abs() < 1e-14 && p != 0.0).then_some((p, q))
    });
    match fraction {
        None => format!("{} π", format_short(share)),
        Some((p, q)) => {
            let p = if p.abs() == 1.0 { p.to_string().replace('1', "") } else { p.to_string() };
            if q == 1.0 { format!("{p}π") } else { format!("{p}π/{q}") }
        }
    }
}

/// A number with `digits` decimals; zero has no sign.
pub fn format_fixed(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    if text.trim_matches(['-', '0', '.']).is_empty() { text.replace('-', "") } else { text }
}

/// A number to four digits, with a power of ten where it is very large or small.
pub fn format_short(x: f64) -> String {
    if x != 0.0 && !(1e-4..1e6).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    let digits = (3 - x.abs().max(1e-4).log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number of things with their noun: `1 piece`, `2 pieces`.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A whole number, at least zero.
///
/// # Errors
/// No such number, or a number beyond the type.
#[cfg(feature = "cli")]
pub fn whole<T: TryFrom<u64>>(text: &str) -> Result<T, String> {
    let not_whole = || "not a whole number, at least zero".to_owned();
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(not_whole());
    }
    let too_large = || format!("larger than any whole number here, 2^{}", 8 * size_of::<T>());
    let value: u64 = text.parse().map_err(|_| too_large())?;
    T::try_from(value).map_err(|_| too_large())
}

/// A whole number, with or without a sign.
///
/// # Errors
/// No such number, or a number beyond the type.
#[cfg(feature = "cli")]
pub fn signed(text: &str) -> Result<i64, String> {
    text.parse().map_err(|_| "not a whole number from -2^63 to below 2^63".to_owned())
}
