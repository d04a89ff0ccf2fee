//! CANopen of the hub-motor drives: every message in both directions, SDO client, set-up, and the master of wheels.

use core::hint::black_box;

use can_motion::facts::Class;
use can_motion::family::ValueLimits;
use can_motion::plan::BitRate;
use can_motion::wheel::{
    FeedbackTiming, WheelArrival, WheelConfig, WheelLimits, WheelMaster, WheelMasterConfig,
    WheelMode, WheelPolls, WheelReactions, WheelStops, WheelTimeouts,
};
use can_motion::{BusUser, Confirmation, Reaction, service};
use zlac8030l::{
    AbortCode, CanopenFrame, DataFrame, DataType, Emcy, FaultCode, Firmware, Heartbeat,
    HeartbeatWatch, MappingEntry, Message, Mode, MoveKind, NmtCommand, NmtRequest, NodeId,
    ObjectAddress, ObjectData, ObjectValue, PdoDirection, PdoMapping, PdoNumber, PdoSetUp,
    SdoClient, SdoQuirks, SdoReply, SdoRequest, SdoTimeouts, SetUp, SetUpOptions, SetUpStep,
    Setting, StatusWord, dictionary, objects,
};

use crate::fake_can::FakeCan;
use crate::master::{AnySink, group, now};
use crate::opaque::{self, consume, hide, number, word};

/// Nodes of the lean program, and wheels of the master.
const NODES: usize = 4;

/// Calls everything of the codec once.
pub fn exercise() {
    messages();
    dictionary_and_words();
    process_data();
    client();
    set_up();
}

/// What a lean program needs for four drives: SDO client, NMT, heartbeat, emergency messages and the states of CiA 402. Its size has
/// a limit.
pub fn four_nodes() {
    // What a driver does to make this frame is not counted.
    let frame = black_box(zlac8030l::Sync.encode());
    for _ in 0..NODES {
        let mut node = LeanNode {
            client: SdoClient::new(NodeId::FACTORY, SdoTimeouts::DEFAULT),
            watch: HeartbeatWatch::new(300_000),
        };
        black_box(&mut node).serve(opaque::bits(), &frame);
    }
    black_box(&Emcy::decode(&frame));
    let start = NmtRequest {
        command: NmtCommand::Start,
        node: None,
    };
    black_box(&black_box(start).encode());
}

/// One drive of the lean program.
struct LeanNode {
    client: SdoClient,
    watch: HeartbeatWatch,
}

impl LeanNode {
    /// A frame comes, time passes, and the drive is led one state towards operation enabled.
    fn serve(&mut self, now_us: u64, frame: &DataFrame) {
        black_box(&self.client.on_frame(now_us, frame));
        if let Some(event) = self.client.poll(now_us) {
            black_box(&event.abort().map(|abort| abort.encode(self.client.node())));
        }
        if let Ok(heartbeat) = Heartbeat::decode(frame) {
            black_box(self.watch.on_heartbeat(now_us, heartbeat.state));
        }
        black_box(self.watch.is_lost(now_us));
        let status = StatusWord::new(word() as u16);
        if let Some(next) = status.state().toward_enabled() {
            let write = objects::CONTROL_WORD.write(next.get());
            black_box(&self.client.start(now_us, write));
        }
    }
}

/// Any calls on any master of wheels in any order.
pub fn wheels() {
    let wheels = [(); NODES].map(|()| wheel());
    let given = wheels.get(..word() as usize).unwrap_or(&wheels);
    let mut master = match WheelMaster::<NODES>::new(bus(), given) {
        Ok(master) => master,
        Err(error) => return consume(error),
    };
    while opaque::flag() {
        match opaque::byte() {
            0..16 => cycle(&mut master),
            16..32 => by_hand(&mut master),
            32..48 => commands(&mut master),
            _ => look(&mut master),
        }
    }
}

/// Any frame.
pub fn any_frame() -> DataFrame {
    let bytes = opaque::bytes::<8>();
    let data = bytes.get(..word() as usize).unwrap_or(&bytes);
    DataFrame::new(word() as u16, data).unwrap_or_else(|_| hide(zlac8030l::Sync.encode()))
}

/// Any node.
pub fn node() -> NodeId {
    NodeId::new(number()).unwrap_or(NodeId::MIN)
}

fn nmt() -> NmtRequest {
    NmtRequest {
        command: opaque::pick([
            NmtCommand::Start,
            NmtCommand::Stop,
            NmtCommand::PreOperational,
        ]),
        node: opaque::maybe(node()),
    }
}

fn address() -> ObjectAddress {
    ObjectAddress::new(word() as u16, opaque::byte())
}

fn data() -> ObjectData {
    let bytes = opaque::bytes::<4>();
    let some = bytes.get(..word() as usize).unwrap_or(&bytes);
    ObjectData::from_bytes(some).unwrap_or(word().to_data())
}

fn request() -> SdoRequest {
    opaque::pick([
        SdoRequest::Read(address()),
        SdoRequest::Write(address(), data()),
        SdoRequest::Abort(address(), AbortCode::new(word())),
    ])
}

fn messages() {
    let frame = any_frame();
    consume(Message::decode(&frame));
    consume(request().encode(node()));
    if let Ok((node, reply)) = SdoReply::decode(&frame) {
        consume((reply.encode(node), reply.address()));
    }
    if let Ok((_, emergency)) = Emcy::decode(&frame) {
        consume(emergency.encode(node()));
    }
    consume(nmt().encode());
    consume((frame.service(), frame.len()));
}

fn dictionary_and_words() {
    consume(dictionary::write(address(), opaque::bits() as i64));
    dictionary::entries().for_each(|entry| consume(entry.default.of(node())));
    let data_type = opaque::pick([DataType::I8, DataType::U16, DataType::I32]);
    consume((
        data_type.data(opaque::bits() as i64),
        data_type.value(data()),
    ));
    let fault = FaultCode::new(word() as u16);
    fault.names().for_each(consume);
    consume((
        Mode::from_value(number() as i8),
        MoveKind::Absolute.check(number()),
    ));
    let status = StatusWord::new(word() as u16);
    consume((status.state(), status.running(), status.deviation()));
}

fn mapping() -> PdoMapping {
    let entries = [(); NODES].map(|()| MappingEntry::from_word(word()));
    let some = entries.get(..word() as usize).unwrap_or(&entries);
    PdoMapping::new(some).unwrap_or(PdoMapping::EMPTY)
}

fn process_data() {
    let mapping = mapping();
    let values = [data(), data(), data(), data()];
    let some = values.get(..word() as usize).unwrap_or(&values);
    consume(mapping.rpdo(node(), PdoNumber::Pdo1, some));
    consume(mapping.tpdo(node(), PdoNumber::Pdo0, some));
    consume(mapping.values(&any_frame()));
}

fn client() {
    let timeouts = SdoTimeouts {
        reply_us: word(),
        settle_us: word(),
    };
    let quirks = SdoQuirks {
        profile_speed_confirmed_as_sub_1: opaque::flag(),
    };
    let mut client = SdoClient::new(node(), timeouts).with_quirks(quirks);
    while opaque::flag() {
        consume(client.start(opaque::bits(), request()));
        consume(client.on_frame(opaque::bits(), &any_frame()));
        consume((client.poll(opaque::bits()), client.poll_at_us()));
        client.abandon(opaque::bits());
        client.withdraw();
    }
}

fn set_up() {
    let pdo = PdoSetUp {
        direction: opaque::pick([PdoDirection::Transmit, PdoDirection::Receive]),
        number: PdoNumber::Pdo2,
        mapping: mapping(),
        transmission_type: opaque::maybe(opaque::byte()),
        inhibit_time: opaque::maybe(word() as u16),
        event_timer: opaque::maybe(word() as u16),
    };
    let steps = [
        SetUpStep::Pdo(pdo),
        SetUpStep::Value(Setting::new(objects::MODE, 3)),
    ];
    let mut set_up = SetUp::new(SetUpOptions {
        firmware: opaque::pick([Firmware::Any, Firmware::Version(word() as u16)]),
        save: opaque::flag(),
    });
    let mut client = SdoClient::new(node(), SdoTimeouts::DEFAULT);
    while opaque::flag() {
        if let Some(request) = set_up.wanted(&steps) {
            consume(client.start(opaque::bits(), request));
        }
        if let Some(event) = client.poll(opaque::bits()) {
            set_up.on_end(&steps, event.end);
        }
        if let zlac8030l::SdoHeard::Ended(event) = client.on_frame(opaque::bits(), &any_frame()) {
            set_up.on_end(&steps, event.end);
        }
        consume(set_up.outcome());
    }
}

fn bus() -> WheelMasterConfig {
    let short = || word() as u16;
    WheelMasterConfig {
        cycle_us: word(),
        requests_per_cycle: opaque::byte(),
        bit_rate: opaque::pick([BitRate::Kbit125, BitRate::Kbit500, BitRate::Kbit1000]),
        feedback: opaque::pick([
            FeedbackTiming::Sync,
            FeedbackTiming::Timer { ticks: short() },
        ]),
        timeouts: WheelTimeouts {
            power_on_us: word(),
            sdo: SdoTimeouts {
                reply_us: word(),
                settle_us: word(),
            },
            heartbeat_ms: short(),
            heartbeat_lost_us: word(),
            feedback_lost_us: word(),
            offline_ms: short(),
            standstill_us: word(),
            standstill_limit_us: word(),
            confirm_us: word(),
            stuck_us: word(),
            lost_after: opaque::byte(),
        },
    }
}

fn wheel() -> WheelConfig {
    let reaction = || opaque::pick([Reaction::Halt, Reaction::RampDown, Reaction::Disable]);
    let short = || word() as u16;
    WheelConfig {
        node: node(),
        group: group(),
        mode: opaque::pick([
            WheelMode::Velocity,
            WheelMode::Position {
                profile_speed_rpm: short(),
            },
            WheelMode::Torque { slope_ma_s: word() },
        ]),
        limits: opaque::pick([
            WheelLimits::speed(short(), word()),
            WheelLimits::position(number(), number(), word(), word()),
            WheelLimits::torque(short(), word(), short()),
            limits(),
        ]),
        speed_resolution: short(),
        ramp_ms: short(),
        counter_clockwise: opaque::flag(),
        stops: WheelStops {
            quick_stop: word() as i16,
            shutdown: word() as i16,
            disable: word() as i16,
            halt: word() as i16,
            emergency_ms: short(),
        },
        load_can_fall: opaque::flag(),
        polls: WheelPolls {
            health_us: opaque::maybe(word()),
        },
        arrival: WheelArrival {
            within_counts: word(),
            limit_us: opaque::maybe(word()),
        },
        firmware: opaque::pick([Firmware::Any, Firmware::Version(short())]),
        quirks: SdoQuirks {
            profile_speed_confirmed_as_sub_1: opaque::flag(),
        },
        reactions: WheelReactions {
            drive: reaction(),
            lost: reaction(),
            following_error: reaction(),
            bus: reaction(),
        },
    }
}

fn limits() -> WheelLimits {
    WheelLimits {
        values: ValueLimits {
            min: number(),
            max: number(),
            max_step: word(),
            max_step_change: word(),
        },
        following_error: word(),
        following_speed: word() as u16,
        following_speed_us: word(),
        standstill: word() as u16,
    }
}

fn cycle(master: &mut WheelMaster<NODES>) {
    consume(master.set_target(word() as usize, number()));
    master.begin_cycle(now());
    consume(service(master, &mut FakeCan, now()));
}

fn by_hand(master: &mut WheelMaster<NODES>) {
    let any = || opaque::maybe(any_frame());
    consume(master.send(now(), &mut AnySink { any }));
    master.on_frame(now(), &any_frame());
    master.on_displaced(now(), &any_frame());
    master.on_bus_off(now());
    master.on_bus_recovered(now());
}

fn commands(master: &mut WheelMaster<NODES>) {
    let at = now();
    let confirmation = opaque::pick([Confirmation::None, Confirmation::Given]);
    consume(master.start(at, word() as usize, request(), confirmation));
    consume(master.enable(at, group()));
    consume(master.adopt(at, group()));
    consume(master.resume(at, group()));
    consume(master.clear(at, group()));
    master.stop(at, group());
    master.halt(at, group());
    master.disable(at, group());
}

fn look(master: &mut WheelMaster<NODES>) {
    consume(master.snapshot(word() as usize));
    consume(master.facts(word() as usize));
    consume(master.may_leave(word() as usize, opaque::pick(Class::ALL)));
    consume(master.next_event());
    consume((master.cycle_counters(), master.poll_at()));
}
