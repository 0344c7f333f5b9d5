//! What a user may choose about the file.

use std::fmt;
use std::str::FromStr;

/// Application protocol of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Schema {
    /// AP242 edition 1: later readers take it, and we use nothing newer.
    #[default]
    Ap242,
    /// AP214 (automotive design).
    Ap214,
    /// AP203 edition 1. Its schema knows neither colours nor measures, so the file has no colour
    /// and no validation properties; it has the approvals and persons that the schema demands.
    Ap203,
}

impl Schema {
    /// The name in FILE_SCHEMA.
    pub fn identifier(self) -> &'static str {
        match self {
            Schema::Ap242 => "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
            Schema::Ap214 => "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
            Schema::Ap203 => "CONFIG_CONTROL_DESIGN",
        }
    }
}

/// A date and time without a zone (written as UTC where the schema asks for one).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeStamp {
    pub year: u16,
    pub month: u8,
    pub day: u8,
    pub hour: u8,
    pub minute: u8,
    pub second: u8,
}

impl Default for TimeStamp {
    /// Fixed, so that equal input gives equal bytes.
    fn default() -> Self {
        TimeStamp { year: 2000, month: 1, day: 1, hour: 0, minute: 0, second: 0 }
    }
}

impl fmt::Display for TimeStamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TimeStamp { year, month, day, hour, minute, second } = self;
        write!(f, "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}")
    }
}

impl FromStr for TimeStamp {
    type Err = String;

    /// `YYYY-MM-DDThh:mm:ss`
    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("time stamp {text:?}: wanted YYYY-MM-DDThh:mm:ss");
        let shape = |(k, c): (usize, char)| match k {
            4 | 7 => c == '-',
            10 => c == 'T',
            13 | 16 => c == ':',
            _ => c.is_ascii_digit(),
        };
        if text.len() != 19 || !text.chars().enumerate().all(shape) {
            return Err(fault());
        }
        let two = |at: usize| text[at..at + 2].parse::<u8>().map_err(|_| fault());
        let year = text[..4].parse().map_err(|_| fault())?;
        let (month, day, hour, minute, second) = (two(5)?, two(8)?, two(11)?, two(14)?, two(17)?);
        let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let days = match month {
            2 => 28 + leap as u8,
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => 0,
        };
        if day == 0 || day > days || hour > 23 || minute > 59 || second > 59 {
            return Err(fault());
        }
        Ok(TimeStamp { year, month, day, hour, minute, second })
    }
}

/// How many digits points, weights and p-curves are written with. Centres, directions and radii keep every bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Digits {
    /// As many as keep gaps and angles far below what the file claims (see `Decimals::new`).
    Auto,
    /// So many decimals of a mm, at most 15.
    Decimals(u32),
    /// Every bit.
    #[default]
    All,
}

impl FromStr for Digits {
    type Err = String;

    /// `auto`, or a number of decimals from 6 to 15.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "auto" => Ok(Digits::Auto),
            Ok(decimals @ 6..=15) => Ok(Digits::Decimals(decimals)),
            _ => Err(format!("{text:?}: wanted `auto`, or a number of decimals from 6 to 15")),
        }
    }
}

/// Decimals of points (of a mm), and of weights and p-curves (of their own unit); none: every bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimals {
    pub points: Option<u32>,
    pub weights: Option<u32>,
}

/// A last decimal of the thinnest radius, with `Digits::Auto`. Reason: control points of a patch are a few hundredths of a radius apart, so tangent planes turn by
/// some 1e-8 rad; a thousandth of a degree (the bar for normal jumps) is a thousand times more.
const LAST_DECIMAL: f64 = 1e-10;

impl Decimals {
    pub const NONE: Decimals = Decimals { points: None, weights: None };

    /// `radii`: the least and the largest radius of the file, mm. Weights are about 1: an error there moves a point by so many radii.
    pub fn new(digits: Digits, radii: [f64; 2]) -> Self {
        let points = match digits {
            Digits::All => return Decimals::NONE,
            Digits::Decimals(decimals) => decimals as i32,
            Digits::Auto => -(LAST_DECIMAL * radii[0]).log10().floor() as i32,
        };
        let places = |decimals: i32| Some(decimals.clamp(0, 15) as u32);
        Decimals { points: places(points), weights: places(points + radii[1].log10().ceil() as i32) }
    }

    /// What rounding may add to the distance of two points, mm.
    pub fn off(self) -> f64 {
        self.points.map_or(0.0, |decimals| 2.0 * 10f64.powi(-(decimals as i32)))
    }
}

/// Everything about the file that the model does not say.
#[derive(Clone, Debug, PartialEq)]
pub struct StepOptions {
    pub schema: Schema,
    pub time_stamp: TimeStamp,
    /// Identifier and name of the product; must not be empty.
    pub product: String,
    pub author: String,
    pub organization: String,
    /// The name in the header; not a path.
    pub file_name: String,
    /// Colour of all solids: red, green, blue, 0 to 1.
    pub colour: [f64; 3],
    pub digits: Digits,
}

impl Default for StepOptions {
    fn default() -> Self {
        StepOptions {
            schema: Schema::default(),
            time_stamp: TimeStamp::default(),
            product: "lattice".into(),
            author: "unknown".into(),
            organization: "unknown".into(),
            file_name: "lattice.step".into(),
            colour: [0.62, 0.67, 0.72],
            digits: Digits::All,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_stamps_round_trip() {
        for text in ["2026-11-22T07:08:09", "2024-02-29T23:59:59"] {
            assert_eq!(text.parse::<TimeStamp>().unwrap().to_string(), text);
        }
        assert_eq!(TimeStamp::default().to_string(), "2000-01-01T00:00:00");
    }

    #[test]
    fn digits_follow_the_radii() {
        let of = |digits, radii| {
            let Decimals { points, weights } = Decimals::new(digits, radii);
            (points, weights)
        };
        assert_eq!(of(Digits::All, [1.0; 2]), (None, None));
        assert_eq!(of(Digits::Decimals(9), [0.5, 20.0]), (Some(9), Some(11)));
        assert_eq!(of(Digits::Auto, [1.0, 1.0]), (Some(10), Some(10)));
        assert_eq!(of(Digits::Auto, [0.5, 0.5]), (Some(11), Some(11)));
        assert_eq!(of(Digits::Auto, [0.002, 0.002]), (Some(13), Some(11)));
        assert_eq!(of(Digits::Auto, [1e-9, 1e9]), (Some(15), Some(15)));
        for text in ["", "5", "16", "-8", "all", "Auto"] {
            text.parse::<Digits>().unwrap_err();
        }
        assert_eq!(["auto", "12"].map(|text| text.parse::<Digits>().unwrap()), [Digits::Auto, Digits::Decimals(12)]);
    }

    #[test]
    fn bad_time_stamps_are_refused() {
        for text in ["", "2026-11-22", "2026-13-01T00:00:00", "2023-02-29T00:00:00", "2026-11-22T24:00:00", "2026-11-22 00:00:00", "2026-11-2éT00:00:0"] {
            text.parse::<TimeStamp>().unwrap_err();
        }
    }
}
