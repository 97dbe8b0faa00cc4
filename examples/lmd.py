#!/usr/bin/env python3
"""Puts a Lexium MDrive into service as its manual does: LSS gives it a node-ID, then it homes on the spot, moves to a position and runs at a velocity.

    lmd.py --interface slcan --channel socket://127.0.0.1:2402

It needs `pip install canopen pyserial`. A drive to try it on: `cargo run -- serve --product lmd --slcan 127.0.0.1:2402`.
"""

import argparse
import time

import canopen

#: The node-ID that it gets; it leaves the factory with 41h.
OWN = 0x42

#: Microsteps in a revolution.
REVOLUTION = 51_200


def until_there(drive):
    """Waits for a drive that boots: until it answers."""
    patience, drive.sdo.RESPONSE_TIMEOUT = drive.sdo.RESPONSE_TIMEOUT, 0.2
    for last in range(50):
        try:
            drive.sdo.upload(0x1000, 0)
            break
        except canopen.SdoCommunicationError:
            assert last < 49, "it does not answer"
    drive.sdo.RESPONSE_TIMEOUT = patience


def until(drive, mask, value, seconds=20):
    """Waits for bits of the statusword."""
    end = time.monotonic() + seconds
    while (word := drive.sdo[0x6041].raw) & mask != value:
        assert time.monotonic() < end, f"statusword {word:04X}h"
        time.sleep(0.01)


def enable(drive):
    """Through the states to operation enabled."""
    for controlword, state in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
        drive.sdo[0x6040].raw = controlword
        until(drive, 0x6F, state)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--interface", required=True)
    parser.add_argument("--channel", required=True)
    arguments = parser.parse_args()
    network = canopen.Network()
    network.connect(interface=arguments.interface, channel=arguments.channel, bitrate=1_000_000)

    # Chapter 5: the only drive on the bus, in the configuration state, gets its node-ID, which counts at once.
    network.lss.RESPONSE_TIMEOUT = 3
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    network.lss.configure_node_id(OWN)
    network.lss.store_configuration()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)

    drive = network.add_node(OWN, "products/lmd/lmd.eds")
    drive.sdo.RESPONSE_TIMEOUT = 3
    until_there(drive)
    print(f"node {OWN:02X}h: {drive.sdo[0x1008].raw}, serial {drive.sdo[0x1018][4].raw}")

    drive.sdo[0x2204].raw, drive.sdo[0x2205].raw = 50, 5
    drive.sdo[0x6060].raw = 6
    drive.sdo[0x6098].raw = 35
    enable(drive)
    drive.sdo[0x6040].raw = 0x1F
    until(drive, 0x1000, 0x1000)
    drive.sdo[0x6040].raw = 0x0F
    print("homed on the spot")

    drive.sdo[0x6060].raw = 1
    drive.sdo[0x6081].raw = REVOLUTION
    drive.sdo[0x6083].raw = drive.sdo[0x6084].raw = 2 * REVOLUTION
    for turns in (1, -1, 0):
        drive.sdo[0x607A].raw = turns * REVOLUTION
        drive.sdo[0x6040].raw = 0x1F
        until(drive, 0x1000, 0x1000)
        drive.sdo[0x6040].raw = 0x0F
        until(drive, 0x1400, 0x0400)
        print(f"at {drive.sdo[0x6064].raw} microsteps")

    drive.sdo[0x6060].raw = 3
    drive.sdo[0x60FF].raw = REVOLUTION
    until(drive, 0x0400, 0x0400)
    print(f"runs at {drive.sdo[0x606C].raw} microsteps/s")
    drive.sdo[0x60FF].raw = 0
    until(drive, 0x1000, 0x1000)
    drive.sdo[0x6040].raw = 0x00
    until(drive, 0x4F, 0x40)
    print("off")
    network.disconnect()


if __name__ == "__main__":
    main()
