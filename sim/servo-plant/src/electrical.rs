//! The windings, solved exactly in each step.
//!
//! A voltage that stands still beside the stator turns backwards in the frame of the rotor: dvd/dt = ωe vq, dvq/dt = −ωe vd. With it as
//! two more states the equations of the windings are linear, `dx/dt = A x + b` with x = (id, iq, vd, vq) and b the voltage of the magnet, as
//! long as the speed is constant. Their solution is the series of the matrix exponential, applied to the state term by term until nothing is added.

use crate::data::{MotorData, Phases};

const SQRT3: f64 = 1.732_050_807_568_877_2;

/// Where a rotor looks from beside the stator: sine and cosine of its electrical angle.
#[derive(Clone, Copy, Debug)]
pub struct Facing {
    sine: f64,
    cosine: f64,
}

impl Facing {
    /// At this electrical angle, in rad.
    pub fn at(angle: f64) -> Self {
        let (sine, cosine) = libm::sincos(angle);
        Self { sine, cosine }
    }

    /// A vector beside the stator in the frame of the rotor.
    pub fn to_rotor(self, [alpha, beta]: [f64; 2]) -> [f64; 2] {
        let Self { sine, cosine } = self;
        [alpha * cosine + beta * sine, beta * cosine - alpha * sine]
    }

    /// A vector in the frame of the rotor beside the stator.
    pub fn to_stator(self, [d, q]: [f64; 2]) -> [f64; 2] {
        let Self { sine, cosine } = self;
        [d * cosine - q * sine, d * sine + q * cosine]
    }
}

/// What a vector beside the stator is in the phases. Those of three add up to 0; of two, the third is 0.
pub fn to_phases(phases: Phases, [alpha, beta]: [f64; 2]) -> [f64; 3] {
    match phases {
        Phases::Two => [alpha, beta, 0.0],
        Phases::Three => {
            let across = SQRT3 / 2.0 * beta;
            [alpha, across - alpha / 2.0, -across - alpha / 2.0]
        }
    }
}

/// The vector of phases, with the amplitude of a phase.
pub fn of_phases(phases: Phases, [a, b, c]: [f64; 3]) -> [f64; 2] {
    match phases {
        Phases::Two => [a, b],
        Phases::Three => [(2.0 * a - b - c) / 3.0, (b - c) / SQRT3],
    }
}

/// The direction in which a phase lies beside the stator.
fn direction(phases: Phases, phase: usize) -> [f64; 2] {
    let mut unit = [0.0; 3];
    if let Some(one) = unit.get_mut(phase) {
        *one = 1.0;
    }
    match (phases, of_phases(phases, unit)) {
        (Phases::Two, vector) => vector,
        (Phases::Three, [alpha, beta]) => [alpha * 1.5, beta * 1.5],
    }
}

/// What a step has done with energy, in J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Work {
    /// Taken from the terminals.
    pub(crate) input: f64,
    /// Become heat in the windings.
    pub(crate) copper: f64,
}

/// The currents of the windings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Winding {
    /// In d and q, in A.
    pub(crate) current: [f64; 2],
    /// One over the inductances of both, in 1/H.
    per_henry: [f64; 2],
}

impl Winding {
    /// Without a current.
    pub(crate) fn new(motor: &MotorData) -> Self {
        Self {
            current: [0.0; 2],
            per_henry: [1.0 / motor.inductance_d, 1.0 / motor.inductance_q],
        }
    }

    /// A voltage beside the stator acts for a time, while the rotor turns on from where it looks at an electrical speed.
    pub(crate) fn turn(
        &mut self,
        motor: &MotorData,
        voltage: [f64; 2],
        facing: Facing,
        speed: f64,
        time: f64,
    ) -> Work {
        let [d, q] = facing.to_rotor(voltage);
        let start = [self.current[0], self.current[1], d, q];
        let [middle, end] = self.solve(motor, start, speed, time);
        self.current = [end[0], end[1]];
        // Simpson's rule over the powers at start, middle and end.
        let over = |power: fn([f64; 4]) -> f64| {
            let sum = power(start) + 4.0 * power(middle) + power(end);
            motor.phases.count() as f64 / 2.0 * sum / 6.0 * time
        };
        Work {
            input: over(|[id, iq, vd, vq]| id * vd + iq * vq),
            copper: over(|[id, iq, ..]| id * id + iq * iq) * motor.resistance,
        }
    }

    /// The states at the middle and at the end of a time: currents and voltages in d and q.
    fn solve(&self, motor: &MotorData, state: [f64; 4], speed: f64, time: f64) -> [[f64; 4]; 2] {
        let MotorData {
            resistance,
            inductance_d: ld,
            inductance_q: lq,
            flux,
            ..
        } = *motor;
        let [per_d, per_q] = self.per_henry;
        // The greatest of what the matrix can do in the time: the series is for times in which that is below one.
        let rate = (resistance + speed.abs() * ld.max(lq) + 1.0) * per_d.max(per_q);
        if rate * time > 1.0 && time > SHORTEST {
            let [_, middle] = self.solve(motor, state, speed, time / 2.0);
            let [_, end] = self.solve(motor, middle, speed, time / 2.0);
            return [middle, end];
        }
        let slope = |[id, iq, vd, vq]: [f64; 4], magnet: f64| {
            [
                (vd - resistance * id + speed * lq * iq) * per_d,
                (vq - resistance * iq - speed * (ld * id + magnet)) * per_q,
                speed * vq,
                -speed * vd,
            ]
        };
        let (mut middle, mut end, mut term) = (state, state, state);
        let (mut magnet, mut half) = (flux, 1.0);
        for share in SHARES {
            let factor = time * share;
            term = slope(term, magnet).map(|value| value * factor);
            magnet = 0.0;
            // Half the time is a power of a half in each term.
            half *= 0.5;
            let before = end;
            middle = std::array::from_fn(|at| middle[at] + term[at] * half);
            end = std::array::from_fn(|at| end[at] + term[at]);
            if end == before {
                break;
            }
        }
        [middle, end]
    }

    /// The currents of the phases with the rotor looking there.
    pub(crate) fn phases(&self, motor: &MotorData, facing: Facing) -> [f64; 3] {
        to_phases(motor.phases, facing.to_stator(self.current))
    }

    /// A phase carries no current.
    pub(crate) fn cut(&mut self, motor: &MotorData, phase: usize, facing: Facing) {
        let [x, y] = direction(motor.phases, phase);
        let [alpha, beta] = facing.to_stator(self.current);
        let along = alpha * x + beta * y;
        self.current = facing.to_rotor([alpha - along * x, beta - along * y]);
    }
}

/// Below this nothing is divided any more, in s: data that are no motor end too.
const SHORTEST: f64 = 1e-10;

/// One over the order of a term.
const SHARES: [f64; 40] = {
    let mut shares = [0.0; 40];
    let mut at = 0;
    while at < shares.len() {
        shares[at] = 1.0 / (at + 1) as f64;
        at += 1;
    }
    shares
};
