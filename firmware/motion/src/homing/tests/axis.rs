//! A motor that follows orders on ramps, switches with hysteresis, and an index track, on virtual time.

use super::super::*;

/// Where a switch is active, without hysteresis.
pub(crate) type Range = (i64, i64);

/// What there is along the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Track {
    pub(crate) negative_limit: Option<Range>,
    pub(crate) positive_limit: Option<Range>,
    pub(crate) home: Option<Range>,
    /// First index pulse and their distance.
    pub(crate) index: Option<(i64, i64)>,
    /// Hard stops.
    pub(crate) stops: Option<Range>,
    /// So far beyond its edge a switch changes.
    pub(crate) hysteresis: i64,
    /// A switch is seen to have changed when it has kept its level for so many ticks.
    pub(crate) latency: usize,
}

pub(crate) const FAR: i64 = 1 << 40;

impl Track {
    /// The axis for which the reference results are known, with this home switch.
    pub(crate) const fn with_home(home: Range) -> Self {
        Self {
            negative_limit: Some((-FAR, -50_000)),
            positive_limit: Some((50_000, FAR)),
            home: Some(home),
            index: Some((400, 3_200)),
            stops: None,
            hysteresis: 0,
            latency: 0,
        }
    }
}

/// A switch, as it is and as it is inputs.
#[derive(Debug)]
struct Switch {
    range: Option<Range>,
    hysteresis: i64,
    active: bool,
    /// Where it left the level that is inputs.
    edge: Option<i32>,
    /// In how many ticks it has not been at that level.
    changing: usize,
    seen: SwitchState,
}

impl Switch {
    fn new(range: Option<Range>, hysteresis: i64, position: i64) -> Self {
        let mut switch = Self {
            range,
            hysteresis,
            active: false,
            edge: None,
            changing: 0,
            seen: SwitchState::default(),
        };
        switch.active = switch.is_active_at(position);
        switch.seen.active = switch.active;
        switch
    }

    fn is_active_at(&self, position: i64) -> bool {
        let margin = if self.active {
            -self.hysteresis
        } else {
            self.hysteresis
        };
        self.range
            .is_some_and(|(low, high)| low + margin <= position && position <= high - margin)
    }

    fn step(&mut self, position: i64) {
        self.active = self.is_active_at(position);
        if self.active != self.seen.active {
            self.edge = self.edge.or(Some(position as i32));
        }
    }

    fn look(&mut self, latency: usize) -> SwitchState {
        self.seen.edge = None;
        if self.active == self.seen.active {
            self.changing = 0;
            self.edge = None;
        } else if self.changing < latency {
            self.changing += 1;
        } else {
            self.changing = 0;
            self.seen.active = self.active;
            self.seen.edge = self.edge.take();
        }
        self.seen.pending = self.edge;
        self.seen
    }
}

/// What the motor is after.
#[derive(Clone, Copy, Debug)]
enum Goal {
    Velocity(i64),
    Position(i64, i64),
}

/// A motor and what is around it.
#[derive(Debug)]
pub(crate) struct Bench {
    pub(crate) position: i64,
    velocity: i64,
    /// Thousandths of a step.
    fraction: i64,
    goal: Goal,
    track: Track,
    switches: [Switch; 3],
    index: Option<i32>,
    blocked: bool,
    pub(crate) halt: bool,
    pub(crate) search_speed: i64,
    pub(crate) zero_speed: i64,
    pub(crate) acceleration: i64,
    /// The farthest positions reached.
    pub(crate) reached: (i64, i64),
    pub(crate) ticks: u32,
}

impl Bench {
    pub(crate) fn new(track: Track, position: i64) -> Self {
        let switch = |range| Switch::new(range, track.hysteresis, position);
        Self {
            position,
            velocity: 0,
            fraction: 0,
            goal: Goal::Velocity(0),
            track,
            switches: [track.negative_limit, track.positive_limit, track.home].map(switch),
            index: None,
            blocked: false,
            halt: false,
            search_speed: 20_000,
            zero_speed: 2_000,
            acceleration: 400_000,
            reached: (position, position),
            ticks: 0,
        }
    }

    pub(crate) fn velocity(&self) -> i64 {
        self.velocity
    }

    pub(crate) fn inputs(&mut self) -> Inputs {
        let [negative_limit, positive_limit, home] = self
            .switches
            .each_mut()
            .map(|switch| switch.look(self.track.latency));
        Inputs {
            elapsed: 1_000,
            position: self.position as i32,
            standstill: self.velocity == 0
                && match self.goal {
                    Goal::Velocity(velocity) => velocity == 0,
                    Goal::Position(target, _) => target == self.position,
                },
            halt: self.halt,
            negative_limit,
            positive_limit,
            home,
            index: self.index.take(),
            blocked: self.blocked,
        }
    }

    pub(crate) fn obey(&mut self, order: Order) {
        let speed = |speed| match speed {
            Speed::Search => self.search_speed,
            Speed::Zero => self.zero_speed,
        };
        self.goal = match order {
            Order::GoOn => self.goal,
            Order::Run(direction, at) => Goal::Velocity(speed(at) * i64::from(direction.sign())),
            Order::Stop => Goal::Velocity(0),
            Order::Go(target) | Order::Return(target) => {
                Goal::Position(target.into(), speed(Speed::Zero))
            }
            Order::CutOff => {
                self.velocity = 0;
                Goal::Velocity(0)
            }
        };
    }

    /// A millisecond passes.
    pub(crate) fn run(&mut self) {
        self.ticks += 1;
        let goal = match self.goal {
            Goal::Velocity(velocity) => velocity,
            // Slow enough to stop at once.
            Goal::Position(target, speed) => {
                (target - self.position).clamp(-1, 1) * speed.min(1_000)
            }
        };
        let max = self.acceleration / 1_000;
        self.velocity += (goal - self.velocity).clamp(-max, max);
        if matches!(self.goal, Goal::Position(..)) {
            self.velocity = goal;
        }
        self.fraction += self.velocity;
        let steps = self.fraction / 1_000;
        self.fraction %= 1_000;
        self.blocked = false;
        for _ in 0..steps.abs() {
            let next = self.position + steps.signum();
            if self
                .track
                .stops
                .is_some_and(|(low, high)| next < low || high < next)
            {
                self.blocked = true;
                return;
            }
            self.position = next;
            for switch in &mut self.switches {
                switch.step(next);
            }
            if let Some((first, distance)) = self.track.index
                && (next - first).rem_euclid(distance) == 0
            {
                self.index = Some(next as i32);
            }
        }
        self.reached = (
            self.reached.0.min(self.position),
            self.reached.1.max(self.position),
        );
        if matches!(self.goal, Goal::Position(target, _) if target == self.position) {
            self.velocity = 0;
            self.fraction = 0;
        }
    }

    pub(crate) fn fitted(&self) -> Fitted {
        Fitted {
            negative_limit: self.track.negative_limit.is_some(),
            positive_limit: self.track.positive_limit.is_some(),
            home: self.track.home.is_some(),
            index: self.track.index.is_some(),
            block: self.track.stops.is_some(),
        }
    }

    /// Begins a method.
    pub(crate) fn begin(&mut self, code: i8, settings: Settings) -> Result<Homing, Failure> {
        let method = Method::from_code(code).unwrap();
        let inputs = self.inputs();
        Homing::begin(method, settings, self.fitted(), &inputs)
    }

    /// One control tick of the engine and the motor.
    pub(crate) fn tick(&mut self, homing: &mut Homing) -> Outcome {
        let outcome = homing.tick(&self.inputs());
        match outcome {
            Outcome::UnderWay(order) => self.obey(order),
            Outcome::Attained(_) | Outcome::Failed(_) => {}
        }
        self.run();
        outcome
    }

    /// A method to its end: the home position.
    pub(crate) fn home(&mut self, code: i8, settings: Settings) -> Result<i32, Failure> {
        let mut homing = self.begin(code, settings)?;
        for _ in 0..200_000 {
            match self.tick(&mut homing) {
                Outcome::UnderWay(_) => {}
                Outcome::Attained(home) => {
                    assert_eq!(self.velocity, 0);
                    return Ok(home);
                }
                Outcome::Failed(failure) => return Err(failure),
            }
        }
        panic!("method {code} goes on for ever: {homing:?}");
    }
}
