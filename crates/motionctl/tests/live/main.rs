//! The tool and a bench as two processes that talk over a pseudo-terminal, as users run them.

mod adapter;
mod adapters;
mod bench;
mod board;
mod board_line;
mod board_stream;
mod commission;
mod documents;
mod first_hour;
mod home;
mod hub;
mod hub_home;
mod hub_recording;
mod hub_tune;
mod identity;
mod other_signals;
mod own_moves;
mod power;
mod power_matrix;
mod programs;
mod record;
mod recording;
mod relay;
mod run;
mod schemas;
mod serial;
mod serial_echo;
mod settings;
mod settings_refusals;
mod stream;
mod tcp;
mod terminal;
#[path = "../tool/mod.rs"]
mod tool;
mod tune;
mod undisturbed;
