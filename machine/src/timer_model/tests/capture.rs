//! Positions of edges: an interrupt tells that there was one, and a capture channel where. Each has a pin of its own.

use motion::Limits;
use motion::advanced_timer::{CaptureChannel, count_at_edge};

use super::super::rig::{HZ, Rig, TIME_SLICE};
use super::{FAST, rig};

/// Between an edge and what its interrupt reads: a microsecond.
const LATENCY: u64 = HZ as u64 / 1_000_000;

const CHANNELS: [(u32, CaptureChannel); 3] = [
    (1, CaptureChannel::One),
    (2, CaptureChannel::Two),
    (4, CaptureChannel::Four),
];

/// Pulses at this rate, once the ramp is over.
fn at(velocity: i32) -> Rig<'static> {
    let mut rig = rig(FAST);
    let limits = Limits {
        velocity: 1_000_000.into(),
        acceleration: 100_000_000,
        deceleration: 100_000_000,
    };
    rig.axis.ramp_to(velocity.into(), limits).unwrap();
    for _ in 0..100 {
        rig.refill(TIME_SLICE.into());
    }
    rig
}

/// The position that the interrupt gets, a latency from now.
fn interrupt(rig: &mut Rig<'_>, channel: CaptureChannel) -> i64 {
    rig.model.run(LATENCY);
    let count = count_at_edge(&rig.model, Some(channel));
    rig.output.position_at(count)
}

/// Refills on time, and looks at the position once a millisecond.
fn wait(rig: &mut Rig<'_>, slices: u32) {
    for time_slice in 0..slices {
        rig.refill(TIME_SLICE.into());
        if time_slice % 4 == 0 {
            rig.output.position();
        }
    }
}

#[test]
fn a_captured_count_is_the_position_of_the_edge() {
    for velocity in [100, 10_000, 100_000, 1_000_000, -1_000_000] {
        let mut rig = at(velocity);
        for (number, channel) in CHANNELS {
            wait(&mut rig, 7);
            rig.model.edge_at_channel(number, 0);
            let there = rig.model.judge().position;
            let found = interrupt(&mut rig, channel);
            // The filter is faster than a step.
            assert!((found - there).abs() <= 1, "{found} for {there}");
        }
        let (number, channel) = CHANNELS[0];
        rig.model.edge_at_channel(number, 0);
        rig.model.run(LATENCY);
        let count = count_at_edge(&rig.model, Some(channel));
        let there = rig.output.position_at(count);
        rig.axis.stop(100_000_000).unwrap();
        rig.finish(1_000);
        assert_eq!(rig.output.position_at(count), there);
    }
}

/// A slow edge reaches the input first, and its channel when the interrupt is over: what was captured belongs to no other edge.
#[test]
fn a_capture_behind_its_interrupt_is_not_taken_for_the_next_edge() {
    for velocity in [3_000, 100_000, 1_000_000] {
        for slices in [1, 2, 5, 40] {
            let mut rig = at(velocity);
            let steps_in_latency = i64::from(velocity) / 1_000_000;
            for (number, channel) in CHANNELS {
                for _ in 0..3 {
                    rig.model.edge_at_channel(number, 4 * LATENCY);
                    let there = rig.model.judge().position;
                    let found = interrupt(&mut rig, channel);
                    let late = found - there;
                    assert!(
                        (0..=1 + steps_in_latency).contains(&late),
                        "{found} for {there}, {velocity} steps/s"
                    );
                    wait(&mut rig, slices);
                }
            }
        }
    }
}

/// Nothing is wired to the channel, and something disturbs its pin at rest: the position is that of the edge, however little has been gone since.
#[test]
fn a_disturbance_at_rest_is_no_capture() {
    let mut rig = rig(FAST);
    let (number, channel) = CHANNELS[2];
    rig.model.edge_at_channel(number, 0);
    wait(&mut rig, 9);
    let limits = Limits {
        velocity: 200_000.into(),
        acceleration: 200_000_000,
        deceleration: 200_000_000,
    };
    rig.axis.ramp_to(200_000.into(), limits).unwrap();
    while rig.model.judge().position < 3 {
        rig.output.service();
        let _ = rig.axis.advance(&mut rig.output);
        rig.model.run(100);
    }
    assert_eq!(interrupt(&mut rig, channel), rig.model.judge().position);
}
