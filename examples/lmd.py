#!/usr/bin/env python3
"""Puts a Lexium MDrive into service as its manual does: LSS gives it a node-ID, then it homes on the spot, moves to a position and runs at a velocity.

    lmd.py --interface slcan --channel socket://127.0.0.1:2402

It needs `pip install canopen pyserial`. A drive to try it on: `cargo run -- serve --product lmd --slcan 127.0.0.1:2402`.
"""

from drive import add, connect, enable, give_node_id, move, until, until_there

#: The node-ID that it gets; it leaves the factory with 41h.
OWN = 0x42

#: Microsteps in a revolution.
REVOLUTION = 51_200


def main():
    network = connect(__doc__)

    # Chapter 5: the only drive on the bus, in the configuration state, gets its node-ID, which counts at once.
    give_node_id(network, OWN)

    drive = add(network, OWN, "lmd")
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
    # It leaves the factory with a position window that every position lies in. Without one a target is reached where the profile ends.
    drive.sdo[0x6067].raw = 0xFFFF_FFFF
    for turns in (1, -1, 0):
        move(drive, turns * REVOLUTION)
        print(f"at {drive.sdo[0x6064].raw} microsteps")

    drive.sdo[0x6060].raw = 3
    until(drive, 0xFF, 3, 0x6061)
    drive.sdo[0x60FF].raw = REVOLUTION
    # It moves, and the velocity is reached.
    until(drive, 0x1400, 0x0400)
    print(f"runs at {drive.sdo[0x606C].raw / REVOLUTION:.1f} turns/s")
    drive.sdo[0x60FF].raw = 0
    until(drive, 0x1000, 0x1000)
    drive.sdo[0x6040].raw = 0x00
    until(drive, 0x4F, 0x40)
    print("off")
    network.disconnect()


if __name__ == "__main__":
    main()
