"""Our reader of data sheets and that of python-canopen see the same objects."""

import io
import json
import math
import re
import subprocess

import canopen
import pytest
from canopen.objectdictionary import ODVariable, datatypes

from conftest import NODE_ID, ROOT

DATA_SHEETS = sorted(
    path
    for folder in ("eds", "tests/eds", "od-gen/tests/data")
    for path in (ROOT / folder).glob("*.[ed][dc][sf]")
    # The mistakes of these are all different, and so is what readers make of them.
    if path.name not in ("broken.eds", "allowed.eds")
)

#: They are the same for every target.
pytestmark = pytest.mark.only("virtual")

ODD_SIGNED = (datatypes.INTEGER24, datatypes.INTEGER40, datatypes.INTEGER48, datatypes.INTEGER56)
NO_NUMBERS = (datatypes.VISIBLE_STRING, datatypes.OCTET_STRING, datatypes.UNICODE_STRING, datatypes.DOMAIN)


@pytest.fixture(scope="session")
def od_gen(pytestconfig):
    return pytestconfig.getoption("--od-gen")


@pytest.fixture(params=DATA_SHEETS, ids=lambda path: path.name)
def data_sheet(request):
    return request.param


def ours(od_gen, data_sheet):
    text = subprocess.run([od_gen, "dump", data_sheet], check=True, capture_output=True, text=True).stdout
    for item in json.loads(text)["objects"]:
        for entry in item["entries"]:
            yield (item["index"], entry["sub"]), entry


def readable(text):
    """A data sheet as python-canopen can read it: with all dummies and small letters, without data types and compact lists of values."""
    dummies = [f"Dummy{code:04X}" for code in range(1, 8)]
    missing = "".join(f"{name}=0\n" for name in dummies if name not in text)
    text = text.replace("[DummyUsage]\n", "[DummyUsage]\n" + missing)
    text = re.sub(r"(?mi)^\[(\w{4})sub", r"[\1sub", text)
    sections = re.split(r"(?m)^(?=\[)", text)
    unreadable = re.compile(r"\[(0\w{3}|\w{4}(Name|Value|Denotation))|\[.*\n(.+\n)*(CompactSubObj|ObjectType=0$)")
    return "".join(section for section in sections if not unreadable.match(section))


def theirs(data_sheet):
    source = io.StringIO(readable(data_sheet.read_text(encoding="utf-8-sig")))
    source.name = data_sheet.name
    dictionary = canopen.import_od(source, NODE_ID)
    for index, item in dictionary.items():
        # Types are defined below 1000h.
        if index >= 0x1000:
            for variable in [item] if isinstance(item, ODVariable) else item.values():
                yield (index, variable.subindex), variable


def expected_default(entry):
    """The default as python-canopen gives it."""
    default = entry["default"]
    if entry["data_type_code"] == datatypes.OCTET_STRING:
        return bytes.fromhex(default)
    return default + NODE_ID if entry["adds_node_id"] else default


def is_octal_or_bits(text):
    """Notations of CiA 306 that python-canopen does not know: octal numbers, and the bits of a REAL in hexadecimal."""
    return re.fullmatch(r"-?0[0-7]+|0x[0-9A-F]{8}", text) is not None


def same(theirs, entry):
    """Whether a default is the same; python-canopen reads the bit pattern of a negative number as a positive one."""
    ours = expected_default(entry)
    if isinstance(ours, float):
        return math.isclose(theirs, ours, rel_tol=1e-6)
    if isinstance(ours, int):
        return (theirs - ours) % 256 ** entry["size"] == 0
    return theirs == ours


def test_both_readers_see_the_same(od_gen, data_sheet):
    mine, yours = dict(ours(od_gen, data_sheet)), dict(theirs(data_sheet))
    compared = 0
    for key, variable in yours.items():
        where = "{:04X}h:{}".format(*key)
        entry = mine.pop(key)
        code = entry["data_type_code"]
        assert variable.data_type == code, where
        assert variable.access_type == entry["access"], where
        assert variable.pdo_mappable == entry["pdo_mapping"], where
        assert variable.name == entry["name"], where
        # python-canopen reads limits of integers alone, and none of signed ones with an odd number of bytes.
        if code not in datatypes.FLOAT_TYPES + NO_NUMBERS + ODD_SIGNED:
            assert variable.min == entry["low_limit"], where
            assert variable.max == entry["high_limit"], where
        if variable.default is None:
            assert entry["default"] in (None, 0, "") or is_octal_or_bits(variable.default_raw), where
        elif code != datatypes.DOMAIN:
            assert same(variable.default, entry), where
        compared += 1
    # What python-canopen was not shown: sub-index 0 where the file has none, and compact objects.
    assert all(key[1] == 0 and entry["access"] == "const" or key[0] == 0x2100 for key, entry in mine.items()), mine
    assert compared > 4
