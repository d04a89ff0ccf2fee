//! A fault script: which fault at which time of the motion, in TOML.

use core::fmt;

use dyn_can::DriveId;
use serde::Deserialize;
use toml::Spanned;

use super::Fault;
use super::entries::{
    AlarmEntry, BlockEntry, CorruptEntry, DelayReplyEntry, DisableEntry, DisturbEntry,
    DropRepliesEntry, Entry, LoseSetPointEntry, MissCyclesEntry, PowerCycleEntry,
    RepeatSetPointEntry, SilenceEntry, UnplugEntry,
};

/// The whole file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct File {
    alarm: Vec<Spanned<AlarmEntry>>,
    silence: Vec<Spanned<SilenceEntry>>,
    unplug: Vec<Spanned<UnplugEntry>>,
    power_cycle: Vec<Spanned<PowerCycleEntry>>,
    disable: Vec<Spanned<DisableEntry>>,
    drop_replies: Vec<Spanned<DropRepliesEntry>>,
    delay_reply: Vec<Spanned<DelayReplyEntry>>,
    repeat_set_point: Vec<Spanned<RepeatSetPointEntry>>,
    lose_set_point: Vec<Spanned<LoseSetPointEntry>>,
    corrupt: Vec<Spanned<CorruptEntry>>,
    block: Vec<Spanned<BlockEntry>>,
    disturb: Vec<Spanned<DisturbEntry>>,
    miss_cycles: Vec<Spanned<MissCyclesEntry>>,
}

/// Faults in the order of their times, which count from the start of the motion.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Script {
    /// The last comes first.
    pending: Vec<(u64, Fault)>,
}

impl Script {
    /// Reads a script for these drives.
    pub(crate) fn parse(text: &str, drives: &[DriveId]) -> Result<Self, ScriptError> {
        let file: File = toml::from_str(text).map_err(ScriptError::Toml)?;
        let mut reader = Reader {
            text,
            drives,
            faults: Vec::new(),
        };
        reader.take(file.alarm)?;
        reader.take(file.silence)?;
        reader.take(file.unplug)?;
        reader.take(file.power_cycle)?;
        reader.take(file.disable)?;
        reader.take(file.drop_replies)?;
        reader.take(file.delay_reply)?;
        reader.take(file.repeat_set_point)?;
        reader.take(file.lose_set_point)?;
        reader.take(file.corrupt)?;
        reader.take(file.block)?;
        reader.take(file.disturb)?;
        reader.take(file.miss_cycles)?;
        let mut pending = reader.faults;
        // Stable: what happens at one time happens in the order of the list above.
        pending.sort_by_key(|(at_ns, _)| *at_ns);
        pending.reverse();
        Ok(Self { pending })
    }

    /// The next fault that is due at this time of the motion.
    pub(crate) fn next_due(&mut self, at_ns: u64) -> Option<Fault> {
        self.pending
            .pop_if(|(due_ns, _)| *due_ns <= at_ns)
            .map(|(_, fault)| fault)
    }

    /// Faults whose time has not come.
    pub(crate) fn left(&self) -> usize {
        self.pending.len()
    }
}

struct Reader<'a> {
    text: &'a str,
    drives: &'a [DriveId],
    faults: Vec<(u64, Fault)>,
}

impl Reader<'_> {
    fn take<E: Entry>(&mut self, entries: Vec<Spanned<E>>) -> Result<(), ScriptError> {
        for entry in entries {
            let start = entry.span().start;
            let entry = entry.into_inner();
            let fault = entry.fault();
            if let Some(drive) = fault.drive().filter(|drive| !self.drives.contains(drive)) {
                return Err(ScriptError::Drive {
                    line: 1 + self
                        .text
                        .bytes()
                        .take(start)
                        .filter(|byte| *byte == b'\n')
                        .count(),
                    drive,
                    drives: self.drives.to_vec(),
                });
            }
            self.faults.push((entry.at().ns, fault));
            self.faults
                .extend(entry.end().map(|(at, fault)| (at.ns, fault)));
        }
        Ok(())
    }
}

/// A script that cannot be run.
#[derive(Debug)]
pub(crate) enum ScriptError {
    /// No TOML, or not the tables and values of a fault script; the message has the line.
    Toml(toml::de::Error),
    /// A drive that takes no part.
    Drive {
        line: usize,
        drive: DriveId,
        drives: Vec<DriveId>,
    },
}

impl fmt::Display for ScriptError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Toml(error) => write!(f, "{}", error.to_string().trim_end()),
            Self::Drive {
                line,
                drive,
                drives,
            } => {
                write!(
                    f,
                    "line {line}: drive {drive} takes no part; the drives are"
                )?;
                drives.iter().try_for_each(|drive| write!(f, " {drive}"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::num::NonZeroU64;
    use dyn_can::Alarm;

    fn drives() -> Vec<DriveId> {
        DriveId::all().take(2).collect()
    }

    fn faults(text: &str) -> Vec<(u64, Fault)> {
        let mut faults = Script::parse(text, &drives()).unwrap().pending;
        faults.reverse();
        faults
    }

    fn refusal(text: &str) -> String {
        Script::parse(text, &drives()).unwrap_err().to_string()
    }

    #[test]
    fn faults_come_in_the_order_of_their_times() {
        let text = "
            [[block]]
            at_s = 2.0
            for_s = 0.05
            [[alarm]]
            at_s = 1.5
            drive = 2
            alarm = \"over-current\"
            repeat_s = 0.01
            [[unplug]]
            at_s = 0.5
            drive = 1
            for_s = 1.25
        ";
        let [one, two] = [drives()[0], drives()[1]];
        assert_eq!(
            faults(text),
            [
                (500_000_000, Fault::Unplug { drive: one }),
                (
                    1_500_000_000,
                    Fault::Alarm {
                        drive: two,
                        alarm: Alarm::OverCurrent,
                        repeat_ns: NonZeroU64::new(10_000_000)
                    }
                ),
                (1_750_000_000, Fault::PlugIn { drive: one }),
                (2_000_000_000, Fault::Block { for_ns: 50_000_000 }),
            ]
        );
    }

    #[test]
    fn a_fault_is_due_once() {
        let mut script = Script::parse("[[disable]]\nat_s = 1\ndrive = 1\n", &drives()).unwrap();
        assert_eq!(script.next_due(999_999_999), None);
        assert!(script.next_due(1_000_000_000).is_some());
        assert_eq!((script.next_due(u64::MAX), script.left()), (None, 0));
    }

    #[test]
    fn the_example_of_the_documentation_is_a_script() {
        let document = include_str!("../../../../../docs/fault-scripts.md");
        let example = document
            .split("```toml\n")
            .nth(1)
            .and_then(|rest| rest.split("```").next())
            .expect("an example");
        let drives: Vec<DriveId> = DriveId::all().take(4).collect();
        let script = Script::parse(example, &drives).unwrap();
        // Thirteen kinds, and the ends of a silence and of an unplugging.
        assert_eq!(script.left(), 15);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let drive = refusal("# a comment\n\n[[disable]]\nat_s = 1.0\ndrive = 9\n");
        assert_eq!(drive, "line 3: drive 9 takes no part; the drives are 1 2");
        for (text, expected) in [
            (
                "[[disable]]\nat_s = -1.0\ndrive = 1\n",
                "must be 0..=86400 s, got -1",
            ),
            (
                "[[disable]]\nat_s = 1.0\ndrive = 64\n",
                "drive id must be 1..=63, got 64",
            ),
            (
                "[[disable]]\nat_s = 1.0\ndrive = 1\ncount = 2\n",
                "unknown field `count`",
            ),
            ("[[explode]]\nat_s = 1.0\n", "unknown field `explode`"),
            (
                "[[alarm]]\nat_s = 1.0\ndrive = 1\nalarm = \"fire\"\n",
                "unknown variant `fire`",
            ),
            ("[[disturb]]\nat_s = 1.0\n", "missing field `for_s`"),
        ] {
            let message = refusal(text);
            assert!(
                message.contains(expected) && message.contains("line "),
                "{message}"
            );
        }
    }
}
