#!/usr/bin/env python3
"""Puts a Nanotec SMCI into service as its manual does: defaults, currents, feed constant, then velocity mode and profile position.

    nanotec.py --interface slcan --channel socket://127.0.0.1:2402

It needs `pip install canopen pyserial`. A drive to try it on: `cargo run -- serve --product nanotec --slcan 127.0.0.1:2402`.
"""

from drive import add, connect, enable, move, save, until, until_there

#: Its rotary switch stands at 1: node-ID 1 and 1 Mbit/s.
NODE = 1


def main():
    network = connect(__doc__)
    drive = add(network, NODE, "nanotec")

    # 1.1.3: defaults first, then what the motor needs. A reset makes the defaults count.
    drive.sdo[0x1011][1].raw = int.from_bytes(b"load", "little")
    drive.nmt.send_command(0x81)
    until_there(drive)
    drive.sdo[0x2004][1].raw = 40
    drive.sdo[0x2004][2].raw = 20
    save(drive)
    print(f"device type {drive.sdo[0x1000].raw}, current {drive.sdo[0x2004][1].raw} %")

    # 2.1: start, state machine, mode, motion. Velocity mode runs with 000Fh; bit 8 halts it.
    drive.nmt.send_command(0x01)
    drive.sdo[0x6060].raw = 2
    enable(drive)
    drive.sdo[0x6042].raw = 500
    until(drive, 0xFFFF, 500, 0x6044)
    print("runs at 500")
    drive.sdo[0x6040].raw = 0x010F
    until(drive, 0xFFFF, 0, 0x6044)
    print("halted")
    drive.sdo[0x6040].raw = 0x0000
    until(drive, 0x4F, 0x40)

    drive.sdo[0x6060].raw = 1
    enable(drive)
    start = drive.sdo[0x6064].raw
    for target in (start + 2_000, start):
        move(drive, target)
        print(f"{drive.sdo[0x6064].raw - start} from where it began")
    drive.sdo[0x6040].raw = 0x00
    print("off")
    network.disconnect()


if __name__ == "__main__":
    main()
