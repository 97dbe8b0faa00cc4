//! Refills come while a plan is made, so there are always enough pulses left, however long that takes.
//!
//! Only a plan that was overtaken by a refill is made once more while the next one waits for it, and that one is far. The run that is preloaded
//! (up to 0.1 ms) cannot be changed any more. An instruction takes a cycle and a half, and a cycle is a tick of the step timer.

use motion::{Goal, Limits, Plan, Ramps};

use super::super::rig::{Rig, TIME_SLICE};
use super::{FAST, HZ, rig};

/// Other interrupts in 250 µs: three frames at full bus load, edges of inputs. In microseconds.
const INTERRUPTED: u64 = 18;

/// What a row of `docs/benchmarks.md` says.
fn instructions(row: &str) -> u64 {
    let page = include_str!("../../../../docs/benchmarks.md");
    let line = page.lines().find_map(|line| line.strip_prefix(row));
    let figure = line.and_then(|line| line.trim_start_matches(" | ").split(' ').next());
    let figure = figure.and_then(|figure| figure.parse().ok());
    figure.unwrap_or_else(|| panic!("no figure in the row {row}"))
}

/// The time of so many instructions, and of what interrupts them, in ticks.
fn time(instructions: u64) -> u64 {
    instructions * 3 / 2 + INTERRUPTED * u64::from(HZ) / 1_000_000
}

/// What a plan may take while a refill waits for it, in instructions: more than the worst that was found.
const WORST_PLAN: u64 = 12_000;

#[test]
fn the_worst_plan_that_was_found_is_not_the_worst_there_may_be() {
    for ramps in ["linear", "sin²"] {
        let row = format!("| motion: plan, worst case found, {ramps}");
        assert!(instructions(&row) < WORST_PLAN, "{ramps}");
    }
}

fn limits(velocity: u32) -> Limits {
    Limits {
        velocity: velocity.into(),
        acceleration: 2_000_000,
        deceleration: 3_000_000,
    }
}

const JERK: u32 = 50_000_000;

const ALL: [Ramps; 3] = [Ramps::Linear, Ramps::SinSquared, Ramps::MovingAverage(JERK)];

/// An axis with a refill in each time slice.
struct Bench {
    rig: Rig<'static>,
    /// Ticks to the next refill.
    left: u64,
    /// Plans that were overtaken.
    overtaken: u32,
}

impl Bench {
    fn new() -> Self {
        Self {
            rig: rig(FAST),
            left: 0,
            overtaken: 0,
        }
    }

    fn pass(&mut self, ticks: u64) {
        let mut passed = 0;
        while passed + self.left <= ticks {
            self.rig.model.run(self.left);
            passed += self.left;
            self.rig.refill(0);
            self.left = TIME_SLICE.into();
        }
        self.rig.model.run(ticks - passed);
        self.left -= ticks - passed;
    }

    /// Lets the axis move for so many time slices.
    fn go_on(&mut self, slices: u32) {
        self.pass(u64::from(slices) * u64::from(TIME_SLICE));
    }

    /// A plan that takes so many instructions, and where it was overtaken another one, for which the refill waits.
    fn order(&mut self, goal: Goal, velocity: u32, ramps: Ramps, cost: u64) {
        let (goal, limits) = match goal {
            Goal::Velocity(stop) if stop == 0.into() => Goal::stop(5_000_000),
            goal => (goal, limits(velocity)),
        };
        let (mut draft, mut plan) = (self.rig.axis.draft(ramps), Plan::at_rest(0, 0));
        draft.plan(&mut plan, goal, limits).unwrap();
        self.pass(time(cost));
        if !self.rig.axis.install(&draft, &plan) {
            self.overtaken += 1;
            self.wait_for(goal, limits, ramps, cost);
        }
    }

    /// A plan that the refill waits for.
    fn wait_for(&mut self, goal: Goal, limits: Limits, ramps: Ramps, cost: u64) {
        self.rig.axis.order(goal, limits, ramps).unwrap();
        self.rig.model.run(time(cost));
        self.left = self.left.saturating_sub(time(cost));
    }
}

/// A motion with `first`, and every few time slices another with ramps of `then` and of `first` in turn, at all moments between two refills. Each plan takes
/// so many instructions. Returns how often there were no pulses, and how many plans were overtaken.
fn planned_anew((first, then): (Ramps, Ramps), velocity: u32, cost: u64) -> (u64, u32) {
    let mut bench = Bench::new();
    let far = i64::from(velocity);
    bench.order(Goal::Rest(far), velocity, first, 0);
    let mut target = far;
    for number in 0..24_u32 {
        bench.go_on(5 + number * 7 % 40);
        bench.pass(u64::from(TIME_SLICE) * u64::from(number * 5 % 24) / 24);
        let ramps = if number % 2 == 0 { then } else { first };
        target = match number % 3 {
            2 => far / 4,
            _ => target + far / 50,
        };
        bench.order(Goal::Rest(target), velocity, ramps, cost);
    }
    let rig = &mut bench.rig;
    let starved = rig.underruns;
    rig.finish(100_000);
    rig.account();
    assert_eq!(rig.model.judge().position, target);
    (starved, bench.overtaken)
}

/// Whatever ramps take the place of whatever others, at any velocity, however long a plan takes.
#[test]
fn no_plan_makes_a_pause() {
    for velocity in [3_000, 200_000, 1_000_000] {
        for first in ALL {
            for then in ALL {
                let (starved, overtaken) = planned_anew((first, then), velocity, WORST_PLAN);
                let case = format!("{first:?}, then {then:?}, {velocity} steps/s");
                assert_eq!(starved, 0, "{case}");
                assert!((3..=20).contains(&overtaken), "{case}: {overtaken}");
            }
        }
    }
}

#[test]
fn no_stop_makes_a_pause() {
    let stop = Goal::Velocity(0.into());
    for velocity in [3_000_u32, 200_000, 1_000_000] {
        for ramps in ALL {
            let mut bench = Bench::new();
            for moment in 0..40_u32 {
                let speed = velocity.cast_signed();
                bench.order(Goal::Velocity(speed.into()), velocity, ramps, WORST_PLAN);
                bench.go_on(40 + moment * 11 % 400);
                bench.pass(u64::from(TIME_SLICE) * u64::from(moment) / 40);
                if moment % 3 > 0 {
                    // An early tick, with the regular one behind it.
                    bench.order(stop, velocity, ramps, WORST_PLAN);
                }
                bench.order(stop, velocity, ramps, WORST_PLAN);
                bench.go_on(7 * moment);
            }
            let rig = &mut bench.rig;
            assert_eq!(rig.underruns, 0, "{ramps:?}, {velocity} steps/s");
            rig.finish(100_000);
            rig.account();
        }
    }
}

/// Even one that is due at once could wait for the worst plan.
#[test]
fn a_refill_may_wait_no_longer() {
    for cost in (2_500..=20_000).step_by(2_500) {
        let mut bench = Bench::new();
        let goal = Goal::Rest(100_000);
        bench.order(goal, 3_000, Ramps::Linear, 0);
        bench.go_on(50);
        for number in 0..100 {
            bench.go_on(2);
            bench.pass(bench.left - 1 - number * 20);
            bench.wait_for(goal, limits(3_000), Ramps::Linear, cost);
        }
        let starved = bench.rig.underruns;
        assert_eq!(starved > 0, cost > 12_500, "{cost}: {starved}");
    }
}
