//! What broke once, in the words of the field: one test for each finding, judged by what drives and bus saw.

mod bus_plan;
mod clear;
mod combinations;
mod commands_in_transition;
mod faults_servo;
mod faults_wheel;
mod found_on;
mod neighbours;
mod outage;
mod own_move_faults;
mod own_moves;
mod procedures;
mod ramps;
mod refusals;
mod support;
mod watch;
mod wheel_life;
mod wheels;
