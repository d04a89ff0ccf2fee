//! A vehicle that follows twists: the odometry takes what the drives report, and is compared with what their wheels did.

use can_motion::AxisState;
use diff_drive::{DiffDrive, JumpError, Odometry, Phase, Twist};
use indicatif::ProgressBar;

use super::{Bench, GROUP};
use crate::recording::Recorded;
use crate::sim::error::SimError;
use crate::sim::wheels::vehicle::{PoseSummary, VehicleSummary};
use crate::twist::{TwistLine, Vehicle};

/// Time after the last twist for the wheels to come to rest and to be read.
const REST_US: u64 = 2_000_000;

/// A vehicle on its way.
struct Drive<'a> {
    vehicle: &'a Vehicle,
    control: DiffDrive,
    /// From the feedback of the drives.
    odometry: Odometry,
    /// From the shafts of the simulated wheels.
    truth: Odometry,
    timed_out_cycles: u32,
    limited_cycles: u32,
    jumps: u32,
}

impl Bench<'_> {
    /// From power-on to rest, with the twists in between. Two wheels: the first is the left one.
    pub(in crate::sim::wheels) fn drive(
        mut self,
        vehicle: &Vehicle,
        lines: &[TwistLine],
        show_progress: bool,
    ) -> Result<(VehicleSummary, Recorded), SimError> {
        self.run_until(AxisState::Ready)?;
        // Refused only when a wheel is not ready, and the summary will say so.
        let _ = self.master.enable(self.now(), GROUP);
        self.run_until(AxisState::Streaming)?;
        self.begin_motion();
        let mut drive = Drive {
            vehicle,
            control: vehicle.drive(self.setup.speed_resolution),
            odometry: vehicle.odometry(),
            truth: vehicle.odometry(),
            timed_out_cycles: 0,
            limited_cycles: 0,
            jumps: 0,
        };
        self.locate(&mut drive);
        let mut cycles = self.cycles_of(lines);
        let bar = if show_progress {
            ProgressBar::new(cycles)
        } else {
            ProgressBar::hidden()
        };
        let mark = self.bench.bus().load_mark();
        let mut next = lines.iter().peekable();
        let mut cycle = 0;
        while cycle < cycles {
            let at_s = cycle as f64 * f64::from(self.setup.cycle_us) * 1e-6;
            let now_us = self.now().as_us();
            // A hair of a cycle: times of a file are decimal and cycles are not.
            while let Some(line) = next.next_if(|line| line.time_s <= at_s + 1e-9) {
                drive.control.set_twist(now_us, line.twist);
            }
            if self.stopped {
                // Nothing comes any more.
                next = [].iter().peekable();
                cycles = cycles.min(cycle + self.rest_cycles());
            }
            if next.peek().is_none() && cycle + self.rest_cycles() >= cycles {
                // The stream has ended: that is a stop, and no silence.
                drive.control.set_twist(now_us, Twist::ZERO);
            }
            self.cycle_of(&mut drive)?;
            cycle += 1;
            bar.inc(1);
        }
        let mean_bus_load = self.bench.bus().load_since(&mark);
        bar.finish_and_clear();
        self.phase(if self.stopped {
            "stopped by the user"
        } else {
            "the motion ends"
        });
        let summary = self.vehicle_summary(&drive, cycles as usize, mean_bus_load);
        let recorded = self.close(summary.verdict(), summary.promises_kept)?;
        Ok((summary, recorded))
    }

    fn rest_cycles(&self) -> u64 {
        REST_US / u64::from(self.setup.cycle_us)
    }

    fn cycles_of(&self, lines: &[TwistLine]) -> u64 {
        let last_s = lines.last().map_or(0.0, |line| line.time_s);
        let cycle_s = f64::from(self.setup.cycle_us) * 1e-6;
        (last_s / cycle_s).ceil() as u64 + self.rest_cycles()
    }

    fn cycle_of(&mut self, drive: &mut Drive<'_>) -> Result<(), SimError> {
        let command = drive.control.step(self.now().as_us());
        drive.timed_out_cycles += u32::from(command.phase == Phase::TimedOut);
        drive.limited_cycles += u32::from(command.is_limited);
        let (left, right) = drive.vehicle.mounted((command.left, command.right));
        for (wheel, speed) in [left, right].into_iter().enumerate() {
            // Refused after a fault, which the summary shows.
            let _ = self.master.set_target(self.wheels[wheel].place, speed);
            self.wheels[wheel].commanded += i64::from(speed);
        }
        self.one_cycle()?;
        self.late_cycles += u32::from(self.set_points_of_cycle < self.wheels.len());
        self.watch_wheels();
        self.locate(drive);
        Ok(())
    }

    /// What the drives report, and what their shafts did.
    fn locate(&self, drive: &mut Drive<'_>) {
        let read = |wheel: usize| {
            let snapshot = self.master.snapshot(self.wheels.get(wheel)?.place)?;
            Some(snapshot.feedback.position_counts?.value)
        };
        let now_ns = self.bench.now_ns();
        let shaft = |wheel: usize| {
            let device = self.devices.get(wheel)?;
            // The lower 32 bits, which is what counts in a drive.
            Some(self.bench.device(*device).travel_counts(now_ns) as i32)
        };
        let mut take = |odometry: &mut Odometry, counts: Option<(i32, i32)>| {
            let Some((left, right)) = counts.map(|counts| drive.vehicle.mounted(counts)) else {
                return;
            };
            if let Err(JumpError { .. }) = odometry.update(left, right) {
                odometry.rebase(left, right);
                drive.jumps += 1;
            }
        };
        take(&mut drive.odometry, read(0).zip(read(1)));
        take(&mut drive.truth, shaft(0).zip(shaft(1)));
    }

    fn vehicle_summary(
        &self,
        drive: &Drive<'_>,
        cycles: usize,
        mean_bus_load: f64,
    ) -> VehicleSummary {
        VehicleSummary::new(
            PoseSummary::of(&drive.odometry),
            PoseSummary::of(&drive.truth),
            [drive.timed_out_cycles, drive.limited_cycles, drive.jumps],
            self.summary(cycles, mean_bus_load),
        )
    }
}
