#!/usr/bin/env python3
"""Puts drives into service by LSS (CiA 305): finds them, numbers them, sets the bit rate of the bus, and sees that they answer.

It needs `pip install canopen pyserial` and an adapter that python-can drives:

    commission.py --interface slcan --channel /dev/ttyACM0 --node-id 10
    commission.py --interface socketcan --channel can0 --node-id 1 --all
    commission.py --interface slcan --channel socket://127.0.0.1:2402 --node-id 10 --new-bitrate 500

Everything it sends is standard, so it serves drives of any make. docs/commissioning.md tells what happens, frame by frame.
"""

import argparse
import queue
import struct
import sys
import time

import can
import canopen
from canopen.lss import (
    CS_FAST_SCAN,
    CS_INQUIRE_PRODUCT_CODE,
    CS_INQUIRE_REVISION_NUMBER,
    CS_INQUIRE_SERIAL_NUMBER,
    CS_INQUIRE_VENDOR_ID,
    LssError,
)
from canopen.sdo.exceptions import SdoError

#: The LSS address of a drive, in the order in which LSS asks for it.
ADDRESS = {
    "vendor": CS_INQUIRE_VENDOR_ID,
    "product": CS_INQUIRE_PRODUCT_CODE,
    "revision": CS_INQUIRE_REVISION_NUMBER,
    "serial": CS_INQUIRE_SERIAL_NUMBER,
}

#: The bit rates of table 0 of CiA 305 in kbit/s, with their indices.
BIT_RATES = {1000: 0, 800: 1, 500: 2, 250: 3, 125: 4, 50: 6, 20: 7, 10: 8}

#: The node-ID of a drive that has none.
UNCONFIGURED = 255

RESET_COMMUNICATION = 0x82


class Failed(Exception):
    """It cannot go on, and why."""


class Bus:
    """The bus with its drives, and the master on it."""

    def __init__(self, interface, channel, bitrate, patience):
        self.interface = interface
        self.channel = channel
        self.patience = patience
        self.network = canopen.Network()
        self.lss = self.network.lss
        self.lss.RESPONSE_TIMEOUT = patience
        self.connect(bitrate)

    def connect(self, bitrate):
        """Goes on the bus at this rate. The rate of a SocketCAN interface is set by `ip link`, not here."""
        options = {"sleep_after_open": 0.1} if self.interface == "slcan" else {}
        self.network.connect(interface=self.interface, channel=self.channel, bitrate=bitrate * 1000, **options)

    def find_unconfigured(self):
        """Finds a drive without a node-ID by fastscan; it is then the only one in the configuration state. Gives its address."""
        answers = self.frames(self.lss.LSS_RX_COBID)
        self.lss.send_identify_non_configured_remote_slave()
        if not self.comes(answers):
            return None
        for _ in range(3):
            address = self.scan(answers)
            if address and self.inquire_address() == address:
                return address
            self.lss.send_switch_state_global(self.lss.WAITING_STATE)
        raise Failed("drives without a node-ID are there, but answer too late for a scan; give them more --patience")

    def scan(self, answers):
        """A fastscan. (It is not `lss.fast_scan`, which goes on at the first answer, and takes a second drive's for that to its
        next question.) What is quick is tried first: an answer that comes too late spoils its number, which is then asked for
        anew with a longer wait."""
        if not self.is_answered(answers, self.patience, 0, 128, 0, 0):
            return None
        address = [0] * len(ADDRESS)
        for sub in range(len(ADDRESS)):
            for wait in (self.patience / 20, self.patience / 5, self.patience):
                address[sub] = self.scan_number(answers, wait, sub)
                if self.is_answered(answers, wait, address[sub], 0, sub, (sub + 1) % len(ADDRESS)):
                    break
            else:
                return None
        return address

    def scan_number(self, answers, wait, sub):
        """A part of the address, its highest bit first."""
        number = 0
        for bit in reversed(range(32)):
            # Drives answer whose bits down to this one agree; silence means that it is a 1.
            if not self.is_answered(answers, wait, number, bit, sub, sub):
                number |= 1 << bit
        return number

    def is_answered(self, answers, wait, number, bit, sub, following):
        """Asks. The first answer may take `wait` seconds, and those of the other drives may come one after the other behind it: all
        must be in before the next question."""
        question = struct.pack("<BIBBB", CS_FAST_SCAN, number, bit, sub, following)
        self.network.send_message(self.lss.LSS_TX_COBID, question)
        is_answered = self.comes(answers, wait)
        while self.comes(answers, wait / 5):
            pass
        return is_answered

    def inquire_address(self):
        """The address of the drive in the configuration state; `None` if there is none."""
        try:
            return [self.lss.inquire_lss_address(inquiry) for inquiry in ADDRESS.values()]
        except LssError:
            return None

    def select(self, address):
        """Takes the drive with this address into the configuration state."""
        try:
            self.lss.send_switch_state_selective(*address)
        except LssError:
            raise Failed(f"no drive has the address {words(address)}") from None

    def select_only(self):
        """Takes every drive into the configuration state, which is right if there is but one. Gives its address."""
        self.lss.send_switch_state_global(self.lss.CONFIGURATION_STATE)
        address = self.inquire_address()
        if address is None:
            raise Failed("no drive answers; is its bit rate that of the bus?")
        return address

    def number(self, node_id):
        """Gives the drive in the configuration state a node-ID, lets it store and use it, and waits until it has booted."""
        old = self.lss.inquire_node_id()
        self.lss.configure_node_id(node_id)
        self.lss.store_configuration()
        booted = self.frames(0x700 + node_id)
        # A drive that had no node-ID boots now; any other keeps its old one until communication is reset.
        self.lss.send_switch_state_global(self.lss.WAITING_STATE)
        if old != UNCONFIGURED:
            self.network.send_message(0, bytes([RESET_COMMUNICATION, old]))
        if not self.comes(booted):
            raise Failed(f"the drive has not booted as node {node_id}")

    def frames(self, cob_id):
        """A queue to which frames with this identifier come from now on."""
        heard = queue.Queue()
        self.network.subscribe(cob_id, lambda _cob_id, data, _time: heard.put(bytes(data)))
        return heard

    def comes(self, frames, wait=None):
        """Does a frame come to the queue in good time?"""
        try:
            frames.get(timeout=wait or self.patience)
        except queue.Empty:
            return False
        return True

    def change_bit_rate(self, addresses, bitrate, delay=0.5):
        """Tells these drives a bit rate, one after the other; then they switch to it together after `delay` seconds of silence, stay
        silent as long again, and the master goes with them. They store it when all of them are there again. False if the master's
        rate is not its own to change: then the drives store at once, and use the new one from the next power-on."""
        for address in addresses:
            self.select(address)
            self.lss.configure_bit_timing(BIT_RATES[bitrate])
            self.lss.send_switch_state_global(self.lss.WAITING_STATE)
        moves = self.interface != "socketcan"
        if moves:
            self.lss.send_switch_state_global(self.lss.CONFIGURATION_STATE)
            self.lss.activate_bit_timing(round(delay * 1000))
            self.network.disconnect()
            time.sleep(delay)
            self.connect(bitrate)
            time.sleep(delay + 0.1)
            self.lss.send_switch_state_global(self.lss.WAITING_STATE)
            for address in addresses:
                self.select(address)
                self.lss.send_switch_state_global(self.lss.WAITING_STATE)
        for address in addresses:
            self.select(address)
            self.lss.store_configuration()
            self.lss.send_switch_state_global(self.lss.WAITING_STATE)
        return moves

    def describe(self, node_id):
        """Who the node says it is."""
        sdo = self.network.add_node(node_id).sdo
        sdo.RESPONSE_TIMEOUT = self.patience
        device_type = int.from_bytes(sdo.upload(0x1000, 0), "little")
        try:
            name = sdo.upload(0x1008, 0).decode("ascii", "replace")
        except canopen.SdoAbortedError:
            name = "without a name"
        return f"node {node_id}: {name}, device type {device_type:08X}h"


def words(address):
    """An LSS address for people."""
    return ", ".join(f"{name} {number:08X}h" for name, number in zip(ADDRESS, address))


def number_drives(bus, arguments):
    """Numbers the drives that are asked for; gives their node-IDs with their addresses."""
    if arguments.address:
        bus.select(arguments.address)
        addresses = [arguments.address]
    elif arguments.only:
        addresses = [bus.select_only()]
    else:
        addresses = iter(bus.find_unconfigured, None)
    numbered = {}
    for node_id, address in enumerate(addresses, start=arguments.node_id):
        if node_id > 127:
            raise Failed("there are no more node-IDs; one drive more is on the bus")
        print(f"found {words(address)}")
        bus.number(node_id)
        print(f"stored and booted as node {node_id}")
        numbered[node_id] = address
        if not arguments.all:
            break
    if not numbered:
        raise Failed("no drive without a node-ID is on the bus; is its bit rate that of the bus?")
    return numbered


def run(arguments):
    """Does what is asked for."""
    bus = Bus(arguments.interface, arguments.channel, arguments.bitrate, arguments.patience)
    try:
        # Nobody shall be left in the configuration state by somebody else.
        bus.lss.send_switch_state_global(bus.lss.WAITING_STATE)
        numbered = number_drives(bus, arguments)
        if arguments.new_bitrate:
            is_in_force = bus.change_bit_rate(numbered.values(), arguments.new_bitrate)
            when = "now" if is_in_force else "from the next power-on; then set the interface to it by `ip link`"
            print(f"the drives use {arguments.new_bitrate} kbit/s {when}")
        for node_id in numbered:
            print(bus.describe(node_id))
    finally:
        if bus.network.bus is not None:
            bus.network.disconnect()


def node_id(text):
    """A node-ID of a drive."""
    number = int(text, 0)
    if not 1 <= number <= 127:
        raise ValueError
    return number


def parse(arguments):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--interface", required=True, help="an interface of python-can, such as slcan or socketcan")
    parser.add_argument("--channel", required=True, help="its channel: /dev/ttyACM0, socket://HOST:PORT, can0")
    rates = ", ".join(str(rate) for rate in BIT_RATES)
    parser.add_argument("--bitrate", type=int, default=1000, choices=BIT_RATES, metavar="KBIT", help=f"of the bus now ({rates})")
    parser.add_argument("--node-id", type=node_id, required=True, metavar="N", help="1 to 127, the first of them with --all")
    parser.add_argument("--new-bitrate", type=int, choices=BIT_RATES, metavar="KBIT", help="for the drives found, which should be all on the bus")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--all", action="store_true", help="number every drive that has no node-ID")
    which.add_argument("--only", action="store_true", help="the drive is alone on the bus; it may have a node-ID")
    which.add_argument(
        "--address", nargs=4, type=lambda text: int(text, 0), metavar=("VENDOR", "PRODUCT", "REVISION", "SERIAL"),
        help="the drive with this identity (1018h); it may have a node-ID",
    )
    parser.add_argument("--patience", type=float, default=1.0, metavar="SECONDS", help="how long an answer may take")
    return parser.parse_args(arguments)


def main():
    try:
        run(parse(None))
    except (Failed, LssError, SdoError, can.CanError, OSError) as problem:
        print(f"commission.py: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
