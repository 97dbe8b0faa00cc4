//! Finding an entry by index and sub-index, in dictionaries of three sizes.

use canopen::od::{buckets, Attributes, DataType, Entry, Table};
use core::hint::black_box;

use crate::{count, row};

/// `N` entries: records with eight sub-indices each, as in the manufacturer's area.
const fn entries<const N: usize>() -> [Entry; N] {
    let attributes = Attributes::READ | Attributes::ROM;
    let first = (0x2000, 0);
    let entry = Entry::new(first, DataType::Unsigned8, 0, Entry::NO_LIMITS, attributes);
    let mut entries = [entry; N];
    let mut at = 0;
    while at < N {
        entries[at].index = 0x2000 + (at / 8) as u16;
        entries[at].sub = (at % 8) as u8;
        at += 1;
    }
    entries
}

const fn table(entries: &'static [Entry], buckets: &'static [u16]) -> Table {
    Table {
        entries,
        buckets,
        rom: &[0],
        defaults: &[],
        limits: &[],
        storage: Table::NO_STORAGE,
    }
}

static SMALL_ENTRIES: [Entry; 100] = entries();
static MIDDLE_ENTRIES: [Entry; 400] = entries();
static LARGE_ENTRIES: [Entry; 2000] = entries();

static SMALL: Table = table(&SMALL_ENTRIES, &buckets::<32>(&SMALL_ENTRIES));
static MIDDLE: Table = table(&MIDDLE_ENTRIES, &buckets::<128>(&MIDDLE_ENTRIES));
static LARGE: Table = table(&LARGE_ENTRIES, &buckets::<512>(&LARGE_ENTRIES));

pub fn run() {
    for (name, table) in [
        ("100 entries", &SMALL),
        ("400 entries", &MIDDLE),
        ("2,000 entries", &LARGE),
    ] {
        row(name, mean(table));
    }
}

/// The mean of all entries, each of which is found.
fn mean(table: &'static Table) -> u32 {
    let table = black_box(table);
    let mut sum = 0;
    for entry in table.entries {
        let (cost, found) = count(|| table.find(black_box(entry.index), black_box(entry.sub)));
        assert!(found == Ok(entry));
        sum += cost;
    }
    sum / table.entries.len() as u32
}
