//! Every help text, checked for what a machine can see.

#[path = "../src/plain_words.rs"]
mod plain_words;
mod tool;

use plain_words::flaws;
use tool::{motionctl, text};

/// The commands that the tool lists.
fn commands() -> Vec<String> {
    let output = motionctl(&["--help"]);
    let help = text(&output.stdout).to_owned();
    let list = help
        .split_once("Commands:\n")
        .expect("a list of commands")
        .1
        .to_owned();
    list.lines()
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

#[test]
fn no_help_text_has_a_flaw() {
    let commands = commands();
    assert!(commands.len() > 12, "{commands:?}");
    for flag in ["--help", "-h"] {
        let mut helps = vec![motionctl(&[flag])];
        helps.extend(
            commands
                .iter()
                .filter(|command| *command != "help")
                .map(|command| motionctl(&[command.as_str(), flag])),
        );
        for help in helps {
            assert!(help.status.success());
            let help = text(&help.stdout);
            assert!(help.contains("Usage:"), "{help}");
            assert_eq!(flaws(help), [""; 0], "{help}");
        }
    }
}

#[test]
fn every_command_says_its_exit_status_or_has_only_the_usual_ones() {
    for command in commands() {
        if ["help", "completions"].contains(&command.as_str()) {
            continue;
        }
        let output = motionctl(&[command.as_str(), "--help"]);
        let help = text(&output.stdout);
        assert!(help.contains("Exit status"), "{command}");
        assert!(help.contains("Examples:"), "{command}");
    }
}
