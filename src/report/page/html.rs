//! Pieces of a page: [`html!`] makes them from literals, and escapes everything that is put into these.

use std::fmt::{Display, Formatter, Result};

use crate::plot::is_text;

/// A piece of a page.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Html(String);

/// A piece of a page from a literal, with what goes into its places: pieces as they are, all else escaped. What the literal names in
/// braces is refused by the compiler: it would not be escaped.
macro_rules! html {
    ($text:literal $(, $part:expr)* $(,)?) => {
        $crate::report::page::html::Html::markup(format!(concat!($text) $(, $crate::report::page::html::Part::part(&$part))*))
    };
}
pub(super) use html;

/// What may stand in a place of [`html!`].
pub(super) trait Part {
    fn part(&self) -> Html;
}

impl Part for Html {
    fn part(&self) -> Html {
        self.clone()
    }
}

impl Part for str {
    fn part(&self) -> Html {
        escaped(self)
    }
}

impl Part for String {
    fn part(&self) -> Html {
        escaped(self)
    }
}

impl Part for usize {
    fn part(&self) -> Html {
        escaped(&self.to_string())
    }
}

impl<T: Part + ?Sized> Part for &T {
    fn part(&self) -> Html {
        (*self).part()
    }
}

impl Display for Html {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(&self.0)
    }
}

impl FromIterator<Html> for Html {
    fn from_iter<I: IntoIterator<Item = Html>>(pieces: I) -> Self {
        Self(pieces.into_iter().map(|piece| piece.0).collect())
    }
}

impl Html {
    /// Markup that is not made from a scene's texts: pictures, styles, scripts.
    pub fn markup(text: impl Into<String>) -> Self {
        Self(text.into())
    }

    pub fn push(&mut self, piece: &Self) {
        self.0.push_str(&piece.0);
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn into_string(self) -> String {
        self.0
    }
}

/// Text as it may stand in HTML, between tags and within quotes.
fn escaped(text: &str) -> Html {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // What may not stand in a document is shown as missing.
            '\n' | '\t' => out.push(c),
            c => out.push(if is_text(c) { c } else { '\u{fffd}' }),
        }
    }
    Html(out)
}

/// Text with the exponents of its numbers raised: 1.5e-3 is 1.5 x 10^-3.
pub(super) fn typeset(text: &str) -> Html {
    let part_of_number = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '+' | '-' | '_');
    let mut out = Html::default();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let alike = part_of_number(first);
        let end = rest.find(|c: char| part_of_number(c) != alike).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        // A full stop at the end of a sentence is no part of the number before it.
        let word = piece.trim_end_matches('.');
        if alike {
            out.push(&number(word));
            out.push(&escaped(&piece[word.len()..]));
        } else {
            out.push(&escaped(piece));
        }
        rest = after;
    }
    out
}

/// A number with its exponent raised; any other word as it is.
fn number(text: &str) -> Html {
    let minus = |text: &str| text.replace('-', "\u{2212}");
    match text.split_once('e') {
        Some((mantissa, power)) if text.parse::<f64>().is_ok() => match (minus(mantissa), power.parse().unwrap_or(0)) {
            (mantissa, 0) => escaped(&mantissa),
            (mantissa, power) => {
                let raised = html!("10<sup>{}</sup>", minus(&i32::to_string(&power)));
                if mantissa == "1" { raised } else { html!("{}\u{202f}·\u{202f}{}", mantissa, raised) }
            }
        },
        _ if text.parse::<f64>().is_ok() => escaped(&minus(text)),
        _ => escaped(text),
    }
}

/// What stands in a cell: numbers to the right, words to the left.
fn cell(text: &str) -> Html {
    match text {
        "-" => html!("<td class=\"n soft\">–</td>"),
        number if number.parse::<f64>().is_ok() => html!("<td class=\"n\">{}</td>", typeset(number)),
        word => html!("<td>{}</td>", typeset(word)),
    }
}

/// Columns beyond which a table is set smaller.
const WIDE: usize = 10;

/// A table with a line of heads; `marked` says which lines stand out.
pub(super) fn table(heads: &[&str], rows: &[Vec<String>], marked: impl Fn(usize) -> bool) -> Html {
    let head = |(k, head): (usize, &&str)| {
        let numbers = rows.iter().any(|row| row[k].parse::<f64>().is_ok());
        if numbers { html!("<th class=\"n\">{}</th>", head) } else { html!("<th>{}</th>", head) }
    };
    let line = |(k, row): (usize, &Vec<String>)| {
        let cells: Html = row.iter().map(|text| cell(text)).collect();
        if marked(k) { html!("<tr class=\"front\">{}</tr>\n", cells) } else { html!("<tr>{}</tr>\n", cells) }
    };
    html!(
        "<div class=\"scroll\"><table{}><thead><tr>{}</tr></thead><tbody>{}</tbody></table></div>\n",
        Html::markup(if heads.len() > WIDE { " class=\"wide\"" } else { "" }),
        heads.iter().enumerate().map(head).collect::<Html>(),
        rows.iter().enumerate().map(line).collect::<Html>()
    )
}

/// A table of names and values.
pub(super) fn facts<'a>(rows: impl IntoIterator<Item = (&'a str, Html)>) -> Html {
    let line = |(name, value)| html!("<tr><th>{}</th><td class=\"wrap\">{}</td></tr>\n", name, value);
    let lines: Html = rows.into_iter().map(line).collect();
    html!("<div class=\"scroll\"><table><tbody>{}</tbody></table></div>\n", lines)
}

/// Sentences as a list; nothing when there are none.
pub(super) fn list<'a>(sentences: impl IntoIterator<Item = &'a str>) -> Html {
    let items: Html = sentences.into_iter().map(|s| html!("<li>{}</li>\n", typeset(s))).collect();
    if items.is_empty() { items } else { html!("<ul>{}</ul>\n", items) }
}

/// An SVG picture within the page, for wide and for narrow screens, with its caption.
pub(super) fn figure(svgs: [&[u8]; 2], caption: &str) -> Html {
    html!("<figure>{}<figcaption>{}</figcaption></figure>\n", both(svgs, caption), typeset(caption))
}

/// The same picture for wide and for narrow screens: one of them is shown.
pub(super) fn both(svgs: [&[u8]; 2], named: &str) -> Html {
    let classes = ["page", "phone"];
    let one = |k: usize| {
        let tag = html!("<svg class=\"{}\" role=\"img\" aria-label=\"{}\" ", classes[k], named);
        Html::markup(String::from_utf8_lossy(svgs[k]).replacen("<svg ", &tag.0, 1))
    };
    (0..2).map(one).collect()
}

/// A section with its heading; nothing where there is nothing to say.
pub(super) fn section(heading: &str, told: Html) -> Html {
    if told.is_empty() { told } else { html!("<section>\n<h2>{}</h2>\n{}</section>\n", heading, told) }
}

#[cfg(test)]
mod tests {

    #[test]
    fn nothing_in_a_name_is_markup() {
        let told = |text: &str| html!("{}", text).into_string();
        assert_eq!(told("<b> & \"x\" 'y'\u{7}"), "&lt;b&gt; &amp; &quot;x&quot; &#39;y&#39;\u{fffd}");
        assert_eq!(told("\u{fffe}\u{ffff}\u{1ffff}\u{fdd0}é\u{1f600}"), "\u{fffd}\u{fffd}\u{fffd}\u{fffd}é\u{1f600}");
        assert_eq!(html!("<b>{}</b>", html!("<i>{}</i>", "&")).into_string(), "<b><i>&amp;</i></b>");
    }

    #[test]
    fn exponents_are_raised() {
        let typeset = |text: &str| super::typeset(text).into_string();
        assert_eq!(typeset("-1.5e-3"), "\u{2212}1.5\u{202f}·\u{202f}10<sup>\u{2212}3</sup>");
        assert_eq!(typeset("2.0e0"), "2.0");
        assert_eq!(typeset("one < e"), "one &lt; e");
        assert_eq!(typeset("12"), "12");
        assert_eq!(typeset("known to 1e-5."), "known to 10<sup>\u{2212}5</sup>.");
        assert_eq!(typeset("(1.5, -2) & height_map-3"), "(1.5, \u{2212}2) &amp; height_map-3");
    }
}
