use std::str::FromStr;

/// What a model unit is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// Millimetre.
    #[default]
    Mm,
    /// Centimetre.
    Cm,
    /// Metre.
    M,
    /// Inch, 25.4 mm.
    In,
}

/// A unit that is none of mm, cm, m and in.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown unit \"{0}\"; units are mm, cm, m and in")]
pub struct UnknownUnit(String);

impl Unit {
    /// All units.
    pub const ALL: [Self; 4] = [Self::Mm, Self::Cm, Self::M, Self::In];

    /// Length of the unit in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Mm => 0.001,
            Self::Cm => 0.01,
            Self::M => 1.0,
            Self::In => 0.0254,
        }
    }

    /// Its symbol: mm, cm, m or in.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::In => "in",
        }
    }
}

impl FromStr for Unit {
    type Err = UnknownUnit;

    fn from_str(s: &str) -> Result<Self, UnknownUnit> {
        Self::ALL.into_iter().find(|u| u.symbol() == s).ok_or_else(|| UnknownUnit(s.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_name_the_units() {
        assert!(Unit::ALL.into_iter().all(|u| u.symbol().parse() == Ok(u)));
        assert_eq!(
            "ft".parse::<Unit>().unwrap_err().to_string(),
            "unknown unit \"ft\"; units are mm, cm, m and in"
        );
    }
}
