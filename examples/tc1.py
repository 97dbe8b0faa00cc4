#!/usr/bin/env python3
"""Puts a TC1 into service as its manual does: node-ID by LSS, heartbeat, RPDO 2 switched on, a move by PDO, everything stored.

    tc1.py --interface slcan --channel socket://127.0.0.1:2402

It needs `pip install canopen pyserial`. A drive to try it on: `cargo run -- serve --product tc1 --slcan 127.0.0.1:2402`.
"""

import argparse
import struct
import time

import canopen

NODE = 1


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


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--interface", required=True)
    parser.add_argument("--channel", required=True)
    arguments = parser.parse_args()
    network = canopen.Network()
    network.connect(interface=arguments.interface, channel=arguments.channel, bitrate=1_000_000)
    drive = network.add_node(NODE, "products/tc1/tc1.eds")
    drive.sdo.RESPONSE_TIMEOUT = 3

    # Chapter 4: the node-ID by CiA 305, to the only drive on the bus.
    network.lss.RESPONSE_TIMEOUT = 3
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    network.lss.configure_node_id(NODE)
    network.lss.store_configuration()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    until_there(drive)
    print(f"{drive.sdo[0x1008].raw}, vendor {drive.sdo[0x1018][1].raw:X}h")

    # Chapters 5 to 7: heartbeat, and RPDO 2 (controlword and target position) switched on.
    drive.sdo[0x1017].raw = 100
    drive.sdo[0x1401][1].raw = 0x300 + NODE
    drive.nmt.send_command(0x01)
    drive.nmt.wait_for_heartbeat(2)

    drive.sdo[0x6060].raw = 1
    for controlword, state in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
        network.send_message(0x300 + NODE, struct.pack("<Hi", controlword, 0))
        until(drive, 0x6F, state)
    for target in (10_000, 0):
        network.send_message(0x300 + NODE, struct.pack("<Hi", 0x1F, target))
        until(drive, 0x1000, 0x1000)
        network.send_message(0x300 + NODE, struct.pack("<Hi", 0x0F, target))
        until(drive, 0x1400, 0x0400)
        print(f"at {drive.sdo[0x6064].raw}, status register {drive.sdo[0x1002].raw:08X}h")
    network.send_message(0x300 + NODE, struct.pack("<Hi", 0x00, 0))
    until(drive, 0x4F, 0x40)

    # Chapter 12: everything is stored.
    drive.sdo[0x1010][1].raw = int.from_bytes(b"save", "little")
    print("stored")
    network.disconnect()


if __name__ == "__main__":
    main()
