"""Time in clocks of the core."""

HZ = 168_000_000
MS = HZ // 1_000
US = HZ // 1_000_000

#: Later than everything.
NEVER = 1 << 62
