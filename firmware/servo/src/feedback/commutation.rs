//! Where the magnet is, found by moving it a little: for a rotor with nothing but an incremental encoder.
//!
//! A current in d pulls the magnet to the field. The field gives way: for each part of a turn that the rotor comes nearer, the field goes several towards it, and more while it is
//! fast, which damps it. So they meet after a small part of the way between them. What is left is to tell meeting from being opposite, where nothing
//! pulls either: the field is turned on and back evenly, and the rotor must follow both ways. Friction holds it back on both alike; the mean of both
//! is the angle.
//!
//! ```text
//! Rise ──► Meet ──► Forward ──► Back ──► found
//!   ▲        │         │          │
//!   └────────┴─────────┴──────────┴── not followed: a quarter of a turn further, three times, then failed
//! ```

use crate::Angle;
use crate::motor::{Implausible, Motor};
use crate::number::{between, is_within, limit, root};

/// How far the field is turned on and back, in electrical turns: 60°.
const SWEEP: f32 = 1.0 / 6.0;

/// How far the rotor must follow that and must not exceed it, as shares of it.
const FOLLOWED: (f32, f32) = (0.6, 1.4);

/// How long the current rises, the rotor comes to rest, and each sweep takes, in s.
const RISE: f32 = 0.15;
const REST: f32 = 0.15;
const SWEEP_TIME: f32 = 0.15;

/// How often it is tried.
const TRIES: u8 = 4;

/// How many times faster than the rotor the field goes towards it, at most.
const MAX_RATIO: f32 = 20.0;

/// The rotor swings in the field no faster than this, in rad/s: an observer of 2,000 rad/s still sees it.
const FASTEST_SWING: f32 = 1_500.0;

/// The field is not turned further than this by a count of the encoder, in electrical turns: 15°.
const STRIDE: f32 = 1.0 / 24.0;

/// What the current loop is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// A current in d, in A, with the frame of the rotor at this electrical angle.
    Hold {
        /// Where the field is.
        angle: Angle,
        /// In A.
        current: f32,
    },
    /// The rotor is at this electrical angle now.
    Found(Angle),
    /// It does not follow: it is blocked, a phase or the encoder is broken, or the encoder counts the other way.
    Failed,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Rise,
    Rest,
    Forward,
    Back,
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Commutation {
    current: f32,
    period: f32,
    /// Electrical turns of a count.
    count: f32,
    ratio: f32,
    /// By so many turns the field goes for an electrical turn/s of the rotor.
    damping: f32,
    state: State,
    tries: u8,
    /// Since the state began, in s.
    time: f32,
    /// Where the count was as the try began.
    from: Option<i64>,
    base: Angle,
    /// In electrical turns from `from`: as the sweep began, and as it came to its other end.
    begin: f32,
    middle: f32,
    /// In electrical turns/s.
    speed: f32,
    moved: f32,
    /// Where the field was when it met the rotor.
    met: Angle,
}

impl Commutation {
    /// With a current in A, called in each period of the current loop, in s.
    ///
    /// # Errors
    /// With a current outside 1 mA to the peak of the motor, or a period outside 5 µs to 1 ms.
    pub fn new(motor: &Motor, current: f32, period: f32) -> Result<Self, Implausible> {
        motor.check()?;
        let is_one = is_within(current, 1e-3, motor.peak_current) && is_within(period, 5e-6, 1e-3);
        Implausible::unless(is_one)?;
        let count = f32::from(motor.pole_pairs) / motor.counts as f32;
        // A pendulum in the field: ω² = p kt I (ratio + 1) / J; damped as much as it can be, by 2 ω / (p kt I / J).
        let pull = f32::from(motor.pole_pairs) * motor.torque_constant() * current / motor.inertia;
        let max = between(STRIDE / count, 0.0, MAX_RATIO);
        let ratio = between(FASTEST_SWING * FASTEST_SWING / pull - 1.0, 0.0, max);
        let damping = 2.0 * root((ratio + 1.0) / pull);
        Ok(Self {
            current,
            period,
            count,
            ratio,
            damping,
            state: State::Rise,
            tries: 0,
            time: 0.0,
            from: None,
            base: Angle::ZERO,
            begin: 0.0,
            middle: 0.0,
            speed: 0.0,
            moved: 0.0,
            met: Angle::ZERO,
        })
    }

    /// A period has passed, and the encoder is at this position, in counts, and goes with this electrical speed, in rad/s.
    pub fn run(&mut self, position: i64, speed: f32) -> Step {
        let from = *self.from.get_or_insert(position);
        let counts = position.wrapping_sub(from).clamp(-(1 << 23), 1 << 23);
        self.moved = counts as i32 as f32 * self.count;
        self.speed = limit(speed, 1e5) * (1.0 / core::f32::consts::TAU);
        self.time += self.period;
        match self.state {
            State::Rise | State::Rest => self.meet(),
            State::Forward | State::Back => {
                let is_forward = self.state == State::Forward;
                if self.time < SWEEP_TIME + REST {
                    let part = self.part(SWEEP_TIME);
                    return self.sweep(if is_forward { part } else { 1.0 - part });
                }
                let way = if is_forward {
                    self.moved - self.begin
                } else {
                    self.middle - self.moved
                };
                if !is_within(way / SWEEP, FOLLOWED.0, FOLLOWED.1) {
                    return self.try_again();
                }
                if is_forward {
                    self.middle = self.moved;
                    self.enter(State::Back);
                    return self.sweep(1.0);
                }
                // Forward the rotor was behind the field by what friction holds, back before it.
                let ahead = 0.5 * (self.middle + self.moved) - 0.5 * SWEEP;
                Step::Found(self.met.plus(Angle::from_turns(self.moved - ahead)))
            }
        }
    }

    /// The field comes to the rotor.
    fn meet(&mut self) -> Step {
        let towards = limit(self.ratio * self.moved, 1.0);
        let met = self.base.minus(Angle::from_turns(towards));
        let damped = limit(self.damping * self.speed, SWEEP);
        let field = met.minus(Angle::from_turns(damped));
        match self.state {
            State::Rise if self.time >= RISE => self.enter(State::Rest),
            State::Rest if self.time >= REST => {
                self.met = met;
                self.begin = self.moved;
                self.enter(State::Forward);
            }
            _ => {}
        }
        let share = match self.state {
            State::Rise => self.part(RISE),
            _ => 1.0,
        };
        self.hold(field, share)
    }

    /// The field is so much of the sweep from where they met.
    fn sweep(&self, part: f32) -> Step {
        let turned = SWEEP * part - limit(self.damping * self.speed, SWEEP);
        self.hold(self.met.plus(Angle::from_turns(turned)), 1.0)
    }

    fn hold(&self, angle: Angle, share: f32) -> Step {
        Step::Hold {
            angle,
            current: self.current * share,
        }
    }

    fn part(&self, time: f32) -> f32 {
        between(self.time / time, 0.0, 1.0)
    }

    fn enter(&mut self, state: State) {
        (self.state, self.time) = (state, 0.0);
    }

    fn try_again(&mut self) -> Step {
        self.tries += 1;
        if self.tries >= TRIES {
            self.tries = TRIES;
            return Step::Failed;
        }
        self.base = self.met.plus(Angle::QUARTER);
        (self.from, self.moved, self.speed) = (None, 0.0, 0.0);
        self.enter(State::Rise);
        self.hold(self.base, 0.0)
    }
}
