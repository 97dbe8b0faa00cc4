"""What the instructions of the FPU cost (Cortex-M4 TRM, 7.2.3), one behind the other in a block of a program: single precision, as this core has no other."""

#: Clocks beyond the first one of a division and a square root, and of what multiplies and adds.
DIVISION, ACCUMULATION = 13, 2

#: Registers that a frame with those of the FPU has more: S0 to S15, FPSCR, and a clock for each to stack them, and to take them back.
STACKED = 17


def is_float(half, second):
    """Whether the FPU has a part in an instruction of two halves."""
    return half >> 8 in (0xEC, 0xED, 0xEE) and second & 0xE00 == 0xA00


class Fpu:
    """What it is at: the result of the instruction before, and the clocks that a division still takes."""

    def __init__(self):
        self.result, self.busy = None, 0

    def pass_by(self, clocks):
        """An instruction of the core takes so many. Behind a division the core goes on meanwhile."""
        self.result, self.busy = None, max(0, self.busy - clocks)

    def extra(self, half, second):
        """Clocks beyond the first one of its next instruction."""
        clocks, result, sources = self.decode(half, second)
        # Every instruction of the FPU waits for a division, and a result that is used at once takes one clock longer.
        waits = self.busy + (self.result in sources)
        is_division = clocks == DIVISION
        self.result, self.busy = result, DIVISION if is_division else 0
        return waits + (0 if is_division else clocks)

    def rest(self):
        """What of a division is left where the block ends: the worst case, that an instruction of the FPU follows."""
        return self.busy

    def decode(self, half, second):
        """Clocks beyond the first one, the register of what it computes, and those that it reads."""
        d, n, m = second >> 11 & 0x1E | half >> 6 & 1, half << 1 & 0x1E | second >> 7 & 1, second << 1 & 0x1E | second >> 5 & 1
        is_double = second >> 8 & 1
        if half >> 8 != 0xEE:
            return self.decode_transfer(half, second, d, is_double)
        if second & 0x10:
            # Between a register of the core and one of the FPU.
            return 0, None, () if half & 0x10 == 0 else (n,)
        operation = half >> 4 & 0xB
        if operation in (0, 1, 9, 10):
            # It reads what it adds to a clock later.
            return ACCUMULATION, d, (n, m)
        if operation == 8:
            return DIVISION, d, (n, m)
        if operation in (2, 3):
            return 0, d, (n, m)
        return self.decode_unary(half, second, d, m)

    @staticmethod
    def decode_unary(half, second, d, m):
        """With one operand, or a constant."""
        kind, is_other = half & 0xF, second & 0x40
        if not is_other:
            return 0, None, ()
        if kind == 1 and second & 0x80:
            return DIVISION, d, (m,)
        if kind in (4, 5):
            # A comparison, the second one with 0.
            return 0, None, (d, m) if kind == 4 else (d,)
        # Moves, the magnitude and the sign compute nothing; conversions do.
        return 0, d if kind >= 8 else None, (m,)

    @staticmethod
    def decode_transfer(half, second, d, is_double):
        """To memory and from it. A store takes a second clock too: of this table no buffer makes an exception, as that of integers does."""
        is_load = half >> 4 & 1
        if half & 0xFFE0 == 0xEC40:
            # Between two registers of the core and two of the FPU.
            return 1, None, ()
        if half & 0x120 == 0x100:
            return 1 + is_double, None, () if is_load else (d,)
        first = d if not is_double else (d >> 1 | d << 4 & 0x10) << 1
        return second & 0xFF, None, () if is_load else range(first, first + (second & 0xFF))
