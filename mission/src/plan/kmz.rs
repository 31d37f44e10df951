//! KMZ: a zip archive with a KML document in it.

use std::io::{Cursor, Read as _, Write as _};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::MAX_FILE_MB;
use super::error::{Fault, Place, PlanError};

/// The first bytes of every zip archive.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// The KML document in an archive: `doc.kml`, or else the first one.
pub(super) fn unpack(bytes: &[u8]) -> Result<String, PlanError> {
    let fault = |text: String| PlanError::at(Place::File, Fault::Zip(text));
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| fault(error.to_string()))?;
    let names: Vec<String> =
        archive.file_names().map(|name| name.map(|name| name.to_lowercase()).unwrap_or_default()).collect();
    let index = names
        .iter()
        .position(|name| name == "doc.kml")
        .or_else(|| names.iter().position(|name| name.ends_with(".kml")))
        .ok_or_else(|| fault("there is no .kml file in it".to_owned()))?;
    let file = archive.by_index(index).map_err(|error| fault(error.to_string()))?;
    // What a small archive holds may be large: it is read no further than any other file.
    let limit = MAX_FILE_MB * 1_000_000;
    let mut text = Vec::new();
    let size = file.take(limit + 1).read_to_end(&mut text).map_err(|error| fault(error.to_string()))?;
    if size as u64 > limit {
        return Err(fault(format!("{} is larger than {MAX_FILE_MB} MB", names[index])));
    }
    String::from_utf8(text).map_err(|_| PlanError::at(Place::File, Fault::NotText))
}

/// An archive with a document in it; the same document gives the same bytes.
pub(super) fn pack(kml: &str) -> Result<Vec<u8>, PlanError> {
    let fault = |error: &dyn std::fmt::Display| PlanError::at(Place::File, Fault::Zip(error.to_string()));
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default());
    writer.start_file("doc.kml", options).map_err(|error| fault(&error))?;
    writer.write_all(kml.as_bytes()).map_err(|error| fault(&error))?;
    Ok(writer.finish().map_err(|error| fault(&error))?.into_inner())
}
