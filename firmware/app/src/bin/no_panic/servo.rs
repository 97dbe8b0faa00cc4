//! Everything `servo` offers, with any numbers.

use ::servo::cascade::{Actual, Demand, Gains, Limits};
use ::servo::control::{Control, ControlConfig, Goal, Order};
use ::servo::current_loop::{CurrentConfig, Sample};
use ::servo::feedback::commutation::Step;
use ::servo::feedback::{absolute, hall, Absolute, Commutation, Incremental, Observer};
use ::servo::filter::Filter;
use ::servo::interrupt::Counts;
use ::servo::modulation::Modulation;
use ::servo::offsets::CurrentSense;
use ::servo::protection::{Blocked, Bus, Derating, PhaseLoss, Thermal};
use ::servo::stepper::{self, Beyond, Stepper, StepperConfig, StepperDemand};
use ::servo::transform::Rotor;
use ::servo::tuning::{self, Chirp, Setup, Tuning};
use ::servo::{Angle, Cascade, CurrentInterrupt, CurrentLoop, Implausible, Motor, Wiring};

use super::{any, any_u64, look};

pub fn number() -> f32 {
    f32::from_bits(any())
}

fn numbers() -> [f32; 3] {
    [number(), number(), number()]
}

fn rotor() -> Rotor {
    Rotor {
        d: number(),
        q: number(),
    }
}

pub fn angle() -> Angle {
    Angle::from_turns(number()).plus(Angle::from_bits(any()))
}

fn show(number: f32) {
    look(number.to_bits());
}

fn width(width: i16) {
    look(width as u32);
}

pub fn motor() -> Result<Motor, Implausible> {
    let motor = Motor {
        wiring: if any() == 0 {
            Wiring::TwoPhase
        } else {
            Wiring::ThreePhase
        },
        pole_pairs: any() as u16,
        resistance: number(),
        inductance_d: number(),
        inductance_q: number(),
        flux: number(),
        rated_current: number(),
        peak_current: number(),
        inertia: number(),
        counts: any(),
    };
    motor.check()?;
    Ok(motor)
}

/// Sets a servo up and lets it run.
#[inline(never)]
pub fn servo() -> Result<(), Implausible> {
    let motor = motor()?;
    let modulation = Modulation::new(motor.wiring, number(), number(), number())?;
    let config = CurrentConfig {
        period: number(),
        share: number(),
        learning: number(),
        max_current: number(),
        trip: number(),
        bus: (number(), number()),
        weakening: number(),
    };
    let mut current = CurrentLoop::new(&motor, config, modulation)?;
    let mut sense = CurrentSense::new(number(), any() as u16, any() as u16)?;
    let mut encoder = Incremental::new(&motor, any() as u16, any());
    let mut absolute = Absolute::new(&motor, any() as u8, angle())?.with_table(&absolute::NO_ERROR);
    let mut observer = Observer::new(number(), number())?;
    let mut interrupt = CurrentInterrupt::new(sense, encoder, observer, current, number())?;
    while any() != 0 {
        match any() {
            0 => current.start(),
            16 => current.weakening.limit(number()),
            1 => look(sense.learn([any() as u16, any() as u16, any() as u16]) as u32),
            2 => sense.restart(),
            3 => look(encoder.index(any() as u16).is_ok().into()),
            4 => encoder.set_angle(angle()),
            5 => look(absolute.look(any()).is_ok().into()),
            6 => absolute.set_angle(angle()),
            7 => observer.stand_at(angle()),
            8 => observer.shift(angle()),
            10 => interrupt.order(rotor(), any() as u16),
            11 => {
                let counts = Counts {
                    currents: [any() as u16, any() as u16, any() as u16],
                    bus: any() as u16,
                    timer: any() as u16,
                };
                let widths = interrupt.run(&counts);
                widths.into_iter().flatten().for_each(width);
            }
            12 => above(&motor)?,
            13 => field(&motor)?,
            14 => ordered(&motor, &mut interrupt)?,
            15 => tuned(motor.wiring, modulation)?,
            9 => look(hall::angle(any() as u8).map_or(0, Angle::bits)),
            _ => {
                encoder.look(any() as u16);
                observer.look(if any() == 0 {
                    encoder.angle()
                } else {
                    absolute.angle()
                });
                let sample = Sample {
                    currents: if any() == 0 {
                        numbers()
                    } else {
                        sense.amperes([any() as u16, any() as u16, any() as u16])
                    },
                    bus: number(),
                    angle: observer.angle(),
                    turn: if any() == 0 {
                        current.turned_in_period(number())
                    } else {
                        observer.turn()
                    },
                };
                match current.run(&sample, rotor()) {
                    Ok(widths) => widths.into_iter().for_each(width),
                    Err(trip) => look(trip as u32),
                }
            }
        }
        show(observer.acceleration() + current.current().q + current.demand().d);
        show(current.voltage().square() + motor.rated_torque());
        look((any_u64() as i64 ^ encoder.position() ^ absolute.position()) as u32);
        look(encoder.index_position().unwrap_or(0) as u32);
    }
    Ok(())
}

fn gains() -> Gains {
    Gains {
        position: number(),
        velocity: number(),
        integral: number(),
    }
}

/// The measurement of a motor.
#[inline(never)]
fn tuned(wiring: Wiring, modulation: Modulation) -> Result<(), Implausible> {
    let mut tuning = Tuning::new(Setup {
        wiring,
        counts: any(),
        period: number(),
        current: number(),
        trip: number(),
        bus: (number(), number()),
        modulation,
        distance: number(),
        max_speed: number(),
    })?;
    let frequencies = (number(), number());
    let mut chirp = Chirp::new(number(), frequencies, number(), number())?;
    while any() != 0 {
        let seen = tuning::Seen {
            currents: numbers(),
            bus: number(),
            timer: any() as u16,
        };
        match tuning.run(&seen) {
            tuning::Step::Widths(widths) => widths.map(width),
            tuning::Step::Done(found) => [found.resistance, found.flux, found.inertia].map(show),
            tuning::Step::Failed(failure) => {
                [f32::from(u8::from(failure == tuning::Failure::Held)); 3].map(show)
            }
        };
        look(tuning.stage().into());
        show(chirp.run().unwrap_or(0.0));
    }
    Ok(())
}

/// The loops above the current, and what protects.
#[inline(never)]
fn above(motor: &Motor) -> Result<(), Implausible> {
    let low_pass = Filter::low_pass(number(), number(), number())?;
    let notch = Filter::notch(number(), number(), number())?;
    let mut cascade = Cascade::new(motor, gains(), number(), number())?;
    cascade.set_filters(low_pass, notch, number());
    let mut commutation = Commutation::new(motor, number(), number())?;
    let mut thermal = Thermal::new(number(), number(), number(), number())?;
    let mut bus = Bus::new(number(), number(), number())?;
    let derating = Derating::new(number(), number())?;
    let mut blocked = Blocked::new(number(), number(), number())?;
    let mut loss = PhaseLoss::new(motor.wiring, number(), number(), number())?;
    while any() != 0 {
        let demand = Demand {
            position: (any() == 0).then(|| any_u64() as i64),
            part: number(),
            velocity: number(),
            acceleration: number(),
            current: number(),
        };
        let actual = Actual {
            position: any_u64() as i64,
            velocity: number(),
        };
        let limits = Limits {
            positive: number(),
            negative: number(),
        };
        match any() {
            0 => cascade.set_gains(gains())?,
            1 => cascade.take_over(number(), &demand, actual),
            2 => show(cascade.run(&demand, actual, limits)),
            3 => match commutation.run(any_u64() as i64, number()) {
                Step::Hold { angle, current } => {
                    look(angle.bits());
                    show(current);
                }
                Step::Found(angle) => look(angle.bits()),
                Step::Failed => look(1),
            },
            4 => show(thermal.run(number()) + thermal.share()),
            5 => look(bus.run(number()).into()),
            8 => show(bus.chopping(number())),
            6 => show(bus.braking(number()) + derating.share(number())),
            7 => look(blocked.run(any() == 0, number()).into()),
            _ => look(loss.run(numbers(), numbers()).unwrap_or(9) as u32),
        }
        look(cascade.is_limited().into());
    }
    Ok(())
}

/// The control of a drive, above an interrupt.
#[inline(never)]
fn ordered(motor: &Motor, interrupt: &mut CurrentInterrupt) -> Result<(), Implausible> {
    let config = ControlConfig {
        period: number(),
        gains: Gains::from_bandwidth(number()),
        friction: number(),
        peak_time: number(),
        stage: (number(), number()),
        bus: Bus::new(number(), number(), number())?,
        derating: Derating::new(number(), number())?,
        blocked: (number(), number()),
        max_speed: number(),
    };
    let mut control = Control::new(motor, config)?;
    while any() != 0 {
        if any() == 0 {
            control.start();
        }
        if any() == 0 {
            control.set_blocked((number(), number()))?;
            control.set_stepper((any() == 0).then(stepper_config))?;
        }
        if any() == 0 {
            let low_pass = Filter::first_low_pass(number(), number())?;
            control.set_filters(low_pass, Filter::notch(number(), number(), number())?);
        }
        let goal = if any() == 0 {
            Goal::Torque
        } else {
            Goal::Position {
                counts: any_u64() as i64,
                part: any(),
                velocity: number(),
                acceleration: number(),
            }
        };
        let order = Order {
            goal,
            torque: number(),
            velocity_ahead: number(),
            max_torque: (number(), number()),
            max_current: number(),
            speed: number(),
        };
        control.order(order, number());
        let seen = interrupt.snapshot(&Counts {
            currents: [any() as u16, any() as u16, any() as u16],
            bus: any() as u16,
            timer: 0,
        });
        look(control.chops(seen.bus).into());
        match control.run(&seen, number()) {
            Ok(current) => match control.field() {
                Some((from, speed)) => interrupt.order_field(current, from, speed),
                None => interrupt.order(current, any() as u16),
            },
            Err(fault) => look(fault as u32),
        }
        let report = control.report(&seen);
        show(report.torque + report.current + report.velocity + report.demand + report.lead);
        look((report.is_limited | report.is_hot).into());
    }
    Ok(())
}

fn stepper_config() -> StepperConfig {
    StepperConfig {
        beyond: match any() {
            0 => Beyond::Reported,
            1 => Beyond::MadeUpAtRest,
            _ => Beyond::MadeUpAtOnce,
        },
        bound: number(),
        speed: number(),
        max_speed: number(),
        current: number(),
        at_rest: number(),
        fall: number(),
    }
}

/// A stepper in closed loop.
#[inline(never)]
fn field(motor: &Motor) -> Result<(), Implausible> {
    let mut stepper = Stepper::new(motor, stepper_config(), number())?;
    while any() != 0 {
        if any() == 0 {
            stepper.reset();
        }
        let demand = StepperDemand {
            position: any_u64() as i64,
            speed: number(),
            is_at_rest: any() == 0,
        };
        let rotor = stepper::Rotor {
            position: any_u64() as i64,
            angle: angle(),
            speed: number(),
        };
        if any() == 0 {
            stepper.take_over(number(), &demand, &rotor);
        }
        let field = stepper.run(&demand, &rotor, number());
        look(stepper.is_held_back().into());
        show(stepper.lead());
        look(field.angle.bits() ^ stepper.behind() as u32 ^ u32::from(field.is_beyond));
        show(field.current + field.lead + field.seen_from(angle()).q);
    }
    Ok(())
}
