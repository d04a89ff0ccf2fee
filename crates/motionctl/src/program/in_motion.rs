//! A program as a source of set-points: pause, override and stop are those of its path, so they keep every limit of its axes.

use std::collections::VecDeque;

use super::check::Checked;
use super::error::ProgramFileError;
use super::player::Player;
use crate::set_points::{Order, SetPointSource, Speed, Step};

/// A checked program under way.
#[derive(Debug)]
pub(crate) struct ProgramInMotion<'a> {
    checked: &'a Checked,
    player: Player,
    row: Vec<i32>,
    cycles: u64,
    asked_percent: u16,
    is_paused: bool,
    is_stopping: bool,
    end: Option<Step>,
    notices: VecDeque<String>,
}

impl<'a> ProgramInMotion<'a> {
    pub(crate) fn new(checked: &'a Checked) -> Result<Self, ProgramFileError> {
        Ok(Self {
            player: checked.player()?,
            row: vec![0; checked.axes()],
            checked,
            cycles: 0,
            asked_percent: 100,
            is_paused: false,
            is_stopping: false,
            end: None,
            notices: VecDeque::new(),
        })
    }

    /// The highest override, in percent of the programmed feeds.
    fn most_percent(&self) -> u16 {
        self.checked.machine().manner.most_percent
    }

    /// The next row, or how it ended.
    fn advance(&mut self) -> Option<Step> {
        let next = match self.player.next() {
            Ok(next) => next,
            Err(error) => {
                self.notices.push_back(format!(
                    "{error}; the tool comes to rest on the path so far"
                ));
                self.is_stopping = true;
                self.player.next().unwrap_or(None)
            }
        };
        let Some(row) = next else {
            return Some(if self.is_stopping || self.row != self.checked.last() {
                Step::Stopped
            } else {
                Step::Completed
            });
        };
        for (to, counts) in self.row.iter_mut().zip(row) {
            // The travel has been checked; a file that was changed since then cannot leave it.
            *to = i32::try_from(counts).unwrap_or(*to);
        }
        self.cycles += 1;
        None
    }
}

impl SetPointSource for ProgramInMotion<'_> {
    fn axes(&self) -> usize {
        self.row.len()
    }

    fn next(&mut self, row: &mut [i32]) -> Step {
        if self.end.is_none() {
            self.end = self.advance();
        }
        for (to, counts) in row.iter_mut().zip(&self.row) {
            *to = *counts;
        }
        self.end.unwrap_or(Step::Goes)
    }

    fn order(&mut self, order: Order) {
        match order {
            Order::Pause => {
                self.is_paused = true;
                self.player.pause();
            }
            Order::Resume => {
                self.is_paused = false;
                self.player.resume();
            }
            Order::Override(percent) => {
                self.asked_percent = percent;
                let most = self.most_percent();
                if percent > most {
                    self.notices.push_back(format!(
                        "speed {percent} % is more than --max-override allows: held to {most} %"
                    ));
                }
                self.player.set_override(percent.min(most));
            }
            Order::Stop => {
                self.is_stopping = true;
                self.player.stop();
            }
        }
    }

    fn speed(&self) -> Speed {
        let percent = self.asked_percent.min(self.most_percent());
        Speed {
            asked_percent: self.asked_percent,
            actual_percent: if self.is_paused { 0.0 } else { percent.into() },
            is_paused: self.is_paused,
        }
    }

    fn progress(&self) -> (u64, Option<u64>) {
        (self.cycles, Some(self.checked.cycles as u64 - 1))
    }

    fn next_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }
}
