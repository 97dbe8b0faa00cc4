"""A device against its own data sheet, by python-canopen: what is expected comes from the file and from CiA 301 alone, so the same procedures are for the
virtual drive (`test_conformance.py`), for a device that is none (`test_basic_device.py`), and for the flashed image on the model of its chip (`tests/machine/test_conformance.py`).

They are the procedures of `tests/cases/conformance` with fewer values: python-canopen is another reader of data sheets, and another client."""

import configparser

import can
import canopen
from canopen.objectdictionary import datatypes
from canopen.sdo import SdoAbortedError, SdoClient

NO_OBJECT, NO_SUB_INDEX = 0x0602_0000, 0x0609_0011
READ_ONLY, WRITE_ONLY, IN_USE = 0x0601_0002, 0x0601_0001, 0x0601_0000
TOO_LONG, TOO_SHORT = 0x0607_0012, 0x0607_0013
TOO_HIGH, TOO_LOW, INVALID, TOO_MANY = 0x0609_0031, 0x0609_0032, 0x0609_0030, 0x0604_0042
NO_SIGNATURE, NO_DATA = 0x0800_0020, 0x0800_0024

#: What "refuse write on download" and "refuse read on scan" are in ObjFlags (CiA 306).
KEEP_WRITES, KEEP_READS = 1, 2

#: The transmission types that there are: what SYNC counts, what a remote frame asks for, what an event sends.
SYNCHRONOUS, ON_REQUEST, ON_EVENT = range(0, 241), (252, 253), (254, 255)
#: Of them these are played.
PLAYED = (0, 1, 2, 3, 17, 240, *ON_REQUEST, *ON_EVENT)

OFF, NO_REMOTE = 1 << 31, 1 << 30

PRE_OPERATIONAL, OPERATIONAL, STOPPED = 0x7F, 0x05, 0x04
#: By NMT command, the state that follows.
COMMANDS = {1: OPERATIONAL, 2: STOPPED, 0x80: PRE_OPERATIONAL, 0x81: PRE_OPERATIONAL, 0x82: PRE_OPERATIONAL}


class Device:
    """A booted device on a network in virtual time, and its data sheet. Two objects of it, UNSIGNED32, take any value by SDO: one that it sends, and one
    that it receives."""

    def __init__(self, network, node_id, sheet, sent=0x6083, received=0x6083):
        self.network, self.node_id = network, node_id
        self.sent, self.received = sent, received
        self.od = canopen.import_od(str(sheet), node_id)
        # The client knows no object, so it neither fits nor cuts a value.
        self.sdo = SdoClient(0x600 + node_id, 0x580 + node_id, canopen.ObjectDictionary())
        self.sdo.network = network
        network.subscribe(self.sdo.tx_cobid, self.sdo.on_response)
        self.seen = {}
        parser = configparser.RawConfigParser(strict=False)
        parser.read(sheet)
        self.flags = {name.lower(): int(section.get("objflags", "0"), 0) for name, section in parser.items()}

    def objects(self):
        """All but the types of the dummies below 1000h."""
        return [(index, entry) for index, entry in self.od.items() if index >= 0x1000]

    def variables(self):
        for _, entry in self.objects():
            yield from entry.values() if hasattr(entry, "subindices") else (entry,)

    def flag(self, variable, bit):
        name = f"{variable.index:x}"
        return (self.flags.get(name, 0) | self.flags.get(f"{name}sub{variable.subindex:x}", 0)) & bit

    def readable(self):
        return [v for v in self.variables() if v.readable and not self.flag(v, KEEP_READS)]

    def writable(self):
        return [v for v in self.variables() if v.writable and not self.flag(v, KEEP_WRITES)]

    # The bus.

    def upload(self, index, subindex=0):
        """The bytes, or the code of the abort."""
        try:
            return self.sdo.upload(index, subindex)
        except SdoAbortedError as error:
            return error.code

    def download(self, index, subindex, data):
        """0, or the code of the abort."""
        try:
            self.sdo.download(index, subindex, bytes(data))
            return 0
        except SdoAbortedError as error:
            return error.code

    def number(self, index, subindex, value, size):
        assert self.download(index, subindex, value.to_bytes(size, "little")) == 0, f"{index:04X}h:{subindex:02X} := {value}"

    def command(self, specifier):
        self.network.send_message(0, bytes([specifier, self.node_id]))

    def count(self, cob_id, seconds, data=None):
        """How many frames of an identifier come within a time."""
        seen = []
        keep = lambda _id, payload, _time: seen.append(bytes(payload))
        self.network.subscribe(cob_id, keep)
        self.network.bus.run(seconds)
        self.network.unsubscribe(cob_id, keep)
        return len(seen) if data is None else seen.count(data)


def name(variable):
    return f"{variable.index:04X}h:{variable.subindex:02X}"


def size(variable):
    """In bytes; None for what has no size of its own."""
    return -(-len(variable) // 8) if variable.data_type in datatypes.NUMBER_TYPES or variable.data_type == datatypes.BOOLEAN else None


def objects_are_what_the_data_sheet_says(device):
    """Every readable object has its size and default, and what is read-only cannot be written."""
    for variable in device.variables():
        index, sub = variable.index, variable.subindex
        if not variable.readable:
            assert device.upload(index, sub) == WRITE_ONLY, name(variable)
        elif index == 0x1003 and sub > 0:
            # An empty history has no entries.
            assert device.upload(index, sub) == NO_DATA, name(variable)
        elif not device.flag(variable, KEEP_READS):
            value = device.upload(index, sub)
            assert isinstance(value, bytes), f"{name(variable)}: {value:08X}h"
            assert size(variable) in (None, len(value)), name(variable)
            if variable.default is not None and size(variable):
                assert value == variable.encode_raw(variable.default), name(variable)
        if not variable.writable:
            assert device.download(index, sub, bytes(size(variable) or 1)) == READ_ONLY, name(variable)


def what_is_not_in_the_data_sheet_is_not_there(device):
    for index, entry in device.objects():
        last = max(entry.subindices) if hasattr(entry, "subindices") else 0
        if last < 255:
            assert device.upload(index, last + 1) == NO_SUB_INDEX, f"{index:04X}h:{last + 1:02X}"
    for index in range(0x1000, 0x6800, 97):
        if index not in device.od:
            assert device.upload(index) == NO_OBJECT, f"{index:04X}h"


def other_lengths_are_refused(device):
    for variable in device.writable():
        if bytes_ := size(variable):
            index, sub = variable.index, variable.subindex
            assert device.download(index, sub, bytes(bytes_ + 1)) == TOO_LONG, name(variable)
            if bytes_ > 1:
                assert device.download(index, sub, bytes(bytes_ - 1)) == TOO_SHORT, name(variable)


def values_beyond_a_limit_are_refused(device):
    """An object whose owner knows better may say so in its own word, and one that is locked is not asked."""
    for variable in device.writable():
        if not size(variable) or variable.data_type not in datatypes.INTEGER_TYPES:
            continue
        for limit, step, code in ((variable.min, -1, TOO_LOW), (variable.max, 1, TOO_HIGH)):
            if limit is None:
                continue
            try:
                data = variable.encode_raw(limit + step)
            except Exception:  # noqa: BLE001: the type has no such value
                continue
            refused = device.download(variable.index, variable.subindex, data)
            assert refused in (code, INVALID, TOO_MANY, IN_USE, NO_SIGNATURE), f"{name(variable)} := {limit + step}: {refused:08X}h"


def commands_lead_where_they_should(device):
    """Each state, and each command in it: the heartbeats that follow, and whether SDO is served."""
    beat = 0x700 + device.node_id
    for enters, state in list(COMMANDS.items())[:3]:
        for specifier, follows in COMMANDS.items():
            what = f"command {specifier:02X}h in {state:02X}h"
            device.number(0x1017, 0, 20, 2)
            device.command(enters)
            device.network.bus.run(0.025)
            assert device.count(beat, 0.021, bytes([state])) == 1, what
            device.command(specifier)
            if specifier >= 0x81:
                assert device.count(beat, 0.2, b"\0") == 1, what
                assert device.upload(0x1017) == b"\0\0", what
                device.number(0x1017, 0, 20, 2)
            device.network.bus.run(0.025)
            assert device.count(beat, 0.021, bytes([follows])) == 1, what
            device.network.send_message(0x600 + device.node_id, bytes.fromhex("40 00 10 00 00 00 00 00"))
            assert device.count(0x580 + device.node_id, 0.02) == (follows != STOPPED), what
            device.command(0x80)
            device.network.bus.run(0.005)
            device.number(0x1017, 0, 0, 2)


class Pdo:
    """The first transmit or receive PDO, with one object in it and without timers; all others are off."""

    def __init__(self, device, communication):
        self.device, self.communication = device, communication
        for index in (*range(0x1400, 0x1600), *range(0x1800, 0x1A00)):
            if index in device.od:
                cob_id = int.from_bytes(device.upload(index, 1), "little")
                device.number(index, 1, cob_id | OFF, 4)
        self.cob_id = (0x200 if communication == 0x1400 else 0x180) + device.node_id

    def have(self, object_, bits, trans_type, remote=NO_REMOTE):
        device, index = self.device, self.communication
        flags = remote if index == 0x1800 else 0
        device.number(index, 1, self.cob_id | flags | OFF, 4)
        device.number(index + 0x200, 0, 0, 1)
        device.number(index + 0x200, 1, object_ << 16 | bits, 4)
        device.number(index + 0x200, 0, 1, 1)
        device.number(index, 2, trans_type, 1)
        if index == 0x1800:
            device.number(index, 3, 0, 2)
            device.number(index, 5, 0, 2)
        device.number(index, 1, self.cob_id | flags, 4)

    def sync(self):
        self.device.network.send_message(0x80, b"")
        return self.device.count(self.cob_id, 0.0005)


def each_transmission_type_is_taken_or_refused(device):
    for index in (0x1400, 0x1800):
        for trans_type in range(256):
            is_there = trans_type in SYNCHRONOUS or trans_type in ON_EVENT or index == 0x1800 and trans_type in ON_REQUEST
            assert device.download(index, 2, [trans_type]) == (0 if is_there else INVALID), f"{index:04X}h:02 := {trans_type}"


def each_type_is_sent_when_it_is_due(device):
    """By SYNC, on entering Operational, and on remote request."""
    pdo = Pdo(device, 0x1800)
    for trans_type in PLAYED:
        device.command(0x80)
        pdo.have(device.sent, 32, trans_type)
        assert pdo.sync() == 0, f"type {trans_type} before Operational"
        device.command(1)
        assert device.count(pdo.cob_id, 0.003) == (trans_type in ON_EVENT), f"type {trans_type} on entering Operational"
        for sync in range(1, (2 if trans_type < 240 else 1) * max(1, min(trans_type, 240)) + 1):
            due = sync == 1 if trans_type == 0 else trans_type in SYNCHRONOUS and sync % trans_type == 0
            assert pdo.sync() == due, f"type {trans_type} at SYNC {sync}"
        for forbidden in (0, NO_REMOTE):
            pdo.have(device.sent, 32, trans_type, forbidden)
            device.count(pdo.cob_id, 0.003)
            device.network.bus.send(can.Message(arbitration_id=pdo.cob_id, is_remote_frame=True, is_extended_id=False, dlc=4))
            answers = trans_type in ON_REQUEST or not forbidden
            assert device.count(pdo.cob_id, 0.003) == answers, f"type {trans_type}, bit 30 {bool(forbidden)}"
    device.command(0x80)


def a_change_is_sent_with_its_inhibit_time_and_again_by_its_timer(device):
    pdo = Pdo(device, 0x1800)
    device.command(0x80)
    pdo.have(device.sent, 32, 255)
    device.number(0x1800, 1, pdo.cob_id | OFF, 4)
    # 10 ms between two of them, and one each 50 ms.
    device.number(0x1800, 3, 100, 2)
    device.number(0x1800, 5, 50, 2)
    device.number(0x1800, 1, pdo.cob_id, 4)
    device.command(1)
    device.network.bus.run(0.2)
    assert device.count(pdo.cob_id, 0.5) in (9, 10, 11)
    times = []
    keep = lambda _id, _data, time: times.append(time)
    device.network.subscribe(pdo.cob_id, keep)
    for value in range(1, 30):
        device.number(device.sent, 0, value, 4)
    device.network.bus.run(0.02)
    device.network.unsubscribe(pdo.cob_id, keep)
    assert len(times) > 1
    assert all(0.0099 < after - before < 0.0505 for before, after in zip(times, times[1:]))
    device.command(0x80)


def each_type_is_received_when_it_is_due(device):
    """0 to 240 at the next SYNC, the others at once."""
    pdo = Pdo(device, 0x1400)
    for trans_type in (trans_type for trans_type in PLAYED if trans_type not in ON_REQUEST):
        device.command(0x80)
        pdo.have(device.received, 32, trans_type)
        device.command(1)
        before, value = device.upload(device.received), (1_000 + trans_type).to_bytes(4, "little")
        device.network.send_message(pdo.cob_id, value)
        device.network.bus.run(0.002)
        expected = before if trans_type in SYNCHRONOUS else value
        assert device.upload(device.received) == expected, f"type {trans_type} before SYNC"
        pdo.sync()
        device.network.bus.run(0.002)
        assert device.upload(device.received) == value, f"type {trans_type} behind SYNC"
    device.command(0x80)


#: Each of them leaves values of its own; the device is a fresh one.
PROCEDURES = (
    objects_are_what_the_data_sheet_says,
    what_is_not_in_the_data_sheet_is_not_there,
    other_lengths_are_refused,
    values_beyond_a_limit_are_refused,
    commands_lead_where_they_should,
    each_transmission_type_is_taken_or_refused,
    each_type_is_sent_when_it_is_due,
    a_change_is_sent_with_its_inhibit_time_and_again_by_its_timer,
    each_type_is_received_when_it_is_due,
)
