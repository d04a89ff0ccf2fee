//! A figure of eight, with wheels that do what they are told: where does the odometry end?

use diff_drive::{DiffDrive, Geometry, Limits, Odometry, Twist};

const CYCLE_US: u64 = 10_000;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let geometry = Geometry::new(0.4, 0.085, 4_096)?;
    let limits = Limits::new(150.0, 300.0, 600.0, 200_000)?;
    let mut vehicle = DiffDrive::new(geometry, limits, 10);
    let mut odometry = Odometry::new(geometry);
    let (mut left, mut right) = (0.0, 0.0);
    odometry.update(0, 0)?;
    for cycle in 0..2_600_u64 {
        let now_us = cycle * CYCLE_US;
        // A circle to the left and one to the right, 12.6 s each.
        let omega = match now_us {
            0..12_566_000 => 0.5,
            12_566_000..25_132_000 => -0.5,
            _ => 0.0,
        };
        let v = if omega == 0.0 { 0.0 } else { 0.3 };
        vehicle.set_twist(now_us, Twist::new(v, omega)?);
        let command = vehicle.step(now_us);
        let counts = |number: i32| f64::from(number) / 10.0 / 60.0 * 4_096.0 * 0.01;
        left += counts(command.left);
        right += counts(command.right);
        odometry.update(left.round() as i32, right.round() as i32)?;
    }
    let pose = odometry.pose();
    println!(
        "x {:.3} m, y {:.3} m, heading {:.1} degrees",
        pose.x_m,
        pose.y_m,
        pose.heading_rad.to_degrees()
    );
    Ok(())
}
