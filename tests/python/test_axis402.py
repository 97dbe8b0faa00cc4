"""The command line `axis402` puts a device into service: over SLCAN, with the firmware in the emulator, on SocketCAN."""

import subprocess

import pytest

from conftest import NODE_ID

pytestmark = pytest.mark.everywhere

NODE = str(NODE_ID)


@pytest.fixture
def axis402(programs):
    """Runs a command on a bus; it must succeed. Returns what it wrote."""

    def run(bus, *arguments):
        command = [str(programs.axis402), *bus.for_axis402(), "--timeout", "5000", *arguments]
        run = subprocess.run(command, capture_output=True, text=True, timeout=300)
        assert run.returncode == 0, (arguments, run.stdout, run.stderr)
        return run.stdout

    return run


def test_a_device_is_found_numbered_and_scanned(start, axis402):
    bus = start()
    assert "1 device without a node-ID\n" in axis402(bus, "lss", "find", "--step", "50")
    told = axis402(bus, "lss", "number", "--first", NODE, "--step", "50")
    assert told.startswith(f"node {NODE}: vendor 00000000h, product 00000402h"), told
    told = axis402(bus, "scan")
    assert told.splitlines()[1].split()[:4] == [NODE, "00040192", "00000000", "00000402"], told
    assert told.endswith("1 node\n"), told


def test_what_is_written_and_saved_lasts(start, axis402, tmp_path):
    bus = start(tmp_path)
    axis402(bus, "lss", "set", "--node-id", NODE)
    axis402(bus, "od", "write", NODE, "profile acceleration", "4321")
    assert axis402(bus, "od", "read", "--bare", NODE, "6083", "6041") == "4321\n0x0250 (switch on disabled)\n"
    assert axis402(bus, "save", NODE) == f"node {NODE} has saved its parameters\n"
    bus.server.stop()
    bus = start(tmp_path)
    assert axis402(bus, "od", "read", "--bare", NODE, "6083") == "4321\n"


def test_a_configuration_is_dumped_and_loaded(start, axis402, tmp_path):
    bus = start()
    axis402(bus, "lss", "set", "--node-id", NODE, "--no-store")
    dcf = str(tmp_path / "drive.dcf")
    axis402(bus, "od", "dump", NODE, "--output", dcf)
    axis402(bus, "od", "write", NODE, "6084", "4321")
    assert axis402(bus, "od", "load", NODE, dcf).startswith("1 values written, ")
    assert axis402(bus, "od", "read", "--bare", NODE, "6084") != "4321\n"


def test_the_traffic_is_told_in_words(start, axis402):
    bus = start()
    axis402(bus, "lss", "set", "--node-id", NODE, "--no-store")
    axis402(bus, "nmt", "start", NODE)
    told = axis402(bus, "monitor", NODE, "--count", "3")
    assert "TPDO 1: switch on disabled\n" in told, told
