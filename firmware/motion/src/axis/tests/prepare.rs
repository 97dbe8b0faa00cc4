//! Whether there are pulses enough for a tick that plans.

use super::behaviour::{T01, command, fly, ms};
use super::{FAST, axis, run};
use crate::PulseSink;

/// Of pulses that are left, and of those alone: at rest there is nothing to hand out, and behind the last ones nothing more.
#[test]
fn it_runs_short_with_less_than_a_segment_and_a_half() {
    let (mut axis, mut sink) = axis(FAST);
    let segment = u64::from(axis.stepper.segment());
    assert!(!axis.runs_short(0));
    command(&mut axis, &mut sink, 30_000, T01);
    fly(&mut axis, &mut sink, ms(50));
    axis.advance(&mut sink).unwrap();
    assert!(!axis.runs_short(sink.pending()));
    assert!(!axis.runs_short(segment * 3 / 2));
    assert!(axis.runs_short(segment * 3 / 2 - 1));
    run(&mut axis, &mut sink);
    assert!(!axis.runs_short(0));
}
