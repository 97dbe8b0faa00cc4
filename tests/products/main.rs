//! The drives of other makers: their motors move, the worked sequences of their manuals play, and each capability has what shows it.

/// Tests of what several products promise: a function for each, and the products that do.
macro_rules! promises {
    ($($what:ident: $($product:ident)*;)*) => {$(
        #[test]
        fn $what() {
            $(super::$what(stringify!($product));)*
        }
    )*};
}

mod behaviour;
mod bench;
mod bus;
mod capabilities;
mod cyclic;
mod gearing;
mod hmt;
mod homing;
mod lmd;
mod lmd_errors;
mod lmd_motion;
mod motion;
mod moves;
mod nanotec;
mod nanotec_gains;
mod nanotec_loop;
mod objects;
mod pdos;
mod periphery;
mod promises;
mod prompt;
mod refusals;
mod s200_commands;
mod s200_homing;
mod s200_loops;
mod s200_registers;
mod s200_servo;
mod s200_status;
mod s200_supply;
mod s200_warnings;
mod scenes;
mod sequences;
mod settings;
mod speeds;
mod steer;
mod storage;
mod tasks;
mod tc1;
mod transfers;
