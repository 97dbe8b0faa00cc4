//! What the control is told, and what it tells.

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// A position, in counts; it moves on from there.
    Position {
        /// Whole counts.
        counts: i64,
        /// Parts of a count beyond, in 2⁻³².
        part: u32,
        /// In counts/s.
        velocity: f32,
        /// In counts/s².
        acceleration: f32,
    },
    /// A torque.
    Torque,
}

/// An order of the drive. Torques are in N·m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// What is to be done.
    pub goal: Goal,
    /// The torque that is held, or that is given ahead.
    pub torque: f32,
    /// What is given ahead beside the velocity of a position, in counts/s.
    pub velocity_ahead: f32,
    /// The greatest positive and negative torque, each at least 0.
    pub max_torque: (f32, f32),
    /// The greatest current, in A, of which a weakened field has its part. Without one the torques are to be within it.
    pub max_current: f32,
    /// The fastest while a torque is held, in counts/s.
    pub speed: f32,
}

/// What becomes of an order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// What is wanted, within all limits, in N·m.
    pub demand: f32,
    /// Of the motor by its current, in N·m.
    pub torque: f32,
    /// As the peak of a phase, with the sign of the torque, in A.
    pub current: f32,
    /// In counts/s.
    pub velocity: f32,
    /// Less was done than was wanted: a limit of the torque.
    pub is_limited: bool,
    /// By how many full steps the field of a stepper is to lead the rotor; 0 where none does.
    pub lead: f32,
    /// The heat has come near its bound.
    pub is_hot: bool,
}
