//! Where in a TOML file a key stands, for errors.

use toml::de::{DeTable, DeValue};

/// The line, counted from 1, of the value at a dotted key such as `damping.surge.linear` or `event.2.at_s`
/// (tables of an array count from 0). `None` when there is none, or the text is no TOML.
pub(crate) fn line_of(text: &str, key: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let mut parts = key.split('.');
    let mut place = document.get_ref().get(parts.next()?)?;
    for part in parts {
        place = match place.get_ref() {
            DeValue::Table(table) => table.get(part)?,
            DeValue::Array(array) => array.get(part.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    let before = text.get(..place.span().start)?;
    Some(before.matches('\n').count() + 1)
}

/// ` (line 12)`, or nothing where the line is not known.
pub(crate) fn in_words(line: Option<usize>) -> String {
    line.map(|line| format!(" (line {line})")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_keys_in_tables_and_arrays() {
        let text = "a = 1\n[b]\nc = 2\nd.e = 3\n\n[[f]]\ng = 4\n[[f]]\nh = 5\n";
        for (key, line) in [("a", 1), ("b.c", 3), ("b.d.e", 4), ("f.0.g", 7), ("f.1.h", 9)] {
            assert_eq!(line_of(text, key), Some(line), "{key}");
        }
        assert_eq!(line_of(text, "f.1.g"), None);
        assert_eq!(line_of("a = [", "a"), None);
    }
}
