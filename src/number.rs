//! Numbers read from text.

/// The double nearest to a decimal: infinite only for `inf`, and zero only for a decimal of zero.
///
/// # Errors
/// No number, or a number that a double cannot hold.
pub(crate) fn double(text: &str) -> Result<f64, String> {
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

/// A whole number, at least zero.
///
/// # Errors
/// No such number, or a number beyond the type.
#[cfg(feature = "cli")]
pub(crate) fn whole<T: TryFrom<u64>>(text: &str) -> Result<T, String> {
    let not_whole = || "not a whole number, at least zero".to_owned();
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(not_whole());
    }
    let too_large = || "larger than any whole number here, 1.8e19".to_owned();
    let value: u64 = text.parse().map_err(|_| too_large())?;
    T::try_from(value).map_err(|_| too_large())
}
