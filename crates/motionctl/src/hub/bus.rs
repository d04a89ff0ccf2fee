//! SDO transfers and NMT commands over a link, one after the other.
//!
//! Every node keeps a client of its own, so that a late answer of one transfer is never taken for that of the next. A read that is not
//! answered is repeated; a write is not, because nobody knows whether it arrived: it is read back.

use std::collections::BTreeMap;

use can_motion::{BusErrorKind, BusUser, Instant, Outcome, Progress, Sink};
use zlac8030l::{
    DataFrame, FrameError, NmtRequest, NodeId, Object, ObjectAddress, ObjectData, ObjectValue,
    SdoClient, SdoEnd, SdoHeard, SdoRequest, SdoTimeouts, dictionary,
};

use super::error::HubError;
use crate::link::{Link, LinkOptions};
use crate::station::{Clock, StallWatch, serve_until};

/// How often a transfer is told that time passes, in microseconds.
const TICK_US: u32 = 1_000;
/// How long a node has to answer: adapters on USB hold bytes back for up to 16 ms, and the system lets a program wait.
const REPLY_US: u32 = 100_000;
/// How often a read is asked before the node counts as silent.
const ATTEMPTS: u32 = 3;

/// A bus of hub motors.
#[derive(Debug)]
pub(super) struct Bus {
    link: Link,
    clock: Clock,
    clients: BTreeMap<NodeId, SdoClient>,
}

impl Bus {
    /// Opens the connection, at 500 kbit/s unless the user names another bit rate.
    ///
    /// # Errors
    /// [`HubError::Open`]; nothing was sent to a drive.
    pub(super) fn open(options: &LinkOptions) -> Result<Self, HubError> {
        let link = options
            .open_of_drives_with(zlac8030l::FACTORY_BIT_RATE)
            .map_err(HubError::Open)?;
        Ok(Self {
            link,
            clock: Clock::start(),
            clients: BTreeMap::new(),
        })
    }

    /// The link, for a master.
    pub(super) fn link(&mut self) -> &mut Link {
        &mut self.link
    }

    /// Seconds since the bus was opened.
    pub(super) fn seconds(&self) -> f64 {
        self.clock.now().as_us() as f64 * 1e-6
    }

    /// Reads an object of a node in the type of its constant.
    ///
    /// # Errors
    /// [`HubError::NoAnswer`], [`HubError::Refused`], [`HubError::BadReply`] or the link's.
    pub(super) fn read<T: ObjectValue>(
        &mut self,
        node: NodeId,
        object: Object<T>,
    ) -> Result<T, HubError> {
        let address = object.address();
        let data = self.read_data(node, address)?;
        T::from_data(data).map_err(|error| HubError::BadReply {
            node,
            address,
            reason: format!("it has {} bytes, expected {}", error.actual, error.expected),
        })
    }

    /// Reads an object of a node, as the number that its type in the dictionary makes of it.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(super) fn read_number(
        &mut self,
        node: NodeId,
        address: ObjectAddress,
    ) -> Result<i64, HubError> {
        let data = self.read_data(node, address)?;
        let entry = dictionary::find(address);
        entry.map_or(Ok(i64::from(data.raw())), |entry| {
            entry
                .data_type
                .value(data)
                .map_err(|error| HubError::BadReply {
                    node,
                    address,
                    reason: format!("it has {} bytes, expected {}", error.actual, error.expected),
                })
        })
    }

    fn read_data(&mut self, node: NodeId, address: ObjectAddress) -> Result<ObjectData, HubError> {
        for _ in 0..ATTEMPTS {
            match self.transfer(node, SdoRequest::Read(address))? {
                SdoEnd::Value(data) => return Ok(data),
                SdoEnd::TimedOut => {}
                end => return Err(HubError::of_end(node, address, end)),
            }
        }
        Err(HubError::NoAnswer { node, address })
    }

    /// Writes an object of a node, once.
    ///
    /// # Errors
    /// [`HubError::WriteInDoubt`] when nobody knows whether it arrived, [`HubError::Refused`], or the link's.
    pub(super) fn write(&mut self, node: NodeId, request: SdoRequest) -> Result<(), HubError> {
        let address = request.address();
        match self.transfer(node, request)? {
            SdoEnd::Written => Ok(()),
            SdoEnd::TimedOut => Err(HubError::WriteInDoubt { node, address }),
            end => Err(HubError::of_end(node, address, end)),
        }
    }

    /// Whether a node answers at all.
    ///
    /// # Errors
    /// The link's.
    pub(super) fn answers(&mut self, node: NodeId) -> Result<bool, HubError> {
        let read = self.read_data(node, zlac8030l::objects::DEVICE_TYPE.address());
        match read {
            Ok(_) | Err(HubError::Refused { .. } | HubError::BadReply { .. }) => Ok(true),
            Err(HubError::NoAnswer { .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Sends an NMT command, which nothing acknowledges.
    ///
    /// # Errors
    /// The link's.
    pub(super) fn command(&mut self, request: NmtRequest) -> Result<(), HubError> {
        let mut exchange = Exchange::sending(request.encode());
        self.run(&mut exchange, |exchange| exchange.outgoing.is_none())
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// The link's.
    pub(super) fn wait(&mut self, us: u32) -> Result<(), HubError> {
        let until = self.clock.now() + us;
        Ok(serve_until(
            &mut Exchange::default(),
            &mut self.link,
            &self.clock,
            until,
        )?)
    }

    fn transfer(&mut self, node: NodeId, request: SdoRequest) -> Result<SdoEnd, HubError> {
        let client = self.client(node);
        let mut exchange = Exchange {
            client: Some(client),
            ..Exchange::default()
        };
        // A late answer of the transfer before may still come.
        while let Some(client) = &mut exchange.client
            && client
                .ready(self.clock.now().as_us(), request.address())
                .is_err()
        {
            let until = self.clock.now() + TICK_US;
            serve_until(&mut exchange, &mut self.link, &self.clock, until)?;
            exchange.tick(self.clock.now());
        }
        exchange.outgoing = Some(request.encode(node));
        exchange.request = Some(request);
        let ended = self.run(&mut exchange, |exchange| exchange.end.is_some());
        if let Some(client) = exchange.client {
            self.clients.insert(node, client);
        }
        ended?;
        let end = exchange.end.unwrap_or(SdoEnd::TimedOut);
        if let Some(abort) = exchange.abort {
            // So that the node does not go on with what nobody waits for; nothing acknowledges it.
            let mut abort = Exchange::sending(abort);
            self.run(&mut abort, |exchange| exchange.outgoing.is_none())?;
        }
        Ok(end)
    }

    fn client(&self, node: NodeId) -> SdoClient {
        let timeouts = SdoTimeouts {
            reply_us: REPLY_US,
            ..SdoTimeouts::DEFAULT
        };
        let kept = self.clients.get(&node).copied();
        kept.unwrap_or(SdoClient::new(node, timeouts))
    }

    fn run(
        &mut self,
        exchange: &mut Exchange,
        is_over: impl Fn(&Exchange) -> bool,
    ) -> Result<(), HubError> {
        let mut watch = StallWatch::new((), self.clock.now());
        while !is_over(exchange) {
            let until = self.clock.now() + TICK_US;
            serve_until(exchange, &mut self.link, &self.clock, until)?;
            exchange.tick(self.clock.now());
            if watch.stalls_at((), self.clock.now()) {
                return Err(HubError::NothingGetsOut);
            }
        }
        Ok(())
    }
}

/// One frame out, and its answer. Sans-I/O, like everything that uses the bus.
#[derive(Debug, Default)]
struct Exchange {
    client: Option<SdoClient>,
    /// The frame that waits for the controller.
    outgoing: Option<DataFrame>,
    /// The transfer that the frame begins.
    request: Option<SdoRequest>,
    end: Option<SdoEnd>,
    abort: Option<DataFrame>,
}

impl Exchange {
    fn sending(frame: DataFrame) -> Self {
        Self {
            outgoing: Some(frame),
            ..Self::default()
        }
    }

    fn tick(&mut self, now: Instant) {
        let event = self
            .client
            .as_mut()
            .and_then(|client| client.poll(now.as_us()));
        if let Some(event) = event {
            self.end = Some(event.end);
            let node = self.client.map(|client| client.node());
            self.abort = node.and_then(|node| Some(event.abort()?.encode(node)));
        }
    }

    /// The controller has the frame.
    fn accepted(&mut self, now: Instant) {
        self.outgoing = None;
        if let (Some(client), Some(request)) = (&mut self.client, self.request) {
            // It was ready before the frame was offered.
            let _ = client.start(now.as_us(), request);
        }
    }
}

impl BusUser for Exchange {
    type Frame = DataFrame;

    fn send<S: Sink<DataFrame>>(&mut self, now: Instant, sink: &mut S) -> Progress {
        let Some(frame) = self.outgoing else {
            return Progress::Idle;
        };
        match sink.offer(&frame) {
            Outcome::Accepted => self.accepted(now),
            Outcome::Displaced(displaced) => {
                self.accepted(now);
                self.on_displaced(now, &displaced);
            }
            Outcome::Full => return Progress::Blocked,
            // Whether it goes out is not known: its answer is awaited.
            Outcome::Failed(_) => self.accepted(now),
        }
        Progress::Idle
    }

    fn on_displaced(&mut self, _: Instant, frame: &DataFrame) {
        if let Some(client) = &mut self.client {
            client.withdraw();
        }
        self.outgoing = Some(*frame);
    }

    fn on_receive_error(&mut self, _: Instant, _: BusErrorKind) {}

    fn on_frame(&mut self, now: Instant, frame: &DataFrame) {
        let heard = self
            .client
            .as_mut()
            .map(|client| client.on_frame(now.as_us(), frame));
        if let Some(SdoHeard::Ended(event)) = heard {
            self.end = Some(event.end);
            let node = self.client.map(|client| client.node());
            self.abort = node.and_then(|node| Some(event.abort()?.encode(node)));
        }
    }

    fn on_foreign_frame(&mut self, _: Instant, _: FrameError) {}
}
