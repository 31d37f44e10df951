//! Numbers and names that mean something, judged where they are read: so a mistake in a configuration file is told with
//! its line.

use std::fmt::Display;
use std::ops::RangeInclusive;

/// Reads a number within `range`; `what` says what the numbers are, for the complaint.
pub(super) fn number_in(
    range: RangeInclusive<f64>,
    what: impl Display + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("choose {} to {} {what}", range.start(), range.end()))
    }
}

/// Reads the name of a boat that comes with helmlink, or of a boat file: [`super::boat::load`] looks into it.
pub(super) fn boat(name: &str) -> Result<String, String> {
    if super::boat::is_file(name) {
        return Ok(name.to_owned());
    }
    super::boat::by_name(name).map(|_| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_out_of_every_range() {
        let read = number_in(2.0..=50.0, "Hz");
        assert_eq!(read("2"), Ok(2.0));
        assert_eq!(read("50.0"), Ok(50.0));
        for wrong in ["1.9", "51", "nan", "inf", "fast", ""] {
            assert_eq!(read(wrong), Err("choose 2 to 50 Hz".to_owned()), "{wrong}");
        }
    }
}
