//! Pieces of a page. Everything that a scene can say passes through [`escaped`].

use std::fmt::Write;

use crate::plot::is_text;

/// Text as it may stand in HTML, between tags and within quotes.
pub(super) fn escaped(text: &str) -> String {
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
    out
}

/// Text, escaped, with the exponents of its numbers raised: 1.5e-3 is 1.5 x 10^-3.
pub(super) fn typeset(text: &str) -> String {
    let part_of_number = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '+' | '-' | '_');
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let alike = part_of_number(first);
        let end = rest.find(|c: char| part_of_number(c) != alike).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        // A full stop at the end of a sentence is no part of the number before it.
        let word = piece.trim_end_matches('.');
        if alike {
            out.push_str(&(number(word) + &piece[word.len()..]))
        } else {
            out.push_str(&escaped(piece))
        }
        rest = after;
    }
    out
}

/// A number with its exponent raised; any other word as it is.
fn number(text: &str) -> String {
    match text.split_once('e') {
        Some((mantissa, power)) if text.parse::<f64>().is_ok() => {
            let power: i32 = power.parse().unwrap_or(0);
            let mantissa = mantissa.replace('-', "\u{2212}");
            if power == 0 {
                return mantissa;
            }
            let sign = if power < 0 { "\u{2212}" } else { "" };
            if mantissa == "1" {
                return format!("10<sup>{sign}{}</sup>", power.unsigned_abs());
            }
            format!("{mantissa}\u{202f}·\u{202f}10<sup>{sign}{}</sup>", power.unsigned_abs())
        }
        _ if text.parse::<f64>().is_ok() => text.replace('-', "\u{2212}"),
        _ => escaped(text),
    }
}

/// What stands in a cell: numbers to the right, words to the left.
fn cell(text: &str) -> String {
    if text == "-" {
        return "<td class=\"n soft\">–</td>".to_owned();
    }
    let class = if text.parse::<f64>().is_ok() { " class=\"n\"" } else { "" };
    format!("<td{class}>{}</td>", typeset(text))
}

/// Columns beyond which a table is set smaller.
const WIDE: usize = 10;

/// A table with a line of heads; `marked` says which lines stand out.
pub(super) fn table(heads: &[&str], rows: &[Vec<String>], marked: impl Fn(usize) -> bool) -> String {
    let wide = if heads.len() > WIDE { " class=\"wide\"" } else { "" };
    let mut out = format!("<div class=\"scroll\"><table{wide}><thead><tr>");
    for (k, head) in heads.iter().enumerate() {
        let numbers = rows.iter().any(|row| row[k].parse::<f64>().is_ok());
        let _ = write!(out, "<th{}>{}</th>", if numbers { " class=\"n\"" } else { "" }, escaped(head));
    }
    out.push_str("</tr></thead><tbody>");
    for (k, row) in rows.iter().enumerate() {
        out.push_str(if marked(k) { "<tr class=\"front\">" } else { "<tr>" });
        row.iter().for_each(|text| out.push_str(&cell(text)));
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table></div>\n");
    out
}

/// A table of names and values.
pub(super) fn facts(rows: &[(&str, String)]) -> String {
    let mut out = "<div class=\"scroll\"><table><tbody>".to_owned();
    for (name, value) in rows {
        let _ = writeln!(out, "<tr><th>{}</th><td class=\"wrap\">{}</td></tr>", escaped(name), typeset(value));
    }
    out.push_str("</tbody></table></div>\n");
    out
}

/// Sentences as a list; nothing when there are none.
pub(super) fn list<'a>(sentences: impl IntoIterator<Item = &'a str>) -> String {
    let items: String = sentences.into_iter().map(|s| format!("<li>{}</li>\n", typeset(s))).collect();
    if items.is_empty() { items } else { format!("<ul>{items}</ul>\n") }
}

/// An SVG picture within the page, for wide and for narrow screens, with its caption.
pub(super) fn figure(svgs: [&[u8]; 2], caption: &str) -> String {
    format!("<figure>{}<figcaption>{}</figcaption></figure>\n", both(svgs, caption), typeset(caption))
}

/// The same picture for wide and for narrow screens: one of them is shown.
pub(super) fn both(svgs: [&[u8]; 2], named: &str) -> String {
    let classes = ["page", "phone"];
    let one = |k: usize| {
        let tag = format!("<svg class=\"{}\" role=\"img\" aria-label=\"{}\" ", classes[k], escaped(named));
        String::from_utf8_lossy(svgs[k]).replacen("<svg ", &tag, 1)
    };
    one(0) + &one(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_name_is_markup() {
        assert_eq!(escaped("<b> & \"x\" 'y'\u{7}"), "&lt;b&gt; &amp; &quot;x&quot; &#39;y&#39;\u{fffd}");
        assert_eq!(
            escaped("\u{fffe}\u{ffff}\u{1ffff}\u{fdd0}é\u{1f600}"),
            "\u{fffd}\u{fffd}\u{fffd}\u{fffd}é\u{1f600}"
        );
    }

    #[test]
    fn exponents_are_raised() {
        assert_eq!(typeset("-1.5e-3"), "\u{2212}1.5\u{202f}·\u{202f}10<sup>\u{2212}3</sup>");
        assert_eq!(typeset("2.0e0"), "2.0");
        assert_eq!(typeset("one < e"), "one &lt; e");
        assert_eq!(typeset("12"), "12");
        assert_eq!(typeset("known to 1e-5."), "known to 10<sup>\u{2212}5</sup>.");
        assert_eq!(typeset("(1.5, -2) & height_map-3"), "(1.5, \u{2212}2) &amp; height_map-3");
    }
}
