use super::*;

fn otter_text() -> &'static str {
    EMBEDDED[0].1
}

fn with(line: &str, replacement: &str) -> String {
    assert!(otter_text().contains(line), "{line}");
    otter_text().replacen(line, replacement, 1)
}

#[test]
fn every_embedded_boat_is_sound_and_carries_its_name() {
    for name in Boat::names() {
        assert_eq!(Boat::embedded(name).unwrap().name, name);
    }
}

#[test]
fn an_unknown_boat_lists_the_known_ones() {
    let text = Boat::embedded("raft").unwrap_err().to_string();
    for name in Boat::names() {
        assert!(text.contains(name), "{text}");
    }
}

#[test]
fn a_value_out_of_range_names_its_key_and_range() {
    let text = Boat::from_toml(&with("lead_m = 3.0", "lead_m = -1.0")).unwrap_err().to_string();
    assert!(text.contains("guidance.lead_m = -1") && text.contains("0.1") && text.contains("1000"), "{text}");
    for (line, bad) in [
        ("m11_kg = 85.5", "m11_kg = 0.0"),
        ("m33_kgm2 = 42.65", "m33_kgm2 = nan"),
        ("ahead_n = 119.7", "ahead_n = -1.0"),
        ("turn_rate_radps = 0.23", "turn_rate_radps = 0.5"),
        ("boundary = 0.2", "boundary = 0.0"),
        ("heading_gain = 1.1", "heading_gain = inf"),
    ] {
        let error = Boat::from_toml(&with(line, bad)).unwrap_err();
        let key = line.split(' ').next().unwrap();
        assert!(error.to_string().contains(key), "{error}");
    }
}

#[test]
fn unknown_and_missing_keys_are_refused_by_name() {
    let text = Boat::from_toml(&with("[hull]", "[hull]\nrudders = 2")).unwrap_err().to_string();
    assert!(text.contains("rudders"), "{text}");
    let text = Boat::from_toml(&with("arm_m = 0.395", "")).unwrap_err().to_string();
    assert!(text.contains("arm_m"), "{text}");
    let text = Boat::from_toml(&with("arm_m = 0.395", "arm_m = 0.395\npaddles = 1")).unwrap_err().to_string();
    assert!(text.contains("paddles"), "{text}");
}
