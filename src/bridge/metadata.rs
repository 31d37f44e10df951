//! What ground stations can read of the bridge's parameters: MAVLink's component metadata
//! (<https://mavlink.io/en/services/component_information.html>).
//!
//! COMPONENT_METADATA, on request, names a file; that file names the other; both are read by MAVLink's file transfer
//! protocol. They are made at the first question and stay the same from then on, as the service wants it.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use helmlink_wire::dialect::{COMPONENT_METADATA_DATA, CharArray, FILE_TRANSFER_PROTOCOL_DATA};
use helmlink_wire::ftp::{FileServer, at, crc32};
use helmlink_wire::{Identity, LinkId, Message, enums};
use serde_json::{Value, json};

use super::Bridge;
use super::parameters::described::parameter_file;
use super::settings::COMPONENT;

/// The file that COMPONENT_METADATA names.
const GENERAL: &str = "general.json";
/// The file on the parameters.
const PARAMETER: &str = "parameter.json";
/// Version of the general file's form: `general.schema.json`, as the other's.
const FORM: u32 = 1;
/// Messages in answer to one request: the rest of a file has to be asked for.
const PIECES_PER_BURST: usize = 16;
/// Messages that wait; further ones are dropped, and clients ask again for what is missing.
const MOST_WAITING: usize = 4 * PIECES_PER_BURST;
/// Bytes of files each second: what steers the boat may have to share a link with them.
const BYTES_PER_S: u32 = 5000;
/// So much lost time is made up for: nobody looks more often than every tick.
const CATCH_UP: Duration = Duration::from_millis(50);
/// Bytes of a message beside the data.
const OVERHEAD_BYTES: u32 = 27;

/// Both files.
#[derive(Debug)]
struct Files {
    general: Arc<[u8]>,
    parameter: Arc<[u8]>,
}

/// Serves the files.
#[derive(Debug)]
pub(super) struct Metadata {
    files: Option<Files>,
    server: FileServer,
    /// To whom, on which link, what.
    waiting: VecDeque<(LinkId, Identity, FILE_TRANSFER_PROTOCOL_DATA)>,
    /// When the next one may go.
    due: Duration,
}

impl Default for Metadata {
    fn default() -> Self {
        let server = FileServer::new(PIECES_PER_BURST);
        Self { files: None, server, waiting: VecDeque::new(), due: Duration::ZERO }
    }
}

impl Metadata {
    /// How many files are open, and how many messages wait.
    #[cfg(test)]
    pub(super) fn kept(&self) -> (usize, usize) {
        (self.server.open_count(), self.waiting.len())
    }

    /// Forgets the clients on a link.
    pub(super) fn forget(&mut self, link: LinkId) {
        self.server.forget(link);
        self.waiting.retain(|(on, ..)| *on != link);
    }
}

impl Files {
    fn new(parameter: &Value) -> Self {
        let parameter = bytes(parameter);
        let general = bytes(&json!({
            "version": FORM,
            "vendorName": "Helmlink",
            "modelName": "Helmlink bridge",
            "firmwareVersion": env!("CARGO_PKG_VERSION"),
            "metadataTypes": [{
                "type": enums::COMP_METADATA_TYPE_PARAMETER,
                "uri": uri(PARAMETER),
                "fileCrc": crc32(&parameter),
            }],
        }));
        Self { general, parameter }
    }

    fn get(&self, path: &str) -> Option<Arc<[u8]>> {
        match path.strip_prefix('/').unwrap_or(path) {
            GENERAL => Some(self.general.clone()),
            PARAMETER => Some(self.parameter.clone()),
            _ => None,
        }
    }
}

impl Bridge {
    /// COMPONENT_METADATA.
    pub(super) fn component_metadata(&mut self) -> Message {
        let boot_s = self.telemetry.boot_s.unwrap_or_default();
        Message::COMPONENT_METADATA(COMPONENT_METADATA_DATA {
            time_boot_ms: (boot_s * 1000.0) as u32,
            file_crc: crc32(&self.metadata_files().general),
            uri: CharArray::from(uri(GENERAL).as_str()),
        })
    }

    /// A request for a file, from whichever link. Answers go back there, one by one.
    pub(super) fn on_file_request(
        &mut self,
        link: LinkId,
        from: Identity,
        request: &FILE_TRANSFER_PROTOCOL_DATA,
    ) {
        let own = self.own_or_default();
        if (request.target_system, request.target_component) != (own.system, own.component) {
            return;
        }
        self.metadata_files();
        let Metadata { files, server, waiting, .. } = &mut self.metadata;
        let file = |path: &str| files.as_ref().and_then(|files| files.get(path));
        let answers = server.answers(link, from, request, file);
        // Whoever asks something else no longer waits for the rest.
        waiting.retain(|(on, who, _)| (*on, *who) != (link, from));
        let room = MOST_WAITING.saturating_sub(waiting.len());
        waiting.extend(answers.into_iter().take(room).map(|answer| (link, from, answer)));
        self.send_files();
    }

    /// Sends the next piece of a file when it is due.
    pub(super) fn send_files(&mut self) {
        while self.driver_now >= self.metadata.due
            && let Some((link, _, answer)) = self.metadata.waiting.pop_front()
        {
            let size = u32::from(answer.payload[at::SIZE]) + OVERHEAD_BYTES;
            let earliest = self.metadata.due.max(self.driver_now.saturating_sub(CATCH_UP));
            self.metadata.due = earliest + size * Duration::from_secs(1) / BYTES_PER_S;
            self.links.send(link, self.own_or_default(), &Message::FILE_TRANSFER_PROTOCOL(answer));
        }
    }

    fn metadata_files(&mut self) -> &Files {
        let (factory, settings) = (&self.factory, &self.settings);
        self.metadata.files.get_or_insert_with(|| Files::new(&parameter_file(factory, &settings.tunables())))
    }
}

/// Where a file of the bridge's is found.
fn uri(file: &str) -> String {
    format!("mftp://[;comp={COMPONENT}]/{file}")
}

fn bytes(file: &Value) -> Arc<[u8]> {
    file.to_string().into_bytes().into()
}
