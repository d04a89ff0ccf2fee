//! Writes a file: every key with its value, and what it means where the name does not say it.

use core::fmt::{self, Write as _};
use std::string::String;

use super::FORMAT;
use crate::axis::{AxisSettings, Dialect, Polls, ReadBack, Travel};
use crate::homing::{HomingDirection, HomingMethod, HomingSearch, HomingSettings, SwitchLevel};
use crate::settings::{BusSettings, Settings};

/// The text of a file with these settings.
#[must_use]
pub fn write(settings: &Settings) -> String {
    let mut text = String::new();
    // A string takes everything.
    let _ = write_settings(&mut text, settings);
    text
}

fn write_settings(text: &mut String, settings: &Settings) -> fmt::Result {
    writeln!(text, "# What a motion board is told.")?;
    writeln!(text, "format = {FORMAT}")?;
    let name = toml::Value::from(settings.name.as_str());
    writeln!(text, "name = {name}\n")?;
    write_bus(text, &settings.bus)?;
    writeln!(text, "\n[inputs]")?;
    writeln!(text, "enable_fitted = {}", settings.inputs.enable_fitted)?;
    settings
        .axes
        .iter()
        .try_for_each(|axis| write_axis(text, axis))
}

fn write_bus(text: &mut String, bus: &BusSettings) -> fmt::Result {
    let BusSettings {
        bit_rate_kbit_per_s,
        requests_per_cycle,
        response_min_us,
        response_max_us,
    } = bus;
    writeln!(text, "[bus]")?;
    writeln!(text, "bit_rate_kbit_per_s = {bit_rate_kbit_per_s}")?;
    writeln!(text, "requests_per_cycle = {requests_per_cycle}")?;
    writeln!(text, "# How long the drives take to answer.")?;
    writeln!(text, "response_min_us = {response_min_us}")?;
    writeln!(text, "response_max_us = {response_max_us}")
}

fn write_axis(text: &mut String, axis: &AxisSettings) -> fmt::Result {
    writeln!(text, "\n[[axis]]")?;
    writeln!(text, "drive = {}", axis.drive)?;
    writeln!(text, "gear_number = {}", axis.gear)?;
    writeln!(text, "speed_rpm = {}", axis.speed_rpm)?;
    writeln!(
        text,
        "acceleration_rpm_per_s = {}",
        axis.acceleration_rpm_per_s
    )?;
    write_optional(text, "jerk_rpm_per_s2", axis.jerk_rpm_per_s2)?;
    let (unit, min, max) = match axis.travel {
        Travel::Millidegrees { min, max } => ("millidegrees", min, max),
        Travel::Counts { min, max } => ("counts", min.into(), max.into()),
    };
    writeln!(text, "travel_min_{unit} = {min}")?;
    writeln!(text, "travel_max_{unit} = {max}")?;
    write_read_back(text, axis.read_back)?;
    writeln!(text, "# Axes of a group stop together.")?;
    writeln!(text, "group = {}", axis.group)?;
    write_polls(text, &axis.polls)?;
    writeln!(text, "unwatched = {}", axis.unwatched)?;
    writeln!(text, "load_can_fall = {}", axis.load_can_fall)?;
    let dialect = match axis.dialect {
        Dialect::Detect => "detect",
        Dialect::V1_2A => "1.2A",
        Dialect::V1_6A => "1.6A",
    };
    writeln!(text, "dialect = \"{dialect}\"")?;
    write_optional(text, "following_error_counts", axis.following_error_counts)?;
    write_optional(text, "drift_tolerance_counts", axis.drift_tolerance_counts)?;
    match &axis.homing {
        Some(homing) => write_homing(text, homing),
        None => Ok(()),
    }
}

fn write_homing(text: &mut String, homing: &HomingSettings) -> fmt::Result {
    let HomingSettings {
        method,
        order,
        reference_millidegrees,
    } = homing;
    let word = match method {
        HomingMethod::Here => "here",
        HomingMethod::Stop { .. } => "stop",
        HomingMethod::Switch { .. } => "switch",
    };
    writeln!(text, "# The travel counts from the origin that it finds.")?;
    writeln!(text, "homing = \"{word}\"")?;
    writeln!(text, "homing_order = {order}")?;
    writeln!(
        text,
        "homing_reference_millidegrees = {reference_millidegrees}"
    )?;
    match method {
        HomingMethod::Here => Ok(()),
        HomingMethod::Stop {
            search,
            torque_permille,
            contact_millidegrees,
        } => {
            write_search(text, search)?;
            writeln!(text, "homing_torque_permille = {torque_permille}")?;
            writeln!(text, "homing_contact_millidegrees = {contact_millidegrees}")
        }
        HomingMethod::Switch {
            search,
            pin,
            active,
        } => {
            write_search(text, search)?;
            writeln!(text, "# A pin of port C.")?;
            writeln!(text, "homing_switch_pin = {pin}")?;
            let active = match active {
                SwitchLevel::Low => "low",
                SwitchLevel::High => "high",
            };
            writeln!(text, "homing_switch_active = \"{active}\"")
        }
    }
}

fn write_search(text: &mut String, search: &HomingSearch) -> fmt::Result {
    let HomingSearch {
        direction,
        speed_rpm,
        slow_speed_rpm,
        acceleration_rpm_per_s,
        most_torque_permille,
        most_millidegrees,
        way_millidegrees,
        back_off_millidegrees,
    } = search;
    let direction = match direction {
        HomingDirection::Positive => "positive",
        HomingDirection::Negative => "negative",
    };
    writeln!(text, "homing_direction = \"{direction}\"")?;
    writeln!(text, "homing_way_millidegrees = {way_millidegrees}")?;
    writeln!(text, "homing_speed_rpm = {speed_rpm}")?;
    writeln!(text, "homing_slow_speed_rpm = {slow_speed_rpm}")?;
    writeln!(
        text,
        "homing_acceleration_rpm_per_s = {acceleration_rpm_per_s}"
    )?;
    writeln!(text, "# What ends the search.")?;
    writeln!(text, "homing_most_torque_permille = {most_torque_permille}")?;
    writeln!(text, "homing_most_millidegrees = {most_millidegrees}")?;
    writeln!(
        text,
        "homing_back_off_millidegrees = {back_off_millidegrees}"
    )
}

fn write_optional(text: &mut String, key: &str, value: Option<u32>) -> fmt::Result {
    value.map_or(Ok(()), |value| writeln!(text, "{key} = {value}"))
}

fn write_read_back(text: &mut String, read_back: ReadBack) -> fmt::Result {
    let word = match read_back {
        ReadBack::CommandCounts => "command-counts",
        ReadBack::MovementPositions => "movement-positions",
        ReadBack::MotorSteps => "motor-steps",
        ReadBack::Ratio {
            read_back_counts,
            command_counts,
        } => {
            writeln!(text, "read_back_counts = {read_back_counts}")?;
            return writeln!(text, "read_back_command_counts = {command_counts}");
        }
    };
    writeln!(text, "read_back = \"{word}\"")
}

fn write_polls(text: &mut String, polls: &Polls) -> fmt::Result {
    let Polls {
        status_us,
        position_us,
        torque_us,
        speed_us,
        counter_us,
    } = polls;
    writeln!(text, "# 0: not read.")?;
    writeln!(text, "status_poll_us = {status_us}")?;
    writeln!(text, "position_poll_us = {position_us}")?;
    writeln!(text, "torque_poll_us = {torque_us}")?;
    writeln!(text, "speed_poll_us = {speed_us}")?;
    writeln!(text, "counter_poll_us = {counter_us}")
}
