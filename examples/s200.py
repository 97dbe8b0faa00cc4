#!/usr/bin/env python3
"""Puts an S200 into service as its manual does: units, software enable, PDOs mapped while they are valid, jog by PDO, homing.

    s200.py --interface slcan --channel socket://127.0.0.1:2402

It needs `pip install canopen pyserial`. A drive to try it on: `cargo run -- serve --product s200 --slcan 127.0.0.1:2402`.
"""

import struct
import time

from drive import add, connect, enable, save, until

#: Its switches stand at 1; 500 kbit/s.
NODE = 1

#: Counts in a turn where PUNIT says counts.
TURN = 65_536


def main():
    network = connect(__doc__, bitrate=500_000)
    drive = add(network, NODE, "s200")

    def send(controlword, target):
        """RPDO 2: controlword and target velocity."""
        network.send_message(0x300 + NODE, struct.pack("<Hi", controlword, target))

    # 7.6: units in counts, AENA = 0, stored.
    drive.sdo[0x3506][1].raw = 0
    save(drive)

    # 7.11: RPDO 2 gets controlword and target velocity, TPDO 2 statusword and position; the PDOs stay valid meanwhile.
    for index, entries in ((0x1601, (0x60400010, 0x60FF0020)), (0x1A01, (0x60410010, 0x60640020))):
        drive.sdo[index][0].raw = 0
        for sub, entry in enumerate(entries, start=1):
            drive.sdo[index][sub].raw = entry
        drive.sdo[index][0].raw = len(entries)
    drive.sdo[0x1801][2].raw = 1

    seen = []
    network.subscribe(0x280 + NODE, lambda _, data, __: seen.append(struct.unpack("<Hi", data)))
    drive.nmt.send_command(0x01)
    drive.sdo[0x6060].raw = 3
    drive.sdo[0x6083].raw = drive.sdo[0x6084].raw = 10 * TURN
    enable(drive, lambda controlword: send(controlword, 0))
    send(0x0F, TURN)
    end = time.monotonic() + 20
    while not seen or seen[-1][1] - seen[0][1] < TURN // 2:
        assert time.monotonic() < end, seen
        time.sleep(0.1)
        network.send_message(0x080, b"")
    send(0x0F, 0)
    until(drive, 0x1000, 0x1000)
    print(f"jogged for {seen[-1][1] - seen[0][1]} counts")

    # 7.10: homing on the spot.
    drive.sdo[0x6060].raw = 6
    drive.sdo[0x6098].raw = 35
    # A mode is taken at rest, and a start before that is lost.
    until(drive, 0xFF, 6, index=0x6061)
    drive.sdo[0x6040].raw = 0x1F
    until(drive, 0x1000, 0x1000)
    print(f"homed, at {drive.sdo[0x6064].raw}")
    drive.sdo[0x6040].raw = 0x00
    print("off")
    network.disconnect()


if __name__ == "__main__":
    main()
