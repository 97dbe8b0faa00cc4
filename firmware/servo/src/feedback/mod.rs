//! Where the rotor is: sensors become an electrical angle, a speed, and a count that goes on.

pub mod absolute;
pub mod commutation;
pub mod hall;
pub mod incremental;
pub mod observer;

pub use absolute::Absolute;
pub use commutation::Commutation;
pub use hall::Hall;
pub use incremental::Incremental;
pub use observer::Observer;

/// What is wrong with a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedbackFault {
    /// The index came where no turn ends: counts were lost or made up, or its wire is broken.
    CountsLost,
    /// An angle that the rotor cannot have come to in the time.
    Jump,
    /// Hall sensors that all say the same, or are not where the encoder is: a wire is broken.
    Hall,
}
