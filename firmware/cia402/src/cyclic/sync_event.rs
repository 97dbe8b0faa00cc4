//! A sync event: the moment of a SYNC and the set-points that hold at it.

use canopen::Instant;
use motion::SignedSpeed;

/// A SYNC, or a set-point that came where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncEvent {
    /// When it arrived.
    pub at: Instant,
    /// It is a SYNC.
    pub is_sync: bool,
    /// 607Ah plus 60B0h in user units, if 607Ah was written since the sync event before.
    pub position: Option<i32>,
    /// 60FFh plus 60B1h, if 60FFh was written since the sync event before.
    pub velocity: Option<SignedSpeed>,
    /// 6071h plus 60B2h in thousandths of the rated torque, if 6071h was written since the sync event before.
    pub torque: Option<i16>,
}
