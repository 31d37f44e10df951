use std::io::{self, Read};

use super::*;
use crate::dialect::{HEARTBEAT_DATA, Message};
use crate::{Encoder, Identity};

const BOAT: Identity = Identity { system: 1, component: 1 };
/// A time stamp of November 2026, microseconds.
const START_US: u64 = 1_795_422_927_539_027;

/// A log of `count` heartbeats one second apart, and where each record starts.
fn log(count: u64) -> (Vec<u8>, Vec<usize>) {
    let (mut encoder, mut starts) = (Encoder::new(), Vec::new());
    let mut writer = TlogWriter::new(Vec::new());
    let mut length = 0;
    for number in 0..count {
        let message =
            Message::HEARTBEAT(HEARTBEAT_DATA { custom_mode: 0x0101_0101, ..HEARTBEAT_DATA::DEFAULT });
        let mut bytes = Vec::new();
        encoder.encode(BOAT, &message, &mut bytes);
        writer.write(time(number), &Frame::parse(&bytes).unwrap()).unwrap();
        starts.push(length);
        length += STAMP_LENGTH + bytes.len();
    }
    (writer.into_inner(), starts)
}

fn time(number: u64) -> u64 {
    START_US + number * 1_000_000
}

/// Time stamp and sequence number of each record; both readers must agree on them.
fn read(log: &[u8]) -> Vec<(u64, u8)> {
    let from_memory: Vec<_> = records(log).map(|record| (record.time_us, record.frame.sequence())).collect();
    let mut streamed = Vec::new();
    let mut reader = TlogReader::new(Dribble(log));
    while let Some(record) = reader.next_record().unwrap() {
        streamed.push((record.time_us, record.frame.sequence()));
    }
    assert_eq!(from_memory, streamed);
    streamed
}

fn expected(numbers: impl Iterator<Item = u64>) -> Vec<(u64, u8)> {
    numbers.map(|number| (time(number), number as u8)).collect()
}

/// A source that yields seven bytes at a time.
struct Dribble<'a>(&'a [u8]);

impl Read for Dribble<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.0.len().min(7);
        buffer[..count].copy_from_slice(&self.0[..count]);
        self.0 = &self.0[count..];
        Ok(count)
    }
}

#[test]
fn what_is_written_is_read() {
    let (log, _) = log(300);
    assert_eq!(read(&log), expected(0..300));
}

#[test]
fn a_log_cut_anywhere_yields_all_whole_records() {
    let (log, starts) = log(5);
    for cut in 0..log.len() {
        let whole = starts[1..].iter().filter(|&&start| start <= cut).count() as u64;
        assert_eq!(read(&log[..cut]), expected(0..whole), "cut at {cut}");
    }
}

#[test]
fn a_log_that_lacks_its_start_yields_all_whole_frames() {
    let (log, starts) = log(5);
    for cut in 0..log.len() {
        let found = read(&log[cut..]);
        let first = starts.iter().filter(|&&start| start + STAMP_LENGTH < cut).count() as u64;
        let frames: Vec<u8> = (first..5).map(|number| number as u8).collect();
        assert_eq!(found.iter().map(|&(_, sequence)| sequence).collect::<Vec<_>>(), frames, "from {cut}");
        assert_eq!(found.get(1..), expected(first..5).get(1..), "from {cut}");
    }
}

#[test]
fn a_hole_anywhere_costs_only_the_records_it_touches() {
    let (log, starts) = log(6);
    for hole in starts[2]..starts[3] {
        let end = hole + 20; // records are longer than that
        let torn: Vec<u8> = log[..hole].iter().chain(&log[end..]).copied().collect();
        let found = read(&torn);
        let touched = |number: u64| {
            let start = starts[number as usize];
            let frame_end = starts.get(number as usize + 1).copied().unwrap_or(log.len());
            hole < frame_end && end > start + STAMP_LENGTH
        };
        let survivors: Vec<u8> =
            (0..6).filter(|&number| !touched(number)).map(|number| number as u8).collect();
        assert_eq!(found.iter().map(|&(_, sequence)| sequence).collect::<Vec<_>>(), survivors, "at {hole}");
        // A stamp that the hole has torn is replaced by that of the record before.
        assert!(found.is_sorted() && found.iter().all(|&(time_us, _)| time_us <= time(5)), "at {hole}");
    }
}

#[test]
fn a_damaged_frame_is_counted_and_its_neighbours_keep_their_times() {
    let (mut log, starts) = log(6);
    log[starts[3] + STAMP_LENGTH + 11] ^= 0x10; // in the payload
    assert_eq!(read(&log), expected([0, 1, 2, 4, 5].into_iter()));
    let mut reader = records(&log);
    assert_eq!(reader.by_ref().count(), 5);
    let statistics = reader.statistics();
    assert_eq!((statistics.crc_errors, statistics.sequence_gaps), (1, 1));
}

#[test]
fn inserted_noise_is_passed_over() {
    let (log, starts) = log(4);
    for noise in [&[0xFD; 40][..], &[0xFE; 300], &[0xFD, 0xFF, 0x00, 0x00], &[0x00]] {
        for place in starts[1]..=starts[2] {
            let noisy = [&log[..place], noise, &log[place..]].concat();
            let found = read(&noisy);
            let sequences: Vec<u8> = found.iter().map(|&(_, sequence)| sequence).collect();
            let frame = &log[starts[1] + STAMP_LENGTH..starts[2]];
            let whole = noisy.windows(frame.len()).any(|window| window == frame);
            assert_eq!(sequences, if whole { vec![0, 1, 2, 3] } else { vec![0, 2, 3] }, "at {place}");
        }
    }
}

#[test]
fn unknown_messages_are_counted_and_do_no_harm() {
    let (log, starts) = log(4);
    let unknown_frame = [0xFD, 3, 0, 0, 1, 1, 1, 0xFF, 0xFF, 0x7F, 0xFD, 0xFE, 0xFD, 0x12, 0x34];
    let unknown = [&time(1).to_be_bytes()[..], &unknown_frame].concat();
    for place in [starts[1], starts[2], log.len()] {
        let mixed = [&log[..place], &unknown, &unknown, &log[place..]].concat();
        assert_eq!(read(&mixed), expected(0..4));
        let mut reader = records(&mixed);
        assert_eq!(reader.by_ref().count(), 4);
        assert_eq!(reader.statistics().unknown_ids, 2);
        assert_eq!(reader.statistics().resynchronised_bytes, 0);
    }
}

#[test]
fn each_record_is_one_write() {
    struct Count(usize);
    impl io::Write for Count {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 += 1;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let (log, _) = log(9);
    let mut writer = TlogWriter::new(Count(0));
    for record in records(&log) {
        writer.write(record.time_us, &record.frame).unwrap();
    }
    assert_eq!(writer.into_inner().0, 9);
}

#[test]
fn an_error_of_the_source_loses_nothing() {
    struct Flaky<'a>(&'a [u8], bool);
    impl Read for Flaky<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.1 = !self.1;
            if self.1 {
                Err(io::Error::other("try again"))
            } else {
                Dribble(self.0).read(buffer).inspect(|&n| self.0 = &self.0[n..])
            }
        }
    }
    let (log, _) = log(5);
    let (mut reader, mut sequences, mut errors) = (TlogReader::new(Flaky(&log, false)), Vec::new(), 0);
    loop {
        match reader.next_record() {
            Ok(Some(record)) => sequences.push(record.frame.sequence()),
            Ok(None) => break,
            Err(_) => errors += 1,
        }
    }
    assert_eq!(sequences, [0, 1, 2, 3, 4]);
    assert!(errors > 5);
}
