//! What cargo does, and beside it what plays with programs that cargo has built.
//!
//! Cargo's part goes step by step, on all processors; the tests of running devices wait most of their time, two steps at once. First everything is built that the second
//! part needs, so that both begin early. Cargo makes way: a device that runs in real time is not to be late.

use std::sync::mpsc::{self, Receiver};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Result, anyhow};

use super::count::Count;
use super::steps::{self, Played, Ready, Run, Step};
use crate::words::say;

/// What became of a step.
#[derive(Debug)]
pub struct Outcome {
    /// Which it was.
    pub step: Step,
    /// Its tests.
    pub count: Count,
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
    for played in played {
        outcomes.extend(played.map_err(|_| anyhow!("a step has panicked"))??);
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
                skipped: None,
                time: started.elapsed(),
            }),
            Run::Skipped(why) => {
                say!("skipped: {why}")?;
                outcomes.push(Outcome {
                    step,
                    count: Count::default(),
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

/// Plays one step after the other until there are no more.
fn play_all(queue: &Mutex<Receiver<Built>>, ready: &Ready) -> Result<Vec<Outcome>> {
    let mut outcomes = Vec::new();
    loop {
        let next = queue.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok((mut played, build)) = next else {
            return Ok(outcomes);
        };
        let started = Instant::now();
        let count = played.play(ready)?;
        outcomes.push(Outcome {
            step: played.step(),
            count,
            skipped: None,
            time: build + started.elapsed(),
        });
    }
}
