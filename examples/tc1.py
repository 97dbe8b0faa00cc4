#!/usr/bin/env python3
"""Puts a TC1 into service as its manual does: node-ID by LSS, heartbeat, RPDO 2 switched on, a move by PDO, everything stored.

    tc1.py --interface slcan --channel socket://127.0.0.1:2402

It needs `pip install canopen pyserial`. A drive to try it on: `cargo run -- serve --product tc1 --slcan 127.0.0.1:2402`.
"""

import struct

from drive import add, connect, enable, give_node_id, save, until, until_there

NODE = 1


def main():
    network = connect(__doc__)
    drive = add(network, NODE, "tc1")

    def send(controlword, target):
        """RPDO 2: controlword and target position."""
        network.send_message(0x300 + NODE, struct.pack("<Hi", controlword, target))

    # Chapter 4: the node-ID by CiA 305, to the only drive on the bus.
    give_node_id(network, NODE)
    until_there(drive)
    print(f"{drive.sdo[0x1008].raw}, vendor {drive.sdo[0x1018][1].raw:X}h")

    # Chapters 5 to 7: heartbeat, and RPDO 2 (controlword and target position) switched on.
    drive.sdo[0x1017].raw = 100
    drive.sdo[0x1401][1].raw = 0x300 + NODE
    drive.nmt.send_command(0x01)
    drive.nmt.wait_for_heartbeat(2)

    drive.sdo[0x6060].raw = 1
    enable(drive, lambda controlword: send(controlword, 0))
    for target in (10_000, 0):
        send(0x1F, target)
        until(drive, 0x1000, 0x1000)
        send(0x0F, target)
        until(drive, 0x1400, 0x0400)
        # Bit 24: the motor stands.
        until(drive, 1 << 24, 1 << 24, 0x1002)
        print(f"at {drive.sdo[0x6064].raw}, status register {drive.sdo[0x1002].raw:08X}h")
    send(0x00, 0)
    until(drive, 0x4F, 0x40)

    # Chapter 12: everything is stored.
    save(drive)
    print("stored")
    network.disconnect()


if __name__ == "__main__":
    main()
