//! The bridge's settings as text (TOML), cut into TUNNEL messages.

use helmlink_wire::Message;
use helmlink_wire::dialect::TUNNEL_DATA;
use serde::{Deserialize, Serialize};

use super::{SETTINGS, TUNNEL_LENGTH};
use crate::bridge::BridgeSettings;

/// What stands at the head of a recording.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct Header {
    /// Version of helmlink that recorded.
    pub helmlink: String,
    /// Microseconds since 1970 UTC at the driver's time zero.
    pub unix_start_us: i64,
    /// What the user had decided.
    pub settings: BridgeSettings,
}

/// Bytes of text in one message, behind part and number of parts (two bytes each).
const PART: usize = TUNNEL_LENGTH - 4;

impl Header {
    /// The header of a recording that is made now.
    pub fn new(unix_start_us: u64, settings: &BridgeSettings) -> Self {
        Self {
            helmlink: env!("CARGO_PKG_VERSION").to_owned(),
            unix_start_us: unix_start_us.min(i64::MAX as u64) as i64,
            settings: settings.clone(),
        }
    }

    /// The header as text.
    ///
    /// # Errors
    /// A value that TOML cannot hold.
    pub fn to_text(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// The header of a text.
    ///
    /// # Errors
    /// What does not fit: most likely another version of helmlink has recorded.
    pub fn from_text(text: &str) -> Result<Self, Box<toml::de::Error>> {
        toml::from_str(text).map_err(Box::new)
    }

    /// The header as messages.
    ///
    /// # Errors
    /// Those of [`Self::to_text`].
    pub fn to_messages(&self) -> Result<Vec<Message>, toml::ser::Error> {
        let text = self.to_text()?;
        let parts: Vec<&[u8]> = text.as_bytes().chunks(PART).collect();
        let count = parts.len().min(usize::from(u16::MAX)) as u16;
        Ok((0..count).zip(parts).map(|(number, part)| settings_part(number, count, part)).collect())
    }
}

fn settings_part(number: u16, count: u16, part: &[u8]) -> Message {
    let mut text = [0; TUNNEL_LENGTH];
    text[..2].copy_from_slice(&number.to_le_bytes());
    text[2..4].copy_from_slice(&count.to_le_bytes());
    text[4..4 + part.len()].copy_from_slice(part);
    tunnel(SETTINGS, &text[..4 + part.len()])
}

/// A TUNNEL to nobody: it is in the log only.
pub(super) fn tunnel(payload_type: u16, content: &[u8]) -> Message {
    let mut payload = [0; TUNNEL_LENGTH];
    payload[..content.len()].copy_from_slice(content);
    let payload_length = content.len() as u8;
    Message::TUNNEL(TUNNEL_DATA { payload_type, payload_length, payload, ..TUNNEL_DATA::DEFAULT })
}

/// Puts the parts of a header together again.
#[derive(Debug, Clone, Default)]
pub struct HeaderParts {
    text: Vec<u8>,
    expected: u16,
}

impl HeaderParts {
    /// Takes the content of a settings TUNNEL; the whole text once the last part has come.
    pub fn push(&mut self, content: &[u8]) -> Option<String> {
        let (head, part) = content.split_at_checked(4)?;
        let number = u16::from_le_bytes([head[0], head[1]]);
        let count = u16::from_le_bytes([head[2], head[3]]);
        if number == 0 {
            self.text.clear();
            self.expected = 0;
        }
        if number != self.expected {
            return None;
        }
        self.expected += 1;
        self.text.extend_from_slice(part);
        (self.expected == count).then(|| String::from_utf8_lossy(&self.text).into_owned())
    }
}
