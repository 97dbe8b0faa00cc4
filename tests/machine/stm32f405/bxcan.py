"""CAN 1 (RM0090, 32), and the bus it is on. One frame at a time, the lowest identifier first; a master acknowledges while there is one."""

import collections
import struct
from collections import namedtuple

from . import can_filters
from .clock import NEVER
from .interrupts import IRQ
from .registers import Peripheral, Register

INRQ, SLEEP, TXFP, ABOM, TTCM, RESET = 1, 2, 1 << 2, 1 << 6, 1 << 7, 0x8000
INAK, SLAK, ERRI = 1, 2, 4
EWGF, EPVF, BOFF = 1, 2, 4
SILENT = 1 << 31

#: Core clocks in a clock of the controller, which has that of APB1.
RATIO = 4

Frame = namedtuple("Frame", "id extended remote data time", defaults=(0,))


class Can(Peripheral):
    NAME = "CAN1"
    READ_SIZES = WRITE_SIZES = (4,)
    CLOCK = (0x40, 25)
    REGISTERS = (
        {
            0x00: Register("MCR", 0x1_80FF, 0x1_0002, known=0x1_0000 | RESET | TTCM | ABOM | TXFP | INRQ | SLEEP),
            0x04: Register("MSR", 0, 0xC02, rc_w1=0x1C, keep=False),
            0x08: Register("TSR", 0x0080_8080, 0x1C00_0000, keep=False),
            0x0C: Register("RF0R", 0x38, keep=False),
            0x10: Register("RF1R", 0x38, keep=False),
            0x14: Register("IER", 0x3_8F7F, known=0x8F5B),
            0x18: Register("ESR", 0x70, keep=False),
            0x1C: Register("BTR", 0xC37F_03FF, 0x0123_0000),
        }
        | {
            0x180 + 16 * i + 4 * j: Register(f"T{i}{name}", bits)
            for i in range(3)
            for j, (name, bits) in enumerate((("IR", 0xFFFF_FFFF), ("DTR", 0xFFFF_010F), ("DLR", 0xFFFF_FFFF), ("DHR", 0xFFFF_FFFF)))
        }
        | {0x1B0 + 16 * i + 4 * j: Register(f"R{i}{name}", 0) for i in range(2) for j, name in enumerate(("IR", "DTR", "DLR", "DHR"))}
        | can_filters.REGISTERS
    )

    def __init__(self, chip):
        #: What the master has sent, and what is told of the frames of this device.
        self.to_send = collections.deque()
        self.on_frame = lambda frame: None
        #: Somebody acknowledges; the clocks of a bit that the others have, or None for those that the controller has.
        self.acknowledged, self.bus_bit = True, None
        #: Somebody holds the bus dominant (`hold`).
        self.held = False
        self.stats = collections.Counter()
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.fifos, self.overruns = ([], []), [False, False]
        #: Which of the mailboxes was asked to send first, with TXFP.
        self.requests, self.requested = 0, [0, 0, 0]
        self.busy_until, self.on_bus, self.idle_from, self.began = NEVER, None, 0, 0
        self.normal_at = self.recover_at = NEVER
        self.wants_to_leave = False

    # Time on the bus.

    def bit(self):
        b = self["BTR"]
        return ((b & 0x3FF) + 1) * (3 + (b >> 16 & 15) + (b >> 20 & 7)) * RATIO

    def frame_time(self, length, extended):
        """Up to the end of the frame, behind which three bits are between frames."""
        bits = 44 + 8 * length + (20 if extended else 0)
        # Every eighth bit is stuffed, about.
        return (bits + (bits - 10) // 8) * self.bit()

    def time_stamp(self):
        """A counter of 16 bits that counts bits, as it was at the start of the frame: where RDTR and TDTR have it. It counts with TTCM alone."""
        if not self["MCR"] & TTCM:
            return 0
        return (self.began // self.bit() & 0xFFFF) << 16

    def takes_part(self):
        return not self.r[0x04] & (INAK | SLAK) and not self.r[0x18] & BOFF

    # Registers.

    def write_MCR(self, value):
        if value & RESET:
            return self.reset()
        if value & INRQ and value & SLEEP:
            self.breach("INRQ and SLEEP at once")
        if value & SLEEP and self["ESR"] & BOFF and not self["MCR"] & SLEEP:
            self.breach("sleep is asked for in bus-off: recovery is INIT and NORMAL")
        self["MCR"] = value
        self.change_mode(self.chip.now())

    def change_mode(self, now):
        if self.on_bus:
            self.wants_to_leave = True
            return
        mcr = self["MCR"]
        msr = self["MSR"] & ~(INAK | SLAK)
        if mcr & (INRQ | SLEEP):
            self.normal_at = self.recover_at = NEVER
            self["MSR"] = msr | (INAK if mcr & INRQ else SLAK)
            return
        if self["MSR"] & (INAK | SLAK):
            from_init = self["MSR"] & INAK
            self.check_pins()
            if self["ESR"] & BOFF:
                self["MSR"] = msr
                if from_init:
                    self.recover_at = now + 128 * 11 * self.bit()
            else:
                # It says that it is there once it has seen so many recessive bits.
                self.normal_at = NEVER if self.held else now + 11 * self.bit()

    def hold(self, held):
        """The bus is held dominant from now on, with no frame on it, or let go."""
        assert not self.on_bus
        self.held = held
        if not held and not self["MCR"] & (INRQ | SLEEP):
            self.normal_at = self.chip.now() + 11 * self.bit()

    def check_pins(self):
        for pin in (8, 9):
            if self.chip.gpio["B"].function(pin) != 9:
                self.breach(f"goes on the bus while PB{pin} is not its pin")
        self.chip.pins.floats("PB8", "CAN receive")

    def write_TSR(self, value):
        for i in range(3):
            if value >> 8 * i & 0x80 and self[f"T{i}IR"] & 1:
                if self.on_bus == ("sent", i):
                    # Only at the end of the frame it shows whether it has left.
                    self["TSR"] |= 0x80 << 8 * i
                    self.stats["aborts of the frame on the bus"] += 1
                else:
                    self.finish(i, False)
                    self.stats["aborts"] += 1

    def store(self, offset, size, value):
        if offset == 0x08 and size == 4 and self.has_clock():
            # RQCP is cleared by 1, and its companions with it.
            for i in range(3):
                if value >> 8 * i & 1:
                    self["TSR"] &= ~(0xF << 8 * i)
        super().store(offset, size, value)

    def finish(self, mailbox, has_left):
        self[f"T{mailbox}IR"] &= ~1
        base = 8 * mailbox
        done = 1 << base | (2 << base if has_left else 0) | 1 << 26 + mailbox
        self["TSR"] = self["TSR"] & ~(0x8E << base) | done

    def read_TSR(self):
        tsr = self["TSR"]
        free = [i for i in range(3) if tsr >> 26 + i & 1]
        code = free[0] if free else max(range(3), key=lambda i: (self[f"T{i}IR"] >> 3, i))
        return tsr & ~(3 << 24) | code << 24

    def read_fifo(self, number):
        length = len(self.fifos[number])
        return min(length, 3) | (length >= 3) << 3 | self.overruns[number] << 4

    def write_fifo(self, number, value):
        if value & 1 << 4:
            self.overruns[number] = False
        if value & 1 << 5:
            if not self.fifos[number]:
                return self.breach(f"the output mailbox is released while FIFO {number} is empty")
            self.fifos[number].pop(0)

    def head(self, number, word):
        if not self.fifos[number]:
            self.breach(f"FIFO {number} is read while it is empty")
            return 0
        return self.fifos[number][0][word]

    def write_BTR(self, value):
        if not self["MSR"] & INAK:
            return self.breach("BTR written outside of initialisation mode")
        if value & 1 << 30:
            self.breach("loop back is not modelled")
        before, behind, jump = 2 + (value >> 16 & 15), 1 + (value >> 20 & 7), 1 + (value >> 24 & 3)
        # CiA 301, 5.3: the middle of what others may have is 87.5 %.
        if not 0.75 <= before / (before + behind) <= 0.9 or jump > behind:
            self.breach(f"BTR {value:#x} samples at {before} of {before + behind} quanta and jumps by {jump}")
        self["BTR"] = value

    def write_mailbox(self, mailbox, name, value):
        if not self["TSR"] >> 26 + mailbox & 1:
            return self.breach(f"mailbox {mailbox} written while a frame waits in it")
        if name == "DTR" and value & 1 << 8:
            self.breach("TGT: the time stamp in the data is not modelled")
        self[f"T{mailbox}{name}"] = value
        if name == "IR" and value & 1:
            self["TSR"] &= ~(1 << 26 + mailbox | 0xF << 8 * mailbox)
            self.requests += 1
            self.requested[mailbox] = self.requests
            self.begin_frame(self.chip.now())

    def write_filter(self, name, value):
        if not self["FMR"] & 1:
            self.breach(f"{name} written outside of the filters' initialisation")
        self[name] = value

    def write_bank(self, bank, name, value):
        if not self["FMR"] & 1 and self["FA1R"] >> bank & 1:
            self.breach(f"{name} written while its bank is on")
        self[name] = value

    # The bus.

    def begin_frame(self, now):
        if self.on_bus or not self.takes_part() or now < self.idle_from:
            return
        waiting = [(self[f"T{i}IR"] >> 3, i) for i in range(3) if self[f"T{i}IR"] & 1]
        if self["BTR"] & SILENT:
            waiting = []
        theirs = self.to_send[0] if self.to_send else None
        order = theirs and (theirs.id if theirs.extended else theirs.id << 18)
        first = min(waiting, default=None)
        if first and self["MCR"] & TXFP:
            first = min(waiting, key=lambda its: self.requested[its[1]])
        if first and (theirs is None or first[0] < order):
            mailbox = first[1]
            self.on_bus, self.began = ("sent", mailbox), now
            self.busy_until = now + self.frame_time(self[f"T{mailbox}DTR"] & 15, self[f"T{mailbox}IR"] & 4)
        elif theirs is not None:
            self.to_send.popleft()
            self.on_bus, self.began = ("received", theirs), now
            self.busy_until = now + self.frame_time(len(theirs.data), theirs.extended)

    def wants_to_send(self):
        return self.r[0x08] >> 26 & 7 != 7 and not self.r[0x1C] & SILENT

    def next_event(self):
        if self.on_bus is None and (self.to_send or self.wants_to_send()) and self.takes_part():
            return max(self.chip.time, self.idle_from)
        return min(self.busy_until, self.normal_at, self.recover_at)

    def event(self):
        now = self.chip.time
        if self.recover_at <= now:
            self.recover_at = NEVER
            self["ESR"] = 0
        if self.normal_at <= now:
            self.normal_at = NEVER
            self["MSR"] &= ~(INAK | SLAK)
        if self.busy_until <= now:
            kind, what = self.on_bus
            self.on_bus, self.busy_until, self.idle_from = None, NEVER, now + 3 * self.bit()
            if self.bus_bit is not None and self.bus_bit != self.bit():
                self.garbled()
            elif kind == "sent":
                self.end_sent(what, now)
            else:
                self.end_received(what)
            if self.wants_to_leave:
                self.wants_to_leave = False
                self.change_mode(now)
        self.begin_frame(now)

    def end_sent(self, mailbox, now):
        if not self.acknowledged:
            # An acknowledge error, for which an error-passive controller counts no more; an abort that was asked for happens.
            self.count_errors(8 if not self["ESR"] & EPVF else 0, 0, 3)
            if self["TSR"] >> 8 * mailbox & 0x80:
                self.finish(mailbox, False)
            return
        self.count_errors(-1, 0, 0)
        ir, length = self[f"T{mailbox}IR"], self[f"T{mailbox}DTR"] & 15
        data = struct.pack("<II", self[f"T{mailbox}DLR"], self[f"T{mailbox}DHR"])[:length]
        extended = bool(ir & 4)
        self[f"T{mailbox}DTR"] |= self.time_stamp()
        self.finish(mailbox, True)
        self.stats["sent"] += 1
        self.on_frame(Frame(ir >> 3 if extended else ir >> 21, extended, bool(ir & 2), data, now))

    def end_received(self, frame):
        self.count_errors(0, -1, 0)
        word = (frame.id << 3 | 4 if frame.extended else frame.id << 21) | frame.remote << 1
        taken = can_filters.match(self, word)
        if taken is None:
            self.stats["filtered"] += 1
            return
        number, filter_number = taken
        fifo = self.fifos[number]
        entry = (word, len(frame.data) | filter_number << 8 | self.time_stamp(), *struct.unpack("<II", frame.data.ljust(8, b"\0")))
        if len(fifo) >= 3:
            fifo[2] = entry
            self.overruns[number] = True
            self.stats["overruns"] += 1
        else:
            fifo.append(entry)
            self.stats["received"] += 1

    def garbled(self):
        """A frame at another bit rate than that of the controller."""
        if not self["BTR"] & SILENT:
            self.count_errors(0, 1, 1)
        else:
            self["ESR"] = self["ESR"] & ~0x70 | 1 << 4

    def count_errors(self, transmit, receive, code):
        esr = self["ESR"]
        tec = max(0, (esr >> 16 & 0xFF) + transmit)
        rec = max(0, (esr >> 24) + receive)
        if tec > 255:
            return self.go_bus_off()
        flags = (tec >= 96 or rec >= 96) * EWGF | (tec > 127 or rec > 127) * EPVF
        rec = min(rec, 255)
        risen = flags & ~esr & (EWGF | EPVF)
        self["ESR"] = rec << 24 | tec << 16 | (code << 4 if code or transmit or receive else esr & 0x70) | flags
        enabled = self["IER"] >> 8 & 7
        if risen & enabled or code and self["IER"] >> 11 & 1:
            self["MSR"] |= ERRI

    def go_bus_off(self):
        """256 transmit errors."""
        self["ESR"] = self["ESR"] & 0xFF00_0070 | 0xFF_0000 | EWGF | EPVF | BOFF
        if self["IER"] >> 10 & 1:
            self["MSR"] |= ERRI
        self.on_bus, self.busy_until = None, NEVER
        if self["MCR"] & ABOM:
            self.recover_at = self.chip.now() + 128 * 11 * self.bit()

    def lines(self):
        ier, irqs = self.r[0x14], []
        if ier & 1 and self.r[0x08] & 0x01_0101:
            irqs.append(IRQ["CAN1_TX"])
        for number, enabled in ((0, ier), (1, ier >> 3)):
            if enabled & 2 and self.fifos[number] or enabled & 8 and self.overruns[number]:
                irqs.append(IRQ[f"CAN1_RX{number}"])
        if ier & 0x8000 and self.r[0x04] & ERRI:
            irqs.append(IRQ["CAN1_SCE"])
        return irqs


def _bind():
    for mailbox in range(3):
        for name in ("IR", "DTR", "DLR", "DHR"):
            write = lambda self, value, m=mailbox, n=name: self.write_mailbox(m, n, value)
            setattr(Can, f"write_T{mailbox}{name}", write)
    for number in range(2):
        setattr(Can, f"read_RF{number}R", lambda self, n=number: self.read_fifo(n))
        setattr(Can, f"write_RF{number}R", lambda self, value, n=number: self.write_fifo(n, value))
        for word, name in enumerate(("IR", "DTR", "DLR", "DHR")):
            setattr(Can, f"read_R{number}{name}", lambda self, n=number, w=word: self.head(n, w))
    for name in can_filters.SETTINGS:
        setattr(Can, f"write_{name}", lambda self, value, n=name: self.write_filter(n, value))
    for bank in range(can_filters.BANKS):
        for name in (f"F{bank}R1", f"F{bank}R2"):
            setattr(Can, f"write_{name}", lambda self, value, b=bank, n=name: self.write_bank(b, n, value))


_bind()
