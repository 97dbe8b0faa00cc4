//! What a product does beyond its data: a module of its own with a hook in the tick.
//!
//! Most of what makes a product of another manufacturer is data: data sheet, binding, habits. Where behaviour is not data (an input that forbids motion, motion tasks),
//! the product's folder has a Rust module whose `Module` implements [`Behaviour`], and `od-gen` puts it into [`Objects::Behaviour`].
//! The generic drive has `()`: nothing of this is in its image.
//!
//! The device calls it in the task that serves the bus:
//! - [`Behaviour::check`] and [`Behaviour::written`] with each write of an object of the drive or of its manufacturer;
//! - [`Behaviour::look`] after each control tick, and before a received frame is served; the dictionary shows what the drive has published;
//! - [`Behaviour::command`] with each set of commands, before the state machine has them;
//! - [`Behaviour::loops`] after each control tick of a servo: what its loops report, and their settings;
//! - [`Behaviour::take_requests`] before commands are posted: what else the module wants done.
//!
//! A call takes a time that is bounded by the module's own numbers, waits for nothing and allocates nothing. A command to stop that it gives is
//! as urgent as one from the bus ([`crate::Exchange::calls_early`]).

use canopen::Instant;
use canopen::cia301::nmt::NmtState;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary, Entry};

use crate::commands::Commands;
use crate::exchange::Actuals;
use crate::loops::{LoopReport, Request, ServoSettings};
use crate::objects::Objects;
pub use motion::{SignedSpeed, Speed};

use crate::units::Units;

/// What [`Behaviour::look`] is given.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// What the drive published last.
    pub actuals: &'a Actuals,
    /// The NMT state.
    pub state: NmtState,
    /// Parameters are being stored or restored.
    pub is_storing: bool,
    /// Which of [`Objects::TOLD_ERRORS`] stand, a bit for each.
    pub errors: u32,
    /// A received frame is served next, which may read what the module shows; otherwise a control tick has passed, and transmit PDOs
    /// are checked for changes.
    pub serves_frame: bool,
    /// The time of this look.
    pub at: Instant,
}

/// Requests of a module beside its commands. Each is carried out once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Requests {
    /// [`Behaviour::command`] would give other commands than last time: they are to be posted.
    pub commands: bool,
    /// The module has written an object of the configuration.
    pub configuration: bool,
    /// The device is to start anew, as NMT reset node says.
    pub reset: bool,
    /// 1010h or 1011h is to be carried out with this sub-index, unless the store is busy.
    pub order: Option<(u16, u8)>,
    /// This number is to be written to an object, as a master would; [`Behaviour::wrote`] gets the result.
    pub write: Option<(u16, u8, i64)>,
    /// An emergency message: this error has come (true) or is gone.
    pub error: Option<(u16, bool)>,
}

/// The module of a product.
pub trait Behaviour: Default + core::fmt::Debug + 'static {
    /// Whether there is one.
    const IS_THERE: bool = true;

    /// The power-on values were loaded; stored parameters follow.
    fn power_on<D: Dictionary + Objects>(&mut self, dictionary: &mut D) {
        let _ = dictionary;
    }

    /// The last check of a write that the rules of the drive allow. `value` is little-endian.
    ///
    /// # Errors
    /// The write is refused with this code, and nothing has changed.
    fn check<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let _ = (dictionary, entry, value);
        Ok(())
    }

    /// An object was written.
    fn written<D: Dictionary + Objects>(&mut self, dictionary: &mut D, entry: &Entry) {
        let _ = (dictionary, entry);
    }

    /// A number that the data sheet leaves to the module (`;Memory=application`) is read; `None` if it is not the module's.
    fn read<D: Dictionary + Objects>(&mut self, dictionary: &D, entry: &Entry) -> Option<i64> {
        let _ = (dictionary, entry);
        None
    }

    /// The result of [`Requests::write`].
    fn wrote<D: Dictionary + Objects>(&mut self, dictionary: &D, result: Result<(), AbortCode>) {
        let _ = (dictionary, result);
    }

    /// The drive has published what it does.
    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        let _ = (dictionary, view);
    }

    /// The commands of the dictionary, on their way to the drive.
    fn command<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        units: &Units,
        commands: &mut Commands,
    ) {
        let _ = (dictionary, units, commands);
    }

    /// For a servo, in each tick: writes the report of the loops to the dictionary, and takes their settings from it. Returns a measurement
    /// that is to begin, once.
    fn loops<D: Dictionary + Objects>(
        &mut self,
        dictionary: &mut D,
        report: &LoopReport,
        settings: &mut ServoSettings,
    ) -> Option<Request> {
        let _ = (dictionary, report, settings);
        None
    }

    /// What the module wants done since the last call.
    fn take_requests(&mut self) -> Requests {
        Requests::default()
    }
}

/// A dictionary whose drive has a behaviour: every one that `od-gen` makes.
pub trait Behaves: Dictionary + Objects<Behaviour: Behaviour> {}

impl<D: Dictionary + Objects<Behaviour: Behaviour>> Behaves for D {}

/// A drive that does what CiA 402-2 says.
impl Behaviour for () {
    const IS_THERE: bool = false;
}

/// The number in an object; 0 if it has none.
// Out of line: a module asks for many.
#[inline(never)]
pub fn number<D: Dictionary>(dictionary: &D, index: u16, sub: u8) -> i64 {
    od::find::<D>(index, sub)
        .ok()
        .and_then(|entry| od::number(entry, od::value(dictionary, entry)))
        .unwrap_or(0)
}

/// Writes a number to an object, with no check of access and rules; of a number that is too large, the low bytes.
#[inline(never)]
pub fn put_number<D: Dictionary>(dictionary: &mut D, index: u16, sub: u8, number: i64) {
    if let Ok(entry) = od::find::<D>(index, sub)
        && let Some(bytes) = number.to_le_bytes().get(..usize::from(entry.size()))
    {
        od::put(dictionary, entry, bytes);
    }
}
