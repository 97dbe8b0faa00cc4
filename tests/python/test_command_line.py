"""How the servers start, refuse and stop."""

import pathlib
import signal
import socket
import subprocess

import pytest

from conftest import NODE_ID
from frames import Frames
from server import free_port


def refusal(command):
    """Runs a command that must refuse: exit code 2, one line in plain words that says why, nothing else."""
    run = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=60)
    assert run.returncode == 2, (run.stdout, run.stderr)
    assert run.stdout == ""
    assert len(run.stderr.splitlines()) == 1, run.stderr
    assert run.stderr.startswith(f"{pathlib.Path(command[0]).name}: "), run.stderr
    assert "error" not in run.stderr
    return run.stderr


@pytest.fixture
def serve(programs, kind):
    """The command that serves this kind of device."""
    return [programs.xtask, "qemu"] if kind == "firmware" else [programs.sim, "serve"]


@pytest.mark.only("virtual", "firmware")
def test_a_busy_port_is_refused(serve):
    with socket.create_server(("127.0.0.1", 0)) as busy:
        address = f"127.0.0.1:{busy.getsockname()[1]}"
        assert f"cannot serve SLCAN on {address}: address already in use" in refusal([*serve, "--slcan", address])


@pytest.mark.only("virtual", "firmware")
@pytest.mark.parametrize("address", ["127.0.0.1:70000", "127.0.0.1", "nowhere", ""])
def test_a_bad_address_is_refused(serve, address):
    assert f"cannot serve SLCAN on {address}: invalid " in refusal([*serve, "--slcan", address])


@pytest.mark.only("firmware")
@pytest.mark.parametrize("option", ["--store", "--image"])
def test_a_file_that_is_something_else_is_refused(serve, option):
    assert __file__ in refusal([*serve, "--slcan", f"127.0.0.1:{free_port()}", option, __file__])


@pytest.mark.only("virtual", "firmware")
def test_an_unknown_option_is_refused(serve):
    refusal([*serve, "--slcan", "127.0.0.1:1", "--nonsense"])


@pytest.mark.only("virtual")
def test_no_bus_is_refused(serve):
    refusal(serve)


@pytest.mark.only("virtual", "socketcan")
def test_a_missing_interface_is_refused(serve):
    assert "nocan7" in refusal([*serve, "--socketcan", "nocan7"])


@pytest.mark.only("virtual")
@pytest.mark.parametrize(
    "argument", ["--node-id=0", "--node-id=128", "--node-id=ten", "--bitrate=333"]
)
def test_a_bad_number_is_refused(serve, argument):
    refusal([*serve, "--slcan", "127.0.0.1:0", argument])


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_it(start, kind, by):
    bus = start()
    assert bus.server.stop(by) == 0
    if kind != "socketcan":
        # Nothing is left that listens there.
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", bus.port), timeout=5)


@pytest.mark.only("virtual", "firmware")
def test_a_master_can_leave_and_another_one_come(start, connect):
    bus = start()
    for _ in range(3):
        network = connect(bus)
        network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
        assert network.lss.inquire_node_id() == 255
        network.disconnect()


@pytest.mark.only("virtual")
def test_every_master_sees_all_frames(start, connect):
    bus = start()
    one, other = connect(bus), connect(bus)
    heard = Frames(other, 0x123), Frames(other, one.lss.LSS_RX_COBID)
    # The other one's connection is open once the server has answered it.
    other.lss.send_switch_state_global(other.lss.CONFIGURATION_STATE)
    assert other.lss.inquire_node_id() == 255
    heard[1].next()
    one.send_message(0x123, b"\x01\x02")
    assert heard[0].next() == b"\x01\x02"
    assert one.lss.inquire_node_id() == 255
    assert heard[1].next()[:2] == b"\x5e\xff"


@pytest.mark.only("virtual", "socketcan")
def test_a_drive_with_a_node_id_from_the_command_line(start, connect):
    network = connect(start(arguments=["--node-id", NODE_ID]))
    assert network.add_node(NODE_ID).sdo.upload(0x1000, 0) == bytes.fromhex("92 01 04 00")
