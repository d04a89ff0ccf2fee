//! From an open port to an adapter on the bus, without a byte that could let an adapter of any kind send a frame.
//!
//! Adapters differ: some repeat their last command on an empty line, some know no `V` or begin its answer with another letter, some
//! acknowledge nothing, some start anew when their port is opened, some read one command of each USB packet and drop the rest.

use std::time::{Duration, Instant};

use super::Slcan;
use super::window::Window;
use crate::lawicel::{self, Token};
use crate::link::OpenError;
use crate::link::channel::Channel;
use crate::output::tell;

/// How long an adapter may take to start after its port was opened.
const BOOT_TIME: Duration = Duration::from_millis(4_000);
/// How long an adapter may take to answer a command while it is set up.
const ANSWER_TIME: Duration = Duration::from_millis(500);
/// Between commands that nobody answers, and for bytes of an earlier use to trickle in.
const SETTLE_TIME: Duration = Duration::from_millis(50);
/// The longest wait for a line that is quiet for once.
const LONGEST_SETTLING: Duration = Duration::from_millis(1_000);

/// Ends half a command of an earlier user. No empty line, because that repeats the last command of some adapters; no digit, because
/// half a frame could become a whole one; and more letters than any adapter has room for.
const FLUSH: &str = match core::str::from_utf8(&[b'V'; 160]) {
    Ok(flush) => flush,
    Err(_) => panic!("plain text"),
};

/// An answer to a command of the set-up.
#[derive(Debug, PartialEq, Eq)]
enum Answer {
    Done,
    Refused,
    /// Not what an adapter says.
    Text(Vec<u8>),
}

impl Slcan {
    /// Wakes the adapter, closes its channel, sets the bit rate and opens the channel.
    pub(super) fn set_up(
        &mut self,
        bit_rate_code: char,
        channel: Channel,
        expects_answers: bool,
    ) -> Result<(), OpenError> {
        let answers = self.wake()?;
        if !answers && expects_answers {
            return Err(self.no_adapter(Vec::new()));
        }
        self.settle()?;
        let bit_rate = format!("S{bit_rate_code}");
        // Both in one packet: an adapter that answers both takes more than one command at a time.
        let answers = self.ask(&format!("C\r{bit_rate}"), 2)?;
        match answers.as_slice() {
            [_, Answer::Refused] => return Err(self.refused(&bit_rate)),
            [_, _] => {}
            _ => self.command(&bit_rate, !answers.is_empty())?,
        }
        if answers.len() == 1 {
            self.window = Window::new(1);
        }
        let answers_commands = !answers.is_empty();
        // What came until here is of an earlier use.
        self.received.clear();
        match channel {
            Channel::Open => self.command("O", answers_commands),
            Channel::ListenOnly => self.listen_only(answers_commands),
        }
    }

    fn listen_only(&mut self, answers_commands: bool) -> Result<(), OpenError> {
        if let Err(error) = self.command("L", answers_commands) {
            return Err(match error {
                OpenError::CommandRefused { port, .. } => OpenError::NoListenOnly { port },
                other => other,
            });
        }
        if !answers_commands {
            tell(format_args!(
                "note: the adapter on {} does not answer the command L; if it does not know it, nothing is received: --acknowledge does without",
                self.name
            ));
        }
        Ok(())
    }

    /// Asks until the adapter answers anything, or its time to start is over. Returns whether it did.
    fn wake(&mut self) -> Result<bool, OpenError> {
        let until = Instant::now() + BOOT_TIME;
        while Instant::now() < until {
            self.say(FLUSH)?;
            self.settle()?;
            for command in ["C", "V"] {
                self.say(command)?;
                let answer_until = Instant::now() + ANSWER_TIME / 2;
                if self.next_answer(answer_until)?.is_some() {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Waits until the line is quiet, and forgets what was on it.
    fn settle(&mut self) -> Result<(), OpenError> {
        let until = Instant::now() + LONGEST_SETTLING;
        while Instant::now() < until && self.next_token(Instant::now() + SETTLE_TIME).is_some() {}
        let cleared = self.port.clear_input();
        cleared.map_err(|error| self.system(error))?;
        self.lines.clear();
        Ok(())
    }

    /// A command of which silence is no refusal.
    fn command(&mut self, command: &str, answers: bool) -> Result<(), OpenError> {
        if !answers {
            self.say(command)?;
            let until = Instant::now() + SETTLE_TIME;
            return match self.next_answer(until)? {
                Some(Answer::Refused) => Err(self.refused(command)),
                _ => Ok(()),
            };
        }
        match self.ask(command, 1)?.as_slice() {
            [Answer::Refused] => Err(self.refused(command)),
            _ => Ok(()),
        }
    }

    /// Up to so many answers to commands that are answered without a text.
    fn ask(&mut self, commands: &str, most: usize) -> Result<Vec<Answer>, OpenError> {
        self.say(commands)?;
        let until = Instant::now() + ANSWER_TIME;
        let mut answers = Vec::new();
        while answers.len() < most
            && let Some(answer) = self.next_answer(until)?
        {
            if let Answer::Text(text) = answer {
                return Err(self.no_adapter(text));
            }
            answers.push(answer);
        }
        Ok(answers)
    }

    fn next_answer(&mut self, until: Instant) -> Result<Option<Answer>, OpenError> {
        while let Some(token) = self.next_token(until) {
            return Ok(Some(match token {
                Token::Bell => Answer::Refused,
                Token::Overlong => Answer::Text(b"a line without end".to_vec()),
                Token::Line(line) if matches!(line.as_slice(), [] | b"z" | b"Z") => Answer::Done,
                Token::Line(line) => match lawicel::decode(&line) {
                    Some(frame) => {
                        self.received.push_back(frame);
                        continue;
                    }
                    None => Answer::Text(line),
                },
            }));
        }
        match self.fault {
            Some(fault) => Err(self.system(std::io::Error::other(fault))),
            None => Ok(None),
        }
    }

    fn say(&mut self, line: &str) -> Result<(), OpenError> {
        let mut bytes = line.as_bytes().to_vec();
        bytes.push(lawicel::CR);
        self.port
            .write_all_within(&bytes, ANSWER_TIME)
            .map_err(|error| self.system(error))
    }

    fn no_adapter(&self, heard: Vec<u8>) -> OpenError {
        let port = self.name.clone();
        OpenError::NoAdapter { port, heard }
    }

    fn refused(&self, command: &str) -> OpenError {
        OpenError::CommandRefused {
            port: self.name.clone(),
            command: command.to_owned(),
        }
    }
}
