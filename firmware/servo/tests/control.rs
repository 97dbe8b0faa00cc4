//! The control above the current interrupt, whatever it is told: limits of current and torque hold, and what it tells are numbers.

mod rig;

use proptest::prelude::*;
use rig::{HALF, PERIOD, modulation, motor, turned};
use servo::cascade::Gains;
use servo::control::{ControlConfig, Goal, Order};
use servo::current_loop::CurrentConfig;
use servo::feedback::{Incremental, Observer};
use servo::filter::Filter;
use servo::interrupt::{Counts, Snapshot};
use servo::modulation::{Widths, shares};
use servo::offsets::CurrentSense;
use servo::protection::{Bus, Derating};
use servo::stepper::{Beyond, StepperConfig};
use servo::{Control, CurrentInterrupt, CurrentLoop, Motor};
use servo_plant::axes::{NEMA17, SERVO_100W};
use servo_plant::data::PlantData;
use servo_plant::{Gates, Plant};

/// Periods of the current loop in one of the control.
const PERIODS: u32 = 5;

/// A control period in s: 4 kHz.
const CONTROL: f32 = PERIODS as f32 * PERIOD;

/// The count of the converter without a current.
const MIDDLE: u16 = 32_768;

/// Volts of a count of the bus.
const BUS: f32 = 0.025;

/// The interrupt and the control of an axis.
struct Servo {
    motor: Motor,
    /// Amperes of a count.
    scale: f32,
    interrupt: CurrentInterrupt,
    control: Control,
}

impl Servo {
    fn new(data: &PlantData, rated: f32, peak: f32, weakening: f32) -> Self {
        let motor = motor(data, rated, peak);
        let volts = data.supply.voltage as f32;
        let scale = 2.5 * peak / f32::from(MIDDLE);
        let bounds = (0.6 * volts, 1.25 * volts);
        let config = CurrentConfig {
            weakening,
            ..CurrentConfig::quick(&motor, PERIOD, 2.0 * peak, bounds)
        };
        let current = CurrentLoop::new(&motor, config, modulation(data, motor.wiring)).unwrap();
        let config = ControlConfig {
            period: CONTROL,
            gains: Gains::from_bandwidth(600.0),
            friction: 0.0,
            peak_time: 2.0,
            stage: (peak, 2.0),
            bus: Bus::new(1.03 * volts, 1.05 * volts, 1.2 * volts).unwrap(),
            derating: Derating::new(80.0, 100.0).unwrap(),
            blocked: (0.0, 0.0),
            max_speed: 400.0,
        };
        let interrupt = CurrentInterrupt::new(
            CurrentSense::new(scale, MIDDLE, 100).unwrap(),
            Incremental::new(&motor, 0, 2),
            Observer::new(3_000.0, PERIOD).unwrap(),
            current,
            BUS,
        );
        Self {
            motor,
            scale,
            interrupt: interrupt.unwrap(),
            control: Control::new(&motor, config).unwrap(),
        }
    }

    /// A period of the current loop, and behind it one of the control, that sees this voltage of the bus, temperature and sum of the currents.
    fn period(&mut self, counts: &Counts, seen: Option<(f32, f32, f32)>) -> Option<Widths> {
        let widths = self.interrupt.run(counts);
        if let Err(trip) = widths {
            self.control.fail(trip.into());
        }
        if let Some((bus, temperature, sum)) = seen
            && let Ok(current) = self.control.run(
                &Snapshot {
                    bus,
                    sum,
                    ..self.interrupt.snapshot(counts)
                },
                temperature,
            )
        {
            let most = self.control.weakening();
            self.interrupt.current.weakening.limit(most);
            match self.control.field() {
                Some((from, speed)) => self.interrupt.order_field(current, from, speed),
                None => self.interrupt.order(current, 0),
            }
        }
        widths.ok().filter(|_| self.control.fault().is_none())
    }

    fn start(&mut self) {
        self.interrupt.current.start();
        self.control.start();
    }
}

/// A stepper and a servo motor, each with its rated and peak current in A.
const AXES: [(PlantData, f32, f32); 2] = [(NEMA17, 1.7, 2.4), (SERVO_100W, 4.0, 12.0)];

fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<u32>().prop_map(f32::from_bits),
        -100.0..100.0_f32,
        Just(f32::NAN)
    ]
}

prop_compose! {
    fn any_goal()(
        is_position: bool,
        counts: i64,
        part: u32,
        velocity in any_number(),
        acceleration in any_number(),
    ) -> Goal {
        if is_position {
            Goal::Position { counts, part, velocity, acceleration }
        } else {
            Goal::Torque
        }
    }
}

prop_compose! {
    fn any_order()(
        goal in any_goal(),
        torque in any_number(),
        velocity_ahead in any_number(),
        max_torque in (any_number(), any_number()),
        max_current in any_number(),
        speed in any_number(),
    ) -> Order {
        Order { goal, torque, velocity_ahead, max_torque, max_current, speed }
    }
}

fn stepper([bound, speed, current, at_rest]: [f32; 4], beyond: u8) -> StepperConfig {
    StepperConfig {
        beyond: match beyond {
            0 => Beyond::Reported,
            1 => Beyond::MadeUpAtRest,
            2 => Beyond::MadeUpAtOnce,
            _ => Beyond::Kept,
        },
        bound,
        speed,
        max_speed: 4_000.0,
        current,
        at_rest,
        fall: 0.05,
    }
}

/// Counts of the converter: mostly what a motor has, so that the loops run on, sometimes anything.
fn any_counts() -> impl Strategy<Value = Counts> {
    let near = (MIDDLE - 4_000)..(MIDDLE + 4_000);
    let current = prop_oneof![20 => near, 1 => any::<u16>()];
    (
        prop::array::uniform3(current),
        prop_oneof![20 => 1_000..1_200_u16, 1 => any::<u16>()],
        prop_oneof![9 => 0..20_u16, 1 => any::<u16>()],
    )
        .prop_map(|(currents, bus, timer)| Counts {
            currents,
            bus,
            timer,
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Any order, any setting, anything that is seen: what is asked of the motor is a number within the limits, and so is what is told of it.
    #[test]
    fn no_number_gets_through_the_control(
        axis in 0..2_usize,
        weakening in 0.0..=1.0_f32,
        settings in (prop::array::uniform3(any_number()), prop::array::uniform4(any_number()), (any_number(), any_number())),
        lead in (any::<bool>(), [1.1..1.7_f32, 1.0..4_000.0_f32, 0.01..2.4_f32, 0.05..1.0_f32], 0..4_u8),
        runs in prop::collection::vec((any_order(), any_number(), any_counts(), any_number(), any_number(), any_number()), 1..60),
    ) {
        let (data, rated, peak) = AXES[axis];
        let mut servo = Servo::new(&data, rated, peak, weakening * peak);
        let (motor, constant) = (servo.motor, servo.motor.torque_constant());
        let ([position, velocity, integral], filters, blocked) = settings;
        // What cannot be is refused, and what was before stays.
        let _ = servo.control.set_gains(Gains { position, velocity, integral });
        let _ = servo.control.set_blocked(blocked);
        let [a, b, c, d] = filters;
        let low_pass = Filter::low_pass(a, b, CONTROL).unwrap_or(Filter::NONE);
        let notch = Filter::notch(c, d, CONTROL).unwrap_or(Filter::NONE);
        servo.control.set_filters(low_pass, notch);
        let (is_stepper, numbers, beyond) = lead;
        if is_stepper {
            servo.control.set_stepper(Some(stepper(numbers, beyond))).unwrap();
        }
        servo.start();
        for (order, since, counts, bus, temperature, sum) in runs {
            servo.control.order(order, since);
            let bus = if bus.is_nan() { data.supply.voltage as f32 } else { bus };
            let temperature = if temperature.is_nan() { 25.0 } else { temperature };
            let sum = if sum.is_nan() { 0.0 } else { sum };
            let widths = servo.period(&counts, Some((bus, temperature, sum)));
            for width in widths.into_iter().flatten() {
                prop_assert!(width.unsigned_abs() <= 31_458, "{}", width);
            }
            // The order of this period is asked for in the next.
            servo.period(&counts, None);
            let asked = servo.interrupt.current.demand();
            prop_assert!(asked.d.hypot(asked.q) <= peak * 1.000_01, "{:?}", asked);
            let weakened = servo.interrupt.current.weakening.current();
            prop_assert!(weakened <= 0.900_01 * order.max_current.max(0.0).min(peak) || servo.control.fault().is_some(), "{}", weakened);
            let (positive, negative) = order.max_torque;
            if servo.control.fault().is_none() && servo.control.field().is_none() {
                prop_assert!(asked.q <= positive.max(0.0) / constant * 1.000_01, "{:?} {:?}", asked, order);
                prop_assert!(asked.q >= -negative.max(0.0) / constant * 1.000_01, "{:?} {:?}", asked, order);
            }
            let told = servo.control.report(&servo.interrupt.snapshot(&counts));
            for number in [told.demand, told.torque, told.current, told.velocity, told.lead, servo.control.heat()] {
                prop_assert!(number.is_finite(), "{:?}", told);
            }
            prop_assert!(told.lead.abs() <= 1.71 || beyond == 0 && is_stepper, "{:?}", told);
            prop_assert!(told.demand.abs() <= peak * motor.torque_constant() * 1.000_01, "{:?}", told);
            if servo.control.fault().is_some() {
                servo.start();
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// A motor of the plant under any gains that are taken, and any orders: its true current stays at its peak, and its torque at the limits that are ordered.
    #[test]
    fn no_gains_and_no_orders_take_the_motor_beyond_its_limits(
        axis in 0..2_usize,
        gains in prop::array::uniform3(0.0..1e4_f32),
        lead in (any::<bool>(), [1.1..1.7_f32, 1.0..4_000.0_f32, 0.1..2.4_f32, 0.05..1.0_f32], 1..3_u8),
        orders in prop::collection::vec((any::<bool>(), -20_000..20_000_i64, -1e5..1e5_f32, -1e7..1e7_f32, -3.0..3.0_f32, (0.0..2.0_f32, 0.0..2.0_f32)), 6),
        load in -0.5..0.5_f64,
        heavier in 1.0..200.0_f64,
    ) {
        let (mut data, rated, peak) = AXES[axis];
        data.load.inertia *= heavier;
        let mut servo = Servo::new(&data, rated, peak, 0.0);
        let [position, velocity, integral] = gains;
        servo.control.set_gains(Gains { position, velocity, integral }).unwrap();
        let (is_stepper, numbers, beyond) = lead;
        if is_stepper && axis == 0 {
            servo.control.set_stepper(Some(stepper(numbers, beyond))).unwrap();
        }
        let mut plant = Plant::new(data, 1);
        servo.interrupt.encoder.set_angle(turned(0.0));
        servo.interrupt.observer.stand_at(turned(0.0));
        servo.start();
        let rated_torque = servo.motor.rated_torque();
        plant.load_torque = load * f64::from(rated_torque);
        for (is_position, counts, velocity, acceleration, torque, max_torque) in orders {
            let goal = if is_position {
                Goal::Position { counts, part: 0, velocity, acceleration }
            } else {
                Goal::Torque
            };
            let order = Order {
                goal,
                torque: torque * rated_torque,
                velocity_ahead: 0.0,
                max_torque: (max_torque.0 * rated_torque, max_torque.1 * rated_torque),
                max_current: f32::MAX,
                speed: f32::INFINITY,
            };
            servo.control.order(order, 0.0);
            for period in 0..100 * PERIODS {
                let readings = plant.measure();
                let count = |amperes: f64| ((amperes / f64::from(servo.scale)).round() + f64::from(MIDDLE)) as u16;
                let read = Counts {
                    currents: readings.currents.map(count),
                    bus: (readings.bus_voltage / f64::from(BUS)).round() as u16,
                    timer: readings.count as u16,
                };
                plant.chopper = servo.control.chops(readings.bus_voltage as f32);
                let seen = (readings.bus_voltage as f32, 25.0, 0.0);
                let widths = servo.period(&read, (period % PERIODS == 0).then_some(seen));
                plant.run(HALF);
                plant.gates = match widths {
                    Some(widths) => Gates::On(shares(servo.motor.wiring, widths).map(f64::from)),
                    None => Gates::Off,
                };
                plant.run(HALF);
                // Where the magnet has more than the bus nothing holds the current.
                let magnet = plant.velocity() * f64::from(servo.motor.flux) * f64::from(servo.motor.pole_pairs);
                if magnet.abs() > 0.8 * f64::from(modulation(&data, servo.motor.wiring).max_voltage(plant.bus_voltage() as f32)) {
                    return Ok(());
                }
                let [d, q] = plant.current();
                let size = d.hypot(q) / f64::from(peak);
                prop_assert!(size <= 1.1, "{} of the peak, fault {:?}", size, servo.control.fault());
                // Beyond it by what the loop takes on its way from one to the other.
                let limits = [max_torque.0, max_torque.1].map(|limit| f64::from(limit * rated));
                let over = (q - limits[0]).max(-q - limits[1]) / f64::from(peak);
                if period > 20 && widths.is_some() {
                    prop_assert!(over <= 0.1, "{} of the peak beyond {:?}", over, limits);
                }
            }
            if servo.control.fault().is_some() {
                // Over-speed and the like: then no current flows.
                let [d, q] = plant.current();
                prop_assert!(d.hypot(q) < 0.05 * f64::from(peak), "{} {}", d, q);
                break;
            }
        }
    }
}
