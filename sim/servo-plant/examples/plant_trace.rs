//! What a plant does, for a judge of another language: a case as JSON on the standard input, samples as JSON on the standard output.
//!
//! The case has the `plant`, `initial` (angle, velocity), and `spans`: each with its `steps`, `gates` and `load_torque`. A sample is taken
//! at the end of each span: time, d and q current, angle, velocity, angle of the load, and the voltage of the bus.

use std::error::Error;
use std::io;

use serde::Deserialize;
use servo_plant::data::PlantData;
use servo_plant::{Gates, Plant};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    plant: PlantData,
    initial: [f64; 2],
    spans: Vec<Span>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Span {
    steps: u32,
    gates: [f64; 3],
    load_torque: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let case: Case = serde_json::from_reader(io::stdin())?;
    let [angle, velocity] = case.initial;
    let mut plant = Plant::new(case.plant, 1).turning(angle, velocity);
    let mut samples = Vec::new();
    for span in case.spans {
        plant.gates = Gates::On(span.gates);
        plant.load_torque = span.load_torque;
        plant.run(span.steps);
        let [d, q] = plant.current();
        samples.push([
            plant.time(),
            d,
            q,
            plant.angle(),
            plant.velocity(),
            plant.load_angle(),
            plant.bus_voltage(),
        ]);
    }
    serde_json::to_writer(io::stdout(), &samples)?;
    Ok(())
}
