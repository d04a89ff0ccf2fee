//! The steps of a preparation, and what they take.

/// The next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    Turned,
    Shape,
    Start,
    Slopes,
    Velocity,
    Acceleration,
    LastEnd,
    Corner,
    BlendFrom,
    BlendDeparts,
    BlendTo,
    BlendArrives,
    Blend,
    BlendSlopes,
    BlendBends,
    BlendVelocity,
    BlendAcceleration,
    BlendFollows,
    FollowBlend,
    GuardBlend,
    AddBlend,
    AddAfterBlend,
    Follow,
    Guard,
    Add,
    FromRest,
}

impl Step {
    /// Instructions for three axes on a Cortex-M4, at most: an arc takes more than a line, as the piece or as the last one before it.
    pub(crate) const fn cost(self, piece: bool, last: bool) -> u32 {
        match self {
            Self::Turned => 320,
            Self::Shape => 300,
            Self::Start | Self::BlendArrives => either(piece, 290, 135),
            Self::Slopes => either(piece, 265, 110),
            Self::Velocity => either(piece, 285, 130),
            Self::Acceleration => either(piece, 270, 200),
            Self::LastEnd | Self::BlendDeparts => either(last, 305, 145),
            Self::BlendFrom => either(last, 355, 175),
            Self::BlendTo => either(piece, 330, 155),
            Self::Guard | Self::GuardBlend | Self::BlendAcceleration => 190,
            Self::Blend | Self::AddAfterBlend => 270,
            Self::BlendSlopes | Self::BlendBends => 290,
            Self::BlendFollows | Self::FollowBlend | Self::Follow => 325,
            Self::Corner | Self::AddBlend | Self::Add | Self::FromRest => 340,
            Self::BlendVelocity => 360,
        }
    }
}

const fn either(is_round: bool, arc: u32, line: u32) -> u32 {
    if is_round { arc } else { line }
}
