"""What the examples of the products share: the bus, the state machine of CiA 402, a move."""

import argparse
import pathlib
import time

import canopen

PRODUCTS = pathlib.Path(__file__).resolve().parent.parent / "products"

#: Controlwords to operation enabled, each with the state that it leads to (bits 0 to 3, 5 and 6).
TO_ENABLED = ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27))


def connect(about, bitrate=1_000_000):
    """The bus that the command line names."""
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("--interface", required=True)
    parser.add_argument("--channel", required=True)
    arguments = parser.parse_args()
    network = canopen.Network()
    network.connect(interface=arguments.interface, channel=arguments.channel, bitrate=bitrate)
    return network


def give_node_id(network, node_id):
    """To the only drive on the bus, by LSS (CiA 305)."""
    network.lss.RESPONSE_TIMEOUT = 3
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    network.lss.configure_node_id(node_id)
    network.lss.store_configuration()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)


def add(network, node_id, product):
    """The drive with this node-ID, by the data sheet of the product."""
    drive = network.add_node(node_id, str(PRODUCTS / product / f"{product}.eds"))
    drive.sdo.RESPONSE_TIMEOUT = 10
    return drive


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


def until(drive, mask, value, index=0x6041, seconds=20):
    """Waits for bits of an object, of the statusword if nothing is said."""
    end = time.monotonic() + seconds
    while (word := drive.sdo[index].raw) & mask != value:
        assert time.monotonic() < end, f"{index:04X}h is {word:X}h"
        time.sleep(0.01)


def enable(drive, send=None):
    """Through the states to operation enabled; `send` sends a controlword, by SDO if nothing is said."""
    for controlword, state in TO_ENABLED:
        if send:
            send(controlword)
        else:
            drive.sdo[0x6040].raw = controlword
        until(drive, 0x6F, state)


def move(drive, target):
    """A set-point of profile position, taken and reached."""
    drive.sdo[0x607A].raw = target
    drive.sdo[0x6040].raw = 0x1F
    until(drive, 0x1000, 0x1000)
    drive.sdo[0x6040].raw = 0x0F
    until(drive, 0x1400, 0x0400)


def save(drive):
    """Stores the parameters (1010h:1)."""
    drive.sdo[0x1010][1].raw = int.from_bytes(b"save", "little")
