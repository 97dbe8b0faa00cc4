//! Step timing by TIMER0, which counts down to each step once: a reload value of 0, which it has from the start, stops it there.

use motion::Direction;

use super::device::{Interrupt, Timer, TIMER0};
use super::now;
use motion::step_interrupt::{Edge, StepTimer};

/// TIMER0 as an alarm clock.
pub struct AlarmTimer;

impl StepTimer for AlarmTimer {
    const FALLING_EDGES: bool = false;

    fn now() -> u32 {
        now()
    }

    fn schedule(&mut self, time: u32, _edge: Edge) -> u32 {
        let now = Self::now();
        let wait = time.wrapping_sub(now);
        let passed = wait > u32::MAX / 2;
        TIMER0.intstatus.write(1);
        TIMER0.value.write(if passed { 1 } else { wait.max(1) });
        TIMER0.ctrl.write(Timer::RUN);
        if passed {
            now
        } else {
            time
        }
    }

    fn stop(&mut self) -> bool {
        TIMER0.ctrl.write(0);
        let has_happened = TIMER0.intstatus.read() != 0;
        TIMER0.intstatus.write(1);
        has_happened
    }

    fn set_direction(&mut self, _direction: Direction) {}

    fn interrupt() {
        cortex_m::peripheral::NVIC::pend(Interrupt::TIMER0);
    }
}
