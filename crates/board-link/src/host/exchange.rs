//! A request that waits for its reply, and is repeated when none comes.

use crate::message::{Request, ToBoard};
use crate::outbox::Outbox;
use crate::refused::Refused;

/// Why a request has no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// The board refuses it.
    #[error(transparent)]
    Refused(Refused),
    /// There was no reply. Whether it was carried out is not known.
    #[error(
        "no reply after {tries} tries: check the cable and the bit rate, then read the state of the board"
    )]
    TimedOut {
        /// How often it was sent.
        tries: u8,
    },
    /// The connection was lost, or made anew, before a reply came.
    #[error("the connection was lost before a reply came: read the state of the board")]
    Lost,
    /// Nothing is sent before the board has answered, and the command is claimed.
    #[error("not connected to a board")]
    Offline,
    /// The request before has no reply yet.
    #[error("the request before has no reply yet: wait for it")]
    Busy,
}

/// So many tries are no limit.
pub(super) const FOR_EVER: u8 = u8::MAX;

/// A request on its way.
#[derive(Debug, Clone)]
pub(super) struct Exchange {
    pub(super) message: ToBoard,
    /// First sent.
    pub(super) first_us: u64,
    sent_us: u64,
    tries: u8,
    /// It is not sent any more; its reply may still come.
    is_recalled: bool,
}

/// A reply to a homing or an enable that was recalled is waited for so many times as long as usual: an axis slows down first, and backs off a
/// stop.
const PATIENCE_WHEN_RECALLED: u8 = 50;

/// What is to be done with an exchange.
pub(super) enum Next {
    Wait,
    GiveUp { tries: u8 },
}

impl Exchange {
    /// Not sent yet.
    pub(super) const fn new(number: u16, session: u32, request: Request) -> Self {
        Self {
            message: ToBoard {
                number,
                session,
                request,
            },
            first_us: 0,
            sent_us: 0,
            tries: 0,
            is_recalled: false,
        }
    }

    /// How often it was sent.
    pub(super) const fn tries(&self) -> u8 {
        self.tries
    }

    /// Sends it no more: something has been asked for since that it must not come after.
    pub(super) const fn recall(&mut self) {
        self.is_recalled = true;
    }

    /// Sends it, first or again, when it is time and there is room.
    pub(super) fn drive<const OUT: usize>(
        &mut self,
        outbox: &mut Outbox<OUT>,
        now_us: u64,
        (timeout_us, most_tries): (u32, u8),
    ) -> Next {
        if self.is_recalled {
            return self.wait_for_reply(now_us, timeout_us, most_tries);
        }
        let is_due = self.tries == 0 || now_us.saturating_sub(self.sent_us) >= timeout_us.into();
        if !is_due {
            return Next::Wait;
        }
        if self.tries >= most_tries && most_tries != FOR_EVER {
            return Next::GiveUp { tries: self.tries };
        }
        if outbox.send(&self.message) {
            if self.tries == 0 {
                self.first_us = now_us;
            }
            self.sent_us = now_us;
            self.tries = self.tries.saturating_add(1);
        }
        Next::Wait
    }

    fn wait_for_reply(&self, now_us: u64, timeout_us: u32, most_tries: u8) -> Next {
        let times = match self.message.request {
            Request::Home | Request::Enable => PATIENCE_WHEN_RECALLED,
            _ => most_tries,
        };
        let most_us = u64::from(times) * u64::from(timeout_us);
        if self.tries > 0 && now_us.saturating_sub(self.sent_us) < most_us {
            return Next::Wait;
        }
        Next::GiveUp { tries: self.tries }
    }
}
