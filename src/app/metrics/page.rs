//! The text format of Prometheus (<https://prometheus.io/docs/instrumenting/exposition_formats/>, version 0.0.4).

use std::fmt::Write;

/// Figures as text.
#[derive(Debug, Default)]
pub(in crate::app) struct Page {
    text: String,
}

/// One family of figures under a name.
pub(in crate::app) struct Family<'a> {
    page: &'a mut Page,
    name: &'static str,
}

impl Page {
    /// A family of figures that go up and down. Its name ends in its unit.
    pub(in crate::app) fn gauge(&mut self, name: &'static str, help: &str) -> Family<'_> {
        self.family(name, "gauge", help)
    }

    /// A family of figures that only grow. Its name ends in `_total`.
    pub(in crate::app) fn counter(&mut self, name: &'static str, help: &str) -> Family<'_> {
        self.family(name, "counter", help)
    }

    fn family(&mut self, name: &'static str, kind: &str, help: &str) -> Family<'_> {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "# HELP {name} {help}\n# TYPE {name} {kind}");
        Family { page: self, name }
    }

    /// The whole page.
    pub(in crate::app) fn into_text(self) -> String {
        self.text
    }
}

impl Family<'_> {
    /// The one figure of a family without labels.
    pub(in crate::app) fn value(&mut self, value: f64) {
        let _ = writeln!(self.page.text, "{} {value}", self.name);
    }

    /// One figure of several.
    pub(in crate::app) fn with(&mut self, labels: &[(&str, &str)], value: f64) {
        let labels: Vec<String> =
            labels.iter().map(|(label, text)| format!("{label}=\"{}\"", escaped(text))).collect();
        let _ = writeln!(self.page.text, "{}{{{}}} {value}", self.name, labels.join(","));
    }
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_have_a_head_and_figures() {
        let mut page = Page::default();
        page.gauge("boat_speed_mps", "Speed over ground.").value(1.25);
        let mut bytes = page.counter("boat_bytes_total", "Bytes.");
        bytes.with(&[("link", "0"), ("peer", "a\"b\\c\n")], 12.0);
        bytes.with(&[("link", "1"), ("peer", "d")], f64::NAN);
        assert_eq!(
            page.into_text(),
            "# HELP boat_speed_mps Speed over ground.\n# TYPE boat_speed_mps gauge\nboat_speed_mps 1.25\n\
             # HELP boat_bytes_total Bytes.\n# TYPE boat_bytes_total counter\n\
             boat_bytes_total{link=\"0\",peer=\"a\\\"b\\\\c\\n\"} 12\nboat_bytes_total{link=\"1\",peer=\"d\"} NaN\n"
        );
    }
}
