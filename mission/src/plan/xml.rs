//! XML, element by element, for the formats built on it.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::error::{Fault, Place, PlanError};
use crate::geodesy::Geodetic;

/// A piece of a document. Names are without their namespace.
#[derive(Debug)]
pub(super) enum Node {
    /// An element begins.
    Open {
        /// Its name.
        name: String,
        /// Its attributes.
        attributes: Vec<(String, String)>,
    },
    /// Text within the element.
    Text(String),
    /// The element ends.
    Close(String),
}

/// Walks through a document.
pub(super) struct Walker<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
}

impl<'a> Walker<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Self { text, reader }
    }

    /// The next piece; none at the end.
    pub(super) fn next(&mut self) -> Result<Option<Node>, PlanError> {
        loop {
            let event = match self.reader.read_event() {
                Ok(event) => event,
                Err(error) => return Err(self.fault(Fault::Xml(error.to_string()))),
            };
            return Ok(Some(match event {
                Event::Start(start) => self.open(&start)?,
                Event::End(end) => Node::Close(local_name(end.local_name().as_ref())),
                Event::Text(text) => Node::Text(String::from_utf8_lossy(&text).into_owned()),
                Event::CData(text) => Node::Text(String::from_utf8_lossy(&text).into_owned()),
                Event::GeneralRef(reference) => match reference.resolve_char_ref() {
                    Ok(Some(character)) => Node::Text(character.to_string()),
                    _ => Node::Text(match &reference[..] {
                        b"amp" => "&".to_owned(),
                        b"lt" => "<".to_owned(),
                        b"gt" => ">".to_owned(),
                        b"quot" => "\"".to_owned(),
                        b"apos" => "'".to_owned(),
                        _ => continue,
                    }),
                },
                Event::Eof => return Ok(None),
                _ => continue,
            }));
        }
    }

    /// Line of the piece last read.
    pub(super) fn line(&self) -> usize {
        let here = (self.reader.buffer_position() as usize).min(self.text.len());
        1 + self.text.as_bytes()[..here].iter().filter(|byte| **byte == b'\n').count()
    }

    /// Something is wrong with the piece last read.
    pub(super) fn fault(&self, fault: impl Into<Fault>) -> PlanError {
        PlanError::at(Place::Line(self.line()), fault)
    }

    fn open(&self, start: &BytesStart<'_>) -> Result<Node, PlanError> {
        let mut attributes = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| self.fault(Fault::Xml(error.to_string())))?;
            let value = String::from_utf8_lossy(&attribute.value).into_owned();
            attributes.push((local_name(attribute.key.local_name().as_ref()), value));
        }
        Ok(Node::Open { name: local_name(start.local_name().as_ref()), attributes })
    }
}

fn local_name(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The name of the outermost element, if there is one.
pub(super) fn root_element(text: &str) -> Option<String> {
    let mut walker = Walker::new(text);
    loop {
        match walker.next() {
            Ok(Some(Node::Open { name, .. })) => return Some(name),
            Ok(Some(_)) => {}
            _ => return None,
        }
    }
}

/// A position from two texts.
pub(super) fn position(latitude: &str, longitude: &str) -> Result<Geodetic, Fault> {
    let position = Geodetic {
        latitude_deg: number("latitude", latitude, "degrees north")?,
        longitude_deg: number("longitude", longitude, "degrees east")?,
    };
    position.check()?;
    Ok(position)
}

/// A finite number.
pub(super) fn number(column: &'static str, found: &str, expected: &'static str) -> Result<f64, Fault> {
    let fault = || Fault::Number { column, found: super::excerpt(found), expected };
    found.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(fault)
}

/// Text that stands for itself in a document.
pub(super) fn escape(text: &str) -> String {
    quick_xml::escape::escape(text).into_owned()
}
