//! What the drives of a maker do in their own way where CiA 402-2 says otherwise or leaves it open, known when the drive is compiled.

/// Where node-ID, bit rate and serial number are objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetworkObjects {
    /// The node-ID that is stored: index and sub-index.
    pub node_id: (u16, u8),
    /// The bit rate that is stored.
    pub bit_rate: (u16, u8),
    /// The numbers that stand for bit rates in it, each with its index of the LSS bit timing table 0; none if they are these indices.
    pub bit_rates: &'static [(u32, u8)],
    /// Where the serial number is beside 1018h:4; (0, 0) if it is nowhere else.
    pub serial_number: (u16, u8),
}

impl NetworkObjects {
    /// Those of the generic drive.
    pub const OWN: Self = Self {
        node_id: (0x5FF0, 1),
        bit_rate: (0x5FF0, 2),
        bit_rates: &[],
        serial_number: (0, 0),
    };

    /// Whether they are those of the generic drive.
    pub const fn are_own(&self) -> bool {
        self.node_id.0 == Self::OWN.node_id.0 && self.bit_rate.0 == Self::OWN.bit_rate.0
    }
}

/// The ways of a drive: [`Habits::STANDARD`], unless the binding of its data sheet says otherwise. The rule that a habit changes
/// asks for it, and costs nothing where it is the standard's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Habits {
    /// Bit 4 of the statusword is 1 from switched on on, and not as soon as there is a supply.
    pub voltage_needs_power: bool,
    /// There is current in the motor from switched on on, and the brake opens then; else from operation enabled on.
    pub power_when_switched_on: bool,
    /// Bit 5 of the statusword is 1 in switch on disabled: no quick stop is active. CiA 402-2 leaves it open there.
    pub quick_stop_bit_while_disabled: bool,
    /// Bit 9 of the statusword is 1 whatever the network does.
    pub is_always_remote: bool,
    /// A set-point of profile position that finds another one waiting takes its place; else it is not taken.
    pub third_set_point_replaces: bool,
    /// Bits 4 to 6 of the controlword mean nothing in velocity mode: the motor runs in operation enabled.
    pub velocity_without_ramp_bits: bool,
    /// A following error is told by bit 13 of the statusword alone, and is no fault.
    pub following_error_is_told: bool,
    /// Without a supply the drive does not leave switch on disabled.
    pub supply_gates_ready: bool,
    /// 6082h is the speed with which a move of profile position begins and ends, at once; else the velocity at its target.
    pub start_speed: bool,
    /// Node-ID, bit rate and serial number are these objects.
    pub network: NetworkObjects,
    /// Bit 8 of the statusword tells that the control tick is locked to SYNC.
    pub lock_is_bit_8: bool,
    /// 604Ch makes revolutions of the motor per minute of the units of velocity mode; else steps/s.
    pub velocity_in_rpm: bool,
    /// Bit 6 of 607Eh turns velocity mode around too.
    pub velocity_has_polarity: bool,
    /// Its module may tell the level of the home switch in place of an input.
    pub home_switch_elsewhere: bool,
    /// Its module has an output that rises at positions.
    pub compares_positions: bool,
}

impl Habits {
    /// As CiA 402-2 says.
    pub const STANDARD: Self = Self {
        voltage_needs_power: false,
        power_when_switched_on: false,
        quick_stop_bit_while_disabled: false,
        is_always_remote: false,
        third_set_point_replaces: false,
        velocity_without_ramp_bits: false,
        following_error_is_told: false,
        supply_gates_ready: false,
        start_speed: false,
        network: NetworkObjects::OWN,
        lock_is_bit_8: false,
        velocity_in_rpm: false,
        velocity_has_polarity: false,
        home_switch_elsewhere: false,
        compares_positions: false,
    };
}
