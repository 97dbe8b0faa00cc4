//! What a drive has of all that `cia402` can do, known when it is compiled.
//!
//! A mode or a part of the periphery whose objects the data sheet does not list is never asked for. So its code is left out, and costs no
//! flash. Nothing changes on the bus: what does not exist is answered as such, and 6060h refuses a mode that is not there.

use crate::Parameter;

/// The modes, by their bits in 6502h, each with what commands it.
const COMMANDED_BY: [(u32, Parameter); 9] = [
    (1 << 0, Parameter::TargetPosition),
    (1 << 1, Parameter::VlTargetVelocity),
    (1 << 2, Parameter::TargetVelocity),
    (1 << 3, Parameter::TargetTorque),
    (1 << 5, Parameter::HomingMethod),
    (1 << 6, Parameter::InterpolationRecord),
    (1 << 7, Parameter::TargetPosition),
    (1 << 8, Parameter::TargetVelocity),
    (1 << 9, Parameter::TargetTorque),
];

/// The modes of torque, profile (4) and cyclic synchronous (10), by their bits in 6502h.
pub const TORQUE_MODES: u32 = 1 << 3 | 1 << 9;

/// The bits of all of them.
const fn every_mode() -> u32 {
    let mut modes = 0;
    let mut rest: &[(u32, Parameter)] = &COMMANDED_BY;
    while let [(bit, _), others @ ..] = rest {
        modes |= *bit;
        rest = others;
    }
    modes
}

/// What makes units others than increments.
const UNITS: [Parameter; 15] = [
    Parameter::PositionEncoderIncrements,
    Parameter::PositionEncoderRevolutions,
    Parameter::VelocityEncoderIncrements,
    Parameter::VelocityEncoderRevolutions,
    Parameter::GearMotorRevolutions,
    Parameter::GearShaftRevolutions,
    Parameter::Feed,
    Parameter::FeedShaftRevolutions,
    Parameter::VelocityFactorNumerator,
    Parameter::VelocityFactorDivisor,
    Parameter::AccelerationFactorNumerator,
    Parameter::AccelerationFactorDivisor,
    Parameter::Polarity,
    Parameter::MinPositionRangeLimit,
    Parameter::MaxPositionRangeLimit,
];

/// The parts of a drive: what is not there is not compiled into it. `od-gen` finds them with [`Features::of`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Features {
    /// The modes, bits as in 6502h.
    pub modes: u32,
    /// 60B8h.
    pub touch_probes: bool,
    /// 60FEh, or functions of outputs.
    pub digital_outputs: bool,
    /// 2064h.
    pub analogue_input: bool,
    /// 2070h.
    pub motor_current: bool,
    /// 2073h and 2074h.
    pub power_stage: bool,
    /// The scope, 20D0h.
    pub scope: bool,
    /// 607Bh, 607Eh, or an object of the factor group. Without them a unit is an increment.
    pub units: bool,
    /// 60C0h. Without it the way between set-points is a straight line.
    pub cubic_interpolation: bool,
    /// 60F2h, or a product's module, which commands them without it.
    pub positioning_options: bool,
}

impl Features {
    /// A drive with everything that pulses can do: a torque takes another actuator.
    pub const ALL: Self = Self {
        modes: every_mode() & !TORQUE_MODES,
        touch_probes: true,
        digital_outputs: true,
        analogue_input: true,
        motor_current: true,
        power_stage: true,
        scope: true,
        units: true,
        cubic_interpolation: true,
        positioning_options: true,
    };

    /// Those of a drive with these parameters, with this 6502h, and with or without a scope.
    pub fn of(offered: &[Parameter], supported_drive_modes: u32, scope: bool) -> Self {
        let has = |parameter| offered.contains(&parameter);
        let modes = COMMANDED_BY.iter().filter(|(_, by)| has(*by));
        Self {
            modes: supported_drive_modes & modes.fold(0, |modes, (bit, _)| modes | bit),
            touch_probes: has(Parameter::TouchProbeFunction),
            digital_outputs: has(Parameter::DigitalOutputs) || has(Parameter::Output1Function),
            analogue_input: has(Parameter::AnalogueInputRaw)
                || has(Parameter::AnalogueInputVoltage)
                || has(Parameter::AnalogueInputFiltered),
            motor_current: has(Parameter::RunCurrent) || has(Parameter::HoldCurrent),
            power_stage: has(Parameter::UnderVoltageFault)
                || has(Parameter::UnderVoltageWarning)
                || has(Parameter::OverVoltageWarning)
                || has(Parameter::OverVoltageFault)
                || has(Parameter::TemperatureWarning)
                || has(Parameter::OverTemperatureFault),
            scope,
            units: UNITS.into_iter().any(has),
            cubic_interpolation: has(Parameter::InterpolationSubMode),
            positioning_options: has(Parameter::PositioningOptionCode),
        }
    }
}
