//! What a servo keeps of its procedures and of the motions that its drive makes by itself.

use bus_user::Instant;
use dyn_can::ParamGroup2;

use crate::servo::activity::Activity;
use crate::servo::own_move::OwnMove;
use crate::servo::procedure::{Procedure, Run, WearLimits};

/// What an axis keeps of its procedures; takes no room in a program without them.
#[derive(Debug)]
pub(super) struct Procedures {
    #[cfg(feature = "procedures")]
    books: Books,
}

/// What there is of it.
#[derive(Debug)]
pub(super) struct Books {
    pub(super) activity: Activity,
    pub(super) wear: WearLimits,
    /// Speed and acceleration of what the drive does by itself, as read since the checks began.
    pub(super) curve: Option<ParamGroup2>,
    /// The same, as configured.
    pub(super) given_curve: Option<ParamGroup2>,
    /// Kinds of trigger for which the drive was ever given a move: what it forgets is not documented (D57).
    loads: u8,
    pub(super) wrote_at: Option<Instant>,
    /// The drive was told to start anew, and until when it does.
    pub(super) starts_until: Option<Instant>,
}

impl Procedures {
    /// None has run.
    #[cfg_attr(
        not(feature = "procedures"),
        expect(unused_variables, reason = "as above")
    )]
    pub(super) const fn new(wear: WearLimits, given_curve: Option<ParamGroup2>) -> Self {
        Self {
            #[cfg(feature = "procedures")]
            books: Books {
                activity: Activity::None,
                wear,
                curve: None,
                given_curve,
                loads: 0,
                wrote_at: None,
                starts_until: None,
            },
        }
    }

    #[inline]
    pub(super) const fn books(&self) -> Option<&Books> {
        #[cfg(feature = "procedures")]
        return Some(&self.books);
        #[cfg(not(feature = "procedures"))]
        None
    }

    #[inline]
    pub(super) const fn books_mut(&mut self) -> Option<&mut Books> {
        #[cfg(feature = "procedures")]
        return Some(&mut self.books);
        #[cfg(not(feature = "procedures"))]
        None
    }

    /// The procedure under way.
    #[inline]
    pub(super) fn run(&self) -> Option<&Run> {
        self.books()?.activity.run()
    }

    pub(super) fn run_mut(&mut self) -> Option<&mut Run> {
        self.books_mut()?.activity.run_mut()
    }

    /// Whether nothing is under way.
    #[inline]
    pub(super) fn is_idle(&self) -> bool {
        self.books().is_none_or(|books| books.activity.is_none())
    }

    /// The motion that the drive makes by itself.
    #[inline]
    pub(super) fn own(&self) -> Option<&OwnMove> {
        self.books()?.activity.own()
    }

    pub(super) fn own_mut(&mut self) -> Option<&mut OwnMove> {
        self.books_mut()?.activity.own_mut()
    }

    /// A motion that was admitted begins.
    pub(super) fn begin_own(&mut self, own: OwnMove) {
        if let Some(books) = self.books_mut() {
            books.activity = Activity::Own(own);
        }
    }

    /// Something else follows what was under way, or nothing.
    pub(super) fn follow(&mut self, activity: Activity) {
        if let Some(books) = self.books_mut() {
            books.activity = activity;
        }
    }

    /// Whether there is room for procedures and motions of the drive.
    pub(super) const fn are_built(&self) -> bool {
        self.books().is_some()
    }

    /// Speed and acceleration of what the drive does by itself.
    pub(super) fn curve(&self) -> Option<ParamGroup2> {
        let books = self.books()?;
        books.curve.or(books.given_curve)
    }

    /// The drive reported them, or what it reported does not count any more.
    pub(super) fn note_curve(&mut self, curve: Option<ParamGroup2>) {
        if let Some(books) = self.books_mut() {
            books.curve = curve;
        }
    }

    pub(super) fn loads(&self) -> u8 {
        self.books().map_or(0, |books| books.loads)
    }

    pub(super) fn note_load(&mut self, kind: u8) {
        if let Some(books) = self.books_mut() {
            books.loads |= kind;
        }
    }

    /// Until when a drive that was told to start anew does, once.
    pub(super) fn take_start(&mut self) -> Option<Instant> {
        self.books_mut()?.starts_until.take()
    }

    /// A procedure that was admitted begins.
    pub(super) fn begin(&mut self, procedure: Procedure) {
        if let Some(books) = self.books_mut() {
            books.activity = Activity::Procedure(Run::new(procedure));
        }
    }

    pub(super) fn end(&mut self) {
        if let Some(books) = self.books_mut() {
            books.activity = Activity::None;
        }
    }
}
