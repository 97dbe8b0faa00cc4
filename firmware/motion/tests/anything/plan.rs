//! Plans to any goal, from any state, again and again on the way: no panic, no jump, limits kept, and an end where it was asked for.

use motion::{Clock, Goal, Limits, Plan, Position, Ramps, State, Ticks, Velocity};

use crate::bytes::Bytes;

/// Orders of a sequence at most.
const ORDERS: usize = 12;

/// A position that is rounded anew may differ by so much of a step, × 2⁻³²; and, where a ramp has lasted for hours, by 2⁻¹⁶ of its ticks.
const ROUNDED: u64 = 1 << 16;
const ROUNDED_OF_HOURS: u32 = 16;

/// The fastest there is: half a step in a tick, × 2⁵⁶.
const FASTEST: u64 = 1 << 55;

/// A sin² ramp is made of cubic pieces, whose ends are rounded: by so much of the fastest in a ramp of a month.
const ROUNDED_VELOCITY: u64 = FASTEST >> 32;

/// A sixth of the jerk is rounded to 2⁻¹²⁸ steps/tick³: what 3 · j/6 · t² makes of half of that in so many ticks, × 2⁻⁵⁶.
fn rounded_jerk(ticks: Ticks) -> u64 {
    let ticks = u128::from(ticks) >> 32;
    u64::try_from((3 * ticks * ticks) >> (73 - 64)).unwrap_or(u64::MAX)
}

/// Time ends in 64 bits, 584 years after the start at 1 GHz: two years before that no more orders are tried.
const LAST_ORDER: Ticks = Ticks::MAX - (1 << 56);

/// The slowest clock that is tried.
const SLOWEST: u32 = 1_000_000;

/// Plays the orders that these bytes say.
///
/// # Panics
/// If a plan breaks a rule.
pub fn check(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let hz = [84_000_000, 168_000_000, 1_000_000_000, SLOWEST][usize::from(bytes.byte() % 4)];
    let clock = Clock::new(hz).expect("a clock that motion can use");
    let from = State {
        position: Position::from_bits(bytes.number(64) as i64),
        velocity: Velocity::from_bits(bytes.signed(55)),
    };
    let mut at = bytes.number(48);
    let mut plan: Option<Plan> = None;
    for _ in 0..ORDERS {
        if bytes.is_empty() {
            break;
        }
        let (goal, limits) = (bytes.goal(), bytes.limits());
        // No jerk that a slow clock can tell leaves the hardest ramps before they are far too fast.
        let ramps = match bytes.ramps() {
            ramps @ (Ramps::Linear | Ramps::MovingAverage(_)) => ramps,
            _ if hz == SLOWEST => Ramps::Linear,
            ramps => ramps,
        };
        let before = plan.as_ref().map_or(from, |plan| plan.state_at(at));
        let next = match plan {
            None => Plan::new(clock, at, from, goal, limits, ramps),
            Some(ref old) => {
                let mut plan = old.clone();
                plan.replan(clock, at, goal, limits, ramps).map(|()| plan)
            }
        };
        let Ok(next) = next else {
            continue;
        };
        let now = next.state_at(at);
        let jump = now.position.bits().wrapping_sub(before.position.bits());
        let order = format!("{goal:?}, {limits:?}, {ramps:?} from {before:?} at {at}, {hz} Hz");
        let hours = (at - plan.map_or(at, |plan| plan.start())) >> ROUNDED_OF_HOURS;
        assert!(
            jump.unsigned_abs() < ROUNDED + hours,
            "jumps by {jump}: {order}"
        );
        ends(&next, goal);
        let limit = Velocity::from_speed(clock, limits.velocity.signed(false));
        let is_linear = matches!(ramps, Ramps::Linear | Ramps::MovingAverage(_));
        let top = match is_linear {
            true => {
                before
                    .velocity
                    .bits()
                    .abs()
                    .max(limit.bits())
                    .unsigned_abs()
                    + 2
            }
            false => FASTEST
                .saturating_add(ROUNDED_VELOCITY)
                .saturating_add(rounded_jerk(last(&next, at, clock) - at)),
        };
        let ticks = all_over(&next, at, clock);
        for t in &ticks {
            let velocity = next.state_at(*t).velocity.bits().unsigned_abs();
            assert!(velocity <= top, "{velocity} of {top} at {t}: {order}");
        }
        if is_linear {
            holds_acceleration(&next, &ticks, clock, limits);
        }
        let later = match bytes.byte() % 4 {
            0 => 0,
            1 => bytes.number(40),
            _ => part_of(last(&next, at, clock) - at, bytes.word()),
        };
        at = match at.checked_add(later) {
            Some(at) if at < LAST_ORDER => at,
            _ => return,
        };
        plan = Some(next);
    }
}

/// It comes to where it was asked for, and stays there.
fn ends(plan: &Plan, goal: Goal) {
    let last = plan.state_at(Ticks::MAX);
    match goal {
        Goal::Rest(target) => {
            let there = State {
                position: Position::from_steps(target),
                velocity: Velocity::ZERO,
            };
            let end = plan.end().expect("a move ends");
            assert_eq!((plan.state_at(end), last), (there, there), "{goal:?}");
        }
        Goal::Velocity(velocity) if velocity.bits() == 0 => {
            assert!(plan.end().is_some(), "a stop ends");
            assert_eq!(last.velocity, Velocity::ZERO);
        }
        Goal::Pass(..) | Goal::Velocity(_) => {}
    }
}

/// The velocity changes by no more than the limits allow.
fn holds_acceleration(plan: &Plan, ticks: &[Ticks], clock: Clock, limits: Limits) {
    let hardest = limits.acceleration.max(limits.deceleration);
    let rate = f64::from(clock.hz());
    for pair in ticks.windows(2) {
        let [v, w] = [pair[0], pair[1]].map(|t| plan.state_at(t).velocity.bits());
        let most = f64::from(hardest) / rate / rate * (pair[1] - pair[0]) as f64;
        let most = most * 2_f64.powi(56) * (1.0 + 1e-9) + 4.0;
        let change = w.abs_diff(v) as f64;
        assert!(change <= most, "{change} of {most} at {pair:?}");
    }
}

/// The end of a plan, or a second behind its last corner.
fn last(plan: &Plan, at: Ticks, clock: Clock) -> Ticks {
    let corner = plan.phases().last().map_or(at, |phase| phase.start());
    let last = plan
        .end()
        .unwrap_or(corner.saturating_add(clock.hz().into()));
    last.max(at)
}

/// Ticks all over a plan, its corners among them. A plan that is not done when time ends, in 64 bits, stands from then on: that is not looked at.
fn all_over(plan: &Plan, at: Ticks, clock: Clock) -> Vec<Ticks> {
    let length = last(plan, at, clock) - at;
    let even = (0..=32).map(|n| at + part_of(length, n << 11));
    let corners = plan.phases().flat_map(|phase| {
        let corner = phase.start();
        [corner.saturating_sub(1), corner, corner.saturating_add(1)]
    });
    let mut ticks: Vec<_> = even
        .chain(corners.filter(|t| *t >= at))
        .filter(|t| *t < Ticks::MAX - 1)
        .collect();
    ticks.sort_unstable();
    ticks
}

fn part_of(length: Ticks, part: u16) -> Ticks {
    ((u128::from(length) * u128::from(part)) >> 16) as Ticks
}
