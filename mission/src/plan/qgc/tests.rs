use proptest::prelude::*;
use serde_json::json;

use super::*;
use crate::geodesy::PositionFault;

fn waypoint(latitude_deg: f64, longitude_deg: f64) -> Value {
    json!({
        "type": "SimpleItem", "command": 16, "frame": 3, "autoContinue": true, "doJumpId": 1,
        "AMSLAltAboveTerrain": null, "Altitude": 0, "AltitudeMode": 1,
        "params": [0, 2.5, 0, null, latitude_deg, longitude_deg, 0]
    })
}

fn survey(items: Value) -> Value {
    json!({
        "type": "ComplexItem", "complexItemType": "survey", "angle": 0, "version": 5,
        "TransectStyleComplexItem": { "version": 2, "Items": items }
    })
}

fn plan(items: Value) -> String {
    json!({
        "fileType": "Plan", "version": 1, "groundStation": "QGroundControl",
        "geoFence": {"circles": [], "polygons": [], "version": 2},
        "rallyPoints": {"points": [], "version": 2},
        "mission": {
            "version": 2, "firmwareType": 3, "vehicleType": 10, "cruiseSpeed": 1.4, "hoverSpeed": 1.4,
            "globalPlanAltitudeMode": 1, "plannedHomePosition": [59.9, 10.7, 0], "items": items
        }
    })
    .to_string()
}

fn fault(text: &str) -> (Place, Fault) {
    match text.parse::<Mission>() {
        Err(PlanError::Content { place, fault, .. }) => (place, fault),
        other => panic!("{other:?}"),
    }
}

#[test]
fn reads_simple_items_and_home() {
    let mission: Mission = plan(json!([waypoint(59.9, 10.7), waypoint(59.91, 10.7)])).parse().unwrap();
    assert_eq!(mission.home, Some(Geodetic::new(59.9, 10.7)));
    let item = mission.items[1];
    assert_eq!((item.x, item.y, item.frame), (599_100_000, 107_000_000, 3));
    assert_eq!(item.params[1], 2.5);
    assert!(item.params[3].is_nan() && item.autocontinue);
}

#[test]
fn a_survey_is_the_items_stored_in_it() {
    let items = json!([waypoint(59.9, 10.7), survey(json!([waypoint(59.91, 10.7), waypoint(59.91, 10.71)]))]);
    assert_eq!(plan(items).parse::<Mission>().unwrap().items.len(), 3);
}

#[test]
fn a_scan_without_items_is_the_places_of_its_transects() {
    let mut scan = survey(json!([]));
    scan["TransectStyleComplexItem"]["VisualTransectPoints"] = json!([[59.91, 10.7], [59.92, 10.7, 3.0]]);
    let mission: Mission = plan(json!([waypoint(59.9, 10.7), scan.clone()])).parse().unwrap();
    let places: Vec<_> = mission.items.iter().map(|item| (item.x, item.y)).collect();
    assert_eq!(places, [599_000_000, 599_100_000, 599_200_000].map(|x| (x, 107_000_000)));
    scan["TransectStyleComplexItem"]["VisualTransectPoints"] = json!([[59.91, 10.7], ["here", 10.7]]);
    assert!(
        matches!(fault(&plan(json!([scan]))), (Place::Item(1), Fault::Json(text)) if text.contains("no position"))
    );
}

#[test]
fn says_which_item_and_what_is_wrong() {
    let here = || waypoint(59.9, 10.7);
    assert_eq!(fault(&plan(json!([]))), (Place::File, Fault::Empty));
    assert_eq!(
        fault(&plan(json!([here(), survey(json!([]))]))),
        (Place::Item(2), Fault::ComplexItem("survey".into()))
    );
    for (kind, words) in [
        ("StructureScan", "structure scan"),
        ("fwLandingPattern", "landing pattern"),
        ("vtolLandingPattern", "landing pattern"),
    ] {
        let aloft =
            json!({"type": "ComplexItem", "complexItemType": kind, "landCoordinate": [59.9, 10.7, 0]});
        let (place, fault) = fault(&plan(json!([here(), aloft])));
        assert_eq!(place, Place::Item(2));
        assert!(matches!(fault, Fault::NotForBoats(_)) && fault.to_string().contains(words), "{fault}");
    }
    assert_eq!(fault(&plan(json!([{"type": "Item"}]))), (Place::Item(1), Fault::ItemType("Item".into())));
    assert_eq!(fault(&plan(json!([7]))), (Place::Item(1), Fault::ItemType("(none)".into())));
    let nowhere = fault(&plan(json!([here(), survey(json!([here(), waypoint(0.0, 0.0)]))])));
    assert_eq!(nowhere, (Place::Within(2, 2), PositionFault::NoPosition.into()));
    let mut short = here();
    short["params"] = json!([0, 0, 0]);
    assert!(
        matches!(fault(&plan(json!([short]))), (Place::Item(1), Fault::Json(text)) if text.contains("3 values"))
    );
    let mut huge = here();
    huge["params"][0] = json!(1e300);
    assert!(matches!(
        fault(&plan(json!([huge]))),
        (Place::Item(1), Fault::Number { column: "a parameter", .. })
    ));
    assert!(matches!(fault("{\"mission\": 5}"), (Place::File, Fault::Json(_))));
    assert!(
        matches!(fault("{\"fileType\": \"Plan\""), (Place::File, Fault::Json(text)) if text.contains("line 1"))
    );
}

#[test]
fn an_unusable_home_is_no_home() {
    for home in ["[0,0,0]", "[null,null,null]", "[]", "null", "[95,0,0]"] {
        let text = plan(json!([waypoint(59.9, 10.7)])).replace("[59.9,10.7,0]", home);
        assert_eq!(text.parse::<Mission>().unwrap().home, None, "{home}");
    }
}

proptest! {
    #[test]
    fn no_damage_makes_it_panic(cuts in prop::collection::vec((0..900usize, "[\\[\\]{},:\"0-9.e-]{0,2}"), 1..6)) {
        let mut text = plan(json!([waypoint(59.9, 10.7), survey(json!([waypoint(59.91, 10.7)]))]));
        for (at, piece) in cuts {
            let at = at.min(text.len());
            text.replace_range(at..(at + 1).min(text.len()), &piece);
        }
        let _ = text.parse::<Mission>();
    }
}
