"""Makes the data sheet of each of the four drives from the table in its folder: python3 products/convert.py [FOLDER]

What a manual does not tell, or tells in a way that no data sheet can, is decided here, in one place:
- A sub-index 0 that the table leaves out is added, with the highest sub-index.
- An entry that the manual gives no access is left out: the drive answers 06090011h. One it calls reserved is kept.
- PDO mapping that is unknown is allowed for the process data of CiA 402 and for what a default mapping maps, else not.
- A default that is no number (such as "motor dependent") is left out, and so are limits that the type has anyway.
- `chosen.csv` beside a table has what the manual leaves open and a drive needs to move: defaults, for the TC1 whole objects.
- What a channel of the S200 tells of its number (limits, default, format, attributes) the manual leaves open: it is what holds here.
- Where 0 is outside the limits and there is no default, the lower limit is the default. A limit that the default breaks
  is left out, and so are those of 1010h and 1011h, which are no range but the signature.
"""

import csv
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent

SIZES = {
    "BOOLEAN": (0x01, 1, False), "INTEGER8": (0x02, 8, True), "INTEGER16": (0x03, 16, True),
    "INTEGER32": (0x04, 32, True), "UNSIGNED8": (0x05, 8, False), "UNSIGNED16": (0x06, 16, False),
    "UNSIGNED32": (0x07, 32, False),
}  # fmt: skip
CODES = {name: size[0] for name, size in SIZES.items()} | {"REAL32": 0x08, "VISIBLE_STRING": 0x09, "OCTET_STRING": 0x0A, "DOMAIN": 0x0F}
KINDS = {"VAR": 7, "ARRAY": 8, "RECORD": 9}
STRINGS = ("VISIBLE_STRING", "OCTET_STRING", "DOMAIN")

# The objects that CiA 402 makes for PDOs, for tables that do not tell.
PROCESS_DATA = {0x603F, 0x6040, 0x6041, 0x6042, 0x6043, 0x6044, 0x6060, 0x6061, 0x6062, 0x6063, 0x6064, 0x606C, 0x6071, 0x6077, 0x607A}  # fmt: skip
PROCESS_DATA |= {0x6081, 0x60C1, 0x60FD, 0x60FE, 0x60FF}

NAMES = {
    0x1003: "Pre-defined error field", 0x1010: "Store parameters", 0x1011: "Restore default parameters",
    0x1016: "Consumer heartbeat time", 0x1018: "Identity object", 0x1026: "OS prompt", 0x1200: "SDO server parameter",
}  # fmt: skip


class Drive:
    """What the head of a data sheet tells, and where the table needs a word."""

    def __init__(self, file, vendor, product, bit_rates, lss, about, remarks=None, silenced=None):
        self.file, self.vendor, self.product = file, vendor, product
        self.bit_rates, self.lss, self.about = bit_rates, lss, about
        # By index, or by (index, sub): a line of comment. By rule or (rule, index): the reason why a finding stands.
        self.remarks, self.silenced = remarks or {}, silenced or {}


ALL_RATES = (10, 20, 50, 125, 250, 500, 800, 1000)

DRIVES = [
    Drive(
        "lmd", "Novanta IMS", "Lexium MDrive", ALL_RATES, True, "Lexium MDrive and Liberty MDrive motion control node",
        silenced={
            ("mapped-length", (0x1603, 2)): "the drive maps its target torque of 16 bits with 32",
            ("mode-not-claimed", 0x6087): "only the drives with hMT have profile torque, and 6502h is told for those without",
        },
    ),
    Drive("tc1", "cpc", "TC1", ALL_RATES, True, "TC1 servo drive, communication objects"),
    Drive("s200", "Danaher Motion", "S200", (125, 250, 500, 1000), False, "S200 servo amplifier, Position Node"),
    Drive(
        "nanotec", "Nanotec", "SMCI and PD", ALL_RATES, False, "SMCI controllers and PD motors",
        silenced={
            ("standard-type", 0x1000): "the manual gives the device type 16 bits",
            ("standard-kind", 0x1009): "the drive spells its versions character by character, one sub-index each",
            ("standard-kind", 0x100A): "the drive spells its versions character by character, one sub-index each",
            ("no-vendor-id", (0x1018, 1)): "the manual does not tell it",
            ("error-list", (0x1003, 0)): "the manual does not tell how to clear the list",
        }
        | {
            ("pdo-without-objects", (index, 0)): "the drive leaves it to the master to map something"
            for first in (0x1600, 0x1A00)
            for index in range(first + 1, first + 4)
        },
    ),
]  # fmt: skip


def number(text):
    """(value, adds the node-ID) of a default or a limit; None where it is not a number."""
    text = text.strip()
    adds = bool(re.search(r"\$NODEID|node[- ]?ID", text, re.I))
    text = re.sub(r"\$NODEID|node[- ]?ID|\+|\s|\(.*\)", "", text, flags=re.I)
    try:
        return int(text, 0), adds
    except ValueError:
        return (int(text), adds) if re.fullmatch(r"-?0*[0-9]+", text) else None


def choose(rows, file):
    """Adds to the rows of a manual what it leaves open: defaults, and objects that a drive of its kind has. Returns why, by index and sub-index."""
    if not file.exists():
        return {}
    with open(file, newline="", encoding="utf-8") as text:
        chosen = list(csv.DictReader(text))
    key = lambda row: (int(row["index"], 16), int(row["sub"], 0))  # noqa: E731
    told = {key(row): row for row in rows}
    for row in chosen:
        if key(row) not in told:
            rows.append(row)
            continue
        for column, cell in row.items():
            if cell and column not in ("index", "sub", "description"):
                old = told[key(row)][column]
                assert not number(old) or column != "default" or cell[0] == ";", f"{row['index']}:{row['sub']}: the manual tells {column}"
                told[key(row)][column] = cell
    rows.sort(key=key)
    return {key(row): row["description"] for row in chosen}


CHANNELS = range(0x3500, 0x3CD0)
READ_ONLY, VOLATILE, FUNCTION = 0x08, 0x20, 0x40


def describe_channels(rows, chosen):
    """Fills in what the channels of the S200 tell of their numbers, sub-indices 2 to 6, and how far they reach. None of it changes."""
    channels = {}
    for row in rows:
        if index_of(row) in CHANNELS:
            channels.setdefault(index_of(row), {})[int(row["sub"], 0)] = row
    for subs in channels.values():
        value = subs.get(1)
        if not value:
            continue
        _, bits, signed = SIZES[value["data_type"]]
        range_of_type = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
        low, high = (number(value[column]) or (limit, False) for column, limit in zip(("min", "max"), range_of_type, strict=True))
        attributes = {"ro": READ_ONLY, "wo": FUNCTION}.get(value["access"], 0) | (VOLATILE if value["persistent"] == "no" else 0)
        default = number(value["default"]) or (0 if low[0] <= 0 <= high[0] else low[0], False)
        facts = (low[0], high[0], default[0], 5 if signed else 4, attributes)
        for sub, fact in enumerate(facts, 2):
            if sub not in subs:
                # Of a channel that is chosen there is the value alone.
                break
            subs[sub] |= {"access": "const", "default": str(fact), "min": "", "max": ""}
    channels[CHANNELS.start][1] |= {"access": "const", "default": str(max(channels) - CHANNELS.start)}
    chosen[CHANNELS.start, 1] = "from here to the last one"


def index_of(row):
    return int(row["index"], 16)


def hexadecimal(value, bits):
    return f"0x{value:0{bits // 4}X}"


def shared_name(index, rows):
    """The name of an object that has sub-indices."""
    pdo = {0x14: "RPDO{} communication parameter", 0x16: "RPDO{} mapping parameter", 0x18: "TPDO{} communication parameter", 0x1A: "TPDO{} mapping parameter"}  # fmt: skip
    if index >> 8 in pdo:
        return pdo[index >> 8].format((index & 0xFF) + 1)
    head, colon, _ = rows[0]["name"].partition(":")
    return NAMES.get(index) or (head if colon else rows[0]["name"])


def entry_name(name, row):
    """The name of a sub-index, without the name of the object in front."""
    if int(row["sub"], 0) == 0:
        return "Number of entries" if row["access"] == "rw" else "Highest sub-index supported"
    own = row["name"].removeprefix(name).lstrip(": ") or row["name"]
    head, colon, rest = own.partition(": ")
    own = rest if colon and name.lower().startswith(head.lower()) else own
    return own[:1].upper() + own[1:]


class Sheet:
    def __init__(self, drive):
        self.drive, self.lines = drive, []
        with open(HERE / drive.file / "objects.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.chosen = choose(rows, HERE / drive.file / "chosen.csv")
        if drive.file == "s200":
            describe_channels(rows, self.chosen)
        self.dummies = {int(row["index"], 16) for row in rows if int(row["index"], 16) < 0x20 and row["pdo_mappable"] == "rx"}
        self.objects = {}
        for row in rows:
            index = int(row["index"], 16)
            if index >= 0x1000:
                self.objects.setdefault(index, []).append(row)
        self.mapped = {
            value[0] >> 16
            for index, rows in self.objects.items()
            if index >> 8 in (0x16, 0x1A)
            for row in rows
            if int(row["sub"], 0) and (value := number(row["default"]))
        }

    def write(self, folder):
        self.head()
        mandatory = [index for index in (0x1000, 0x1001, 0x1018) if index in self.objects]
        maker = [index for index in self.objects if 0x2000 <= index < 0x6000]
        optional = [index for index in self.objects if index not in mandatory and index not in maker]
        for title, indices in (("MandatoryObjects", mandatory), ("OptionalObjects", optional), ("ManufacturerObjects", maker)):
            self.put(f"[{title}]", f"SupportedObjects={len(indices)}")
            self.put(*(f"{count}=0x{index:04X}" for count, index in enumerate(sorted(indices), 1)), "")
            for index in sorted(indices):
                self.object(index, self.objects[index])
        home = folder / self.drive.file
        home.mkdir(exist_ok=True)
        (home / f"{self.drive.file}.eds").write_text("\n".join(self.lines), encoding="utf-8", newline="\n")

    def put(self, *lines):
        self.lines += lines

    def head(self):
        drive = self.drive
        identity = {int(row["sub"], 0): number(row["default"]) or number(row["min"]) for row in self.objects[0x1018]}
        vendor, product, revision = ((identity[sub] or (0, False))[0] for sub in (1, 2, 3))
        self.put(f"; {drive.about}: the object dictionary as the manual tells it.", "; Made by products/convert.py.")
        self.put(*(f"; od-gen: allow {rule} because {why}" for rule, why in drive.silenced.items() if isinstance(rule, str)), "")
        self.put("[FileInfo]", f"FileName={drive.file}.eds", "FileVersion=1", "FileRevision=0", "EDSVersion=4.0", f"Description={drive.about}")
        self.put("CreationTime=12:00PM", "CreationDate=11-21-2026", "CreatedBy=Axis402", "")
        self.put("[DeviceInfo]", f"VendorName={drive.vendor}", f"VendorNumber={hexadecimal(vendor, 32)}", f"ProductName={drive.product}")
        self.put(f"ProductNumber={hexadecimal(product, 32)}", f"RevisionNumber={hexadecimal(revision, 32)}", "OrderCode=")
        self.put(*(f"BaudRate_{rate}={int(rate in drive.bit_rates)}" for rate in ALL_RATES))
        self.put("SimpleBootUpMaster=0", "SimpleBootUpSlave=1", "Granularity=8", "DynamicChannelsSupported=0", "GroupMessaging=0")
        count = lambda page: sum(index >> 8 == page for index in self.objects)  # noqa: E731
        self.put(f"NrOfRXPDO={count(0x14)}", f"NrOfTXPDO={count(0x18)}", f"LSS_Supported={int(drive.lss)}", "")
        self.put("[DummyUsage]", *(f"Dummy{index:04X}={int(index in self.dummies)}" for index in range(1, 8)), "")
        self.put("[Comments]", "Lines=0", "")

    def object(self, index, rows):
        kind = "RECORD" if any(row["object_type"] == "RECORD" for row in rows) else rows[0]["object_type"] or "VAR"
        subs = {int(row["sub"], 0): row for row in rows}
        if list(subs) == [0]:
            self.section(f"{index:04X}", rows[0]["name"], "VAR", rows[0])
            return
        kind = "ARRAY" if kind == "VAR" else kind
        name = shared_name(index, rows)
        present = {sub: row for sub, row in subs.items() if row["access"] != "none"}
        self.put(*self.remark(index))
        if kind == "ARRAY" and len({row["data_type"] for sub, row in present.items() if sub}) > 1:
            kind = "RECORD"
        added = dict.fromkeys(rows[0], "") | {"index": rows[0]["index"], "sub": "0", "data_type": "UNSIGNED8", "access": "const", "pdo_mappable": "no"}  # fmt: skip
        if 0 not in present:
            present = {0: added} | present
        self.put(f"[{index:04X}]", f"ParameterName={name}", f"ObjectType=0x{KINDS[kind]}", f"SubNumber={len(present)}", "")
        for sub, row in present.items():
            if sub == 0 and index >> 8 not in (0x16, 0x1A) and index != 0x1003:
                row = self.highest(row, max(present))
            self.section(f"{index:04X}sub{sub:X}", entry_name(name, row), "VAR", row, (index, sub))

    def highest(self, row, highest):
        """Sub-index 0 with the highest sub-index that there is; what else the manual says goes into a comment."""
        told = number(row["default"])
        if told and told[0] != highest and index_of(row) >> 8 not in (0x14, 0x18):
            self.put(f"; The manual's number of entries is {told[0]}.")
            told = None
        return row if told else row | {"default": str(highest), "min": "", "max": ""}

    def remark(self, key):
        if key in self.drive.remarks:
            yield f"; {self.drive.remarks[key]}"
        for rule, why in self.drive.silenced.items():
            if isinstance(rule, tuple) and rule[1] == key:
                yield f"; od-gen: allow {rule[0]} because {why}"

    def section(self, title, name, kind, row, place=None):
        index, sub = place or (int(row["index"], 16), 0)
        data_type = row["data_type"] or "UNSIGNED8"
        access, mappable = self.access(index, row)
        if (index, sub) in self.chosen:
            self.put(f"; Chosen, as the manual does not tell: {self.chosen[index, sub]}.")
        text = []
        if row["default"].startswith(";"):
            text.append(row["default"])
        elif data_type in STRINGS:
            if row["default"]:
                text.append(f"DefaultValue={row['default']}")
        elif data_type in SIZES:
            text += self.numbers(data_type, row)
        is_parameter = access == "rw" and index not in (0x1003, 0x1010, 0x1011)
        # In the order of `od-gen fmt`: comments, then keys.
        self.put(*self.remark((index, sub) if place else index), f"[{title}]")
        self.put(*(line for line in text if line.startswith(";")))
        if row["unit"]:
            self.put(f";Unit={row['unit']}")
        if row["persistent"] == "no" and is_parameter:
            self.put(";Storage=none")
        self.put(f"ParameterName={name}", f"ObjectType=0x{KINDS[kind]}", f"DataType=0x{CODES[data_type]:04X}", f"AccessType={access}")
        self.put(*(line for line in text if not line.startswith(";")), f"PDOMapping={int(mappable)}", "")

    def access(self, index, row):
        access, told = row["access"] or "ro", row["pdo_mappable"]
        access = "rw" if access == "reserved" else access
        unknown = told not in ("no", "rx", "tx", "yes")
        mappable = index >= 0x1000 and (told in ("rx", "tx", "yes") or (unknown and index in PROCESS_DATA) or index in self.mapped)
        if access == "rw" and mappable and told == "rx":
            access = "rww"
        if access == "rw" and mappable and told == "tx":
            access = "rwr"
        return access, mappable

    def numbers(self, data_type, row):
        _, bits, signed = SIZES[data_type]
        least, most = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
        default, low, high = (number(row[column]) for column in ("default", "min", "max"))
        if index_of(row) in (0x1010, 0x1011):
            low = high = None
        if low and high and not default and not low[0] <= 0 <= high[0]:
            default, row = low, row | {"default": row["min"]}
        for text, limit in (("lower", low), ("upper", high)):
            if limit and default and not default[1] and (default[0] < limit[0] if text == "lower" else default[0] > limit[0]):
                yield f"; The manual's {text} limit is {limit[0]}."
                low, high = (None, high) if text == "lower" else (low, None)
        if low and least < low[0] <= most and not low[1]:
            yield f"LowLimit={low[0]}"
        if high and least <= high[0] < most and not high[1]:
            yield f"HighLimit={high[0]}"
        if default:
            value, adds = default
            shown = hexadecimal(value, bits) if "x" in row["default"].lower() else str(value)
            yield f"DefaultValue={'$NODEID+' if adds else ''}{shown}"
        elif row["default"]:
            yield f"; The manual's default: {row['default']}"


def main(folder):
    for drive in DRIVES:
        Sheet(drive).write(folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
