//! A run as a page that needs nothing else: no network, no script, light and dark, wide and narrow.

use std::fmt::Write as _;

use super::charts::{self, TimeAxis};
use super::svg::{Area, Svg};
use super::{Run, legend, map, tables, theme};

/// Width of the map, pixels; it shrinks with the page.
const MAP_WIDTH: f64 = 640.0;
/// Height of the map without its legend, pixels.
const MAP_HEIGHT: f64 = 520.0;
/// Width of a chart, pixels: little more than a phone's, so that its letters stay legible there.
const CHART_WIDTH: f64 = 460.0;
/// Height of a chart, pixels.
const CHART_HEIGHT: f64 = 230.0;

/// Colours follow the reader's choice of light or dark; pictures drawn for light paper are turned over in the dark
/// with their hues kept.
const STYLE: &str = "\
:root{color-scheme:light dark;--paper:#fdfcf9;--ink:#1d2933;--muted:#66737d;--rule:#dde3e5}
@media(prefers-color-scheme:dark){:root{--paper:#12181d;--ink:#e6ebee;--muted:#98a5ae;--rule:#2c363d}
svg{filter:invert(.93) hue-rotate(180deg)}}
*{box-sizing:border-box}
body{margin:0 auto;padding:1rem;max-width:1400px;background:var(--paper);color:var(--ink);
font:15px/1.45 Inter,'Helvetica Neue',Helvetica,Arial,sans-serif}
h1{font-size:1.45rem;margin:.2rem 0}h2{font-size:1.05rem;margin:1.4rem 0 .4rem}
p{margin:.1rem 0;color:var(--muted)}svg{display:block;width:100%;height:auto}
.map{max-width:900px}
@media(min-width:1000px){.overview{display:grid;gap:0 2rem;grid-template-columns:minmax(0,3fr) minmax(0,2fr)}.map{order:-1}}
.charts{display:grid;gap:1rem;grid-template-columns:repeat(auto-fit,minmax(min(100%,400px),1fr))}
table{border-collapse:collapse;width:100%;max-width:900px}
td{padding:.25rem .5rem .25rem 0;border-bottom:1px solid var(--rule);vertical-align:top;overflow-wrap:anywhere}
td:first-child{color:var(--muted)}.events td:first-child{white-space:nowrap;text-align:right;width:6rem}
ul{padding-left:1.1rem}a{color:inherit}
";

/// Draws a run as one HTML file; `files` names what lies beside it, with a few words on each.
///
/// No input makes it fail, and every text is escaped.
pub fn report_html(run: &Run, files: &[(&str, &str)]) -> String {
    let mut page = String::with_capacity(64 * 1024);
    let title = escaped(&run.title);
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <title>{title}</title>\n<style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n"
    );
    for line in &run.subtitle {
        let _ = writeln!(page, "<p>{}</p>", escaped(line));
    }
    // Beside each other where there is room, the figures first where there is not.
    page.push_str("<div class=\"overview\">\n<div>\n");
    table(&mut page, "Figures", "figures", run.figures.iter().cloned());
    page.push_str("</div>\n<div class=\"map\">\n<h2>Track over mission</h2>\n");
    page.push_str(&map_svg(run));
    page.push_str("</div>\n</div>\n");
    if !run.track.is_empty() {
        page.push_str("<h2>Over time</h2>\n<div class=\"charts\">\n");
        for chart in charts::page_charts(run, CHART_WIDTH, CHART_HEIGHT) {
            page.push_str(&chart);
        }
        page.push_str("</div>\n");
    }
    let axis = TimeAxis::of(run);
    let mut events: Vec<&(f64, String)> =
        run.events.iter().filter(|(time_s, _)| super::is_reading(*time_s)).collect();
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let letters: Vec<char> = tables::shown_events(run).map(|(letter, ..)| letter).collect();
    table(
        &mut page,
        "Events",
        "events",
        events.into_iter().enumerate().map(|(number, (time_s, text))| {
            let letter = letters.get(number).map_or(String::new(), |letter| format!("{letter}  "));
            (format!("{letter}{}", axis.label(*time_s)), text.clone())
        }),
    );
    if !files.is_empty() {
        page.push_str("<h2>Files</h2>\n<ul>\n");
        for (name, words) in files {
            let name = escaped(name);
            let _ = writeln!(page, "<li><a href=\"{name}\">{name}</a>: {}</li>", escaped(words));
        }
        page.push_str("</ul>\n");
    }
    page.push_str("</body></html>\n");
    page
}

fn map_svg(run: &Run) -> String {
    let mut svg = Svg::new(MAP_WIDTH, MAP_HEIGHT + legend::HEIGHT, "Track over mission", theme::FONT_FAMILY);
    let scale = legend::ErrorScale::of(&run.track);
    map::draw(&mut svg, run, &scale, Area { left: 0.0, top: 0.0, width: MAP_WIDTH, height: MAP_HEIGHT });
    let strip = Area { left: 0.0, top: MAP_HEIGHT, width: MAP_WIDTH, height: legend::HEIGHT };
    legend::draw(&mut svg, run, &scale, strip);
    svg.finish()
}

fn table(page: &mut String, heading: &str, class: &str, rows: impl Iterator<Item = (String, String)>) {
    let mut rows = rows.peekable();
    if rows.peek().is_none() {
        return;
    }
    let _ = writeln!(page, "<h2>{heading}</h2>\n<table class=\"{class}\">");
    for (label, value) in rows {
        let _ = writeln!(page, "<tr><td>{}</td><td>{}</td></tr>", escaped(&label), escaped(&value));
    }
    page.push_str("</table>\n");
}

/// Text that is text in HTML, whatever it holds.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            character if character.is_control() && character != '\n' => out.push('\u{fffd}'),
            character => out.push(character),
        }
    }
    out
}
