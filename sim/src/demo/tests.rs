use std::process::ExitCode;

use super::*;
use crate::plant::{AXES, ServoAxisData};
use master::bus::simulated::Interference;

#[test]
fn the_drive_goes_there_and_back_to_the_step() {
    let story = play(NODE_ID).unwrap();
    assert_eq!(story.arrivals, [(TARGET, TARGET), (0, 0)]);
    let farthest = story.motion.iter().map(|sample| sample.position).max();
    assert_eq!(farthest, Some(TARGET.into()));
    assert_eq!(story.motion.last().map(|sample| sample.position), Some(0));
}

#[test]
fn the_same_demonstration_gives_the_same_output() {
    let demo = Demo {
        node_id: 127,
        product: None,
        axis: None,
        plot: None,
    };
    let tell = || {
        let mut output = Vec::new();
        show(&demo, &mut output).unwrap();
        String::from_utf8(output).unwrap()
    };
    let told = tell();
    assert_eq!(told, tell());
    for part in [
        "boot-up of node 127",
        "operation enabled",
        "Sent to  20000, 6064h is  20000: exact.",
        "What to try next",
    ] {
        assert!(told.contains(part), "{part} is missing in\n{told}");
    }
    let fastscan = told
        .lines()
        .filter(|line| line.contains("fastscan"))
        .count();
    assert!(fastscan <= 2, "{fastscan} lines of fastscan");
}

#[test]
fn the_picture_is_svg_with_both_curves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("move.svg");
    let story = play(NODE_ID).unwrap();
    plot::as_svg(&story.motion, &path).unwrap();
    let picture = std::fs::read_to_string(&path).unwrap();
    assert!(picture.starts_with("<svg"));
    assert!(picture.matches("<polyline").count() >= 2);
    for text in ["Position in steps", "Velocity in steps/s"] {
        assert!(picture.contains(text));
    }
}

/// With what its data sheet gives it; a position window may be wide.
#[test]
fn every_product_goes_there_and_back() {
    for name in Product::names() {
        let story = product::play(Product::named(name).unwrap(), None, NODE_ID)
            .unwrap_or_else(|failure| panic!("{name}: {failure}"));
        let targets: Vec<i32> = story.arrivals.iter().map(|(target, _)| *target).collect();
        assert_eq!(targets, [TARGET, 0], "{name}");
        for (target, position) in story.arrivals {
            assert!(
                (target - position).abs() <= 1,
                "{name}: at {position} for {target}"
            );
        }
    }
}

/// The same on an axis with a servo.
#[test]
fn every_product_goes_there_and_back_with_a_servo() {
    for (name, axis) in [
        ("lmd", "nema23"),
        ("nanotec", "nema23"),
        ("s200", "servo_100w"),
        ("tc1", "servo_400w"),
    ] {
        let axis = ServoAxisData::named(axis).map(ServoAxisData::at_work);
        let story = product::play(Product::named(name).unwrap(), axis, NODE_ID)
            .unwrap_or_else(|failure| panic!("{name}: {failure}"));
        for (target, position) in story.arrivals {
            let away = (target - position).abs();
            assert!(away <= 8, "{name}: at {position} for {target}");
        }
    }
}

/// A servo stands where it is sent to, and gives the torque that it is asked for.
#[test]
fn every_axis_goes_there_and_back_and_gives_its_torque() {
    for axis in AXES {
        let story = play_axis(&axis.at_work(), NODE_ID)
            .unwrap_or_else(|failure| panic!("{}: {failure}", axis.name));
        assert_eq!(story.arrivals, [(TARGET, TARGET), (0, 0)], "{}", axis.name);
        assert_eq!(story.torques, [(100, 100)], "{}", axis.name);
    }
}

#[test]
fn what_to_try_next_is_on_the_same_axis() {
    let demo = Demo {
        node_id: NODE_ID,
        product: None,
        axis: ServoAxisData::named("nema17").map(ServoAxisData::at_work),
        plot: None,
    };
    let mut output = Vec::new();
    show(&demo, &mut output).unwrap();
    let told = String::from_utf8(output).unwrap();
    for command in ["demo --panel --axis nema17 ", "serve --axis nema17 "] {
        assert!(told.contains(command), "{command}is missing in\n{told}");
    }
}

/// What is said of a demonstration on a bus with this interference.
fn stopped(interferer: impl FnMut(&Logged) -> Interference + 'static) -> Problem {
    let mut bus = Bus::new(BitRate::Kbit1000);
    bus.interfere(interferer);
    let demo = Demo {
        node_id: NODE_ID,
        product: None,
        axis: None,
        plot: None,
    };
    let mut output = Vec::new();
    let problem = show_on(bus, &demo, &mut output).unwrap_err();
    assert!(output.is_empty(), "nothing is told of half a story");
    problem
}

/// Loses every frame with this identifier.
fn losing(cob_id: u16) -> impl FnMut(&Logged) -> Interference {
    move |logged| {
        if logged.frame.standard_id() == Some(cob_id) {
            Interference::Lose
        } else {
            Interference::None
        }
    }
}

#[test]
fn a_demonstration_that_fails_says_in_one_line_what_was_missed() {
    for (problem, expected) in [
        (
            stopped(|_| Interference::Destroy),
            "expected a drive without a node-ID, got none",
        ),
        (
            stopped(losing(0x704)),
            "expected boot-up of node 4, nothing came in 100 ms",
        ),
        (
            stopped(losing(0x584)),
            "expected an SDO answer 584, nothing came in 100 ms",
        ),
        (
            stopped(losing(0x184)),
            "expected statusword 0040h under mask 004Fh from node 4, nothing came in 100 ms",
        ),
        (
            stopped(losing(0x404)),
            "expected statusword 1000h under mask 1000h from node 4, nothing came in 100 ms",
        ),
    ] {
        let line = problem.to_string();
        let start = format!("the demonstration stopped: {expected}");
        assert!(line.starts_with(&start), "{line}");
        assert_eq!(line.lines().count(), 1, "{line}");
        assert_eq!(crate::cli::conclude(Err(problem)), ExitCode::FAILURE);
    }
}
