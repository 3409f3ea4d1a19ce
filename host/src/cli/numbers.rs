//! Parsers of numbers on command lines.

use std::fmt;
use std::ops::{Bound, RangeBounds, RangeInclusive};
use std::str::FromStr;

/// Returns the parser of a whole number within a range, `1..=8` or `1..`. The error names the
/// range.
pub fn whole<T>(
    range: impl RangeBounds<T> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + fmt::Display + 'static,
{
    move |text| {
        let number = text.trim().parse().ok();
        number
            .filter(|number| range.contains(number))
            .ok_or_else(|| match (range.start_bound(), range.end_bound()) {
                (Bound::Included(least), Bound::Included(most)) => {
                    format!("give a whole number from {least} to {most}")
                }
                (Bound::Included(least), _) => format!("give a whole number from {least} on"),
                _ => "give a whole number".to_owned(),
            })
    }
}

/// Returns the parser of any number; its user checks the range.
pub fn number<T: FromStr>(text: &str) -> Result<T, String> {
    let number = text.trim().parse();
    number.map_err(|_| "give a number, such as 1.5".to_owned())
}

/// Returns the parser of a number within a range. The error says what is `expected`.
pub fn within<T: FromStr + PartialOrd + Clone + Send + Sync + 'static>(
    range: RangeInclusive<T>,
    expected: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.trim().parse().ok();
        let number = number.filter(|number| range.contains(number));
        number.ok_or_else(|| format!("give {expected}"))
    }
}
