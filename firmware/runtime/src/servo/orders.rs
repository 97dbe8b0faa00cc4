//! Orders of the axis as the loops take them, and what these tell as the axis reads it: counts, µN·m and mA on one side, floats on the other.

use cia402::{ServoGoal, ServoOrder, ServoReport};
use motion::SignedSpeed;
use servo::Motor;
use servo::control::{Fault, Goal, Order, Report};

/// 2³²: of a speed in counts/s.
const BITS: f32 = 4_294_967_296.0;

/// In counts/s, by halves: what goes from 64 bits into a float at once is a call.
fn speed(bits: i64) -> f32 {
    (bits >> 32) as i32 as f32 + part(bits as u32)
}

/// Behind the point.
fn part(bits: u32) -> f32 {
    bits as f32 * (1.0 / BITS)
}

/// Thousandths.
fn share(thousandths: u16) -> f32 {
    f32::from(thousandths) * 1e-3
}

/// The nearest whole number of a value by so many.
fn whole(value: f32, by: f32) -> i32 {
    let value = value * by;
    (value + if value < 0.0 { -0.5 } else { 0.5 }) as i32
}

/// An order of the axis, whose positions count from `origin` on. A motor that is let go is held at `held`, if that is somewhere. Of the velocity and the
/// acceleration so many thousandths go ahead of the loops.
pub(super) fn order(
    order: &ServoOrder,
    motor: &Motor,
    origin: i64,
    held: Option<i64>,
    ahead: (u16, u16),
) -> Order {
    let torque = |micro: u32| micro as f32 * 1e-6;
    let by_current = order.current as f32 * 1e-3 * motor.torque_constant();
    let max = |micro: u32| torque(micro).min(by_current);
    let goal = match (order.goal, held) {
        (ServoGoal::Free, Some(counts)) => Goal::Position {
            counts,
            part: 1 << 31,
            velocity: 0.0,
            acceleration: 0.0,
        },
        (ServoGoal::Torque | ServoGoal::Free, _) => Goal::Torque,
        (
            ServoGoal::Position {
                counts,
                part,
                velocity,
                acceleration,
            },
            _,
        ) => Goal::Position {
            counts: counts.wrapping_add(origin),
            part,
            velocity: speed(velocity.bits()),
            acceleration: acceleration as f32 * share(ahead.1),
        },
    };
    let less = match goal {
        Goal::Position { velocity, .. } => velocity * (share(ahead.0) - 1.0),
        Goal::Torque => 0.0,
    };
    Order {
        goal,
        torque: order.torque as f32 * 1e-6,
        velocity_ahead: speed(order.velocity_ahead.bits()) + less,
        max_torque: (max(order.max_torque.0), max(order.max_torque.1)),
        max_current: order.current as f32 * 1e-3,
        speed: (order.velocity.bits() >> 32) as u32 as f32 + part(order.velocity.bits() as u32),
    }
}

/// What has become of the orders, with the encoder at `counts`.
pub(super) fn report(report: &Report, counts: i64, wants_free: bool) -> ServoReport {
    ServoReport {
        counts,
        velocity: SignedSpeed::from_bits((report.velocity * BITS) as i64),
        demand: whole(report.demand, 1e6),
        torque: whole(report.torque, 1e6),
        current: whole(report.current, 1e3),
        is_limited: report.is_limited,
        wants_free,
    }
}

/// A fault as an error code of CiA 402.
pub fn error_code(fault: Fault) -> u16 {
    match fault {
        Fault::OverCurrent => 0x2310,
        Fault::Short => 0x2320,
        Fault::UnderVoltage => 0x3220,
        Fault::OverVoltage => 0x3210,
        Fault::Temperature => 0x4310,
        Fault::Blocked => 0x7121,
        Fault::PhaseLost => 0x7122,
        Fault::CurrentSensor => 0x7300,
        Fault::Encoder => 0x7305,
        Fault::OverSpeed => 0x7310,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::Speed;

    const MOTOR: Motor = crate::servo::tests::DATA.motor;

    #[test]
    fn an_order_counts_from_the_origin_and_its_current_limits_the_torque() {
        let given = ServoOrder {
            goal: ServoGoal::Position {
                counts: -7,
                part: 1 << 30,
                velocity: SignedSpeed::from_bits(-3 << 32),
                acceleration: 250,
            },
            torque: -120_000,
            velocity_ahead: SignedSpeed::ZERO,
            max_torque: (50_000, u32::MAX),
            current: 2_000,
            velocity: Speed::MAX,
        };
        let taken = order(&given, &MOTOR, 100, Some(5), (1_000, 1_000));
        let goal = Goal::Position {
            counts: 93,
            part: 1 << 30,
            velocity: -3.0,
            acceleration: 250.0,
        };
        assert_eq!((taken.goal, taken.torque), (goal, -0.12));
        assert_eq!(taken.max_torque, (0.05, 2.0 * MOTOR.torque_constant()));
        let free = ServoOrder {
            goal: ServoGoal::Free,
            ..given
        };
        assert_eq!(
            order(&free, &MOTOR, 0, None, (1_000, 1_000)).goal,
            Goal::Torque
        );
        let held = order(&free, &MOTOR, 0, Some(5), (1_000, 1_000)).goal;
        assert!(matches!(held, Goal::Position { counts: 5, .. }));
    }

    #[test]
    fn a_report_is_rounded_to_the_nearest() {
        let told = Report {
            demand: -0.000_001_6,
            torque: 0.25,
            current: -0.000_4,
            velocity: -1.5,
            is_limited: true,
            is_hot: false,
            lead: 0.0,
        };
        let read = report(&told, 9, false);
        assert_eq!((read.demand, read.torque, read.current), (-2, 250_000, 0));
        assert_eq!(read.velocity.bits(), -3 << 31);
        assert!(read.is_limited && read.counts == 9);
    }
}
