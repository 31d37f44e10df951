//! The recipes of docs/simulator.md, run as they stand there.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::Path;
use std::process::Command;

use support::process::Process;
use support::python::python_folder;

const SIMULATOR: &str = include_str!("../docs/simulator.md");

/// The code of the only block of this language in a chapter.
fn block(chapter: &str, language: &str) -> String {
    let chapter = SIMULATOR.split("\n## ").find(|text| text.starts_with(chapter)).expect("the chapter");
    let fence = format!("```{language}\n");
    let mut blocks = chapter.split(&fence).skip(1);
    let (first, second) = (blocks.next().expect("a block"), blocks.next());
    assert!(second.is_none(), "one block only");
    first.split("\n```").next().unwrap().to_owned()
}

#[test]
fn the_recipe_for_ci_works_as_it_stands() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recipe-for-ci");
    std::fs::create_dir_all(&folder).unwrap();
    let chapter = "In CI, without sleeping";
    std::fs::write(folder.join("my_ground_station_test.py"), block(chapter, "python")).unwrap();
    let (shell, program) = (block(chapter, "bash"), Path::new(env!("CARGO_BIN_EXE_helmlink")));
    let path = std::env::join_paths(
        [program.parent().unwrap().to_owned(), python_folder()]
            .into_iter()
            .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )
    .unwrap();
    let mut command = Command::new("bash");
    command.args(["-eu", "-c", &shell]).current_dir(&folder).env("PATH", path).env("MAVLINK20", "1");
    Process::start("the recipe for CI", &mut command).succeed();
}
