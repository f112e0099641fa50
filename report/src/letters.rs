//! Texts as runs of letters of one size: subscripts, superscripts and powers of ten.
//!
//! The marks are chosen so that texts stay readable in JSON and Markdown, where they are not set:
//!
//! | written | set as |
//! |---|---|
//! | `E_{xy}`, `ε^{1−α}` | subscript and superscript |
//! | `ω_b`, `E_x`, `ω_tw` | subscript of one to three letters after a symbol of one letter |
//! | `ε^(1−α)`, `|λ|^m` | superscript: what is in brackets, or one number or word |
//! | `1e-9`, `2.5e7` | 10 to a power, with its factor if that is not 1 |
//!
//! Everything else, such as `omega_b`, `fig:tw_r03` or `eq:w_tw`, is set as it is written.

/// Position and size of the letters of a run: on the line, or smaller and below or above it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// On the line.
    Line,
    /// Below it, smaller.
    Sub,
    /// Above it, smaller.
    Super,
}

impl Level {
    /// Size of the letters, and the distance of their baseline below the line, in units of the size
    /// on the line.
    pub(super) fn scale_and_drop(self) -> (f64, f64) {
        match self {
            Self::Line => (1.0, 0.0),
            Self::Sub => (0.72, 0.16),
            Self::Super => (0.72, -0.36),
        }
    }
}

/// Longest subscript without braces.
const MOST_LETTERS: usize = 3;

/// The runs of a text, none of them empty.
pub fn runs(text: &str) -> Vec<(Level, String)> {
    let letters: Vec<char> = text.chars().collect();
    let mut runs: Vec<(Level, String)> = Vec::new();
    let mut push = |level: Level, part: String| match runs.last_mut() {
        Some(last) if last.0 == level => last.1 += &part,
        _ if part.is_empty() => {}
        _ => runs.push((level, part)),
    };
    let mut i = 0;
    while i < letters.len() {
        if let Some((level, part, next)) = script(&letters, i) {
            push(level, part);
            i = next;
        } else if let Some((factor, exponent, next)) = power(&letters, i) {
            push(Level::Line, factor);
            push(Level::Super, exponent);
            i = next;
        } else {
            push(Level::Line, letters[i].to_string());
            i += 1;
        }
    }
    runs
}

/// The subscript or superscript that begins with the mark at `at`, and where the text goes on.
fn script(letters: &[char], at: usize) -> Option<(Level, String, usize)> {
    let level = match letters[at] {
        '_' => Level::Sub,
        '^' => Level::Super,
        _ => return None,
    };
    let rest = &letters[at + 1..];
    let enclosed = |open: char, close: char| {
        let mut depth = 0;
        let end = rest.iter().position(|&c| {
            depth += i32::from(c == open) - i32::from(c == close);
            depth == 0
        })?;
        (rest[0] == open).then(|| (level, rest[1..end].iter().collect(), at + end + 2))
    };
    let word = |from: usize| rest[from..].iter().take_while(|c| c.is_alphanumeric()).count();
    match (level, rest.first()?) {
        (_, '{') => enclosed('{', '}'),
        (Level::Super, '(') => enclosed('(', ')'),
        (Level::Super, first) => {
            let sign = usize::from("-−+".contains(*first));
            let mut end = sign + word(sign);
            if rest.get(end) == Some(&'.') && end > sign {
                end += if word(end + 1) > 0 { 1 + word(end + 1) } else { 0 };
            }
            (end > sign).then(|| (level, signed(&rest[..end]), at + 1 + end))
        }
        _ => {
            let length = word(0);
            let symbol = at.checked_sub(1).is_some_and(|k| letters[k].is_alphabetic() && begins_word(letters, k));
            let fits = (1..=MOST_LETTERS).contains(&length) && rest.get(length) != Some(&'_');
            (symbol && fits).then(|| (level, rest[..length].iter().collect(), at + 1 + length))
        }
    }
}

/// Whether a word or number may begin at this letter: the one before belongs to none.
fn begins_word(letters: &[char], at: usize) -> bool {
    at == 0 || !(letters[at - 1].is_alphanumeric() || "_.:".contains(letters[at - 1]))
}

fn signed(letters: &[char]) -> String {
    letters.iter().collect::<String>().replace('-', "−")
}

/// A number such as `2.5e-7` that begins at `at`: what is set on the line, the exponent above it,
/// and where the text goes on.
fn power(letters: &[char], at: usize) -> Option<(String, String, usize)> {
    if !(letters[at].is_ascii_digit() && begins_word(letters, at)) {
        return None;
    }
    let digits = |from: usize| letters[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let mut end = at + digits(at);
    if letters.get(end) == Some(&'.') && digits(end + 1) > 0 {
        end += 1 + digits(end + 1);
    }
    let factor: String = letters[at..end].iter().collect();
    let sign = usize::from(letters.get(end + 1).is_some_and(|c| "-−+".contains(*c)));
    let from = end + 1;
    if letters.get(end) != Some(&'e') || letters.len() <= from + sign || digits(from + sign) == 0 {
        return None;
    }
    let next = from + sign + digits(from + sign);
    if letters.get(next).is_some_and(|c| c.is_alphanumeric()) {
        return None;
    }
    let exponent = signed(&letters[from..next]).replace('+', "");
    match (factor.as_str(), exponent.trim_start_matches('−').trim_start_matches('0')) {
        (_, "") => Some((factor, String::new(), next)),
        ("1", _) => Some(("10".to_owned(), exponent, next)),
        _ => Some((factor + "·10", exponent, next)),
    }
}
