//! Lets a CANopen master or drive that somebody else wrote meet ours, over lines on standard input and output.
//!
//! `canopen_bridge client` is the SDO client of `zlac8030l`, `canopen_bridge drive NODE` a simulated drive, and
//! `canopen_bridge dictionary` prints the object dictionary. See the modules of `host_tests::canopen_bridge`.

use std::process::ExitCode;

use host_tests::canopen_bridge::{client, dictionary, drive};
use zlac8030l::NodeId;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words[..] {
        ["client"] => client::run(),
        ["dictionary"] => dictionary::print(),
        ["drive", node] => match node.parse().map(NodeId::new) {
            Ok(Ok(node)) => drive::run(node),
            _ => return usage("a node is 1..=127"),
        },
        _ => return usage("expected client, dictionary, or drive with a node number"),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        // The other side has closed its end: that is how a run ends.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("canopen_bridge: {error}");
            ExitCode::FAILURE
        }
    }
}

fn usage(reason: &str) -> ExitCode {
    eprintln!("canopen_bridge: {reason}\nusage: canopen_bridge client | dictionary | drive NODE");
    ExitCode::from(2)
}
