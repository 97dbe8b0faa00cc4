//! Why a transfer was refused: the SDO abort codes of CiA 301 (table 22). Every error of the device maps to one of
//! these, here.

/// An SDO abort code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[non_exhaustive]
pub enum AbortCode {
    /// Toggle bit not alternated.
    ToggleNotAlternated = 0x0503_0000,
    /// SDO protocol timed out.
    TimedOut = 0x0504_0000,
    /// Client/server command specifier not valid or unknown.
    InvalidCommand = 0x0504_0001,
    /// Invalid block size.
    InvalidBlockSize = 0x0504_0002,
    /// Invalid sequence number.
    InvalidSequenceNumber = 0x0504_0003,
    /// CRC error.
    CrcError = 0x0504_0004,
    /// Out of memory.
    OutOfMemory = 0x0504_0005,
    /// Unsupported access to an object.
    UnsupportedAccess = 0x0601_0000,
    /// Attempt to read a write only object.
    WriteOnly = 0x0601_0001,
    /// Attempt to write a read only object.
    ReadOnly = 0x0601_0002,
    /// Object does not exist.
    NoObject = 0x0602_0000,
    /// Object cannot be mapped to the PDO.
    NotMappable = 0x0604_0041,
    /// Number and length of the objects to be mapped would exceed PDO length.
    PdoLengthExceeded = 0x0604_0042,
    /// General parameter incompatibility.
    ParameterIncompatible = 0x0604_0043,
    /// Access failed due to a hardware error.
    HardwareError = 0x0606_0000,
    /// Data type does not match, length of service parameter does not match.
    LengthMismatch = 0x0607_0010,
    /// Length of service parameter too high.
    LengthTooHigh = 0x0607_0012,
    /// Length of service parameter too low.
    LengthTooLow = 0x0607_0013,
    /// Sub-index does not exist.
    NoSubIndex = 0x0609_0011,
    /// Invalid value for parameter.
    InvalidValue = 0x0609_0030,
    /// Value of parameter written too high.
    ValueTooHigh = 0x0609_0031,
    /// Value of parameter written too low.
    ValueTooLow = 0x0609_0032,
    /// General error.
    General = 0x0800_0000,
    /// Data cannot be transferred or stored to the application.
    NotTransferable = 0x0800_0020,
    /// ... because of the present device state.
    DeviceState = 0x0800_0022,
    /// No data available.
    NoData = 0x0800_0024,
    /// A maker's own: his buffer is full.
    BufferFull = 0xFF03_0000,
    /// A maker's own: his last command is still being carried out.
    CommandBusy = 0xFF04_0000,
}

impl AbortCode {
    /// The number on the bus.
    pub const fn get(self) -> u32 {
        self as u32
    }
}
