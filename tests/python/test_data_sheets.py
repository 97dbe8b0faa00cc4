"""The electronic data sheets, read by other programs than our own."""

import logging
import pathlib
import subprocess
import sys
import warnings

import canopen
import pytest

from conftest import NODE_ID, ROOT

DATA_SHEETS = [path for folder in ("eds", "products/*", "tests/eds") for path in sorted(ROOT.glob(f"{folder}/*.eds"))]


# They are the same for every target.
pytestmark = pytest.mark.only("virtual")


@pytest.fixture(params=DATA_SHEETS, ids=lambda path: path.name)
def data_sheet(request):
    return request.param


def test_python_canopen_imports_it_without_a_warning(data_sheet, caplog):
    with warnings.catch_warnings(), caplog.at_level(logging.WARNING):
        warnings.simplefilter("error")
        dictionary = canopen.import_od(str(data_sheet), NODE_ID)
    assert caplog.records == []
    assert dictionary[0x1018][1].data_type == canopen.objectdictionary.UNSIGNED32
    assert dictionary[0x1400][1].default & 0x7FF == 0x200 + NODE_ID


def test_dcfchk_has_no_complaint(data_sheet):
    checker = pathlib.Path(sys.executable).parent / "dcfchk"
    check = subprocess.run([checker, "-n", str(NODE_ID), data_sheet], capture_output=True, text=True)
    assert (check.returncode, check.stdout, check.stderr) == (0, "", "")


def test_the_products_are_what_the_converter_makes(tmp_path):
    subprocess.run([sys.executable, ROOT / "products" / "convert.py", tmp_path], check=True)
    made = {path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.glob("*/*.eds")}
    assert len(made) == 4
    assert made == {name: (ROOT / "products" / name).read_bytes() for name in made}
