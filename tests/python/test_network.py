"""Networks: what `od-gen network` makes, as lely's dcfgen makes it."""

import pathlib
import subprocess
import sys
import warnings

import dcf
import pytest

from conftest import ROOT

NETWORK = ROOT / "od-gen" / "tests" / "data" / "network"

# They are the same for every target.
pytestmark = pytest.mark.only("virtual")


@pytest.fixture(scope="module", params=["machine.toml", "machine.yaml"])
def made(request, pytestconfig, tmp_path_factory):
    """What both make of the same network: the folder of od-gen, and that of dcfgen."""
    ours, theirs = tmp_path_factory.mktemp("ours"), tmp_path_factory.mktemp("theirs")
    od_gen = pytestconfig.getoption("--od-gen")
    subprocess.run([od_gen, "network", NETWORK / request.param, "--output", ours], check=True)
    dcfgen = pathlib.Path(sys.executable).parent / "dcfgen"
    subprocess.run([dcfgen, "-r", "-d", theirs, "machine.yml"], cwd=NETWORK, check=True)
    return ours, theirs


def test_the_concise_dcf_is_that_of_dcfgen(made):
    ours, theirs = made
    for name in ["axis_x.bin", "axis_y.bin", "io.bin"]:
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
        assert (theirs / name).read_bytes() == (NETWORK / name).read_bytes(), name


def test_dcfchk_has_no_complaint(made):
    checker = pathlib.Path(sys.executable).parent / "dcfchk"
    for name in ["axis_x.dcf", "axis_y.dcf", "io.dcf", "master.dcf"]:
        check = subprocess.run([checker, made[0] / name], capture_output=True, text=True)
        assert (check.returncode, check.stdout, check.stderr) == (0, "", ""), name


def test_the_master_is_told_what_dcfgen_tells_it(made):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ours, theirs = (dcf.Device.from_dcf(str(folder / "master.dcf")) for folder in made)

    def value(device, index, sub):
        if index not in device or sub not in device[index]:
            return "" if index == 0x1F22 else 0
        entry = device[index][sub]
        return getattr(entry, "upload_file", "") if entry.data_type.index == 0x0F else entry.parse_value()

    # dcfgen writes revisions and serial numbers into master.bin; what io hears from axis_x it has the master send, too.
    indices = [0x1005, 0x1006, 0x1016, 0x1017, 0x1F22, 0x1F80, 0x1F81, 0x1F84, 0x1F85, 0x1F86, 0x1F89]
    indices += [base + n for base in (0x1400, 0x1600, 0x2000, 0x5800, 0x5A00) for n in range(8)]
    indices += [base + n for base in (0x1800, 0x1A00, 0x2200, 0x5C00, 0x5E00) for n in range(3)]
    for index in indices:
        assert index in ours, f"{index:04X}"
        for sub in {*ours[index], *theirs[index]} - {0}:
            assert value(ours, index, sub) == value(theirs, index, sub), f"{index:04X}:{sub:X}"


SHEETS = sorted([*ROOT.glob("eds/*.eds"), *ROOT.glob("products/*/*.eds"), *ROOT.glob("tests/eds/*.eds")])


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda sheet: sheet.stem)
def test_the_concise_dcf_of_every_data_sheet_is_that_of_dcfgen(sheet, pytestconfig, tmp_path):
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    ours.mkdir()
    theirs.mkdir()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        device = dcf.Device.from_dcf(str(sheet), {"NODEID": 4})

    def on(first):
        indices = [first + number for number in range(4) if first + number in device]
        return [1 + index - first for index in indices if not device[index][1].parse_value() & 1 << 31]

    # Every transmit PDO that is on comes with each third SYNC; the receive PDOs are switched off, so that nobody has to send them.
    rpdos, tpdos = on(0x1400), on(0x1800)
    heartbeat = 0x1017 in device
    toml = ["[network]", "bit_rate = 500", "[sync]", "period = 4000", "[master]", "node_id = 1", "[[node]]"]
    toml += ['name = "node"', f'sheet = "{sheet}"', "node_id = 4", "revision_number = 3"]
    yml = ["master: {node_id: 1, baudrate: 500, sync_period: 4000}", "node:", f"  dcf: {sheet}", "  node_id: 4"]
    yml += ["  revision_number: 3"]
    if heartbeat:
        toml += ["heartbeat = 200"]
        yml += ["  heartbeat_producer: 200"]
    for kind, numbers, of_toml, of_yml in [
        ("rpdo", rpdos, "enabled = false", lambda number: f"cob_id: {0x80000104 + 0x100 * number:#x}"),
        ("tpdo", tpdos, "transmission = 3", lambda number: "transmission: 3"),
    ]:
        yml += [f"  {kind}:"] if numbers else []
        for number in numbers:
            toml += [f"[node.{kind}.{number}]", of_toml]
            yml += [f"    {number}: {{{of_yml(number)}}}"]
    (tmp_path / "net.toml").write_text("\n".join(toml) + "\n")
    (tmp_path / "net.yml").write_text("\n".join(yml) + "\n")
    subprocess.run([pytestconfig.getoption("--od-gen"), "network", "net.toml", "--output", ours], cwd=tmp_path, check=True)
    dcfgen = pathlib.Path(sys.executable).parent / "dcfgen"
    subprocess.run([dcfgen, "-r", "-d", theirs, "net.yml"], cwd=tmp_path, check=True)
    made = (theirs / "node.bin").read_bytes() if (theirs / "node.bin").exists() else None
    own = (ours / "node.bin").read_bytes() if (ours / "node.bin").exists() else None
    assert own == made
    assert own is not None and len(own) > 4, "nothing is compared"
