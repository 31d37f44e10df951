//! The control step allocates nothing, for any boat.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use helmlink::control::{Boat, Helm};
use helmlink::guidance::{EndOfPath, VesselState};
use helmlink_mission::geodesy::NorthEast;
use helmlink_mission::path::{Path, PathLimits};

thread_local! {
    /// Allocations of this thread so far: the test harness has threads of its own.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn count_one() {
    ALLOCATIONS.with(|count| count.set(count.get() + 1));
}

/// The system's allocator, counting.
struct Counting;

// A global allocator cannot be written without `unsafe`; this one hands everything to the system's.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count_one();
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count_one();
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_step_allocates_nothing() {
    let points = [(0.0, 0.0), (0.0, 200.0), (150.0, 200.0), (150.0, 0.0)]
        .map(|(north_m, east_m)| NorthEast { north_m, east_m });
    let path = Path::through(&points, &PathLimits::new(8.0, 6.0)).unwrap();
    for name in Boat::names() {
        let boat = Boat::embedded(name).unwrap();
        let mut helm = Helm::new(&boat, EndOfPath::Stop);
        helm.set_delay_s(0.4);
        let mut state = VesselState {
            position: NorthEast { north_m: 1.0, east_m: 0.0 },
            heading_rad: 1.0,
            surge_mps: 1.0,
            sway_mps: 0.1,
            yaw_rate_radps: 0.05,
        };
        helm.engage(&state, 0.0).unwrap();
        let before = ALLOCATIONS.get();
        for tick in 0..4000 {
            let place = path.point(0.1 * f64::from(tick));
            state.position = place.position + NorthEast { north_m: 0.3, east_m: -0.2 };
            state.heading_rad = place.heading_rad + 0.2;
            helm.step(0.05, &state, &path, 1.2).unwrap();
            let lost = VesselState { surge_mps: f64::NAN, ..state };
            helm.step(0.05, &lost, &path, 1.2).unwrap_err();
        }
        assert_eq!(ALLOCATIONS.get() - before, 0, "{name}");
    }
}
