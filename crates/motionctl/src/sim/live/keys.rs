//! What the keys do.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::control::{Wish as MotionWish, wish};
use crate::sim::spectator::Order;

/// Speeds to choose from, in virtual seconds a second.
const SPEEDS: [f64; 7] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
const REAL_TIME: usize = 4;

/// The keys in words, two blanks between them.
pub(super) const KEYS: &str =
    "up/down select  a alarm  p pull/plug  space pause  + - 1 speed  s stop  f [ ] time  q quit";
/// The same where a motion has no path on which it could be paused.
pub(super) const KEYS_WITHOUT_PATH: &str =
    "up/down select  a alarm  p pull/plug  s stop  f [ ] time  q quit";

/// A key that means something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Key {
    Up,
    Down,
    Alarm,
    Plug,
    /// Of the motion.
    Motion(MotionWish),
    /// Of time, for everything.
    Freeze,
    Faster,
    Slower,
    Leave,
}

impl Key {
    /// The meaning of a key event; releases mean nothing.
    pub(super) fn of(event: &KeyEvent) -> Option<Self> {
        if event.kind == KeyEventKind::Release {
            return None;
        }
        Some(match event.code {
            KeyCode::Char('c') if event.modifiers.contains(KeyModifiers::CONTROL) => Self::Leave,
            KeyCode::Up | KeyCode::Char('k') => Self::Up,
            KeyCode::Down | KeyCode::Char('j') => Self::Down,
            KeyCode::Char('a') => Self::Alarm,
            KeyCode::Char('p') => Self::Plug,
            KeyCode::Char('f') => Self::Freeze,
            KeyCode::Char(']') => Self::Faster,
            KeyCode::Char('[') => Self::Slower,
            KeyCode::Char('q') | KeyCode::Esc => Self::Leave,
            // The others mean what they mean while a real motion runs.
            KeyCode::Char(key) => Self::Motion(wish(u8::try_from(key).ok()?)?),
            _ => return None,
        })
    }
}

/// What a key asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Wish {
    /// Of the simulation.
    Order(Order),
    /// Of the clock.
    Speed(f64),
}

/// The state behind the keys.
#[derive(Debug)]
pub(super) struct Panel {
    unplugged: Vec<bool>,
    selected: usize,
    speed: usize,
    is_frozen: bool,
    is_leaving: bool,
}

impl Panel {
    pub(super) fn new(axes: usize) -> Self {
        Self {
            unplugged: vec![false; axes],
            selected: 0,
            speed: REAL_TIME,
            is_frozen: false,
            is_leaving: false,
        }
    }

    /// Obeys a key.
    pub(super) fn press(&mut self, key: Key) -> Option<Wish> {
        match key {
            Key::Up => self.selected = self.selected.saturating_sub(1),
            Key::Down => {
                self.selected = (self.selected + 1).min(self.unplugged.len().saturating_sub(1))
            }
            Key::Freeze => self.is_frozen = !self.is_frozen,
            Key::Motion(wish) => {
                // In frozen time nothing would obey.
                self.is_frozen = false;
                return Some(Wish::Order(Order::Motion(wish)));
            }
            Key::Faster => return self.set_speed(self.speed + 1),
            Key::Slower => return self.set_speed(self.speed.saturating_sub(1)),
            Key::Alarm => return Some(Wish::Order(Order::Alarm(self.selected))),
            Key::Plug => return self.plug(),
            Key::Leave => {
                self.is_leaving = true;
                self.is_frozen = false;
                return Some(Wish::Order(Order::Stop));
            }
        }
        None
    }

    fn set_speed(&mut self, speed: usize) -> Option<Wish> {
        self.speed = speed.min(SPEEDS.len() - 1);
        Some(Wish::Speed(self.speed()))
    }

    fn plug(&mut self) -> Option<Wish> {
        let unplugged = self.unplugged.get_mut(self.selected)?;
        *unplugged = !*unplugged;
        let order = if *unplugged {
            Order::Unplug(self.selected)
        } else {
            Order::PlugIn(self.selected)
        };
        Some(Wish::Order(order))
    }

    pub(super) fn selected(&self) -> usize {
        self.selected
    }

    /// Whether each axis was pulled off the bus.
    pub(super) fn unplugged(&self) -> &[bool] {
        &self.unplugged
    }

    pub(super) fn speed(&self) -> f64 {
        SPEEDS[self.speed]
    }

    pub(super) fn is_frozen(&self) -> bool {
        self.is_frozen
    }

    /// Whether the view shall close.
    pub(super) fn is_leaving(&self) -> bool {
        self.is_leaving
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set_points::Order as MotionOrder;

    fn panel() -> Panel {
        Panel::new(2)
    }

    fn key(code: KeyCode) -> Option<Key> {
        Key::of(&KeyEvent::new(code, KeyModifiers::NONE))
    }

    #[test]
    fn alarms_and_plugs_concern_the_selected_drive() {
        let mut panel = panel();
        panel.press(Key::Down);
        panel.press(Key::Down);
        assert_eq!(panel.selected(), 1);
        let order = |order| Some(Wish::Order(order));
        assert_eq!(panel.press(Key::Plug), order(Order::Unplug(1)));
        assert_eq!(panel.unplugged(), [false, true]);
        assert_eq!(panel.press(Key::Plug), order(Order::PlugIn(1)));
        assert_eq!(panel.press(Key::Alarm), order(Order::Alarm(1)));
    }

    #[test]
    fn leaving_stops_and_ends_a_pause() {
        let mut panel = panel();
        panel.press(Key::Freeze);
        assert!(panel.is_frozen());
        assert_eq!(panel.press(Key::Leave), Some(Wish::Order(Order::Stop)));
        assert!(panel.is_leaving() && !panel.is_frozen());
    }

    #[test]
    fn speed_stays_within_its_steps() {
        let mut panel = panel();
        for _ in 0..9 {
            panel.press(Key::Faster);
        }
        assert_eq!(panel.speed(), 10.0);
        for _ in 0..9 {
            panel.press(Key::Slower);
        }
        assert_eq!(panel.speed(), 0.01);
    }

    #[test]
    fn control_c_leaves_and_a_plain_c_does_not() {
        let control = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(Key::of(&control), Some(Key::Leave));
        assert_eq!(key(KeyCode::Char('c')), None);
    }

    #[test]
    fn the_keys_of_the_motion_are_those_of_a_real_one() {
        let mut panel = panel();
        for (key_code, wish) in [
            (' ', MotionWish::TogglePause),
            ('+', MotionWish::Faster),
            ('-', MotionWish::Slower),
            ('s', MotionWish::Order(MotionOrder::Stop)),
        ] {
            let pressed = key(KeyCode::Char(key_code)).expect("a key");
            panel.press(Key::Freeze);
            let order = Some(Wish::Order(Order::Motion(wish)));
            assert_eq!(panel.press(pressed), order);
            assert!(!panel.is_frozen());
        }
        assert_eq!(key(KeyCode::Char('ü')), None);
    }
}
