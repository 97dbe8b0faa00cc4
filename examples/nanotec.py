#!/usr/bin/env python3
"""Puts a Nanotec SMCI into service as its manual does: defaults, currents, feed constant, then velocity mode and profile position.

    nanotec.py --interface slcan --channel socket://127.0.0.1:2402

It needs `pip install canopen pyserial`. A drive to try it on: `cargo run -- serve --product nanotec --slcan 127.0.0.1:2402`.
"""

import argparse
import time

import canopen

#: Its rotary switch stands at 1: node-ID 1 and 1 Mbit/s.
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
    drive = network.add_node(NODE, "products/nanotec/nanotec.eds")
    drive.sdo.RESPONSE_TIMEOUT = 10

    # 1.1.3: defaults first, then what the motor needs. A reset makes the defaults count.
    drive.sdo[0x1011][1].raw = int.from_bytes(b"load", "little")
    drive.nmt.send_command(0x81)
    until_there(drive)
    drive.sdo[0x2004][1].raw = 40
    drive.sdo[0x2004][2].raw = 20
    drive.sdo[0x1010][1].raw = int.from_bytes(b"save", "little")
    print(f"device type {drive.sdo[0x1000].raw}, current {drive.sdo[0x2004][1].raw} %")

    # 2.1: start, state machine, mode, motion. Velocity mode runs with 000Fh; bit 8 halts it.
    drive.nmt.send_command(0x01)
    drive.sdo[0x6060].raw = 2
    enable(drive)
    drive.sdo[0x6042].raw = 500
    time.sleep(1.5)
    assert drive.sdo[0x6044].raw == 500
    print("runs at 500")
    drive.sdo[0x6040].raw = 0x010F
    while drive.sdo[0x6044].raw:
        time.sleep(0.05)
    print("halted")
    drive.sdo[0x6040].raw = 0x0000
    until(drive, 0x4F, 0x40)

    drive.sdo[0x6060].raw = 1
    enable(drive)
    start = drive.sdo[0x6064].raw
    for target in (start + 2_000, start):
        drive.sdo[0x607A].raw = target
        drive.sdo[0x6040].raw = 0x1F
        until(drive, 0x1000, 0x1000)
        drive.sdo[0x6040].raw = 0x0F
        until(drive, 0x1400, 0x0400)
        print(f"{drive.sdo[0x6064].raw - start} from where it began")
    drive.sdo[0x6040].raw = 0x00
    print("off")
    network.disconnect()


if __name__ == "__main__":
    main()
