//! The reference vectors: moves and ramps computed to 40 digits, as exact decimals and fractions.

use serde_json::Value;
use std::string::String;
use std::vec::Vec;

/// A move to a target. Units are steps, steps/s, steps/s² and seconds.
#[derive(Debug)]
pub(crate) struct Move {
    pub(crate) name: String,
    pub(crate) distance: i64,
    pub(crate) v0: i32,
    pub(crate) velocity: u32,
    pub(crate) acceleration: u32,
    pub(crate) deceleration: u32,
    pub(crate) peak: f64,
    pub(crate) duration: f64,
    /// Seconds and acceleration of each phase that lasts.
    pub(crate) phases: Vec<(f64, f64)>,
    pub(crate) lowest: f64,
    pub(crate) highest: f64,
}

/// A ramp from one velocity to another.
#[derive(Debug)]
pub(crate) struct Ramp {
    pub(crate) name: String,
    pub(crate) v0: i32,
    pub(crate) v1: i32,
    pub(crate) acceleration: u32,
    pub(crate) deceleration: u32,
    pub(crate) duration: f64,
    pub(crate) distance: f64,
}

/// A jerk-limited move from rest to rest, with the same jerk and acceleration at both ends.
#[derive(Debug)]
#[cfg_attr(
    not(feature = "limited-jerk"),
    expect(dead_code, reason = "what limited jerk alone attains")
)]
pub(crate) struct Smooth {
    pub(crate) name: String,
    pub(crate) distance: i64,
    pub(crate) velocity: u32,
    pub(crate) acceleration: u32,
    pub(crate) jerk: u32,
    /// That of the fastest move there is.
    pub(crate) duration: f64,
    /// That of the linear move and a window of acceleration by jerk behind it.
    pub(crate) averaged: f64,
    pub(crate) peak: f64,
    pub(crate) peak_acceleration: f64,
}

fn document() -> Value {
    serde_json::from_str(include_str!("../tests/motion-vectors.json")).unwrap()
}

fn whole<T: TryFrom<i64>>(value: &Value) -> T {
    let number = value
        .as_i64()
        .unwrap_or_else(|| value.as_str().unwrap().parse().unwrap());
    T::try_from(number).ok().unwrap()
}

/// A decimal, or a fraction of two.
fn real(value: &Value) -> f64 {
    let text = value.as_str().unwrap();
    match text.split_once('/') {
        Some((above, below)) => above.parse::<f64>().unwrap() / below.parse::<f64>().unwrap(),
        None => text.parse().unwrap(),
    }
}

pub(crate) fn moves() -> Vec<Move> {
    let document = document();
    let vectors = document["trapezoid"].as_array().unwrap().iter();
    vectors
        .map(|v| Move {
            name: v["name"].as_str().unwrap().into(),
            distance: whole(&v["S"]),
            v0: whole(&v["v0"]),
            velocity: whole(&v["vmax"]),
            acceleration: whole(&v["a"]),
            deceleration: whole(&v["d"]),
            peak: real(&v["vpeak"]),
            duration: real(&v["T"]),
            phases: v["phases"]
                .as_array()
                .unwrap()
                .iter()
                .map(|phase| (real(&phase[0]), real(&phase[1])))
                .filter(|(seconds, _)| *seconds > 0.0)
                .collect(),
            lowest: real(&v["xmin"]),
            highest: real(&v["xmax"]),
        })
        .collect()
}

pub(crate) fn ramps() -> Vec<Ramp> {
    let document = document();
    let vectors = document["velocity"].as_array().unwrap().iter();
    vectors
        .map(|v| Ramp {
            name: v["name"].as_str().unwrap().into(),
            v0: whole(&v["v0"]),
            v1: whole(&v["v1"]),
            acceleration: whole(&v["a"]),
            deceleration: whole(&v["d"]),
            duration: real(&v["t"]),
            distance: real(&v["dx"]),
        })
        .collect()
}

pub(crate) fn smooth_moves() -> Vec<Smooth> {
    let document = document();
    let vectors = document["jerk"].as_array().unwrap().iter();
    vectors
        .map(|v| Smooth {
            name: v["name"].as_str().unwrap().into(),
            distance: whole(&v["S"]),
            velocity: whole(&v["v"]),
            acceleration: whole(&v["a"]),
            jerk: whole(&v["j"]),
            duration: real(&v["T_opt"]),
            averaged: real(&v["T_box"]),
            peak: real(&v["vpeak"]),
            peak_acceleration: real(&v["apeak"]),
        })
        .collect()
}

pub(crate) fn a_move(id: &str) -> Move {
    moves()
        .into_iter()
        .find(|v| v.name.starts_with(id))
        .unwrap()
}

pub(crate) fn a_ramp(id: &str) -> Ramp {
    ramps()
        .into_iter()
        .find(|v| v.name.starts_with(id))
        .unwrap()
}
