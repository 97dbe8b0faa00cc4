//! What may be asked of motor and stage, and when it must end.
//!
//! Each subject is a file: the heat of a current above the rated one, the voltage of the bus, temperatures, a rotor that does not turn, and a phase
//! that carries nothing. What they say is combined by the least of their limits and the first of their faults.

pub mod blocked;
pub mod bus;
pub mod phase_loss;
pub mod temperature;
pub mod thermal;

pub use blocked::Blocked;
pub use bus::Bus;
pub use phase_loss::PhaseLoss;
pub use temperature::Derating;
pub use thermal::Thermal;
