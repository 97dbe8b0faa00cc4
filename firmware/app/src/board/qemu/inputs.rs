//! What is along the axis of the emulated motor, for its digital inputs: the file `inputs.bin` in the folder where the emulator was started.
//!
//! The file has up to [`MARKS`] marks of twelve bytes: the input (1 to 6), then the first and the last step between which it is high, counted
//! from where the motor is at power-on; each a 32-bit number, little-endian. An input that has several marks is high on each of them. Without
//! the file every input is low: nothing is connected.
//!
//! The step interrupt looks behind each pulse, and an input that changes raises its interrupt, as the lines of the board do. So an edge is
//! captured at its very step.

use core::sync::atomic::{AtomicU8, Ordering};

use super::device::Interrupt;
use super::semihosting::{File, Mode};
use crate::board::InputLines;

const NAME: &core::ffi::CStr = c"inputs.bin";
/// The most marks of a file.
const MARKS: usize = 16;
/// Bytes of a mark.
const LENGTH: usize = 12;

/// The inputs that are high, input `n` in bit `n − 1`.
static HIGH: AtomicU8 = AtomicU8::new(0);
/// Those that have changed since the interrupt of the inputs.
static CHANGED: AtomicU8 = AtomicU8::new(0);

/// The levels of the inputs.
pub fn levels() -> u8 {
    HIGH.load(Ordering::Relaxed)
}

/// A stretch of the axis on which an input is high.
#[derive(Clone, Copy)]
struct Mark {
    input: u8,
    first: i32,
    last: i32,
}

/// All marks.
pub struct Axis {
    marks: [Option<Mark>; MARKS],
    high: u8,
}

impl Axis {
    /// Reads the file, with the motor at 0.
    pub fn open() -> Self {
        let mut axis = Self {
            marks: [None; MARKS],
            high: 0,
        };
        if let Ok(mut file) = File::open(NAME, Mode::Update) {
            for (number, mark) in axis.marks.iter_mut().enumerate() {
                let mut bytes = [0; LENGTH];
                if file.read(number * LENGTH, &mut bytes).is_err() {
                    break;
                }
                *mark = Mark::from_bytes(bytes);
            }
        }
        axis.high = axis.levels_at(0);
        HIGH.store(axis.high, Ordering::Relaxed);
        axis
    }

    /// The motor has come to a step.
    pub fn pass(&mut self, position: i32) {
        let high = self.levels_at(position);
        let changed = high ^ self.high;
        if changed != 0 {
            self.high = high;
            HIGH.store(high, Ordering::Relaxed);
            CHANGED.fetch_or(changed, Ordering::Relaxed);
            cortex_m::peripheral::NVIC::pend(Interrupt::PORT0);
        }
    }

    fn levels_at(&self, position: i32) -> u8 {
        (self.marks.iter().map_while(|mark| *mark))
            .filter(|mark| (mark.first..=mark.last).contains(&position))
            .fold(0, |high, mark| high | mark.input)
    }
}

impl Mark {
    /// `None` if there is no such input.
    fn from_bytes(bytes: [u8; LENGTH]) -> Option<Self> {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = bytes;
        let number = u32::from_le_bytes([a, b, c, d]);
        (1..=6).contains(&number).then_some(Self {
            input: 1 << (number - 1),
            first: i32::from_le_bytes([e, f, g, h]),
            last: i32::from_le_bytes([i, j, k, l]),
        })
    }
}

/// The interrupt of the inputs.
pub struct Lines;

impl InputLines for Lines {
    fn take(&mut self) -> u8 {
        CHANGED.swap(0, Ordering::Relaxed)
    }
}
