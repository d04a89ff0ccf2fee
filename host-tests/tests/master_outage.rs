//! An outage of the bus, and a drive that is gone: what it costs the others.
//!
//! A set-point is late when it ends on the wire after the end of the cycle in which the controller accepted it. The
//! n-th set-point that the controller accepted for an axis is the n-th of its identifier on the wire, because the
//! controller sends in the order of the requests.

use drive_sim::{Outage, OutageKind};
use dyn_can::FunctionCode;
use host_tests::rig::Rig;

const AXES: usize = 8;
const CYCLE_NS: u64 = 1_000_000;

/// In which cycle each set-point was accepted, axis by axis.
struct Accepted {
    cycles: Vec<Vec<u64>>,
}

impl Accepted {
    fn new(rig: &Rig) -> Self {
        let before = |axis| vec![0; rig.axis(axis).counters.set_points as usize];
        Self {
            cycles: (0..AXES).map(before).collect(),
        }
    }

    fn note(&mut self, rig: &Rig) {
        let cycle = rig.bench.now_ns() / CYCLE_NS - 1;
        for (axis, cycles) in self.cycles.iter_mut().enumerate() {
            cycles.resize(rig.axis(axis).counters.set_points as usize, cycle);
        }
    }

    /// Cycles of the late set-points that were accepted from a cycle on.
    fn late_from(&self, rig: &Rig, first: u64) -> Vec<u64> {
        let mut late = Vec::new();
        for (axis, cycles) in self.cycles.iter().enumerate() {
            let id = (axis as u16 + 1) << 5 | FunctionCode::GoRelativePosPd as u16;
            let ends = rig.traffic.iter().filter(|record| {
                let standard = embedded_can::StandardId::new(id).map(embedded_can::Id::Standard);
                Some(embedded_can::Frame::id(&record.frame)) == standard
                    && record.outcome.is_received()
            });
            let ends = ends.map(|record| record.end_ns);
            let pairs = cycles
                .iter()
                .zip(ends)
                .filter(|(cycle, _)| **cycle >= first);
            late.extend(
                pairs
                    .filter(|(cycle, end)| *end > (*cycle + 1) * CYCLE_NS)
                    .map(|(cycle, _)| *cycle),
            );
        }
        late
    }
}

fn cycle_with_motion(rig: &mut Rig, start: &[i32], step: i32) {
    for (axis, start) in start.iter().enumerate() {
        // Refused for an axis that stopped, which the test looks at.
        let _ = rig.master.set_target(axis, start + 35 * step);
    }
    rig.cycle();
}

fn moving() -> (Rig, Vec<i32>) {
    let mut rig = Rig::with_axes(AXES);
    rig.stream();
    let start: Vec<i32> = (0..AXES).map(|axis| rig.axis(axis).target_counts).collect();
    (1..=50).for_each(|step| cycle_with_motion(&mut rig, &start, step));
    (rig, start)
}

#[test]
fn ten_milliseconds_without_a_bus_leave_seven_late_frames_at_most() {
    for phase_us in [0, 100, 250, 400, 500, 750, 900] {
        let (mut rig, start) = moving();
        let mut accepted = Accepted::new(&rig);
        let from_ns = rig.bench.now_ns() + phase_us * 1_000;
        let first = rig.bench.now_ns() / CYCLE_NS;
        let until_ns = from_ns + 10_000_000;
        let outage = Outage {
            kind: OutageKind::Blocked,
            from_ns,
            until_ns,
        };
        rig.bench.bus_mut().add_outage(outage).unwrap();
        for step in 51..=150 {
            cycle_with_motion(&mut rig, &start, step);
            accepted.note(&rig);
        }
        rig.cycles(20);
        let late = accepted.late_from(&rig, first);
        println!(
            "outage from {phase_us} us in the cycle: {} late, in the cycles {late:?}",
            late.len()
        );
        assert!(late.len() <= 7, "phase {phase_us}: {} late", late.len());
        let clean_from = until_ns.div_ceil(CYCLE_NS) + 3;
        assert_eq!(
            accepted.late_from(&rig, clean_from),
            Vec::<u64>::new(),
            "phase {phase_us}"
        );
        for axis in 0..AXES {
            assert_eq!(rig.axis(axis).fault, None, "phase {phase_us}, axis {axis}");
            assert_eq!(rig.drive(axis).commanded_counts(), 35 * 150, "axis {axis}");
        }
    }
}

#[test]
fn a_lost_drive_costs_the_others_no_cycle() {
    let (mut rig, start) = moving();
    let mut accepted = Accepted::new(&rig);
    let first = rig.bench.now_ns() / CYCLE_NS;
    rig.drive_mut(3).faults_mut().leave_bus();
    for step in 51..=150 {
        cycle_with_motion(&mut rig, &start, step);
        accepted.note(&rig);
    }
    assert_eq!(rig.axis(3).fault, Some(can_motion::Fault::Lost));
    assert_eq!(accepted.late_from(&rig, first), Vec::<u64>::new());
    assert_eq!(rig.master.cycle_counters().late, 0);
}
