"""The filters of bxCAN (RM0090, 32.7.4): banks of masks or lists, of 32 bits or twice 16, each for one of the two FIFOs."""

from .registers import Register

#: Banks of CAN 1, as CAN2SB has it behind a reset.
BANKS = 14
ALL = (1 << BANKS) - 1

REGISTERS = {
    0x200: Register("FMR", 0x3F01, 0x2A1C_0E01, keep=False, known=1),
    0x204: Register("FM1R", 0x0FFF_FFFF, known=ALL),
    0x20C: Register("FS1R", 0x0FFF_FFFF, known=ALL),
    0x214: Register("FFA1R", 0x0FFF_FFFF, known=ALL),
    0x21C: Register("FA1R", 0x0FFF_FFFF, known=ALL),
} | {0x240 + 8 * bank + 4 * i: Register(f"F{bank}R{i + 1}") for bank in range(BANKS) for i in range(2)}

#: The registers that may be written while the filters are initialised, and no other time; those of a bank while it is off, too.
SETTINGS = ("FM1R", "FS1R", "FFA1R")


def halves(word):
    return word & 0xFFFF, word >> 16


def short(word):
    """An identifier as filters of 16 bits see it."""
    return word >> 21 << 5 | (word >> 1 & 1) << 4 | (word >> 2 & 1) << 3 | word >> 18 & 7


def filters(can, bank):
    """The filters of a bank, each as a test of an identifier."""
    first, second = can[f"F{bank}R1"], can[f"F{bank}R2"]
    is_list, is_wide = can["FM1R"] >> bank & 1, can["FS1R"] >> bank & 1
    if is_wide and is_list:
        return [lambda word, its=its: not (word ^ its) >> 1 for its in (first, second)]
    if is_wide:
        return [lambda word: not (word ^ first) & second]
    if is_list:
        return [lambda word, its=its: short(word) == its for its in (*halves(first), *halves(second))]
    return [lambda word, pair=halves(pair): not (short(word) ^ pair[0]) & pair[1] for pair in (first, second)]


def match(can, word):
    """The FIFO that takes a frame and the number of the filter that has let it in, or None. Filters of 32 bits go before those of 16, lists before
    masks, and then the lower number, which counts those that are off, too."""
    if can["FMR"] & 1:
        return None
    found, numbers = [], [0, 0]
    for bank in range(BANKS):
        fifo = can["FFA1R"] >> bank & 1
        is_wide, is_list = can["FS1R"] >> bank & 1, can["FM1R"] >> bank & 1
        if can["FA1R"] >> bank & 1:
            order = (not is_wide, not is_list)
            found += [(order, numbers[fifo] + i, fifo) for i, lets_in in enumerate(filters(can, bank)) if lets_in(word)]
        numbers[fifo] += (1 if is_wide else 2) << is_list
    if not found:
        return None
    _, number, fifo = min(found)
    return fifo, number
