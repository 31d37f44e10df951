//! The file formats: which is which, what each can hold.

use std::fmt;
use std::path::Path;

use helmlink_wire::enums::MAV_CMD_NAV_WAYPOINT;

use super::error::{Fault, Place, PlanError};
use super::{CommandName, Item, Outline, Plan, csv, excerpt, geojson, gpx, kml, kmz, qgc, wpl};

/// A mission file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `QGC WPL 110`: Mission Planner, MAVProxy, ArduPilot.
    Wpl,
    /// QGroundControl's `.plan`.
    Qgc,
    /// GeoJSON, RFC 7946.
    GeoJson,
    /// GPX 1.1 routes; tracks are read too.
    Gpx,
    /// KML 2.2 paths.
    Kml,
    /// Zipped KML.
    Kmz,
    /// A table with a line of headings.
    Csv,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Wpl, Self::Qgc, Self::GeoJson, Self::Gpx, Self::Kml, Self::Kmz, Self::Csv];

    /// The name as it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wpl => "wpl",
            Self::Qgc => "plan",
            Self::GeoJson => "geojson",
            Self::Gpx => "gpx",
            Self::Kml => "kml",
            Self::Kmz => "kmz",
            Self::Csv => "csv",
        }
    }

    /// The format called `name`, as [`Format::name`] gives it.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name().eq_ignore_ascii_case(name))
    }

    /// The format that a file's ending stands for.
    pub fn of_path(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "waypoints" | "wpl" | "txt" | "mission" => Some(Self::Wpl),
            "json" => Some(Self::GeoJson),
            other => Self::from_name(other),
        }
    }

    /// The format of a file's content.
    ///
    /// # Errors
    /// Content of no format that is known.
    pub(super) fn of_content(text: &str) -> Result<Self, PlanError> {
        let first_line = text
            .lines()
            .map(str::trim)
            .find(|line| !line.is_empty() && !line.starts_with('#'))
            .unwrap_or_default();
        if first_line.is_empty() {
            Err(PlanError::at(Place::File, Fault::Nothing))
        } else if first_line.starts_with(wpl::MAGIC) {
            Ok(Self::Wpl)
        } else if first_line.starts_with('{') {
            Ok(if qgc::looks_like_geojson(text) { Self::GeoJson } else { Self::Qgc })
        } else if first_line.starts_with('<') {
            match super::xml::root_element(text).as_deref() {
                Some("gpx") => Ok(Self::Gpx),
                Some("kml") => Ok(Self::Kml),
                _ => Err(PlanError::at(Place::File, Fault::NotAMission(excerpt(first_line)))),
            }
        } else if csv::looks_like_headings(first_line) {
            Ok(Self::Csv)
        } else {
            Err(PlanError::at(Place::File, Fault::NotAMission(excerpt(first_line))))
        }
    }

    /// A plan as a file of this format, and what the format could not hold.
    ///
    /// # Errors
    /// A plan that this format cannot hold at all: one of nothing, say.
    pub fn encode(self, plan: &Plan) -> Result<(Vec<u8>, Vec<Loss>), PlanError> {
        let losses = self.losses(plan);
        let bytes = match self {
            Self::Wpl => wpl::format_plan(plan).into_bytes(),
            Self::Qgc => qgc::format(plan)?.into_bytes(),
            Self::GeoJson => geojson::format(plan)?.into_bytes(),
            Self::Gpx => gpx::format(plan).into_bytes(),
            Self::Kml => kml::format(plan).into_bytes(),
            Self::Kmz => kmz::pack(&kml::format(plan))?,
            Self::Csv => csv::format(plan).into_bytes(),
        };
        Ok((bytes, losses))
    }

    /// What of a plan this format cannot hold; nothing when it holds everything.
    pub fn losses(self, plan: &Plan) -> Vec<Loss> {
        let mut losses = Vec::new();
        match self {
            Self::GeoJson | Self::Csv => {}
            Self::Qgc => {
                let items: Vec<usize> = numbers_where(plan, |item| {
                    item.params.iter().chain([&item.z]).any(|value| value.is_infinite())
                });
                push(&mut losses, &items, "an infinite parameter, which is left to the vehicle instead");
            }
            Self::Wpl => {
                let has_mission = !plan.mission.items.is_empty();
                let has_fence = !plan.fence.is_empty();
                if !has_mission && plan.mission.home.is_some() {
                    losses.push(Loss::new("home: a fence or rally points in this format have none"));
                }
                if has_fence && has_mission {
                    losses.push(Loss::new("the fence: write it to a file of its own, or as .plan"));
                }
                if !plan.rally.is_empty() && (has_mission || has_fence) {
                    losses
                        .push(Loss::new("the rally points: write them to a file of their own, or as .plan"));
                }
            }
            Self::Gpx | Self::Kml | Self::Kmz => path_losses(plan, self == Self::Gpx, &mut losses),
        }
        losses
    }
}

/// What is lost in a format that knows only places in a row.
fn path_losses(plan: &Plan, no_areas: bool, losses: &mut Vec<Loss>) {
    let mut dropped: Vec<(u16, Vec<usize>)> = Vec::new();
    for (number, item) in (1..).zip(&plan.mission.items) {
        if item.command != MAV_CMD_NAV_WAYPOINT {
            match dropped.iter_mut().find(|(command, _)| *command == item.command) {
                Some((_, numbers)) => numbers.push(number),
                None => dropped.push((item.command, vec![number])),
            }
        }
    }
    for (command, numbers) in dropped {
        let keeps_place = plan.mission.items[numbers[0] - 1].position().is_some();
        let what = if keeps_place { "of which only the place is kept" } else { "which is left out" };
        push(losses, &numbers, &format!("{}, {what}", CommandName(command)));
    }
    let parameters = numbers_where(plan, |item| {
        item.command == MAV_CMD_NAV_WAYPOINT && item.params.iter().any(|p| !p.is_nan() && *p != 0.0)
    });
    push(losses, &parameters, "hold time, acceptance radius or other parameters of the waypoint");
    let frames = numbers_where(plan, |item| item.position().is_some() && item.frame != super::DEFAULT_FRAME);
    push(losses, &frames, "what its altitude is measured from");
    let pauses = numbers_where(plan, |item| !item.autocontinue);
    push(losses, &pauses, "that the vehicle waits there to be told to go on");
    if no_areas && !plan.fence.areas.is_empty() {
        losses.push(Loss::new("the areas of the fence"));
    }
    if !no_areas && plan.fence.areas.iter().any(|area| matches!(area.outline, Outline::Circle { .. })) {
        losses.push(Loss::new("circles of the fence, which are drawn as polygons"));
    }
    if plan.fence.return_point.is_some() {
        losses.push(Loss::new("the return point of the fence"));
    }
}

fn numbers_where(plan: &Plan, is_lost: impl Fn(&Item) -> bool) -> Vec<usize> {
    (1..).zip(&plan.mission.items).filter(|(_, item)| is_lost(item)).map(|(number, _)| number).collect()
}

fn push(losses: &mut Vec<Loss>, items: &[usize], what: &str) {
    /// More item numbers than this are not listed one by one.
    const LISTED: usize = 8;
    let list: Vec<String> = items.iter().take(LISTED).map(usize::to_string).collect();
    let more = items.len().saturating_sub(LISTED);
    match items.len() {
        0 => {}
        1 => losses.push(Loss::new(format!("item {}: {what}", list[0]))),
        _ if more > 0 => losses.push(Loss::new(format!("items {} and {more} more: {what}", list.join(", ")))),
        _ => losses.push(Loss::new(format!("items {}: {what}", list.join(", ")))),
    }
}

/// Something that a format cannot hold, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loss(pub String);

impl Loss {
    fn new(text: impl Into<String>) -> Self {
        Self(text.into())
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
#[path = "format_tests.rs"]
mod tests;
