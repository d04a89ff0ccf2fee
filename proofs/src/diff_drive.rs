//! A vehicle on two wheels: every call of the differential drive.

use diff_drive::{DiffDrive, Geometry, Limits, Odometry, Pose, Twist};

use crate::opaque::{self, consume, float, number, word};

/// Every call with values that the compiler does not know.
pub fn exercise() {
    let geometry = Geometry::new(float(), float(), word());
    let limits = Limits::new(float(), float(), float(), opaque::bits());
    let (Ok(geometry), Ok(limits)) = (geometry, limits) else {
        return;
    };
    let geometry = *opaque::reach(&geometry);
    let mut vehicle = DiffDrive::new(geometry, limits, word() as u16);
    let vehicle = opaque::reach_mut(&mut vehicle);
    if let Ok(twist) = Twist::new(float(), float()) {
        let speeds = geometry.wheel_speeds(twist);
        consume(speeds.within(float()).scaled(float()));
        consume((twist.v_m_s(), twist.omega_rad_s(), speeds.fastest_rpm()));
        vehicle.set_twist(opaque::bits(), twist);
    }
    consume(vehicle.step(opaque::bits()));
    if opaque::flag() {
        vehicle.stand();
    }
    consume(*vehicle.geometry());
    let mut odometry = Odometry::new(geometry);
    let odometry = opaque::reach_mut(&mut odometry);
    consume(odometry.update(number(), number()).is_ok());
    consume(
        odometry
            .update(number(), number())
            .map_err(|jump| jump.most),
    );
    odometry.rebase(number(), number());
    odometry.set_pose(Pose {
        x_m: float(),
        y_m: float(),
        heading_rad: float(),
    });
    consume(odometry.update(number(), number()).is_ok());
    let pose = odometry.pose();
    consume((pose.wrapped_heading_rad(), pose.distance_m()));
    consume(odometry.travel_counts());
    consume((
        geometry.m_per_count(),
        geometry.track_m(),
        geometry.counts_per_turn(),
    ));
}
