//! Scales and labels that all pictures share.

use plotters::prelude::RGBColor;

/// Points of a picture for one pixel on the screen: positions are whole numbers, and lines drawn on whole pixels are ragged.
pub(super) const FINE: u32 = 3;

/// So many pixels on the screen, in points.
pub(super) const fn px(pixels: u32) -> u32 {
    FINE * pixels
}

/// As [`px`], for positions.
pub(super) const fn at(pixels: i32) -> i32 {
    FINE as i32 * pixels
}

/// Grid lines.
pub(super) const GRID: RGBColor = RGBColor(225, 225, 225);

/// The power of 1000 by which numbers up to `largest` become readable in this unit: always one that has a prefix, where units have them.
pub(super) fn power_of_ten(largest: f64, unit: &str) -> i32 {
    if !(largest > 0.0 && largest.is_finite()) {
        return 0;
    }
    let power = 3 * (largest.log10() / 3.0).floor() as i32;
    if prefixed(unit, power).is_some() || !(0.01..10_000.0).contains(&largest) { power } else { 0 }
}

/// Prefixes of the SI by powers of ten.
const PREFIXES: [(&str, i32); 9] =
    [("p", -12), ("n", -9), ("µ", -6), ("m", -3), ("", 0), ("k", 3), ("M", 6), ("G", 9), ("T", 12)];

/// Units of the SI that take prefixes: "mm" and 3 is "m", "Pa" and 9 is "GPa"; `None` for any other label.
fn prefixed(unit: &str, power: i32) -> Option<String> {
    let base = ["Pa", "N", "m"].into_iter().find(|base| unit.ends_with(base))?;
    let own = match unit.strip_suffix(base)? {
        "u" | "\u{3bc}" => "µ",
        own => own,
    };
    let (_, before) = PREFIXES.into_iter().find(|(prefix, _)| *prefix == own)?;
    let (prefix, _) = PREFIXES.into_iter().find(|(_, p)| *p == before + power)?;
    // Nobody measures in kilometres or megametres here.
    (base != "m" || before + power <= 0).then(|| format!("{prefix}{base}"))
}

/// "depth (µm)", "depth (1e-6 length)": the quantity, its unit with the power taken out.
pub(super) fn named(quantity: &str, unit: &str, power: i32) -> String {
    match (quantity == unit, power) {
        (true, 0) => quantity.to_owned(),
        (true, power) => format!("{quantity} (1e{power})"),
        (false, power) => format!("{quantity} ({})", scaled(unit, power)),
    }
}

/// "µm", "1e-6 length", or the unit itself when no power was taken out.
pub(super) fn scaled(unit: &str, power: i32) -> String {
    if power == 0 {
        return unit.to_owned();
    }
    prefixed(unit, power).unwrap_or_else(|| format!("1e{power} {unit}"))
}

/// A tick, without trailing noise.
pub(super) fn tick(x: f64) -> String {
    let text = format!("{:.4}", x);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Three or four digits, for the end of a scale.
pub(super) fn brief(x: f64) -> String {
    let whole = x.abs().max(f64::MIN_POSITIVE).log10().floor() as i32;
    tick(format!("{x:.*}", (3 - whole).clamp(0, 4) as usize).parse().unwrap_or(x))
}

/// A step of 1, 2 or 5 times a power of ten that divides `largest` into at most `parts`.
pub(super) fn round_step(largest: f64, parts: f64) -> f64 {
    let decade = 10f64.powf(largest.log10().floor());
    let steps = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0].map(|m| m * decade);
    steps.into_iter().find(|step| largest / step <= parts).unwrap_or(10.0 * decade)
}

/// The power of ten that is no greater.
pub(super) fn decade_below(x: f64) -> f64 {
    10f64.powf(x.log10().floor())
}

/// The power of ten that is no less.
pub(super) fn decade_above(x: f64) -> f64 {
    10f64.powf(x.log10().ceil())
}

/// A decade of a logarithmic axis; what lies between is not written.
pub(super) fn decade(x: &f64) -> String {
    let power = x.log10().round();
    if (x / 10f64.powf(power) - 1.0).abs() < 1e-6 { format!("1e{power}") } else { String::new() }
}

/// Whether a character may stand in XML and HTML: no control characters, and none of those that Unicode has set aside for good
/// (U+FDD0 to U+FDEF and the last two of each plane).
pub(crate) fn is_text(c: char) -> bool {
    let code = u32::from(c);
    !c.is_control() && !(0xfdd0..=0xfdef).contains(&code) && code & 0xfffe != 0xfffe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_the_si_take_prefixes() {
        assert_eq!(named("x", "m", -6), "x (µm)");
        assert_eq!(named("force", "N", 3), "force (kN)");
        assert_eq!((scaled("mm", -3), scaled("MPa", 3), scaled("um", -3)), ("µm".into(), "GPa".into(), "nm".into()));
        assert_eq!(scaled("lbf/in²", 3), "1e3 lbf/in²");
        assert_eq!(named("x", "length", -6), "x (1e-6 length)");
        assert_eq!((power_of_ten(0.012, "m"), power_of_ten(0.012, "length")), (-3, 0));
        // No kilometres.
        assert_eq!(power_of_ten(5e3, "m"), 0);
        assert_eq!((brief(425.26), brief(1.18493), brief(0.01234)), ("425.3".into(), "1.185".into(), "0.0123".into()));
    }
}
