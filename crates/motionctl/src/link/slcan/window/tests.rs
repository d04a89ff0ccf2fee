use embedded_can::{Frame as _, StandardId};

use super::*;

fn frame(number: usize) -> Frame {
    let bytes = u16::try_from(number).unwrap().to_be_bytes();
    Frame::new(StandardId::new(0x03C).unwrap(), &bytes).unwrap()
}

/// A window and a clock that only the test moves on.
struct Rig {
    window: Window,
    start: Instant,
    now: Instant,
    sent: usize,
}

impl Rig {
    fn new() -> Self {
        let now = Instant::now();
        let window = Window::new(MOST_UNANSWERED);
        Self {
            window,
            start: now,
            now,
            sent: 0,
        }
    }

    /// One that has answered for its first frame.
    fn answering() -> Self {
        let mut rig = Self::new();
        rig.send(1);
        rig.hear("z");
        rig
    }

    fn send(&mut self, frames: usize) {
        for _ in 0..frames {
            assert!(self.window.has_room(), "frame {}", self.sent);
            self.window.sent(frame(self.sent), self.now);
            self.sent += 1;
        }
    }

    /// `z` for a frame that is taken, `b` for a BEL.
    fn hear(&mut self, answers: &str) {
        for letter in answers.chars() {
            let answer = match letter {
                'z' => Answer::Taken,
                _ => Answer::Refused,
            };
            self.window.answer(answer, self.now);
            self.window.tick(self.now);
        }
    }

    fn pass(&mut self, time: Duration) {
        self.now += time;
        self.window.tick(self.now);
    }

    /// The frames that are given back, by their number, and how many are of unknown fate.
    fn outcome(&mut self) -> (Vec<Frame>, usize) {
        let refused = std::iter::from_fn(|| self.window.take_refused()).collect();
        (refused, self.window.take_unknown())
    }
}

#[test]
fn a_refusal_is_believed_when_the_answers_are_as_many_as_the_frames() {
    let mut rig = Rig::answering();
    rig.send(4);
    rig.hear("zbz");
    assert!(!rig.window.has_room(), "the count must not be disturbed");
    rig.hear("z");
    rig.pass(QUIET - Duration::from_millis(1));
    assert_eq!(rig.outcome(), (vec![], 0));
    rig.pass(Duration::from_millis(1));
    assert_eq!(rig.outcome(), (vec![frame(2)], 0));
    rig.send(MOST_UNANSWERED);
}

#[test]
fn a_refusal_that_belongs_to_no_frame_is_noise() {
    // Before, between and behind the answers of the frames that wait.
    for answers in ["bzzz", "zbzz", "zzbz", "zzzb"] {
        let mut rig = Rig::answering();
        rig.send(3);
        rig.hear(answers);
        rig.pass(ANSWER_LIMIT);
        assert_eq!(rig.outcome(), (vec![], 0), "{answers}");
        rig.send(MOST_UNANSWERED);
    }
}

#[test]
fn a_refusal_beside_a_lost_answer_gives_no_frame_back() {
    for answers in ["bz", "zb"] {
        let mut rig = Rig::answering();
        rig.send(3);
        rig.hear(answers);
        rig.pass(ANSWER_LIMIT - Duration::from_millis(1));
        assert_eq!(rig.outcome().0, vec![], "{answers}");
        rig.pass(Duration::from_millis(1));
        let (refused, unknown) = rig.outcome();
        assert_eq!(refused, vec![], "{answers}");
        assert!(unknown > 0, "{answers}");
        assert!(rig.window.has_room());
    }
}

#[test]
fn lost_answers_end_as_unknown_after_the_stated_time_and_free_the_window() {
    let mut rig = Rig::answering();
    rig.send(MOST_UNANSWERED);
    assert!(!rig.window.has_room());
    rig.pass(ANSWER_LIMIT - Duration::from_millis(1));
    assert!(!rig.window.has_room());
    assert_eq!(rig.outcome(), (vec![], 0));
    rig.pass(Duration::from_millis(1));
    assert_eq!(rig.outcome(), (vec![], MOST_UNANSWERED));
    rig.send(MOST_UNANSWERED);
}

#[test]
fn one_lost_answer_in_many_is_found_at_the_latest_when_the_window_is_full() {
    let mut rig = Rig::answering();
    let mut cycles = 0;
    while rig.window.has_room() {
        rig.send(1);
        cycles += 1;
        if cycles % 40 != 0 {
            rig.hear("z");
        }
        rig.pass(Duration::from_millis(1));
    }
    assert_eq!(cycles, 40 * MOST_UNANSWERED);
    rig.pass(ANSWER_LIMIT);
    assert_eq!(rig.outcome(), (vec![], MOST_UNANSWERED));
}

#[test]
fn answers_beyond_the_frames_change_nothing_and_make_refusals_incredible() {
    let mut rig = Rig::answering();
    rig.hear("zz");
    assert_eq!(rig.outcome(), (vec![], 0));
    rig.send(MOST_UNANSWERED);
    rig.hear(&"z".repeat(MOST_UNANSWERED));
    rig.send(2);
    // The second of these may be for any of the two.
    rig.hear("zb");
    rig.pass(ANSWER_LIMIT);
    assert_eq!(rig.outcome(), (vec![], 1));
    rig.send(1);
    rig.hear("zb");
    assert_eq!(rig.outcome(), (vec![], 1));
    // Long after the latest frame it is noise.
    rig.pass(ANSWER_LIMIT);
    rig.hear("b");
    assert_eq!(rig.outcome(), (vec![], 0));
}

#[test]
fn an_adapter_that_never_answers_holds_nothing_up_but_its_first_frames() {
    let mut rig = Rig::new();
    rig.send(MOST_UNANSWERED);
    assert!(!rig.window.has_room() && !rig.window.is_silent());
    rig.pass(ANSWER_LIMIT);
    assert!(rig.window.is_silent());
    assert_eq!(rig.outcome(), (vec![], 0));
    rig.send(10 * MOST_UNANSWERED);
    rig.pass(ANSWER_LIMIT);
    assert_eq!(rig.outcome(), (vec![], 0));
    // A refusal can be of any of the frames of late.
    rig.send(1);
    rig.hear("b");
    assert_eq!(rig.outcome(), (vec![], 1));
}

#[test]
fn one_that_answers_late_is_not_silent_for_ever() {
    let mut rig = Rig::new();
    rig.send(3);
    rig.pass(ANSWER_LIMIT);
    assert!(rig.window.is_silent());
    rig.send(1);
    rig.hear("z");
    assert!(!rig.window.is_silent());
    rig.send(MOST_UNANSWERED);
    assert!(!rig.window.has_room());
    assert!(rig.start < rig.now);
}

proptest::proptest! {
    /// Frames with answers of which some are lost and some are too many: what is given back was refused, or so many answers are
    /// wrong at the same time that they cancel out.
    #[test]
    fn what_is_given_back_was_refused(
        fates in proptest::collection::vec(0..100_u8, 1..200), lost_every in 2..50_usize
    ) {
        let mut rig = Rig::answering();
        let mut refused = Vec::new();
        for (number, fate) in fates.iter().enumerate() {
            while !rig.window.has_room() {
                rig.pass(Duration::from_millis(10));
            }
            let (given_back, _) = rig.outcome();
            proptest::prop_assert!(given_back.iter().all(|frame| refused.contains(frame)));
            rig.send(1);
            let is_refused = *fate < 10;
            if is_refused {
                refused.push(frame(rig.sent - 1));
            }
            if number % lost_every != 0 {
                rig.hear(if is_refused { "b" } else { "z" });
            }
        }
        rig.pass(ANSWER_LIMIT);
        let (given_back, _) = rig.outcome();
        proptest::prop_assert!(given_back.iter().all(|frame| refused.contains(frame)));
    }
}

proptest::proptest! {
    /// Whatever an adapter answers, and when: there is room again after the stated time of silence, and no frame is given back that
    /// was not handed over, or twice.
    #[test]
    fn nothing_holds_the_window_up_for_longer_than_stated(
        steps in proptest::collection::vec((0..4_u8, 0..600_u64), 0..300), most in 1..=MOST_UNANSWERED
    ) {
        let mut rig = Rig::new();
        rig.window = Window::new(most);
        let mut back = Vec::new();
        for (what, ms) in steps {
            match what {
                0 if rig.window.has_room() => rig.send(1),
                1 => rig.hear("z"),
                2 => rig.hear("b"),
                _ => rig.pass(Duration::from_millis(ms)),
            }
            back.extend(rig.outcome().0);
        }
        rig.pass(ANSWER_LIMIT);
        proptest::prop_assert!(rig.window.has_room());
        back.extend(rig.outcome().0);
        let handed_over: Vec<Frame> = (0..rig.sent).map(frame).collect();
        for (place, frame) in back.iter().enumerate() {
            proptest::prop_assert!(handed_over.contains(frame));
            proptest::prop_assert!(!back[..place].contains(frame));
        }
    }
}

#[test]
fn more_answers_than_frames_and_too_few_that_took_one_leave_them_unknown() {
    let mut rig = Rig::answering();
    rig.send(3);
    rig.hear("bbzz");
    assert_eq!(rig.outcome(), (vec![], 3));
    assert!(rig.window.has_room());
    // As many as the frames were taken: the refusal was noise.
    rig.send(3);
    rig.hear("bzzz");
    rig.pass(QUIET);
    assert_eq!(rig.outcome(), (vec![], 0));
}

#[test]
fn one_that_only_refuses_does_not_answer() {
    let mut rig = Rig::new();
    rig.send(2);
    rig.hear("b");
    rig.pass(ANSWER_LIMIT);
    // Its silence about the other one is no loss.
    assert!(rig.window.is_silent());
    assert_eq!(rig.outcome(), (vec![], 0));
}
