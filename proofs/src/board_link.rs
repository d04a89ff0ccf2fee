//! The buffer of timed set-points, and both ends of the link: every call, with any values in any order.

use board_link::board::{Application, Board, BoardConfig, Command, Link, Machine};
use board_link::host::{Client, ClientConfig};
use board_link::message::{AxisSnapshot, BoardState, Event, FaultEntry, Info, Request};
use board_link::segment::{AxisSegment, Begin, Segment, SegmentConfig, SegmentQueue, Shape};
use board_link::{AxisLimits, Config, Reason, Refused, SetPointBuffer, WhenDry};
use trajectory::{Limits, Position, Time};

use crate::opaque::{bits, byte, bytes, consume, flag, maybe, reach_mut, word};

const AXES: usize = 2;

/// Calls everything once.
pub fn exercise() {
    let float = || f32::from_bits(word());
    let Ok(motion) = Limits::new(float(), float(), float()) else {
        return;
    };
    let limits = AxisLimits {
        motion,
        lowest: position(),
        highest: position(),
    };
    let config = Config {
        longest_gap: Time::from_ticks(bits()),
        window: Time::from_ticks(bits()),
        when_dry: if flag() { WhenDry::End } else { WhenDry::Wait },
        ..Config::with_cycles_per_second(word())
    };
    let stand = [position(); AXES];
    let Some(mut buffer) = SetPointBuffer::<AXES, 64>::new(&[limits; AXES], &stand, config) else {
        return;
    };
    let mut positions = stand;
    while flag() {
        consume(buffer.push(Time::from_ticks(bits()), &[position(), position()]));
        consume(buffer.set_override(word() as u16));
        if flag() {
            buffer.pause();
        }
        if flag() {
            buffer.resume();
        }
        if flag() {
            buffer.stop();
        }
        if flag() {
            buffer.end();
        }
        consume(buffer.advance(&mut positions));
        consume(positions);
        consume((buffer.credit(), buffer.free(), buffer.buffered()));
        consume((buffer.time(), buffer.last_time(), buffer.phase()));
        consume((buffer.percent(), buffer.highest_percent()));
        consume((buffer.is_open(), buffer.is_paused(), buffer.axes()));
        consume(buffer.counters().refused_in_all());
    }
}

fn position() -> Position {
    Position::from_units(bits() as i64)
}

/// An application of which nothing is known.
struct Anything {
    settings: [u8; 256],
}

impl Application for Anything {
    fn info(&self) -> Info {
        Info {
            boot: word(),
            cycle_us: word(),
            ..Info::default()
        }
    }

    fn post(&mut self, ticket: u16, command: Command) -> Result<(), Refused> {
        consume((ticket, command));
        if flag() {
            Ok(())
        } else {
            Err(Reason::Busy.plain())
        }
    }

    fn result(&mut self) -> Option<(u16, Result<(), Refused>)> {
        let result = if flag() {
            Ok(())
        } else {
            Err(Reason::StopInput.plain())
        };
        maybe((word() as u16, result))
    }

    fn machine(&mut self) -> Machine {
        Machine {
            state: if flag() {
                BoardState::Enabled
            } else {
                BoardState::Faulted
            },
            axes: [AxisSnapshot {
                target: word() as i32,
                ..AxisSnapshot::default()
            }; AXES]
                .into_iter()
                .collect(),
            late_cycles: word(),
        }
    }

    fn event(&mut self) -> Option<Event> {
        maybe(Event::Claimed { session: word() })
    }

    fn settings(&self) -> &[u8] {
        self.settings.get(..word() as usize).unwrap_or_default()
    }

    fn staging(&mut self) -> &mut [u8] {
        &mut self.settings
    }

    fn check_settings(&mut self, length: u32) -> Result<(), Refused> {
        consume(length);
        if flag() {
            Ok(())
        } else {
            Err(Reason::Settings.plain())
        }
    }

    fn fault(&mut self, index: u32) -> Option<FaultEntry> {
        maybe(FaultEntry {
            number: index,
            ..FaultEntry::default()
        })
    }
}

/// The end of a board: any bytes, any time.
pub fn exercise_board() {
    let float = || f32::from_bits(word());
    let Ok(motion) = Limits::new(float(), float(), float()) else {
        return;
    };
    let limits = AxisLimits {
        motion,
        lowest: position(),
        highest: position(),
    };
    let mut queue = SegmentQueue::<AXES, 17>::new();
    let config = SegmentConfig {
        lead: Time::from_ticks(bits()),
        longest: Time::from_ticks(bits()),
        farthest_start: word(),
    };
    let Some((admission, mut player)) = reach_mut(&mut queue).split(&[limits; AXES], config) else {
        return;
    };
    let config = BoardConfig {
        silence: word(),
        patience: word(),
    };
    let application = Anything { settings: bytes() };
    let mut board = Board::new(application, maybe(admission), config);
    let mut link = Link::<2_048>::new();
    let mut out = [position(); AXES];
    while flag() {
        link.on_bytes(reach_mut(&mut board), bits(), &bytes::<64>());
        link.poll(reach_mut(&mut board), bits());
        consume(link.output().first().copied());
        link.consume(word() as usize);
        consume(player.advance(bits(), &[position(); AXES], &mut out));
        consume(out);
        if flag() {
            player.halt();
        }
    }
}

/// The end of a host.
pub fn exercise_host() {
    let config = ClientConfig {
        timeout_us: word(),
        tries: byte(),
        heartbeat_us: word(),
        sync_us: word(),
        commands: flag(),
    };
    let mut client = Client::<4, 2_048>::new(config, word());
    let client = reach_mut(&mut client);
    while flag() {
        client.on_bytes(bits(), &bytes::<64>());
        client.poll(bits());
        consume(client.output().first().copied());
        client.consume(word() as usize);
        consume(client.request(if flag() {
            Request::Enable
        } else {
            Request::Stop
        }));
        let begin = Begin {
            stream: word(),
            start: maybe(bits()),
            when_dry: WhenDry::Wait,
            percent: word() as u16,
            from: [bits() as i64; AXES].into_iter().collect(),
        };
        consume(client.begin(begin));
        let part = AxisSegment {
            end: bits() as i64,
            shape: Shape::MinimumJerk,
        };
        let segment = Segment {
            duration: bits(),
            axes: [part; AXES].into_iter().collect(),
        };
        consume(client.offer(segment));
        if flag() {
            client.finish();
        }
        consume(client.next());
        consume((client.clock().cycle_at(bits()), client.clock().error_us()));
    }
}
