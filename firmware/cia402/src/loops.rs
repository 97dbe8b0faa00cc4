//! The settings of the loops of a servo, the measurements they are asked for, and what they report.
//!
//! A generic drive has objects for all of it (20C0h to 20C5h). A product has objects of its own, of which its module makes this
//! ([`Behaviour::loops`](crate::Behaviour::loops)).

/// Whether the drive may have loops: without the feature `torque` it has none, and nothing calls
/// [`Behaviour::loops`](crate::Behaviour::loops).
pub const MAY_BE_THERE: bool = cfg!(feature = "torque");

/// The settings of motor and loops from the objects; 0 stands for the value built into the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServoSettings {
    /// 20C2h: in µΩ, nH along and across, nV·s, g·mm², µN·m. Taken over while the power is off.
    pub motor: [u32; 6],
    /// 20C2h:7: the greatest current that may weaken the field, in mA. Taken over while the power is off.
    pub weakening: u32,
    /// Taken over while the power is off.
    pub pole_pairs: u16,
    /// The commutation offset: how far the rotor's flux is ahead of the angle from the encoder, in electrical turns of 2¹⁶. Taken over
    /// while the power is off.
    pub offset: u16,
    /// The encoder counts the other way. Taken over while the power is off.
    pub is_turned: bool,
    /// Counts of the encoder in a turn, where a turn has another number of positions; 0 is what the axis has. Taken over while the
    /// power is off.
    pub encoder: u32,
    /// The words of the Hall sensors in the order in which the magnet passes them forward, from its angle 0 on; all 0 is that of the
    /// axis. Taken over while the power is off.
    pub hall: [u8; 6],
    /// The magnet is looked for, whatever sensor tells where it is. Taken over while the power is off.
    pub is_searched: bool,
    /// How much the current vector leads the flux beyond a quarter of an electrical turn, in turns of 2¹⁶.
    pub lead: i16,
    /// No current, whatever is ordered.
    pub is_barred: bool,
    /// The feed-forward of velocity and of acceleration, in thousandths.
    pub ahead: (u16, u16),
    /// 60F9h:1 and 2, 60FBh:1, in 1/s.
    pub gains: [u16; 3],
    /// 60F6h:1: the gain of the current loop across the magnet (q axis), in thousandths.
    pub share: u16,
    /// The same along the magnet (d axis); 0 is as across it.
    pub share_along: u16,
    /// The share of the unknown voltage that the current loop learns in a period, in thousandths; 0 is that of the axis.
    pub learning: u16,
    /// 20C3h: the low-pass in Hz and its quality in thousandths, the notch likewise.
    pub filters: [u16; 4],
    /// 20C4h.
    pub stepper: StepperSettings,
    /// 20C5h: time in ms and speed in 1/min.
    pub blocked: (u16, u16),
}

impl Default for ServoSettings {
    fn default() -> Self {
        Self::NONE
    }
}

/// A stepper with a rotating field in place of field-oriented control, 20C4h:1 to 6. The lead is the angle by which the field is ahead of
/// the rotor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepperSettings {
    /// 20C4h:1: 0 field-oriented control. As a stepper: 1, a lead beyond the bound is reported only; 2 to 4, the field is held at the
    /// bound, and the steps that it falls behind are made up at rest (2), at once (3), or not at all (4). Taken over while the power is
    /// off.
    pub mode: u8,
    /// 20C4h:2: the bound of the lead, in hundredths of a full step.
    pub bound: u16,
    /// 20C4h:3: the velocity with which steps are made up, in full steps/s.
    pub speed: u16,
    /// 20C4h:4: the current in motion, in thousandths of 6075h.
    pub current: u16,
    /// 20C4h:5: the current at rest, in thousandths of that in motion.
    pub at_rest: u16,
    /// 20C4h:6: the time in which the current falls to a third of the difference, in ms.
    pub fall: u16,
    /// These settings are taken over at once, whatever the motor does.
    pub is_at_once: bool,
}

impl ServoSettings {
    /// All as the axis has it.
    pub const NONE: Self = Self {
        motor: [0; 6],
        weakening: 0,
        pole_pairs: 0,
        offset: 0,
        is_turned: false,
        encoder: 0,
        hall: [0; 6],
        is_searched: false,
        lead: 0,
        is_barred: false,
        ahead: (1_000, 1_000),
        gains: [0; 3],
        share: 0,
        share_along: 0,
        learning: 0,
        filters: [0; 4],
        stepper: StepperSettings {
            mode: 0,
            bound: 0,
            speed: 0,
            current: 0,
            at_rest: 0,
            fall: 0,
            is_at_once: false,
        },
        blocked: (500, 10),
    };
}

/// What is to be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Identify the motor: with this current in thousandths of the rated one, within this distance in thousandths of a turn, for this
    /// bandwidth in 1/s.
    Motor {
        /// 20C0h:2.
        current: u16,
        /// 20C0h:3.
        distance: u16,
        /// 20C0h:4.
        bandwidth: u16,
    },
    /// A chirp: a sine added to the torque, of this amplitude in thousandths of the rated torque, from one frequency to another in 0.1 Hz,
    /// for so many ms.
    Chirp {
        /// 20C0h:5.
        torque: u16,
        /// 20C0h:6 and 7.
        frequencies: (u16, u16),
        /// 20C0h:8.
        time: u16,
        /// 20C0h:3.
        distance: u16,
    },
    /// Nothing any more.
    End,
}

/// The result of a measurement, as 20C1h shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// 20C1h:1 and 2.
    pub state: u8,
    /// See `state`.
    pub failure: u8,
    /// 20C1h:3 to 6.
    pub winding: [u32; 4],
    /// 20C1h:7.
    pub pole_pairs: u16,
    /// 20C1h:8.
    pub direction: i8,
    /// 20C1h:9.
    pub angle: u16,
    /// 20C1h:10 and 11.
    pub loads: [u32; 2],
    /// 20C1h:12 to 14.
    pub gains: [u16; 3],
}

impl Found {
    /// There was no measurement yet.
    pub const NONE: Self = Self {
        state: 0,
        failure: 0,
        winding: [0; 4],
        pole_pairs: 0,
        direction: 0,
        angle: 0,
        loads: [0; 2],
        gains: [0; 3],
    };

    /// Whether the measurement is over.
    pub fn has_ended(&self) -> bool {
        self.state >= 6
    }
}

/// What the loops report beside the actual values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoopReport {
    /// What a measurement has found.
    pub found: Found,
    /// The motor that the loops go by, as 20C2h has it, and its pole pairs.
    pub motor: [u32; 6],
    /// See `motor`.
    pub pole_pairs: u16,
    /// The same of the axis itself, whatever is set.
    pub own_motor: [u32; 6],
    /// See `own_motor`.
    pub own_pole_pairs: u16,
    /// See `own_motor`.
    pub own_torque_constant: u32,
    /// The torque constant in µN·m/A.
    pub torque_constant: u32,
    /// The gains of the axis where no others are set, as [`ServoSettings::gains`] has them, and the share of its current loop.
    pub own_gains: [u16; 3],
    /// See `own_gains`.
    pub own_share: u16,
    /// The same as [`ServoSettings::learning`].
    pub own_learning: u16,
    /// Of the rotor, in thousandths of a turn in a minute.
    pub speed: i32,
    /// Whole counts of the encoder from where it began, and those of a turn.
    pub counts: i64,
    /// See `counts`.
    pub counts_of_turn: u32,
    /// Of the motor, in mA.
    pub rated_current: u32,
    /// The peak of that.
    pub peak_current: u32,
    /// The fastest that it may turn, in 1/min.
    pub max_speed: u32,
    /// The electrical angle that the magnet has where the encoder is at 0, without the offset of the settings, in turns of 2¹⁶.
    pub zero: u16,
    /// The lead of a stepper's field in hundredths of a full step.
    pub lead: u16,
    /// Along the magnet and across it, in mA.
    pub current: (i32, i32),
    /// The electrical angle of the rotor, in turns of 2¹⁶.
    pub angle: u16,
    /// The I²t load, in thousandths of the limit.
    pub heat: u16,
    /// A limit of torque, current or lead is in the way, or steps are held back.
    pub is_limited: bool,
    /// The loops have current to give.
    pub is_on: bool,
}
