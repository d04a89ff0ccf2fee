//! Faults of a drive, on command of a test.
//!
//! Specification: a drive does none of this by itself. What changes the drive takes effect at the present instant, once its bench runs; what changes
//! replies concerns the next ones that are prepared.

use core::num::NonZeroU64;

use dyn_can::{Alarm, ConfigByte};

/// What changes the drive itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    Alarm(Alarm),
    PowerCycle { off_ns: u64 },
    Disable,
    Misconfigure(ConfigByte),
}

/// How far the drive takes part in the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Presence {
    #[default]
    Normal,
    Silent,
    Gone,
}

/// Change of the length of a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Resize {
    /// The last byte is missing.
    Shorter,
    /// A zero byte follows.
    Longer,
}

/// What becomes of one reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ReplyFault {
    pub(super) copies: u32,
    pub(super) delay_ns: u64,
    pub(super) resize: Option<Resize>,
}

/// Control panel for the faults of one drive.
#[derive(Debug, Clone, Default)]
pub struct DriveFaults {
    actions: Vec<Action>,
    presence: Presence,
    drops: u64,
    delay_ns: u64,
    duplicate: bool,
    resize: Option<Resize>,
    repeat_alarm_ns: Option<NonZeroU64>,
    settings_left: Option<u64>,
}

impl DriveFaults {
    /// The drive goes into an alarm: motor free, motion commands ignored, alarm frame sent at once. [`Alarm::None`] changes nothing.
    pub fn raise_alarm(&mut self, alarm: Alarm) {
        self.actions.push(Action::Alarm(alarm));
    }

    /// The power goes away for `off_ns` and comes back; `u64::MAX` for never. The power-on delay follows.
    ///
    /// Replies in preparation are lost, frames that already wait in the node's controller still go out; [`Port::power_off`](crate::Port::power_off)
    /// takes those too.
    pub fn power_cycle(&mut self, off_ns: u64) {
        self.actions.push(Action::PowerCycle { off_ns });
    }

    /// The drive restarts at once: a power cycle without time off.
    pub fn reboot(&mut self) {
        self.power_cycle(0);
    }

    /// The servo goes off as by Servo_Disable, but nobody asked for it.
    pub fn disable_itself(&mut self) {
        self.actions.push(Action::Disable);
    }

    /// The working copy of the configuration byte changes; the EEPROM does not.
    pub fn misconfigure(&mut self, config: ConfigByte) {
        self.actions.push(Action::Misconfigure(config));
    }

    /// From now on nothing is sent, no alarm either; requests are still heard and obeyed.
    pub fn fall_silent(&mut self) {
        self.presence = Presence::Silent;
    }

    /// From now on nothing is sent and nothing is heard, as with a broken cable; what moves goes on.
    pub fn leave_bus(&mut self) {
        self.presence = Presence::Gone;
    }

    /// Ends [`Self::fall_silent`] and [`Self::leave_bus`].
    pub fn wake(&mut self) {
        self.presence = Presence::Normal;
    }

    /// The next `replies` replies are not sent. Data errors are not replies.
    pub fn drop_next_replies(&mut self, replies: u64) {
        self.drops = replies;
    }

    /// The next reply takes `delay_ns` longer, and those behind it wait for it.
    pub fn delay_next_reply(&mut self, delay_ns: u64) {
        self.delay_ns = delay_ns;
    }

    /// The next reply is sent twice.
    pub fn duplicate_next_reply(&mut self) {
        self.duplicate = true;
    }

    /// The next reply lacks its last data byte.
    pub fn truncate_next_reply(&mut self) {
        self.resize = Some(Resize::Shorter);
    }

    /// The next reply has a zero byte too many.
    pub fn lengthen_next_reply(&mut self) {
        self.resize = Some(Resize::Longer);
    }

    /// While in alarm the alarm frame is sent again every `period_ns`; `None` for once, as documented.
    pub fn repeat_alarm_frames(&mut self, period_ns: Option<NonZeroU64>) {
        self.repeat_alarm_ns = period_ns;
    }

    /// The next `settings` commands that store something are obeyed, those behind them are not, without a word.
    pub fn ignore_settings_after(&mut self, settings: u64) {
        self.settings_left = Some(settings);
    }

    /// Whether a command that stores something is obeyed; it counts.
    pub(super) fn takes_setting(&mut self) -> bool {
        match &mut self.settings_left {
            None => true,
            Some(0) => false,
            Some(left) => {
                *left -= 1;
                true
            }
        }
    }

    pub(super) fn has_actions(&self) -> bool {
        !self.actions.is_empty()
    }

    pub(super) fn take_actions(&mut self) -> Vec<Action> {
        core::mem::take(&mut self.actions)
    }

    pub(super) fn hears(&self) -> bool {
        self.presence != Presence::Gone
    }

    pub(super) fn sends(&self) -> bool {
        self.presence == Presence::Normal
    }

    pub(super) fn alarm_period_ns(&self) -> Option<u64> {
        self.repeat_alarm_ns.map(NonZeroU64::get)
    }

    /// The fault of the reply that is being prepared. A dropped one uses up nothing else.
    pub(super) fn next_reply(&mut self) -> ReplyFault {
        if self.drops > 0 {
            self.drops -= 1;
            return ReplyFault {
                copies: 0,
                delay_ns: 0,
                resize: None,
            };
        }
        ReplyFault {
            copies: 1 + u32::from(core::mem::take(&mut self.duplicate)),
            delay_ns: core::mem::take(&mut self.delay_ns),
            resize: self.resize.take(),
        }
    }
}
