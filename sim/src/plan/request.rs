//! From the command line to a plan.

use motion::{
    Axis, AxisConfig, Clock, DriverTiming, Goal, Limits, Plan, Position, Ramps, Speed, State,
    Ticks, Velocity,
};

use super::curve::Curve;
use super::{Arguments, Profile, decimal};

/// Shortest time of the step signal being high, and being low, in ns: what a fast driver chip needs.
const PULSE: u32 = 100;
/// From a change of direction to a pulse and the other way round, in ns.
const TURN: u32 = 20;

/// Pulses are made in time slices of 250 µs, as in the drive. A move that lasts for hours gets longer ones, so that there are at
/// most so many; no time slice lasts longer than a second, and what would need more of them is not played.
const MAX_TIME_SLICES: u64 = 10_000_000;

/// A planned move.
pub(super) struct Move {
    pub(super) clock: Clock,
    pub(super) curve: Curve,
    pub(super) axis: AxisConfig,
    pub(super) ramps: Ramps,
    /// Where it begins, in steps.
    pub(super) origin: i64,
    /// The tick at which the target is reached. The plan begins with tick 0.
    pub(super) end: Ticks,
}

impl Move {
    /// Plans what the command line asks for.
    pub(super) fn of(arguments: &Arguments) -> Result<Self, String> {
        let clock = Clock::new(arguments.clock).ok_or_else(|| {
            format!(
                "a clock of {} Hz is not supported: {} to {} Hz are",
                arguments.clock,
                Clock::SLOWEST,
                Clock::FASTEST
            )
        })?;
        let ticks = |nanoseconds: u32| {
            let ticks = u64::from(clock.hz()) * u64::from(nanoseconds);
            u32::try_from(ticks.div_ceil(1_000_000_000)).unwrap_or(u32::MAX)
        };
        let timing = DriverTiming {
            pulse_high: ticks(PULSE),
            pulse_low: ticks(PULSE),
            direction_setup: ticks(TURN),
            direction_hold: ticks(TURN),
        };
        let limits = Limits {
            velocity: arguments.velocity,
            acceleration: arguments.acceleration,
            deceleration: arguments.deceleration.unwrap_or(arguments.acceleration),
        };
        let fastest = clock.hz() / timing.shortest_period();
        let initial = arguments.initial_velocity.unsigned_abs();
        for (name, velocity) in [
            ("velocity", arguments.velocity),
            ("initial velocity", initial),
            ("end velocity", arguments.end_velocity),
        ] {
            if velocity > fastest.into() {
                let velocity = decimal::shown(velocity);
                return Err(format!(
                    "{name} of {velocity} steps/s is too high: pulses come at {fastest} steps/s at most with this clock"
                ));
            }
        }
        if arguments.end_velocity > arguments.velocity {
            return Err("the end velocity is above the profile velocity".to_owned());
        }
        let origin = origin(arguments.distance)?;
        let target = origin + arguments.distance;
        let goal = if arguments.end_velocity == Speed::ZERO {
            Goal::Rest(target)
        } else {
            Goal::Pass(target, arguments.end_velocity)
        };
        let from = State {
            position: Position::from_steps(origin),
            velocity: Velocity::from_speed(clock, arguments.initial_velocity),
        };
        let ramps = ramps(arguments)?;
        let plan =
            Plan::new(clock, 0, from, goal, limits, ramps).map_err(|error| error.to_string())?;
        let mut end = match plan.end() {
            // The clock counts no further.
            Some(end) if end >= Ticks::MAX - 1 => {
                let years = Ticks::MAX / u64::from(clock.hz()) / 31_556_952;
                return Err(format!("the move takes longer than {years} years"));
            }
            Some(end) => end,
            None => passing(&plan, target)?,
        };
        let second = u64::from(clock.hz());
        if end / second > MAX_TIME_SLICES {
            let days = 86_400 * second;
            return Err(format!(
                "the move takes {} days: its pulses are played for {} days at most",
                end / days,
                MAX_TIME_SLICES / 86_400
            ));
        }
        let time_slice = (end / MAX_TIME_SLICES).clamp(second / 4000, second.min(1 << 28));
        let axis = AxisConfig {
            clock,
            time_slice: time_slice as u32,
            timing,
        };
        let curve = if let Ramps::MovingAverage(_) = ramps {
            let mut mover = Axis::on_plan(axis, standing(clock, from, arguments)?);
            mover.set_ramps(ramps);
            let moved = mover.move_to(target, limits);
            moved.map_err(|error| error.to_string())?;
            match mover.mean() {
                Some(mean) => {
                    let curve = Curve::averaged(mover, mean);
                    end = curve.end();
                    curve
                }
                None => Curve::of(axis, plan),
            }
        } else {
            Curve::of(axis, plan)
        };
        Ok(Self {
            clock,
            curve,
            axis,
            ramps,
            origin,
            end,
        })
    }
}

/// Where a moving average begins: at rest, or at a velocity that has been kept.
fn standing(clock: Clock, from: State, arguments: &Arguments) -> Result<Plan, String> {
    if arguments.end_velocity != Speed::ZERO {
        return Err("the profile `average` ends at rest".to_owned());
    }
    let velocity = arguments.initial_velocity;
    if velocity.bits() == 0 {
        return Ok(Plan::at_rest(from.position.whole_steps(), 0));
    }
    let limits = Limits {
        velocity: velocity.unsigned_abs(),
        acceleration: 1,
        deceleration: 1,
    };
    Plan::velocity(clock, 0, from, velocity, limits).map_err(|error| error.to_string())
}

/// The ramps of the profile.
fn ramps(arguments: &Arguments) -> Result<Ramps, String> {
    let profile = match (arguments.profile, arguments.jerk) {
        (Some(profile), _) => profile,
        (None, None) => Profile::Trapezoid,
        (None, Some(_)) => Profile::Jerk,
    };
    match (profile, arguments.jerk) {
        (Profile::Trapezoid, None) => Ok(Ramps::Linear),
        (Profile::Sin2, None) => Ok(Ramps::SinSquared),
        #[cfg(feature = "limited-jerk")]
        (Profile::Jerk, Some(jerk)) => Ok(Ramps::JerkLimited(jerk)),
        #[cfg(not(feature = "limited-jerk"))]
        (Profile::Jerk, Some(_)) => {
            Err("limited jerk is not built in (cargo feature `limited-jerk`)".to_owned())
        }
        (Profile::Average, Some(jerk)) => Ok(Ramps::MovingAverage(jerk)),
        (Profile::Jerk, None) => Err("the profile `jerk` needs --jerk".to_owned()),
        (Profile::Average, None) => Err("the profile `average` needs --jerk".to_owned()),
        (_, Some(_)) => Err("--jerk is for the profiles `jerk` and `average` alone".to_owned()),
    }
}

/// Where a move of this distance can begin, so that its target lies in the span of positions.
fn origin(distance: i64) -> Result<i64, String> {
    let (low, high) = (i64::from(i32::MIN), i64::from(i32::MAX));
    match distance {
        _ if low <= distance && distance <= high => Ok(0),
        _ if (0..=high - low).contains(&distance) => Ok(low),
        _ if (low - high..=0).contains(&distance) => Ok(high),
        _ => Err(format!(
            "a distance of {distance} steps is too long: {} is the most",
            high - low
        )),
    }
}

/// The tick at which a plan that keeps its velocity passes the target.
fn passing(plan: &Plan, target: i64) -> Result<Ticks, String> {
    let last = plan.phases().last().map_or(0, |phase| phase.start());
    let there = plan.state_at(last).position.bits();
    let missed = there.wrapping_sub(Position::from_steps(target).bits());
    // One tick later it may be a little further.
    let slack = plan.state_at(last).velocity.bits().unsigned_abs() >> 23;
    if missed.unsigned_abs() > slack + (1 << 16) {
        return Err("the way is too short to come to the end velocity".to_owned());
    }
    Ok(last)
}
