//! What cargo does, and beside it what plays with programs that cargo has built.
//!
//! Cargo's part goes step by step, on all processors; the tests of running devices wait most of their time, two steps at once. First everything is built that the second
//! part needs, so that both begin early. Cargo makes way: a device that runs in real time is not to be late.
//!
//! A busy PC may still be late for it. So the tests of devices in real time that failed are played once more at the end, when the PC does nothing else; what fails then has
//! failed, and the summary names what needed the second time. The model of the board has a clock of its own, and no second time.

use std::sync::mpsc::{self, Receiver};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Result, anyhow};

use super::count::Count;
use super::steps::{self, Played, Ready, Run, Step};
use crate::words::say;

/// More failures than this are no matter of time.
const FEW: usize = 10;

/// What became of a step.
#[derive(Debug)]
pub struct Outcome {
    /// Which it was.
    pub step: Step,
    /// Its tests.
    pub count: Count,
    /// What failed beside everything else, and was played again.
    pub again: Vec<String>,
    /// Why the step did not run.
    pub skipped: Option<String>,
    /// How long it took, its builds included.
    pub time: Duration,
}

/// Steps that are played at the same time.
const PLAYERS: usize = 2;

/// How far cargo makes way for the devices, as `nice` counts.
#[cfg(target_os = "linux")]
const MAKES_WAY: i32 = 5;

/// A step whose programs are built, and how long that took.
type Built = (Played, Duration);

/// Runs the steps; the outcomes come in the steps' own order.
///
/// # Errors
/// When a program cannot be started.
pub fn run(steps: &[Step], ready: &Ready) -> Result<Vec<Outcome>> {
    let (sender, queue) = mpsc::channel();
    let queue = Mutex::new(queue);
    let (built, played) = thread::scope(|scope| {
        let players: [_; PLAYERS] =
            std::array::from_fn(|_| scope.spawn(|| play_all(&queue, ready)));
        let built = build_all(steps, ready, &sender);
        // The players end with the last step that they were given.
        drop(sender);
        (built, players.map(|player| player.join()))
    });
    let mut outcomes = built?;
    for player in played {
        for (played, outcome) in player.map_err(|_| anyhow!("a step has panicked"))?? {
            outcomes.push(play_again(played, outcome, ready)?);
        }
    }
    outcomes.sort_by_key(|outcome| Step::ALL.iter().position(|step| *step == outcome.step));
    Ok(outcomes)
}

/// Cargo's part. A step that is played is handed over when its programs are there.
fn build_all(steps: &[Step], ready: &Ready, players: &mpsc::Sender<Built>) -> Result<Vec<Outcome>> {
    // Counts for this thread and for what it starts. Where it is refused, everything has the same rank.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::nice(MAKES_WAY);

    let (quick, others): (Vec<Step>, Vec<Step>) =
        steps.iter().partition(|step| **step == Step::Format);
    let (played, built): (Vec<Step>, Vec<Step>) =
        others.into_iter().partition(|step| step.is_played());
    let mut outcomes = Vec::new();
    for step in quick.into_iter().chain(played).chain(built) {
        say!("\n=== {step}: {} ===", step.subject())?;
        let started = Instant::now();
        match steps::run(step, ready)? {
            Run::Done(count) => outcomes.push(Outcome {
                step,
                count,
                again: Vec::new(),
                skipped: None,
                time: started.elapsed(),
            }),
            Run::Skipped(why) => {
                say!("skipped: {why}")?;
                outcomes.push(Outcome {
                    step,
                    count: Count::default(),
                    again: Vec::new(),
                    skipped: Some(why),
                    time: started.elapsed(),
                });
            }
            Run::Built(played) => {
                // Nobody takes it when a player could not start its program, which is told at the end.
                let _ = players.send((played, started.elapsed()));
            }
        }
    }
    Ok(outcomes)
}

/// Plays the tests that failed once more, if they are few.
fn play_again(mut played: Played, mut outcome: Outcome, ready: &Ready) -> Result<Outcome> {
    let names = &outcome.count.names;
    let are_named = names.len() == outcome.count.failed as usize;
    if outcome.step != Step::Board && are_named && (1..=FEW).contains(&names.len()) {
        let started = Instant::now();
        let names = names.clone();
        say!("\n=== {}: again what failed ===", outcome.step)?;
        played.choose(&names);
        outcome.count = outcome.count.after(played.play(ready)?);
        outcome.again = names;
        outcome.time += started.elapsed();
    }
    Ok(outcome)
}

/// Plays one step after the other until there are no more.
fn play_all(queue: &Mutex<Receiver<Built>>, ready: &Ready) -> Result<Vec<(Played, Outcome)>> {
    let mut outcomes = Vec::new();
    loop {
        let next = queue.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok((mut played, build)) = next else {
            return Ok(outcomes);
        };
        let started = Instant::now();
        let count = played.play(ready)?;
        let outcome = Outcome {
            step: played.step(),
            count,
            again: Vec::new(),
            skipped: None,
            time: build + started.elapsed(),
        };
        outcomes.push((played, outcome));
    }
}
