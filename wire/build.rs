//! Generates the MAVLink message structures from `dialect/messages.xml`.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let definitions = "dialect/messages.xml";
    println!("cargo:rerun-if-changed={definitions}");
    let out_dir = PathBuf::from(env::var("OUT_DIR")?);
    mavlink_bindgen::generate(mavlink_bindgen::XmlDefinitions::Files(vec![definitions]), &out_dir)?;

    // The generator writes a file for `mod`; it is read by `include!`, which allows no inner attributes.
    let generated = out_dir.join("messages.rs");
    let text = fs::read_to_string(&generated)?;
    let start = text.find("# [allow (unused_imports)]").ok_or("the generated code has changed its head")?;
    fs::write(&generated, &text[start..])?;
    Ok(())
}
