//! What a packet that comes in is: the reply that is awaited, an echo, or neither.

use super::sent::EchoOf;
use super::{Answer, Client, Job, State, count};
use crate::address::Address;
use crate::error::DecodeError;
use crate::function::ReplyFunction;
use crate::packet::Packet;
use crate::reply::Reply;

impl Job {
    /// Something that was sent came back. When it is the request itself, what came before it was sent before it too.
    fn after_echo(self, echo: Option<EchoOf>) -> Self {
        match echo {
            Some(EchoOf::Latest) => Self {
                is_doubtful: false,
                is_echoed: true,
                ..self
            },
            Some(EchoOf::Earlier) => Self {
                is_echoed: true,
                ..self
            },
            None => self,
        }
    }
}

impl Client {
    pub(super) fn hear(&mut self, now_us: u64, packet: &Packet) {
        let State::Waiting { job, until_us } = self.state else {
            let _ = self.hear_unasked(now_us, packet);
            return;
        };
        let is_from_it = job.to == Address::All || packet.start_byte() == job.to.start_byte();
        if !is_from_it || job.awaited.map(ReplyFunction::code) != Some(packet.code()) {
            let echo = self.hear_unasked(now_us, packet);
            self.state = State::Waiting {
                job: job.after_echo(echo),
                until_us,
            };
            return;
        }
        if self.sent.holds(packet, now_us) {
            count(&mut self.traffic.doubtful);
            let job = Job {
                held: Some(*packet),
                is_doubtful: true,
                ..job
            };
            self.state = State::Waiting { job, until_us };
            return;
        }
        self.hear_reply(packet, job, until_us);
    }

    /// A packet that is not the reply that is awaited.
    fn hear_unasked(&mut self, now_us: u64, packet: &Packet) -> Option<EchoOf> {
        let echo = self.sent.take(packet, now_us);
        if echo == Some(EchoOf::Latest) {
            self.echo_until_us = 0;
        }
        count(if echo.is_some() {
            &mut self.traffic.echoes
        } else {
            &mut self.traffic.unexpected
        });
        echo
    }

    fn hear_reply(&mut self, packet: &Packet, job: Job, until_us: u64) {
        match Reply::decode(packet) {
            Ok((from, reply)) => {
                count(&mut self.traffic.replies);
                self.echo_until_us = 0;
                self.state = State::Done(Ok(Answer::Reply { from, reply }));
            }
            Err(error) => {
                count(match error {
                    DecodeError::Length { .. } => &mut self.traffic.wrong_length,
                    _ => &mut self.traffic.out_of_range,
                });
                let bad = Some(error);
                self.state = State::Waiting {
                    job: Job { bad, ..job },
                    until_us,
                };
            }
        }
    }
}
