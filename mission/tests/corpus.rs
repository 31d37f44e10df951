//! Mission files in the conventions of many tools read as expected, whatever is done to them nothing panics, and
//! what was read can be written in every format.
// Clippy takes only the test functions themselves for tests, not their helpers.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use helmlink_mission::plan::{Format, Outline, Reading};
use helmlink_mission::route::Route;
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use proptest::test_runner::{RngAlgorithm, TestRng};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus")
}

/// Name and content of every file of the corpus.
fn corpus() -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let missions = files.filter(|path| path.extension().is_some_and(|ending| ending != "md"));
    missions
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap()))
        .collect()
}

/// Everything that was read of a file, in a few lines.
fn describe(reading: &Reading) -> String {
    let plan = &reading.plan;
    let mut text = format!("{:?}", reading.format);
    if let Some(home) = plan.mission.home {
        let _ = write!(text, " home {home}");
    }
    for (number, item) in (1..).zip(&plan.mission.items) {
        let _ = write!(text, "\n  {number}: {} frame {}", item.command, item.frame);
        if let Some(place) = item.position() {
            let _ = write!(text, " at {place}");
        }
        let _ = write!(text, " {:?} z {}", item.params, item.z);
    }
    for area in &plan.fence.areas {
        let side = if area.inclusion { "inside" } else { "outside" };
        let _ = match &area.outline {
            Outline::Polygon(corners) => write!(text, "\n  {side} {} corners", corners.len()),
            Outline::Circle { centre, radius_m } => write!(text, "\n  {side} {radius_m} m of {centre}"),
        };
    }
    if let Some(place) = plan.fence.return_point {
        let _ = write!(text, "\n  return to {} z {}", place.position, place.altitude_m);
    }
    for place in &plan.rally {
        let _ = write!(text, "\n  rally at {} z {}", place.position, place.altitude_m);
    }
    for note in &reading.notes {
        let _ = write!(text, "\n  note: {note}");
    }
    text
}

#[test]
fn every_file_reads_as_expected() {
    let corpus = corpus();
    assert!(corpus.len() >= 40, "{} files", corpus.len());
    let mut found = String::from("# What the files of this folder hold\n\n```text\n");
    for (name, bytes) in &corpus {
        let reading = Reading::from_bytes(bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        let _ = write!(found, "{name}: {}\n\n", describe(&reading));
    }
    found.push_str("```\n");
    let path = folder().join("expected.md");
    let expected = fs::read_to_string(&path).unwrap_or_default();
    if expected != found {
        let new = std::env::temp_dir().join("helmlink-corpus-expected.md");
        fs::write(&new, &found).unwrap();
        panic!("the corpus is read differently: compare {} with {}", path.display(), new.display());
    }
}

#[test]
fn what_was_read_is_written_in_every_format_and_read_again() {
    for (name, bytes) in corpus() {
        let plan = Reading::from_bytes(&bytes).unwrap().plan;
        for format in Format::ALL {
            let (written, losses) = format.encode(&plan).unwrap();
            let again = Reading::from_bytes(&written);
            let kept_nothing = again.is_err() && !losses.is_empty();
            let Ok(again) = again else {
                assert!(kept_nothing, "{name} as {}: {again:?}", format.name());
                continue;
            };
            if losses.is_empty() {
                // NaN is equal to nothing: compare the descriptions. To leave a parameter to the vehicle is the
                // same as 0 for a boat, and all that a path can say.
                let before = describe(&Reading { plan: plan.clone(), format, notes: Vec::new() });
                let is_path = matches!(format, Format::Gpx | Format::Kml | Format::Kmz);
                let before = if is_path { before.replace("NaN", "0.0") } else { before };
                let after = describe(&Reading { notes: Vec::new(), ..again });
                assert_eq!(after, before, "{name} as {}", format.name());
            }
        }
    }
}

/// Reads, and does with the result what the program does.
fn use_it(bytes: &[u8]) {
    if let Ok(reading) = Reading::from_bytes(bytes) {
        let _ = Route::from_mission(&reading.plan.mission);
        for format in Format::ALL {
            let _ = format.encode(&reading.plan);
        }
    }
}

/// One thing done to a file.
#[derive(Debug, Clone)]
enum Damage {
    Overwrite(usize, u8),
    Insert(usize, Vec<u8>),
    Remove(usize, usize),
    Repeat(usize, usize),
    Cut(usize),
}

fn any_damage() -> impl Strategy<Value = Damage> {
    let place = 0..100_000usize;
    let piece = prop_oneof![
        prop::collection::vec(any::<u8>(), 1..6),
        prop::sample::select(vec![
            "1e999",
            "-1",
            "nan",
            "inf",
            "null",
            "[]",
            "{}",
            "<",
            "</",
            "&amp;",
            "&#0;",
            "\t",
            ",",
            "65536",
            "4294967296",
            "\"",
            "]]>",
            "<rte>",
            "QGC WPL 110",
            "\n",
            "\u{feff}",
            "-0.0",
            "0x10",
            "1_000",
        ])
        .prop_map(|text| text.as_bytes().to_vec()),
    ];
    prop_oneof![
        (place.clone(), any::<u8>()).prop_map(|(at, byte)| Damage::Overwrite(at, byte)),
        (place.clone(), piece).prop_map(|(at, piece)| Damage::Insert(at, piece)),
        (place.clone(), 1..40usize).prop_map(|(at, length)| Damage::Remove(at, length)),
        (place.clone(), 1..200usize).prop_map(|(at, length)| Damage::Repeat(at, length)),
        place.prop_map(Damage::Cut),
    ]
}

fn damaged(mut bytes: Vec<u8>, damages: &[Damage]) -> Vec<u8> {
    for damage in damages {
        let length = bytes.len();
        let place = |at: usize| if length == 0 { 0 } else { at % length };
        match damage {
            Damage::Overwrite(at, byte) => {
                if let Some(target) = bytes.get_mut(place(*at)) {
                    *target = *byte;
                }
            }
            Damage::Insert(at, piece) => {
                let at = place(*at);
                bytes.splice(at..at, piece.iter().copied());
            }
            Damage::Remove(at, count) => {
                let at = place(*at);
                bytes.drain(at..(at + count).min(length));
            }
            Damage::Repeat(at, count) => {
                let at = place(*at);
                let piece = bytes[at..(at + count).min(length)].to_vec();
                bytes.splice(at..at, piece);
            }
            Damage::Cut(at) => bytes.truncate(place(*at)),
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_files_are_read_or_refused(
        file in any::<prop::sample::Index>(), damages in prop::collection::vec(any_damage(), 1..6),
    ) {
        let corpus: Vec<Vec<u8>> = corpus().into_values().collect();
        use_it(&damaged(corpus[file.index(corpus.len())].clone(), &damages));
    }

    #[test]
    fn arbitrary_bytes_are_read_or_refused(
        head in prop::sample::select(vec!["", "QGC WPL 110\n", "{\"mission\":", "<gpx>", "<kml>", "lat,lon\n", "PK\u{3}\u{4}"]),
        rest in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let mut bytes = head.as_bytes().to_vec();
        bytes.extend(rest);
        use_it(&bytes);
    }

    #[test]
    fn arbitrary_texts_are_read_or_refused(
        head in prop::sample::select(vec!["QGC WPL 110\n", "{\"type\":\"FeatureCollection\",\"features\":[", "<gpx><rte>", "<kml>", "lat;lon\n"]),
        rest in "[0-9a-z<>/\\[\\]{}\",.:;= \t\n-]{0,200}",
    ) {
        use_it(format!("{head}{rest}").as_bytes());
    }
}

/// Damages files for as many minutes as `FUZZ_MINUTES` says (1 if it is not set), starting from `FUZZ_SEED`:
///
/// `FUZZ_MINUTES=10 cargo test --release -p helmlink-mission --test corpus -- --ignored --nocapture`
#[test]
#[ignore = "runs for minutes"]
fn fuzz_for_minutes() {
    let number = |name: &str, default: u64| {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
    };
    let (minutes, seed) = (number("FUZZ_MINUTES", 1), number("FUZZ_SEED", 1));
    let mut seed_bytes = [0; 32];
    seed_bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed_bytes);
    let mut runner = proptest::test_runner::TestRunner::new_with_rng(ProptestConfig::default(), rng);
    let corpus: Vec<(String, Vec<u8>)> = corpus().into_iter().collect();
    let what = (any::<prop::sample::Index>(), prop::collection::vec(any_damage(), 1..12));
    let end = Instant::now() + Duration::from_secs(60 * minutes);
    let (mut count, mut slowest) = (0u64, Duration::ZERO);
    while Instant::now() < end {
        let (file, damages) = what.new_tree(&mut runner).unwrap().current();
        let (name, bytes) = &corpus[file.index(corpus.len())];
        let input = damaged(bytes.clone(), &damages);
        let started = Instant::now();
        let outcome = std::panic::catch_unwind(|| use_it(&input));
        slowest = slowest.max(started.elapsed());
        assert!(outcome.is_ok(), "{name}: {damages:?}");
        count += 1;
    }
    println!("{count} damaged files in {minutes} min, seed {seed}: no panic, slowest {slowest:?}");
}
