//! Rules of the communication profile, CiA 301.

pub(super) mod cob_id;
pub(super) mod device_info;
pub(super) mod device_type;
pub(super) mod error_control;
pub(super) mod mapping;
pub(super) mod pdo;
pub(super) mod predefined;
pub(super) mod storage;
pub(super) mod sync;
