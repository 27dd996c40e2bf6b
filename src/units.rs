//! Labels of the units that a user's numbers are in. Numbers are never converted.

use crate::error::InputError;

/// Longest label.
const LONGEST: usize = 16;

/// Labels of the units of length and force; those of pressure, stiffness, energy and area follow from them.
///
/// ```
/// use contact_patch::UnitLabels;
/// let units = UnitLabels::new("mm", "N")?;
/// assert_eq!((units.pressure().as_str(), units.stiffness().as_str(), units.area().as_str()), ("MPa", "N/mm", "mm²"));
/// assert_eq!(UnitLabels::new("in", "lbf")?.pressure(), "lbf/in²");
/// assert_eq!(UnitLabels::new("", "N").unwrap_err().path, "length");
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitLabels {
    length: String,
    force: String,
}

impl UnitLabels {
    /// Labels of 1 to 16 characters each.
    ///
    /// # Errors
    /// Names `length` or `force` when empty, longer, or with control characters, quotes, commas or line ends.
    pub fn new(length: &str, force: &str) -> Result<Self, InputError> {
        let checked = |name: &str, label: &str| {
            let plain = |c: char| !c.is_control() && !matches!(c, '"' | ',' | ';' | '*' | '\\' | '<' | '>' | '&');
            let count = label.chars().count();
            if (1..=LONGEST).contains(&count) && label.chars().all(plain) && label.trim() == label {
                return Ok(label.to_owned());
            }
            let given = format!("{:?}", label.chars().take(2 * LONGEST).collect::<String>());
            Err(InputError::new(name, given, format!("a label of 1 to {LONGEST} characters, such as \"mm\" or \"N\"")))
        };
        Ok(Self { length: checked("length", length)?, force: checked("force", force)? })
    }

    /// The kinds of units in place of labels, for pictures whose units nobody named.
    #[must_use]
    pub fn kinds() -> Self {
        Self { length: "length".to_owned(), force: "force".to_owned() }
    }

    /// Of a length.
    #[must_use]
    pub fn length(&self) -> &str {
        &self.length
    }

    /// Of a force.
    #[must_use]
    pub fn force(&self) -> &str {
        &self.force
    }

    /// Of a force over an area: pascals where length and force make them.
    #[must_use]
    pub fn pressure(&self) -> String {
        match (self.length.as_str(), self.force.as_str()) {
            ("m", "N") => "Pa".to_owned(),
            ("mm", "N") => "MPa".to_owned(),
            ("um" | "µm" | "μm", "uN" | "µN" | "μN") => "MPa".to_owned(),
            ("nm", "nN") => "GPa".to_owned(),
            (length, force) => format!("{force}/{length}²"),
        }
    }

    /// Of a force over a length.
    #[must_use]
    pub fn stiffness(&self) -> String {
        format!("{}/{}", self.force, self.length)
    }

    /// Of a force times a length: energies and moments.
    #[must_use]
    pub fn work(&self) -> String {
        format!("{} {}", self.force, self.length)
    }

    /// Of a length squared.
    #[must_use]
    pub fn area(&self) -> String {
        format!("{}²", self.length)
    }
}
