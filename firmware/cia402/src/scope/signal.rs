//! What can be recorded: the values that a control tick has at hand, by the objects that show them.

use motion::low;

/// Hands the table to the macro of this name: a value, its object, its length in bits, how to read it, with which feature of the crate it is there, and where it comes
/// from in a tick ([`crate::exchange::TickResult`]).
macro_rules! every_signal {
    ($make:ident) => {
        $make! {
            /// 2034h:1.
            HomingReferenced 0x2034 1 8 Unsigned |tick| tick.actuals.referenced.into();
            /// 2034h:2.
            HomingFailure 0x2034 2 8 Unsigned |tick| tick.actuals.homing_failure.into();
            /// 603Fh.
            ErrorCode 0x603F 0 16 Unsigned |tick| tick.actuals.error_code.into();
            /// 6040h, as the tick took it.
            Controlword 0x6040 0 16 Unsigned |tick| tick.commands.controlword.into();
            /// 6041h.
            Statusword 0x6041 0 16 Unsigned |tick| tick.actuals.statusword.into();
            /// 6043h.
            VlVelocityDemand 0x6043 0 16 Signed |tick| tick.actuals.vl_velocity_demand.cast_unsigned().into();
            /// 6044h.
            VlVelocityActualValue 0x6044 0 16 Signed |tick| tick.actuals.vl_velocity_actual.cast_unsigned().into();
            /// 6061h.
            ModesOfOperationDisplay 0x6061 0 8 Signed |tick| tick.actuals.mode_display.cast_unsigned().into();
            /// 6062h.
            PositionDemandValue 0x6062 0 32 Signed |tick| tick.actuals.position_demand.cast_unsigned();
            /// 6063h.
            PositionActualInternalValue 0x6063 0 32 Signed |tick| tick.actuals.position_actual_internal.cast_unsigned();
            /// 6064h.
            PositionActualValue 0x6064 0 32 Signed |tick| tick.actuals.position_actual.cast_unsigned();
            /// 606Bh.
            VelocityDemandValue 0x606B 0 32 Signed |tick| tick.actuals.velocity_demand.cast_unsigned();
            /// 606Ch.
            VelocityActualValue 0x606C 0 32 Signed |tick| tick.actuals.velocity_actual.cast_unsigned();
            /// 6074h.
            TorqueDemand 0x6074 0 16 Signed with "torque" |tick| tick.actuals.torque.demand.cast_unsigned().into();
            /// 6077h.
            TorqueActualValue 0x6077 0 16 Signed with "torque" |tick| tick.actuals.torque.actual.cast_unsigned().into();
            /// 6078h.
            CurrentActualValue 0x6078 0 16 Signed with "torque" |tick| tick.actuals.torque.current.cast_unsigned().into();
            /// 607Ah, as the tick took it.
            TargetPosition 0x607A 0 32 Signed |tick| tick.commands.target_position.cast_unsigned();
            /// 60F4h.
            FollowingErrorActualValue 0x60F4 0 32 Signed |tick| tick.actuals.following_error.cast_unsigned();
            /// 60FDh.
            DigitalInputs 0x60FD 0 32 Unsigned |tick| tick.actuals.digital_inputs;
            /// 60FFh, as the tick took it: in user units, rounded to increments and back.
            TargetVelocity 0x60FF 0 32 Signed |tick| tick.units.velocity_in_units(tick.commands.target_velocity).cast_unsigned();
        }
    };
}

pub(crate) use every_signal;

/// How the bits of a value are to be read.
#[derive(Clone, Copy)]
enum Kind {
    Unsigned,
    Signed,
}

/// Makes the list.
macro_rules! signals {
    ($($(#[$doc:meta])* $signal:ident $index:literal $sub:literal $bits:literal $kind:ident $(with $feature:tt)? |$tick:ident| $value:expr;)*) => {
        /// A value that can be recorded.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Signal {
            $($(#[$doc])* $(#[cfg(feature = $feature)])? $signal,)*
        }

        impl Signal {
            /// All of them, by their objects.
            pub const ALL: &[Self] = &[$($(#[cfg(feature = $feature)])? Self::$signal,)*];

            /// The value that a mapping names: index, sub-index and length in bits as in a PDO mapping (CiA 301, 1600h). `None` if that
            /// is no value of a control tick, or has another length.
            pub const fn mapped(mapping: u32) -> Option<Self> {
                match mapping {
                    $($(#[cfg(feature = $feature)])? mapping if mapping == Self::$signal.mapping() => Some(Self::$signal),)*
                    _ => None,
                }
            }

            /// Its mapping.
            pub const fn mapping(self) -> u32 {
                match self {
                    $($(#[cfg(feature = $feature)])? Self::$signal => $index << 16 | $sub << 8 | $bits,)*
                }
            }

            const fn kind(self) -> Kind {
                match self {
                    $($(#[cfg(feature = $feature)])? Self::$signal => Kind::$kind,)*
                }
            }
        }
    };
}

every_signal!(signals);

impl Signal {
    /// Its length in bits: 8, 16 or 32.
    pub const fn length(self) -> u32 {
        self.mapping() & 0xFF
    }

    /// Its bits as the number they are.
    pub const fn number(self, bits: u32) -> i64 {
        match (self.kind(), self.length()) {
            (Kind::Unsigned, _) => bits as i64,
            (Kind::Signed, 8) => low::u8(bits).cast_signed() as i64,
            (Kind::Signed, 16) => low::u16(bits).cast_signed() as i64,
            (Kind::Signed, _) => bits.cast_signed() as i64,
        }
    }
}
