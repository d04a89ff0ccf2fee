//! What the plan promises, against what is on the bus.

use crate::support::servos::{Line, Servo, Servos, ToDrive, Told, line, servo, servos};
use crate::support::{Call, assert_none};

const CYCLE_NS: u64 = 1_000_000;

/// Cycles in which each axis must have had its set-point through, and had not.
fn late(to_drives: &[ToDrive], axes: usize, first: u64, cycles: u64) -> usize {
    let mut through = vec![vec![0_u32; cycles as usize]; axes];
    for to in to_drives {
        if let Told::SetPoint(_) = to.told {
            let cycle = to.free_ns.saturating_sub(1) / CYCLE_NS;
            if let Some(count) = cycle
                .checked_sub(first)
                .and_then(|cycle| through[to.axis].get_mut(cycle as usize))
            {
                *count += 1;
            }
        }
    }
    through
        .iter()
        .flatten()
        .filter(|count| **count != 1)
        .count()
}

/// As many servos as the plan takes, in slow motion: set-points that were late, and set-points at all.
fn streamed(line: Line, servos: &[Servo], cycles: u64) -> (usize, u64, u32) {
    let mut machine = Servos::on(line, servos);
    machine.stream();
    machine.run(8);
    let first = machine.now_ns() / CYCLE_NS;
    let mark = machine.mark();
    // Slow motion: two of three set-points are 0.
    let start: Vec<i32> = (0..servos.len()).map(|axis| machine.target(axis)).collect();
    for cycle in 0..cycles as i32 {
        for (axis, start) in start.iter().enumerate() {
            let _ = machine.set_target(axis, start + cycle / 3 * axis as i32);
        }
        machine.run(1);
    }
    let told = machine.told_since(mark);
    let counted = machine.0.master.cycle_counters().late;
    (
        late(&told, servos.len(), first, cycles),
        cycles * servos.len() as u64,
        counted,
    )
}

/// Finding 16.
#[test]
fn what_the_plan_admits_by_identifier_is_in_time() {
    let line = line().by_identifier();
    let mut found = Vec::new();
    let mut admitted = 0;
    for count in 1..=14 {
        let servos = servos(count);
        if line.admits(&servos).is_err() {
            continue;
        }
        admitted += 1;
        let (late, all, counted) =
            streamed(line, &servos, 20_000 / u64::from(count.unsigned_abs()));
        if late > 0 || counted > 0 {
            found.push(format!(
                "{count} polled axes, by identifier: {late} of {all} set-points are late, the master counts {counted} late cycles"
            ));
        }
    }
    assert!(admitted > 0, "the plan admits nothing by identifier");
    assert_none(&found);
}

/// The same first in, first out, which is right.
#[test]
fn what_the_plan_admits_first_in_first_out_is_in_time() {
    let mut found = Vec::new();
    for count in [1, 4, 8] {
        let (late, all, counted) = streamed(line(), &servos(count), 2_000);
        if late > 0 || counted > 0 {
            found.push(format!(
                "{count} axes: {late} of {all} late, {counted} counted"
            ));
        }
    }
    assert_none(&found);
}

/// Finding 17: a group whose axes are not all confirmed at once.
#[test]
fn readings_that_confirm_an_enabling_group_keep_the_bound_of_the_plan() {
    let mut found = Vec::new();
    for polled in [false, true] {
        let mut worst = [(0, 0, [0; 2]); 2];
        for delays_us in (1..20).flat_map(|one| (1..20).map(move |two| [one * 100, two * 100])) {
            let servos: Vec<Servo> = delays_us
                .iter()
                .zip(1..)
                .map(|(delay_us, id)| {
                    let servo = servo(id).any_step().drive(|drive| {
                        drive.response_delay = drive_sim::ResponseDelay::fixed(delay_us * 1_000);
                    });
                    if polled { servo } else { servo.unwatched() }
                })
                .collect();
            let ends = ends_while_enabling(&servos);
            for (axis, bits) in ends.into_iter().enumerate() {
                let bound = u64::from(line().set_point_bound_bits(&servos, axis));
                if bits > bound && bits > worst[axis].0 {
                    worst[axis] = (bits, bound, delays_us);
                }
            }
        }
        for (axis, (bits, bound, delays_us)) in worst.into_iter().enumerate() {
            if bits > bound {
                found.push(format!(
                    "polled: {polled}, replies after {delays_us:?} us: a set-point of axis {axis} is through after {bits} us while its group is enabled, its bound is {bound}"
                ));
            }
        }
    }
    assert_none(&found);
}

/// When the latest set-point of each axis was through, from the start of its cycle, in microseconds, from enable on.
fn ends_while_enabling(servos: &[Servo]) -> [u64; 2] {
    let mut machine = Servos::new(servos);
    machine.become_ready();
    let mark = machine.mark();
    machine.call(Call::Enable).unwrap();
    let mut step = 8_191;
    for _ in 0..260 {
        for axis in 0..2 {
            let target = machine.target(axis) + step;
            let _ = machine.set_target(axis, target);
        }
        step = -step;
        machine.run(1);
    }
    let mut ends = [0, 0];
    for to in machine.told_since(mark) {
        if let Told::SetPoint(_) = to.told {
            ends[to.axis] = ends[to.axis].max((to.free_ns % CYCLE_NS) / 1_000);
        }
    }
    ends
}
