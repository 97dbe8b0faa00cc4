//! The loops of a servo on a board, and what its stage is told and says, with any counts.

use ::servo::feedback::absolute::NO_ERROR;
use ::servo::interrupt::Counts;
use ::servo::stage::drv8301::{Gain, Settings};
use ::servo::stage::{sensors, thermistor, BridgeDriver, Counter, GateDriver};
use ::servo::Implausible;
use cia402::{Behaves, Behaviour, DriveConfig, Exchange, Inputs, Outputs};
use motion::{PulseSink, Record};
use runtime::servo::{
    Current, Feedback, Link, LinkedLoops, Loops, Port, ServoData, ServoObjects, ServoSettings,
    StageData,
};
use runtime::PowerStage;

use super::dictionary::Dictionary;
use super::servo::{angle, motor, number};
use super::{any, any_inputs, any_time, any_u64, look, Axis402, Moving};

static LINK: Link = Link::new();

fn data() -> Result<ServoData, Implausible> {
    Ok(ServoData {
        motor: motor()?,
        friction: number(),
        bandwidth: number(),
        speed: any(),
        feedback: match any() {
            0 => Feedback::Incremental,
            1 => Feedback::Hall,
            _ => Feedback::Absolute {
                bits: any() as u8,
                table: &NO_ERROR,
                offset: angle(),
            },
        },
        encoder: any(),
        stage: StageData {
            period: number(),
            control: any() as u8,
            voltage: number(),
            dead_time: number(),
            ripple: number(),
            reach: number(),
            current: number(),
            middle: (any() as u16, any() as u16),
            bus: number(),
            bears: (number(), number()),
        },
    })
}

/// The module of the data sheet; the generic drive has none.
struct Product<D: Behaves>(D::Behaviour);

impl<D: Behaves> Product<D> {
    fn new() -> Self {
        Self(D::Behaviour::default())
    }

    fn attend(&mut self, dictionary: &mut D, data: &ServoData) {
        let mut settings = ServoSettings::NONE;
        let report = LINK.loop_report(data);
        let request = self.0.loops(dictionary, &report, &mut settings);
        LINK.set_up(settings, request);
    }
}

struct AnyServo(Port);

impl PowerStage for AnyServo {
    type Pulses = Port;

    fn pulses(&mut self) -> &mut Port {
        &mut self.0
    }

    fn service(&mut self) {
        self.0.pass(any());
    }

    fn look(&mut self, inputs: &mut Inputs) -> canopen::Instant {
        *inputs = any_inputs();
        any_time()
    }

    fn measure(&mut self, inputs: &mut Inputs) {
        *inputs = any_inputs();
    }

    fn carry_out(&mut self, outputs: &Outputs) {
        LINK.energise(outputs.power_stage);
    }

    fn drop_pulses(&mut self) {
        look(0);
    }
}

/// The loops, their link, and a drive with a servo axis above.
#[inline(never)]
pub fn loops(config: DriveConfig) -> Result<(), Implausible> {
    let magnet = (any() == 0).then(angle);
    let mut current = Current::new(&data()?, any() as u16, magnet)?;
    let mut loops = LinkedLoops::new(Loops::new(&data()?)?, &LINK, any());
    let mut servo_objects = ServoObjects::default();
    let mut dictionary = Dictionary::new();
    let mut product = Product::<Dictionary>::new();
    let mut stage = AnyServo(Port::new(&LINK, any(), any() as u16).with_counts(any(), any()));
    let mut exchange = Exchange::new();
    let mut control = Axis402::control(config);
    let settings = Settings {
        limit: any() as u8,
        gain: Gain::Forty,
    };
    let mut gates = GateDriver::new(settings);
    let mut bridges = BridgeDriver::new();
    while any() != 0 {
        match any() {
            0 => {
                current.hall(any() as u8);
                look(current.word((any() == 0).then(any)).into());
                let counts = Counts {
                    currents: sensors::three_of_two(any() as u16, any() as u16, any() as u16),
                    bus: any() as u16,
                    timer: any() as u16,
                };
                let counter = Counter::new(any() as u16);
                let widths = current.period(&counts);
                for width in widths.into_iter().flatten() {
                    look(counter.half_bridge(width).into());
                    counter
                        .full_bridge(width)
                        .into_iter()
                        .for_each(|value| look(value.into()));
                }
                look((current.is_due() ^ current.is_off()).into());
                let state = loops.run(&mut current, any());
                let values = counter.chopper(loops.chopping(&state), any() as u16);
                current.index(any() as u16);
                loops.tell(&mut current, &state);
                values.into_iter().for_each(|value| look(value.into()));
            }
            1 => {
                let (settings, request) = servo_objects.read(&dictionary);
                LINK.set_up(settings, request);
                servo_objects.show(&mut dictionary, &LINK.found());
                // That of a product, if the data sheet is one's.
                product.attend(&mut dictionary, &data()?);
            }
            2 => {
                LINK.set_stage(thermistor::tenths(any() as u16), any() == 0);
                look(LINK.status().millivolts);
            }
            3 => {
                let answer = (any() == 0).then(|| any() as u16);
                let action = gates.tick(answer, any() == 0, any() == 0);
                look(action.send.map_or(0, u32::from) ^ u32::from(action.enable));
                look(u32::from(gates.is_ready()) ^ gates.fault().map_or(0, u32::from));
            }
            4 => {
                gates.mend();
                bridges.mend();
            }
            9 => {
                bridges.tick(any() == 0, any() == 0);
                look(u32::from(bridges.is_ready()) ^ bridges.fault().map_or(0, u32::from));
            }
            5 => look(stage.0.position_at(any() as u16) as u32),
            6 => {
                let record = Record {
                    period: any(),
                    repeat: any() as u16,
                    width: any() as u16,
                    direction: motion::Direction::Forward,
                };
                look(stage.0.push(record).is_ok().into());
            }
            7 => look(control.stop(any(), &mut stage, &mut exchange).into()),
            8 => control.refill(&mut stage),
            _ => {
                let (now, next) = control.tick(any(), any() == 0, &mut stage, &mut exchange);
                look(now.ticks() as u32 + next.map_or(0, |next| next.ticks() as u32));
            }
        }
        look(any_u64() as u32);
    }
    Ok(())
}
