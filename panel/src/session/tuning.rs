//! The drive measures its motor, and how its loops answer ([`master::tuning`]). Windows see the drive meanwhile, and may stop it.

use canopen::Duration;
use master::axis402::{Node, Problem};
use master::data_sheet::Address;
use master::tuning::{self, Found, Host, Motor, PARAMETERS, Point, Stage, Wanted};
use master::{Failure, Line, Master};

use super::drive::STOP_TIME;
use super::poll::number;
use super::{PanelLine, Session};
use crate::message::{Answer, Response, Step, Tuned, TunedParameter, TuningProgress, TuningWish};

/// What 20C0h takes (docs/servo.md).
const CURRENT: Address = Address::new(0x20C0, 2);
const BANDWIDTH: Address = Address::new(0x20C0, 4);

/// What was found of the drive that is open.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    motor: Option<Motor>,
    response: Vec<Point>,
    step: Vec<(f64, i32, i32)>,
}

impl<L: Line> Session<L> {
    pub(super) fn tune(&mut self, wish: TuningWish) -> Result<Answer, Problem> {
        self.is_ended = false;
        let tuned = self.begin_tuning(wish);
        self.state.tuning = None;
        // What broke it off is told, and not where it was just then.
        if tuned.is_err() && (self.is_ended || self.master.line_mut().urgent().stop) {
            let text = "the measurement was stopped, and everything is as it was";
            return Err(Problem::Failed(text.to_owned()));
        }
        tuned
    }

    fn begin_tuning(&mut self, wish: TuningWish) -> Result<Answer, Problem> {
        let usage = |text: &str| Err(Problem::Usage(text.to_owned()));
        let node = self.tunable()?;
        if wish
            .current
            .is_some_and(|percent| !(1..=100).contains(&percent))
        {
            return usage("the current is 1 to 100 per cent of the rated one");
        }
        if wish
            .bandwidth
            .is_some_and(|one| !(10..=5_000).contains(&one))
        {
            return usage("a bandwidth is 10 to 5000 1/s");
        }
        if self.recording.is_some() {
            return usage("the recorder is at work: stop it first");
        }
        if tuning::has_power(self.statusword()?.into()) {
            return usage("the motor has power: take it away first");
        }
        self.prepare()?;
        let wanted = Wanted {
            motor: wish.motor,
            current: wish.current.map(|percent| percent * 10),
            bandwidth: wish.bandwidth,
            writes: false,
            response: wish.response,
            step: wish.step,
        };
        let usual = self.master.answer_time();
        let mut tuner = Tuner {
            parts: parts(&wish),
            session: self,
        };
        let found = tuning::tune(&mut tuner, &node, &wanted);
        self.master.set_answer_time(usual);
        self.master.line_mut().set_interruptible(true);
        let Found {
            motor,
            response,
            step,
            ..
        } = found?;
        let known = &mut self.known;
        known.motor = motor.or(known.motor.take());
        if wish.response {
            known.response = response;
        }
        if wish.step {
            known.step = step;
        }
        self.state.tunings += 1;
        Ok(Answer::Text("measured; nothing is written".to_owned()))
    }

    /// What was found is written, now that a person has said so.
    pub(super) fn write_tuning(&mut self) -> Result<Answer, Problem> {
        let node = self.tunable()?;
        let Some(motor) = self.known.motor.clone() else {
            return Err(Problem::Usage("nothing was measured yet".to_owned()));
        };
        tuning::write(&mut Tuner::idle(self), &node, &motor)?;
        self.state.tunings += 1;
        let text = format!(
            "node {} goes by it now; it keeps it when its parameters are saved",
            node.id
        );
        Ok(Answer::Text(text))
    }

    /// What is known, beside what is set.
    pub(super) fn tuned(&mut self) -> Result<Answer, Problem> {
        let node = self.tunable()?;
        let mut read = |address| match node.upload(&mut self.master, address) {
            Ok(bytes) => Ok(number(&bytes, false) as u32),
            Err(failure) => Err(Problem::with_node(node.id, failure)),
        };
        let (current, bandwidth) = (read(CURRENT)?, read(BANDWIDTH)?);
        let set = tuning::values(&mut Tuner::idle(self), &node)?;
        let Known {
            motor,
            response,
            step,
        } = &self.known;
        let found = motor.as_ref().map(|motor| motor.values);
        let parameters = PARAMETERS.iter().enumerate().map(|(place, parameter)| {
            let shown =
                |values: [u32; 9]| values.get(place).map(|raw| figures(*raw, parameter.factor));
            TunedParameter {
                name: parameter.name,
                unit: parameter.unit,
                object: parameter.address.to_string(),
                found: found.and_then(shown),
                set: shown(set).filter(|_| set.get(place) != Some(&0)),
            }
        });
        Ok(Answer::Tuned(Box::new(Tuned {
            node: node.id,
            current,
            bandwidth,
            parameters: parameters.collect(),
            encoder: motor.as_ref().map(encoder),
            is_written: found == Some(set),
            response: Response {
                frequency: response.iter().map(|point| point.frequency).collect(),
                decibels: (response.iter())
                    .map(|point| 20.0 * point.amplitude.log10())
                    .collect(),
                phase: response.iter().map(|point| point.phase).collect(),
            },
            step: Step {
                time: step.iter().map(|(time, ..)| time * 1e3).collect(),
                wanted: step.iter().map(|(_, wanted, _)| *wanted).collect(),
                was: step.iter().map(|(_, _, was)| *was).collect(),
            },
        })))
    }

    fn tunable(&mut self) -> Result<Node, Problem> {
        let node = self.chosen_node()?;
        match tuning::is_possible(&node.sheet) {
            true => Ok(node),
            false => Err(Problem::Failed(
                "the drive has no motor that it could measure (20C0h to 20C2h)".to_owned(),
            )),
        }
    }
}

/// The parts of a measurement, in their order.
fn parts(wish: &TuningWish) -> Vec<Stage> {
    let motor = [Stage::Winding, Stage::Field, Stage::Strokes];
    let motor = motor.into_iter().filter(|_| wish.motor);
    let response = wish.response.then_some(Stage::Response);
    let step = wish.step.then_some(Stage::Step);
    [Stage::Enabling]
        .into_iter()
        .chain(motor)
        .chain(response)
        .chain(step)
        .collect()
}

/// A number with four figures that count.
fn figures(raw: u32, factor: f64) -> String {
    let value = f64::from(raw) * factor;
    let before = if value > 0.0 {
        value.log10().floor() as i32
    } else {
        0
    };
    let decimals = if factor == 1.0 {
        0
    } else {
        (3 - before).clamp(0, 6)
    };
    format!("{value:.*}", decimals as usize)
}

fn encoder(motor: &Motor) -> String {
    let way = match motor.direction {
        1 => "counts as the motor turns",
        _ => "counts the other way",
    };
    format!(
        "{} pole pairs, {way}, {:.1}° electrical at 0",
        motor.pole_pairs, motor.angle
    )
}

/// The session as the measurement has it: what windows want is attended to in each of its pauses.
struct Tuner<'a, L> {
    session: &'a mut Session<L>,
    parts: Vec<Stage>,
}

impl<'a, L: Line> Tuner<'a, L> {
    fn idle(session: &'a mut Session<L>) -> Self {
        Self {
            session,
            parts: Vec::new(),
        }
    }
}

impl<L: Line> Host for Tuner<'_, L> {
    type Line = PanelLine<L>;

    fn master(&mut self) -> &mut Master<PanelLine<L>> {
        &mut self.session.master
    }

    fn pause(&mut self, span: Duration) -> Result<(), Problem> {
        let session = &mut *self.session;
        let end = session.master.now() + span;
        while session.master.now() < end {
            match session.pass() {
                Ok(true) => {}
                Ok(false) => return Err(Problem::Stopped),
                Err(down) => return Err(Failure::LineDown(down).into()),
            }
            if session.is_ended {
                return Err(Problem::Failed("stopped".to_owned()));
            }
        }
        Ok(())
    }

    fn at(&mut self, stage: Stage) {
        let part = self.parts.iter().position(|part| *part == stage);
        let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        self.session.state.tuning = Some(TuningProgress {
            words: stage.words(),
            part: part.map_or(0, count),
            parts: count(self.parts.len()),
        });
    }

    fn conclude(&mut self) {
        // A stop that has broken it off goes first; what follows is soon done, and nothing moves any more.
        self.session.attend();
        self.session.master.line_mut().set_interruptible(false);
        self.session.master.set_answer_time(STOP_TIME);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_figures_count() {
        assert_eq!(figures(601_234, 1e-6), "0.6012");
        assert_eq!(figures(1_650_000, 1e-6), "1.650");
        assert_eq!(figures(12_345_678, 1e-6), "12.35");
        assert_eq!(figures(600, 1.0), "600");
        assert_eq!(figures(0, 1e-6), "0.000");
    }
}
