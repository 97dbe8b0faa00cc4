//! A driver with bridges of its own that takes pulse widths, an enable and no words (DRV8412 and
//! its like): one line tells that it has shut itself off, and why is not told.

/// Error code 5400h of CiA 402: the hardware of the power section.
const POWER_SECTION: u16 = 0x5400;

/// Ticks of a millisecond from the supply on until its line says something.
const SETTLING: u8 = 20;

/// See the module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BridgeDriver {
    /// Ticks with a supply, up to [`SETTLING`].
    fed: u8,
    is_faulty: bool,
}

impl BridgeDriver {
    /// Without a supply.
    pub const fn new() -> Self {
        Self {
            fed: 0,
            is_faulty: false,
        }
    }

    /// A tick of a millisecond: whether its line has told of no fault since the last one, and
    /// whether it has its supply. Without that it tells of faults that are none.
    pub fn tick(&mut self, is_well: bool, is_fed: bool) {
        if !is_fed {
            *self = Self::new();
        } else if self.is_set_up() {
            self.is_faulty |= !is_well;
        } else {
            self.fed += 1;
        }
    }

    /// It has had its supply for long enough. Before that its faults are to be forgotten.
    pub fn is_set_up(&self) -> bool {
        self.fed >= SETTLING
    }

    /// The bridges may be enabled.
    pub fn is_ready(&self) -> bool {
        self.is_set_up() && !self.is_faulty
    }

    /// A fault as an error code of CiA 402. It stays until [`BridgeDriver::mend`].
    pub fn fault(&self) -> Option<u16> {
        self.is_faulty.then_some(POWER_SECTION)
    }

    /// What had latched in it is cleared, by an edge of its enable.
    pub fn mend(&mut self) {
        self.is_faulty = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled() -> BridgeDriver {
        let mut driver = BridgeDriver::new();
        for _ in 0..SETTLING {
            assert!(!driver.is_ready());
            // What it says meanwhile is nothing.
            driver.tick(false, true);
        }
        driver
    }

    #[test]
    fn it_is_ready_once_it_has_had_its_supply_for_a_while() {
        let mut driver = settled();
        driver.tick(true, true);
        assert!(driver.is_ready() && driver.fault().is_none());
        driver.tick(false, false);
        assert!(!driver.is_set_up() && driver.fault().is_none());
    }

    #[test]
    fn a_fault_that_is_over_is_told_until_it_is_mended() {
        let mut driver = settled();
        driver.tick(false, true);
        driver.tick(true, true);
        assert_eq!(driver.fault(), Some(POWER_SECTION));
        assert!(driver.is_set_up() && !driver.is_ready());
        driver.mend();
        driver.tick(true, true);
        assert!(driver.is_ready());
        driver.tick(false, true);
        driver.mend();
        driver.tick(false, true);
        assert_eq!(driver.fault(), Some(POWER_SECTION), "it is still there");
    }
}
