//! What a formula that cannot be read was probably meant to be.

/// Advice about the text from byte `at` on, where reading ended; `is_function` knows the names of functions.
pub(super) fn advice(text: &str, at: usize, is_function: impl Fn(&str) -> bool) -> Option<String> {
    let (before, rest) = (text[..at].trim_end(), text[at..].trim_start());
    let next = rest.chars().next()?;
    let last = before.chars().next_back();
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let conditions = ["if", "and", "or", "then", "else", "where"];
    let has = |word: &str| text.split(|c: char| !c.is_alphanumeric()).any(|w| w.eq_ignore_ascii_case(word));
    if matches!(next, '<' | '>' | '?' | '&' | '!') || conditions.contains(&word(rest).as_str()) || has("if") {
        return Some(CONDITIONS.into());
    }
    match next {
        '|' => Some("an absolute value is written abs(x)".into()),
        '²' | '³' | '\u{2070}'..='\u{207f}' => Some("a power is written x^2".into()),
        '·' | '×' | '\u{2219}' | '\u{22c5}' => Some("a product is written 2*x".into()),
        '−' | '–' => Some("a minus is written -".into()),
        '=' => Some("the gap alone, without \"z =\" before it".into()),
        ',' if last.is_some_and(|c| c.is_ascii_digit()) && rest[1..].starts_with(|c: char| c.is_ascii_digit()) => {
            Some("a number has a decimal point, not a comma: 0.5".into())
        }
        c if c.is_alphanumeric() || c == '(' => {
            let name = before.chars().rev().take_while(|c| c.is_ascii_alphanumeric()).count();
            let name = &before[before.len() - name..];
            if is_function(name) {
                return Some(format!("a function needs its parentheses: {name}(...)"));
            }
            last.filter(|l| l.is_alphanumeric() || *l == ')').map(|_| "a product is written with a star: 2*x".into())
        }
        _ => None,
    }
}

/// What to say of a name that is none.
pub(super) fn of_name(word: &str) -> Option<String> {
    Some(match word {
        "X" | "Y" | "R" | "THETA" | "Theta" => format!("did you mean {}?", word.to_ascii_lowercase()),
        "PI" | "Pi" => "did you mean pi?".into(),
        "z" | "h" | "g" => "the formula is the height of the gap itself".into(),
        "phi" | "t" => "did you mean theta, the angle from x?".into(),
        "rho" => "did you mean r, the distance from the origin?".into(),
        "if" | "where" | "and" | "or" => CONDITIONS.into(),
        _ => return None,
    })
}

/// What to say of a function that is none.
pub(super) fn of_function(word: &str) -> Option<String> {
    Some(match word {
        "if" | "where" | "iif" | "piecewise" | "heaviside" | "step" => CONDITIONS.into(),
        "arcsin" | "arccos" | "arctan" | "arctan2" => format!("did you mean {}?", word.replacen("arc", "a", 1)),
        "sqr" | "square" => "a square is written x^2".into(),
        "root" => "did you mean sqrt?".into(),
        "power" => "did you mean pow?".into(),
        "fabs" | "Abs" => "did you mean abs?".into(),
        "lg" => "did you mean log10?".into(),
        "sgn" => "did you mean sign?".into(),
        _ => return None,
    })
}

const CONDITIONS: &str = "there are no conditions: max(a, b), min(a, b), abs(a) and sign(a) make kinks and steps, and \"region\" ends a body";
