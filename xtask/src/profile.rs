//! `cargo xtask profile`: where the instructions of a cycle go, by function.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::axis_profile;
use crate::emulator::{AxisMotion, Emulator, Load};
use crate::error::Error;
use crate::images::{Board, Image};
use crate::output::print;
use crate::thumb::Builder;
use crate::toolchain::Preference;

/// What is counted and printed when nobody says how much.
const MILLISECONDS: u32 = 2_000;
const ROWS: usize = 40;
/// Instructions are told in tenths.
const PARTS: u64 = 10;

/// Runs the image of the firmware on the emulated board and prints how many instructions of a cycle each function takes.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask profile --axes 8 --response-us 500 --moving    where a cycle of eight moving axes goes\n  \
    cargo xtask profile --axes 8 --board stm32g474             the other board, axes that hold their positions\n  \
    cargo xtask profile --axes 2 --rows 1000                   every function on a line of its own\n  \
    cargo xtask profile --axes 8 --json                        every function, for another program\n  \
    cargo xtask profile --link --context TIM2                  the cycle of the image that takes orders, behind a host that streams\n  \
    cargo xtask profile --master-alone                         one axis of the master, without firmware and bus\n\n\
    The lines add up to the mean of a millisecond, which is one cycle. An instruction counts for the innermost function of this\n\
    project or of a package that it belongs to, also where the compiler has inlined that function; the standard library\n\
    counts for its caller. Drives take the time of --response-us to answer, each time up to a quarter more or less. Contexts are the\n\
    interrupts of the vector table, and the thread. Instructions are counted on the emulated board, which has no wait states.")]
pub(crate) struct Arguments {
    /// Number of axes, with the drives 1, 2, 3 and so on
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u8).range(1..=14))]
    axes: u8,

    /// Time until a drive answers, in microseconds
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    response_us: u32,

    /// The axes move; without this they hold their positions
    #[arg(long)]
    moving: bool,

    /// The image that takes orders, with a host that streams 50 segments a second and reads as many snapshots, in the place of the one with
    /// a built-in motion
    #[arg(long, conflicts_with = "moving")]
    link: bool,

    /// Only what runs in this context: an interrupt by its name in the vector table, such as TIM2, or thread
    #[arg(long, conflicts_with = "json")]
    context: Option<String>,

    /// The board
    #[arg(long, value_enum, default_value = "stm32f405")]
    board: Board,

    /// Milliseconds to count
    #[arg(long, default_value_t = MILLISECONDS, value_parser = clap::value_parser!(u32).range(1..))]
    ms: u32,

    /// Most functions to print; those that take least share the last line
    #[arg(long, default_value_t = ROWS, conflicts_with = "json")]
    rows: usize,

    /// Print one line of JSON
    #[arg(long)]
    json: bool,

    /// One axis in one cycle of the master alone, target in, frame out, in the place of the firmware: what a cycle of eight axes takes
    /// more than one of one axis, by seven
    #[arg(long, conflicts_with_all = ["axes", "response_us", "moving", "link", "context", "board", "ms", "json"])]
    master_alone: bool,

    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,
}

/// Runs the task.
///
/// # Errors
/// When the image or the emulator does not build, or the emulator fails.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let builder = Builder::find(arguments.toolchain)?;
    let emulator = Emulator::prepare()?;
    if arguments.master_alone {
        return print(axis_profile::table(&builder, &emulator, arguments.rows)?);
    }
    let axes = usize::from(arguments.axes);
    let motion = match (arguments.link, arguments.moving) {
        (true, _) => AxisMotion::Streamed,
        (false, true) => AxisMotion::BuiltIn,
        (false, false) => AxisMotion::Standing,
    };
    let image = if arguments.link {
        Image::with_link(arguments.board)
    } else {
        Image::with_axes(arguments.board, axes)
    };
    let image = image.build(&builder, emulator.images())?;
    let load = Load {
        axes,
        response_us: arguments.response_us,
        motion,
    };
    let answer = emulator.profile(&image, arguments.board, load, arguments.ms)?;
    if arguments.json {
        return print(format_args!("{answer}\n"));
    }
    let table = read(&answer, arguments.context.as_deref())?.table(arguments.rows);
    print(format_args!(
        "{}: {load}\n{table}",
        arguments.board.feature()
    ))
}

/// The table of an image, with its usual number of lines.
///
/// # Errors
/// When the emulator fails.
pub(crate) fn table(
    emulator: &Emulator,
    image: &Path,
    board: Board,
    load: Load,
) -> Result<String, Error> {
    let answer = emulator.profile(image, board, load, MILLISECONDS)?;
    Ok(read(&answer, None)?.table(ROWS))
}

fn read(answer: &Value, context: Option<&str>) -> Result<Profile, Error> {
    let profile = Profile::read(answer, context).ok_or_else(|| Error::Answer {
        program: "the emulator's program `profile`".into(),
        expected: "instructions by function and context",
    })?;
    if let Some(actual) = context
        && profile.contexts.is_empty()
    {
        let all = read(answer, None)?.contexts.into_iter();
        return Err(Error::Context {
            actual: actual.into(),
            known: all.map(|(name, _)| name).collect(),
        });
    }
    Ok(profile)
}

/// How often what was executed.
struct Profile {
    milliseconds: u64,
    instructions: u64,
    worst: u64,
    /// Name, file and instructions of each function, the one that takes most first.
    functions: Vec<(String, u64)>,
    /// The same by context.
    contexts: Vec<(String, u64)>,
}

impl Profile {
    /// What ran in a context, or in all of them; `None` when something is missing.
    fn read(answer: &Value, only: Option<&str>) -> Option<Self> {
        let mut functions = Vec::new();
        let mut contexts: Vec<(String, u64)> = Vec::new();
        for entry in answer["functions"].as_array()? {
            let mut sum = 0;
            let by_context = entry["instructions"].as_object()?.iter();
            for (context, instructions) in
                by_context.filter(|(context, _)| only.is_none_or(|only| only == *context))
            {
                let instructions = instructions.as_u64()?;
                sum += instructions;
                match contexts.iter_mut().find(|(name, _)| name == context) {
                    Some((_, all)) => *all += instructions,
                    None => contexts.push((context.clone(), instructions)),
                }
            }
            let (function, file) = (entry["function"].as_str()?, entry["file"].as_str()?);
            if sum > 0 {
                functions.push((format!("{function}  {file}"), sum));
            }
        }
        for list in [&mut functions, &mut contexts] {
            list.sort_by(|one, other| (other.1, &one.0).cmp(&(one.1, &other.0)));
        }
        Some(Self {
            milliseconds: answer["milliseconds"].as_u64()?,
            instructions: contexts.iter().map(|(_, all)| all).sum(),
            worst: answer["worst_millisecond"].as_u64()?,
            functions,
            contexts,
        })
    }

    fn table(&self, rows: usize) -> String {
        let mut text = format!(
            "{} instructions a cycle, the mean of {} ms; in the worst millisecond {} in all contexts\n",
            tenths(self.of_a_cycle(self.instructions)),
            self.milliseconds,
            self.worst
        );
        self.write(&mut text, "context", &self.contexts);
        let (shown, rest) = self.functions.split_at(rows.min(self.functions.len()));
        let mut shown = shown.to_vec();
        if !rest.is_empty() {
            let sum = rest.iter().map(|(_, instructions)| instructions).sum();
            shown.push((format!("{} other functions", rest.len()), sum));
        }
        self.write(&mut text, "function", &shown);
        text
    }

    fn of_a_cycle(&self, instructions: u64) -> u64 {
        (PARTS * instructions + self.milliseconds / 2) / self.milliseconds.max(1)
    }

    fn write(&self, text: &mut String, what: &str, lines: &[(String, u64)]) {
        let counts: Vec<u64> = lines.iter().map(|&(_, count)| count).collect();
        let total = self.of_a_cycle(self.instructions);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n{:>12}  {:>6}  {what}", "instructions", "share");
        for ((name, _), part) in lines.iter().zip(apportion(total, &counts)) {
            let share = 100.0 * part as f64 / total.max(1) as f64;
            let _ = writeln!(text, "{:>12}  {share:>5.1} %  {name}", tenths(part));
        }
        let _ = writeln!(text, "{:>12}  100.0 %  all", tenths(total));
    }
}

fn tenths(value: u64) -> String {
    format!("{}.{}", value / PARTS, value % PARTS)
}

/// Whole parts of a total in proportion to the counts, rounded so that they add up to it.
fn apportion(total: u64, counts: &[u64]) -> Vec<u64> {
    let all = counts
        .iter()
        .map(|&count| u128::from(count))
        .sum::<u128>()
        .max(1);
    let exact = |count: u64| u128::from(total) * u128::from(count);
    let mut parts: Vec<u64> = counts
        .iter()
        .map(|&count| (exact(count) / all) as u64)
        .collect();
    let mut by_remainder: Vec<usize> = (0..counts.len()).collect();
    by_remainder.sort_by_key(|&index| std::cmp::Reverse(exact(counts[index]) % all));
    let missing = total.saturating_sub(parts.iter().sum()) as usize;
    for &index in by_remainder.iter().take(missing) {
        parts[index] += 1;
    }
    parts
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn answer() -> Value {
        json!({
            "milliseconds": 3,
            "instructions": 1_000,
            "worst_millisecond": 400,
            "functions": [
                {"function": "b", "file": "b.rs", "instructions": {"CAN1_TX": 100, "thread": 201}},
                {"function": "a", "file": "a.rs", "instructions": {"CAN1_TX": 600}},
                {"function": "c", "file": "c.rs", "instructions": {"thread": 99}},
            ],
        })
    }

    fn profile() -> Profile {
        Profile::read(&answer(), None).unwrap()
    }

    #[test]
    fn a_context_is_shown_alone_and_an_unknown_one_is_refused_with_the_known_ones() {
        let table = read(&answer(), Some("thread")).unwrap().table(40);
        assert!(table.starts_with("100.0 instructions a cycle"), "{table}");
        assert!(!table.contains("a.rs"), "{table}");
        let Err(refused) = read(&answer(), Some("TIM3")) else {
            panic!("nothing ran there");
        };
        assert_eq!(
            refused.to_string(),
            "--context: expected one of CAN1_TX, thread, in which something ran, got TIM3"
        );
    }

    #[test]
    fn the_lines_of_each_table_add_up_to_the_cycle() {
        for rows in [1, 2, 40] {
            let text = profile().table(rows);
            assert!(text.starts_with("333.3 instructions a cycle"), "{text}");
            for table in text.split("\n\n").skip(1) {
                let parts = table.lines().skip(1).map(|line| {
                    let digits = line.split_whitespace().next().unwrap().replace('.', "");
                    digits.parse::<u64>().unwrap()
                });
                let mut parts: Vec<u64> = parts.collect();
                let total = parts.pop().unwrap();
                assert_eq!(
                    (total, parts.iter().sum::<u64>()),
                    (3_333, 3_333),
                    "{table}"
                );
            }
        }
    }

    #[test]
    fn the_largest_comes_first_and_the_smallest_share_a_line() {
        let text = profile().table(1);
        let functions: Vec<&str> = text.split("\n\n").nth(2).unwrap().lines().collect();
        assert!(functions[1].ends_with("a  a.rs"), "{functions:?}");
        assert!(functions[2].ends_with("2 other functions"), "{functions:?}");
    }

    #[test]
    fn an_answer_without_a_figure_is_refused() {
        assert!(Profile::read(&json!({"functions": []}), None).is_none());
    }
}
