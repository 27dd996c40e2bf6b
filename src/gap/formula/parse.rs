//! From text to tape, by the grammar in `grammar.pest` (pest, with its Pratt parser for the order of operations).

use std::sync::LazyLock;

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::{Pair, Pairs};
use pest::pratt_parser::{Assoc, Op as Binds, PrattParser};

use super::advice;
use super::functions::{One, Two};
use super::tape::{Op, STACK, Tape};
use crate::error::InputError;

/// Longest formula in bytes, deepest nesting of parentheses, most powers: bounds on the recursion of the parser.
const LONGEST: usize = 4000;
const DEEPEST: usize = 64;
const MOST_POWERS: usize = 200;

const VARIABLES: [&str; 4] = ["x", "y", "r", "theta"];

#[derive(pest_derive::Parser)]
#[grammar = "gap/formula/grammar.pest"]
struct Grammar;

static PRECEDENCE: LazyLock<PrattParser<Rule>> = LazyLock::new(|| {
    PrattParser::new()
        .op(Binds::infix(Rule::sum, Assoc::Left) | Binds::infix(Rule::difference, Assoc::Left))
        .op(Binds::infix(Rule::product, Assoc::Left) | Binds::infix(Rule::quotient, Assoc::Left))
        .op(Binds::prefix(Rule::negation))
        .op(Binds::infix(Rule::power, Assoc::Right))
});

/// A name and the function it stands for.
enum Called {
    One(One),
    Two(Two),
    /// Of two or more.
    Several(Two),
}

/// Whether there is a function of this name.
pub(super) fn is_function(name: &str) -> bool {
    called(name).is_some()
}

fn called(name: &str) -> Option<Called> {
    Some(match name {
        "abs" => Called::One(One::Abs),
        "sign" | "signum" => Called::One(One::Sign),
        "sqrt" => Called::One(One::Sqrt),
        "cbrt" => Called::One(One::Cbrt),
        "exp" => Called::One(One::Exp),
        "ln" | "log" => Called::One(One::Ln),
        "log10" => Called::One(One::Log10),
        "log2" => Called::One(One::Log2),
        "sin" => Called::One(One::Sin),
        "cos" => Called::One(One::Cos),
        "tan" => Called::One(One::Tan),
        "asin" => Called::One(One::Asin),
        "acos" => Called::One(One::Acos),
        "atan" => Called::One(One::Atan),
        "sinh" => Called::One(One::Sinh),
        "cosh" => Called::One(One::Cosh),
        "tanh" => Called::One(One::Tanh),
        "floor" => Called::One(One::Floor),
        "ceil" => Called::One(One::Ceil),
        "atan2" => Called::Two(Two::Atan2),
        "hypot" => Called::Two(Two::Hypot),
        "pow" => Called::Two(Two::Power),
        "min" => Called::Several(Two::Min),
        "max" => Called::Several(Two::Max),
        _ => return None,
    })
}

/// The formula as a tape; errors name `expression` and the column, counted in characters from 1.
pub(super) fn parse(text: &str) -> Result<Tape, InputError> {
    let refuse = |given: String, allowed: &str| InputError::new("expression", given, allowed);
    if text.trim().is_empty() {
        return Err(refuse("an empty formula".into(), "a formula such as x^2/2 + 0.1*abs(y)^3"));
    }
    if text.len() > LONGEST {
        return Err(refuse(format!("a formula of {} bytes", text.len()), &format!("at most {LONGEST} bytes")));
    }
    let powers = text.matches('^').count() + text.matches("**").count();
    if powers > MOST_POWERS {
        return Err(refuse(format!("a formula with {powers} powers"), &format!("at most {MOST_POWERS} of them")));
    }
    let mut open = 0_usize;
    for (at, c) in text.char_indices() {
        match c {
            '(' => open += 1,
            ')' => open = open.saturating_sub(1),
            _ => {}
        }
        if open > DEEPEST {
            let allowed = format!("at most {DEEPEST} parentheses inside one another");
            return Err(refuse(format!("`(` at column {}", column(text, at)), &allowed));
        }
    }
    let pairs = Grammar::parse(Rule::formula, text).map_err(|error| {
        let at = match error.location {
            InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
        };
        let mut wanted = match error.variant {
            ErrorVariant::ParsingError { positives, .. } => positives,
            ErrorVariant::CustomError { .. } => Vec::new(),
        };
        wanted.sort();
        let mut wanted: Vec<&str> = wanted.into_iter().map(plainly).collect();
        wanted.dedup();
        let unclosed = text[..at].matches('(').count() > text[..at].matches(')').count();
        if unclosed && wanted.contains(&"an operator") {
            wanted.push("a closing parenthesis");
        }
        let expected = format!("expected {}", wanted.join(" or "));
        refuse(
            place(text, at),
            &advice::advice(text, at, is_function).map_or(expected.clone(), |advice| format!("{expected}; {advice}")),
        )
    })?;
    let mut tape = Tape::default();
    emit(text, pairs, &mut tape)?;
    if tape.fits() {
        Ok(tape)
    } else {
        let allowed = format!("a formula in which at most {STACK} operands wait for one another");
        Err(refuse(format!("a formula of {} operations", tape.ops().len()), &allowed))
    }
}

/// What the grammar wanted, in words.
fn plainly(rule: Rule) -> &'static str {
    match rule {
        Rule::sum | Rule::difference | Rule::product | Rule::quotient | Rule::power | Rule::EOI => "an operator",
        _ => "a number, a variable, a function or an opening parenthesis",
    }
}

/// What is allowed, after what was probably meant.
fn with(allowed: &str, advice: Option<String>) -> String {
    advice.map_or(allowed.to_owned(), |advice| format!("{advice}; {allowed}"))
}

fn column(text: &str, at: usize) -> usize {
    text[..at].chars().count() + 1
}

/// The next few characters and where they stand.
fn place(text: &str, at: usize) -> String {
    let next: String = text[at..].chars().take(12).collect();
    if next.trim().is_empty() {
        format!("the end of `{text}` at column {}", column(text, at))
    } else {
        format!("`{next}` at column {}", column(text, at))
    }
}

/// Reads the tree in the order of operations and appends it to the tape.
fn emit(text: &str, pairs: Pairs<'_, Rule>, tape: &mut Tape) -> Result<(), InputError> {
    // The Pratt parser builds operands before their operator; each piece is the list of its operations.
    let ops = PRECEDENCE
        .map_primary(|pair| operand(text, pair))
        .map_prefix(|sign, a| {
            let mut a = a?;
            if sign.as_str() == "-" {
                a.push(Op::One(One::Negate));
            }
            Ok(a)
        })
        .map_infix(|a, operator, b| {
            let mut a = a?;
            a.extend(b?);
            a.push(Op::Two(match operator.as_rule() {
                Rule::sum => Two::Add,
                Rule::difference => Two::Subtract,
                Rule::product => Two::Multiply,
                Rule::quotient => Two::Divide,
                _ => Two::Power,
            }));
            Ok(a)
        })
        .parse(pairs.filter(|pair| pair.as_rule() != Rule::EOI))?;
    ops.into_iter().for_each(|op| tape.push(op));
    Ok(())
}

fn operand(text: &str, pair: Pair<'_, Rule>) -> Result<Vec<Op>, InputError> {
    let at = column(text, pair.as_span().start());
    let refuse = |given: String, allowed: &str| Err(InputError::new("expression", given, allowed));
    let word = pair.as_str();
    match pair.as_rule() {
        Rule::number => match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(vec![Op::Constant(value)]),
            _ => refuse(format!("`{word}` at column {at}"), "a number that fits"),
        },
        Rule::name => match (VARIABLES.iter().position(|v| *v == word), word) {
            (Some(k), _) => Ok(vec![Op::Variable(k)]),
            (None, "pi") => Ok(vec![Op::Constant(std::f64::consts::PI)]),
            (None, "e") => Ok(vec![Op::Constant(std::f64::consts::E)]),
            _ if called(word).is_some() => {
                refuse(format!("`{word}` at column {at}"), &format!("a function needs its parentheses: {word}(...)"))
            }
            _ => {
                let known = "the variables are x, y, r, theta and the constants pi, e; others are written as numbers";
                refuse(format!("`{word}` at column {at}"), &with(known, advice::of_name(word)))
            }
        },
        Rule::call => {
            let mut inner = pair.into_inner();
            let name = inner.next().map_or("", |function| function.as_str());
            let arguments = inner.map(|argument| operand(text, argument)).collect::<Result<Vec<_>, _>>()?;
            let Some(function) = called(name) else {
                let allowed = "the functions are abs, sign, sqrt, cbrt, exp, ln, log, log10, log2, sin, cos, tan, asin, \
                               acos, atan, sinh, cosh, tanh, floor, ceil, min, max, pow, atan2, hypot";
                return refuse(format!("`{name}` at column {at}"), &with(allowed, advice::of_function(name)));
            };
            let count = arguments.len();
            let (fits, wanted) = match function {
                Called::One(_) => (count == 1, "one argument"),
                Called::Two(_) => (count == 2, "two arguments"),
                Called::Several(_) => (count >= 2, "two or more arguments"),
            };
            if !fits {
                let given = format!("{count} argument{} of `{name}` at column {at}", if count == 1 { "" } else { "s" });
                return refuse(given, &format!("{name} takes {wanted}"));
            }
            let mut ops = Vec::new();
            for (k, argument) in arguments.into_iter().enumerate() {
                ops.extend(argument);
                match function {
                    Called::One(f) => ops.push(Op::One(f)),
                    Called::Two(f) | Called::Several(f) if k > 0 => ops.push(Op::Two(f)),
                    _ => {}
                }
            }
            Ok(ops)
        }
        _ => {
            let mut tape = Tape::default();
            emit(text, pair.into_inner(), &mut tape)?;
            Ok(tape.ops().to_vec())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        parse(text).unwrap_or_else(|e| panic!("{text}: {e}")).run([3.0, 5.0, 34f64.sqrt(), 5f64.atan2(3.0)])
    }

    #[test]
    fn order_of_operations_is_that_of_mathematics() {
        for (text, expected) in [
            ("-x^2", -9.0),
            ("(-x)^2", 9.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("2**-x*4", 0.5),
            ("-2^-x^2*512", -1.0),
            ("x - y - 1", -3.0),
            ("x/2/3", 0.5),
            ("1/(1+x)/2", 0.125),
            ("x*-y", -15.0),
            ("x - -y", 8.0),
            ("--x", 3.0),
            ("+x", 3.0),
            ("1e-3*x", 3e-3),
            ("1.5E+2 + .5 + 2.", 152.5),
            ("max(min(x, 1), y)", 5.0),
            ("max(1+min(x,y), max(x, y+1)/2)", 4.0),
            ("max(1, 2, x, 2.5)", 3.0),
            ("pow(x, 2) + hypot(x, 4)", 14.0),
            ("cos(pi)*ln(e)", -1.0),
            ("r^2", 34.0),
            ("r*cos(theta)", 3.0),
            ("abs(-x)^3 + sign(-y)", 26.0),
            (" x\n + y ", 8.0),
            ("max (x,y)", 5.0),
        ] {
            let got = value(text);
            assert!((got - expected).abs() < 1e-13 * expected.abs(), "{text}: {got} {expected}");
        }
    }

    #[test]
    fn errors_say_where() {
        for (text, wanted) in [
            ("", "empty"),
            ("x^^2", "`^2` at column 3"),
            ("2x", "`x` at column 2"),
            ("(x", "column 3"),
            ("x)", "`)` at column 2"),
            ("x +", "end of"),
            ("1..2", "column 3"),
            ("é", "`é` at column 1"),
            ("x + é", "column 5"),
            ("sin x", "`x` at column 5"),
            ("sin", "sin(...)"),
            ("foo(x)", "`foo` at column 1"),
            ("x + t", "`t` at column 5"),
            ("max(x)", "two or more"),
            ("sqrt(x, y)", "one argument"),
            ("max(x,,y)", "column 7"),
            ("sin()", "column 5"),
            ("1e999", "fits"),
            ("x; y", "column 2"),
        ] {
            let error = parse(text).unwrap_err();
            assert_eq!(error.path, "expression");
            assert!(error.to_string().contains(wanted), "{text}: {error}");
        }
        assert!(parse(&"(".repeat(10_000)).is_err());
        assert!(parse(&"(".repeat(3_000)).is_err());
        assert!(parse(&format!("{}x{}", "(".repeat(64), ")".repeat(64))).is_ok());
        assert!(parse(&format!("x{}", "^x".repeat(1900))).is_err());
        assert!(parse(&format!("x{}", "^(x)".repeat(900))).is_err());
        // As deep as the parser recurses.
        assert!(parse(&format!("{}x^2{}", "-(-(x^".repeat(32), "))".repeat(32))).is_ok());
        assert!(parse(&format!("x{}", "^y".repeat(200))).is_err_and(|e| e.to_string().contains("wait")));
        assert!(parse(&format!("{}x", "-".repeat(3900))).is_err());
        assert!(parse(&format!("x{}", "+x".repeat(1900))).is_ok());
    }
}
