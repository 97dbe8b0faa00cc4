//! CiA 302: what a CANopen network needs beside its devices. A slave has one object of it, the NMT [`startup`].

pub mod startup;
