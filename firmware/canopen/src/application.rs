//! What the device asks of the firmware around it when an object is written.
//! A generated dictionary has the same with types, two methods for each object that can be written (its trait `Hooks`, which
//! `Hooked` makes an [`Application`] of).
//!
//! A device whose outputs must never be on all at once, and that counts how often they were written:
//!
//! ```
//! use canopen::cia301::nmt::Reset;
//! use canopen::cia301::sdo::AbortCode;
//! use canopen::od::Entry;
//! use canopen::{Application, BitRate, Frame, Instant, Node, NodeId, Settings};
//! # mod dictionary {
//! #     include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/io_device/dictionary.rs"));
//! # }
//! use dictionary::Dictionary; // made from a data sheet by `od-gen`
//!
//! struct Outputs {
//!     writes: u32,
//! }
//!
//! impl Application<Dictionary> for Outputs {
//!     fn validate(&mut self, _: &Dictionary, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
//!         match (entry.index, entry.sub, value) {
//!             (0x6200, 1, [0xFF]) => Err(AbortCode::InvalidValue),
//!             _ => Ok(()),
//!         }
//!     }
//!
//!     fn written(&mut self, _: &mut Dictionary, entry: &Entry) {
//!         self.writes += u32::from(entry.index == 0x6200);
//!     }
//! }
//!
//! let settings = Settings { node_id: NodeId::new(5).unwrap(), bit_rate: BitRate::Kbit500 };
//! let mut node = Node::new(Dictionary::new(), settings);
//! let (mut outputs, now) = (Outputs { writes: 0 }, Instant::from_ticks(0));
//! node.boot(Reset::Node, now, &mut outputs);
//! // An SDO client writes 6200h:1, first 0Fh, then FFh: 06090030h, invalid value.
//! for value in [0x0F, 0xFF] {
//!     let request = [0x2F, 0x00, 0x62, 1, value, 0, 0, 0];
//!     node.receive(&Frame::data_frame(0x605, &request), now, &mut outputs);
//! }
//! assert_eq!(node.dictionary().digital_outputs_1_to_8(), 0x0F);
//! assert_eq!(outputs.writes, 1);
//! let boot_up = node.transmit(&mut outputs);
//! assert_eq!(boot_up, Some(Frame::data_frame(0x705, &[0])));
//! let answers = [node.transmit(&mut outputs).unwrap(), node.transmit(&mut outputs).unwrap()];
//! assert_eq!(*answers[0].bytes(), [0x60, 0x00, 0x62, 1, 0, 0, 0, 0]);
//! assert_eq!(*answers[1].bytes(), [0x80, 0x00, 0x62, 1, 0x30, 0x00, 0x09, 0x06]);
//! ```

use crate::od::{Dictionary, Entry};
use crate::wire::sdo::AbortCode;

/// The application's word on its own objects (everything outside 1000h to 1FFFh, and there the clock 1013h and the operating system, 1023h to
/// 1026h). The calls are short and never wait.
///
/// An object with [`Attributes::STREAMED`](crate::od::Attributes::STREAMED) has no bytes in the dictionary: the application gives and takes its value piece by piece, at
/// positions in bytes from 0. One client at a time writes an object, and none begins or ends a write while another one reads it:
/// it is refused with 08000022h, and the reader gets one value whole. A transfer that has begun may end without a word to the reader of it; the writer learns by
/// [`Application::end_write`] or [`Application::abandon_write`]. A number among them (an element of a large array) is read by one
/// [`Application::read_at`] of all its bytes, and written by one [`Application::write_at`] after its length, its limits and
/// [`Application::validate`].
pub trait Application<D: Dictionary> {
    /// Whether [`Application::written`] may change the dictionary. If it never does, transmit PDOs are not compared with it after
    /// every receive PDO, but only after one that writes what they map.
    const WRITES_BACK: bool = true;

    /// The last check of a write that passed every rule of the dictionary (existence, access, length, limits). `value` is
    /// what was sent, little-endian. Nothing has changed yet. By SDO an error is sent as the abort code; of a receive
    /// PDO, the object keeps its value and the others are written.
    fn validate(&mut self, dictionary: &D, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
        let _ = (dictionary, entry, value);
        Ok(())
    }

    /// An object was written, by SDO or by a receive PDO; the dictionary holds the new value. For a PDO this is called
    /// for each mapped object after all of them have been copied.
    fn written(&mut self, dictionary: &mut D, entry: &Entry) {
        let _ = (dictionary, entry);
    }

    /// Whether the write that [`Application::written`] has just been told of is done. With [`Completion::Later`] the answer to an SDO
    /// waits for [`Node::complete_write`](crate::Node::complete_write), as for a value that is being stored.
    fn completion(&mut self, dictionary: &D, entry: &Entry) -> Completion {
        let _ = (dictionary, entry);
        Completion::Now
    }

    /// A client begins to read a streamed object: its present size in bytes, or `None` if that is not known before its end.
    ///
    /// # Errors
    /// The object cannot be read, or not now. By default 06010000h, unsupported access.
    fn size(&mut self, dictionary: &D, entry: &Entry) -> Result<Option<u32>, AbortCode> {
        let _ = (dictionary, entry);
        Err(AbortCode::UnsupportedAccess)
    }

    /// Puts the bytes of a streamed object from `position` on into `into`, and returns how many those are: fewer than there is
    /// room for only where the value ends. It is asked for more than one segment at once. Lost segments are sent again, so a position may be asked for
    /// more than once, and its bytes stay what they were until the next [`Application::size`].
    ///
    /// # Errors
    /// The value cannot be read further; the transfer ends with this code.
    fn read_at(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        let _ = (dictionary, entry, position, into);
        Err(AbortCode::UnsupportedAccess)
    }

    /// A client begins to write a streamed object, with so many bytes if it has told.
    ///
    /// # Errors
    /// The object cannot be written, not now, or not with this size. By default 06010000h, unsupported access.
    fn begin_write(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        size: Option<u32>,
    ) -> Result<(), AbortCode> {
        let _ = (dictionary, entry, size);
        Err(AbortCode::UnsupportedAccess)
    }

    /// The next bytes of a streamed object. Each position comes once, in order.
    ///
    /// # Errors
    /// The transfer ends with this code; [`Application::abandon_write`] is not called.
    fn write_at(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        let _ = (dictionary, entry, position, data);
        Err(AbortCode::UnsupportedAccess)
    }

    /// All `length` bytes of a streamed object have been written, and what the protocol can check is right. With
    /// [`Completion::Later`] the answer waits for [`Node::complete_write`](crate::Node::complete_write).
    ///
    /// # Errors
    /// The value is refused.
    fn end_write(
        &mut self,
        dictionary: &mut D,
        entry: &Entry,
        length: u32,
    ) -> Result<Completion, AbortCode> {
        let _ = (dictionary, entry, length);
        Ok(Completion::Now)
    }

    /// The client has given up, or has fallen silent: what [`Application::begin_write`] has begun will not be ended.
    fn abandon_write(&mut self, dictionary: &D, entry: &Entry) {
        let _ = (dictionary, entry);
    }

    /// Power-on values have just been loaded (reset node): put in what only the firmware knows, such as the serial number.
    fn power_on(&mut self, dictionary: &mut D) {
        let _ = dictionary;
    }
}

/// When a write that was not refused is complete, and the client gets its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Completion {
    /// At once.
    Now,
    /// When the owner of the object says so ([`Node::complete_write`](crate::Node::complete_write)): saving parameters takes a while. The server
    /// waits without a time-out; an abort or a new request of the client drops the answer, not the work. An owner that
    /// is asked for the same again before it is done refuses with [`AbortCode::DeviceState`].
    Later,
}

/// No application: plain objects, for tests and simple devices.
impl<D: Dictionary> Application<D> for () {
    const WRITES_BACK: bool = false;
}
