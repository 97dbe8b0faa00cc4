//! Where node-ID and bit rate come from at power-on, and which source goes before which.
//!
//! | | source | says something about |
//! |---|---|---|
//! | 1 | the build | what it fixes |
//! | 2 | the switches of the board | what their position sets ([`Switches`](super::Switches)) |
//! | 3 | the store: what LSS or an object of the manufacturer has configured last | both |
//! | 4 | the factory ([`Habits::factory`](crate::od::Habits)) | both; else no node-ID, 1 Mbit/s |
//!
//! Node-ID and bit rate are chosen each for itself: the first source that says something counts. A bit rate that this board cannot
//! make is as if nothing was said, so no setting keeps a device off the bus for ever.
//!
//! The order is asked at power-on and never later. What is configured afterwards counts as CiA 305 says; only what the build has
//! fixed cannot be configured.

use super::{BitRate, BitTiming, Configuration, NodeId};

/// What one source says; `None` leaves it to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wish {
    /// The node-ID.
    pub node_id: Option<NodeId>,
    /// The bit rate, or the order to find it.
    pub bit_timing: Option<BitTiming>,
}

impl Wish {
    /// Nothing is asked for.
    pub const NOTHING: Self = Self {
        node_id: None,
        bit_timing: None,
    };

    /// What is asked for, and of the rest what is there.
    pub(crate) const fn over(self, there: Configuration) -> Configuration {
        Configuration {
            node_id: match self.node_id {
                Some(node_id) => node_id,
                None => there.node_id,
            },
            bit_timing: match self.bit_timing {
                Some(bit_timing) => bit_timing,
                None => there.bit_timing,
            },
        }
    }

    /// What a build fixes, from texts that are given to it: the node-ID (1 to 127) and the bit rate (in kbit/s, or `auto`). A text
    /// that is not there fixes nothing. `None` if a text means nothing; that is for the build to refuse.
    pub const fn of_build(node_id: Option<&str>, bit_rate: Option<&str>) -> Option<Self> {
        let mut wish = Self::NOTHING;
        if let Some(text) = node_id {
            wish.node_id = match number(text.as_bytes()) {
                Some(number @ 1..=127) => NodeId::new(number as u8),
                _ => return None,
            };
        }
        if let Some(text) = bit_rate {
            wish.bit_timing = match text.as_bytes() {
                b"auto" => Some(BitTiming::Automatic),
                digits => match number(digits) {
                    Some(1000) => Some(BitTiming::Fixed(BitRate::Kbit1000)),
                    Some(800) => Some(BitTiming::Fixed(BitRate::Kbit800)),
                    Some(500) => Some(BitTiming::Fixed(BitRate::Kbit500)),
                    Some(250) => Some(BitTiming::Fixed(BitRate::Kbit250)),
                    Some(125) => Some(BitTiming::Fixed(BitRate::Kbit125)),
                    Some(50) => Some(BitTiming::Fixed(BitRate::Kbit50)),
                    Some(20) => Some(BitTiming::Fixed(BitRate::Kbit20)),
                    Some(10) => Some(BitTiming::Fixed(BitRate::Kbit10)),
                    _ => return None,
                },
            };
        }
        Some(wish)
    }
}

/// One to four decimal digits.
const fn number(digits: &[u8]) -> Option<u16> {
    if digits.len() > 4 {
        return None;
    }
    let mut number = None;
    let mut rest = digits;
    while let [digit @ b'0'..=b'9', others @ ..] = rest {
        let before = match number {
            Some(number) => number,
            None => 0_u16,
        };
        number = Some(before * 10 + (*digit - b'0') as u16);
        rest = others;
    }
    if rest.is_empty() { number } else { None }
}

impl From<Configuration> for Wish {
    fn from(configuration: Configuration) -> Self {
        Self {
            node_id: Some(configuration.node_id),
            bit_timing: Some(configuration.bit_timing),
        }
    }
}

/// The sources, with the numbers by which objects tell them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Source {
    /// Nobody has said anything.
    Factory = 0,
    /// Stored.
    Store = 1,
    /// The switches of the board.
    Switches = 2,
    /// Fixed by the build.
    Build = 3,
}

/// All that is said at a power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    /// What the build has fixed.
    pub build: Wish,
    /// What the switches ask for; [`Wish::NOTHING`] without switches.
    pub switches: Wish,
    /// What is stored, if anything is.
    pub stored: Option<Configuration>,
    /// What the device leaves the factory with.
    pub factory: Configuration,
}

/// A value and who has said it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chosen<T> {
    /// What counts.
    pub value: T,
    /// Where it comes from.
    pub source: Source,
}

/// What a device starts with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PowerOn {
    /// The node-ID, or [`NodeId::UNCONFIGURED`].
    pub node_id: Chosen<NodeId>,
    /// The bit rate, or the order to find it.
    pub bit_timing: Chosen<BitTiming>,
    /// What is stored, whatever counts now; that of the factory if nothing is.
    pub stored: Configuration,
}

impl PowerOn {
    /// Node-ID and bit rate without their sources.
    pub const fn configuration(&self) -> Configuration {
        Configuration {
            node_id: self.node_id.value,
            bit_timing: self.bit_timing.value,
        }
    }
}

impl Sources {
    /// What a device starts with that makes the bit rates `supported`. If all sources ask for a bit rate it cannot make, and it
    /// cannot make that of the factory either, it has the first of `supported`.
    pub fn choose(&self, supported: &[BitRate]) -> PowerOn {
        let stored = self.stored.map_or(Wish::NOTHING, Wish::from);
        let factory = self.factory;
        let node_id = first(
            [self.build.node_id, self.switches.node_id, stored.node_id],
            factory.node_id,
        );
        let is_possible = |timing: &BitTiming| match timing {
            BitTiming::Fixed(bit_rate) => supported.contains(bit_rate),
            BitTiming::Automatic => true,
        };
        let fastest = supported.first().copied().map(BitTiming::Fixed);
        let factory = Some(factory.bit_timing)
            .filter(is_possible)
            .or(fastest)
            .unwrap_or(factory.bit_timing);
        let wishes = [self.build, self.switches, stored];
        let bit_timing = first(
            wishes.map(|wish| wish.bit_timing.filter(is_possible)),
            factory,
        );
        PowerOn {
            node_id,
            bit_timing,
            stored: self.stored.unwrap_or(self.factory),
        }
    }
}

/// The first that says something, of build, switches and store; otherwise the factory's.
fn first<T>([build, switches, stored]: [Option<T>; 3], factory: T) -> Chosen<T> {
    let chosen = |source| move |value| Chosen { value, source };
    (build.map(chosen(Source::Build)))
        .or(switches.map(chosen(Source::Switches)))
        .or(stored.map(chosen(Source::Store)))
        .unwrap_or(Chosen {
            value: factory,
            source: Source::Factory,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wish(node_id: u8, bit_rate: BitRate) -> Wish {
        Wish {
            node_id: NodeId::new(node_id),
            bit_timing: Some(BitTiming::Fixed(bit_rate)),
        }
    }

    fn stored(node_id: u8, bit_rate: BitRate) -> Option<Configuration> {
        Some(Configuration {
            node_id: NodeId::new(node_id).unwrap(),
            bit_timing: BitTiming::Fixed(bit_rate),
        })
    }

    /// Node-ID and bit rate with the number of their source.
    fn chosen(sources: Sources) -> ((u8, Source), (u32, Source)) {
        let PowerOn {
            node_id,
            bit_timing,
            ..
        } = sources.choose(&BitRate::ALL);
        let rate = bit_timing
            .value
            .bit_rate()
            .map_or(0, BitRate::kbit_per_second);
        (
            (node_id.value.get(), node_id.source),
            (rate, bit_timing.source),
        )
    }

    #[test]
    fn a_build_fixes_what_it_is_given() {
        let of_build = Wish::of_build;
        assert_eq!(of_build(None, None), Some(Wish::NOTHING));
        let both = Some(wish(127, BitRate::Kbit250));
        assert_eq!(of_build(Some("127"), Some("250")), both);
        let automatic = of_build(None, Some("auto")).unwrap();
        assert_eq!(automatic.bit_timing, Some(BitTiming::Automatic));
        for bit_rate in BitRate::ALL {
            let text = std::format!("{}", bit_rate.kbit_per_second());
            let timing = of_build(None, Some(&text)).unwrap().bit_timing;
            assert_eq!(timing, Some(BitTiming::Fixed(bit_rate)));
        }
        for wrong in ["", "0", "128", "255", "5x", "-1", "00005", "65541"] {
            assert_eq!(of_build(Some(wrong), None), None, "{wrong}");
            assert_eq!(of_build(None, Some(wrong)), None, "{wrong}");
        }
        assert_eq!(of_build(None, Some("100")), None);
    }

    #[test]
    fn without_a_word_a_device_is_as_it_left_the_factory() {
        assert_eq!(
            chosen(Sources::default()),
            ((255, Source::Factory), (1000, Source::Factory))
        );
    }

    #[test]
    fn build_goes_before_switches_before_store() {
        let mut sources = Sources {
            build: wish(1, BitRate::Kbit10),
            switches: wish(2, BitRate::Kbit20),
            stored: stored(3, BitRate::Kbit50),
            factory: stored(65, BitRate::Kbit125).unwrap(),
        };
        assert_eq!(chosen(sources), ((1, Source::Build), (10, Source::Build)));
        sources.build = Wish::NOTHING;
        assert_eq!(
            chosen(sources),
            ((2, Source::Switches), (20, Source::Switches))
        );
        sources.switches = Wish::NOTHING;
        assert_eq!(chosen(sources), ((3, Source::Store), (50, Source::Store)));
        sources.stored = None;
        let factory = ((65, Source::Factory), (125, Source::Factory));
        assert_eq!(chosen(sources), factory);
        let stored = sources.choose(&BitRate::ALL).stored;
        assert_eq!(stored, sources.factory, "what counts if nothing is stored");
    }

    #[test]
    fn node_id_and_bit_rate_are_chosen_each_for_itself() {
        let sources = Sources {
            build: Wish {
                bit_timing: Some(BitTiming::Automatic),
                ..Wish::NOTHING
            },
            switches: Wish {
                node_id: NodeId::new(9),
                ..Wish::NOTHING
            },
            stored: stored(3, BitRate::Kbit50),
            ..Sources::default()
        };
        let power_on = sources.choose(&BitRate::ALL);
        assert_eq!(power_on.node_id.value.get(), 9);
        assert_eq!(power_on.bit_timing.value, BitTiming::Automatic);
        assert_eq!(power_on.configuration().bit_timing, BitTiming::Automatic);
    }

    #[test]
    fn a_stored_node_id_may_be_that_there_is_none() {
        let sources = Sources {
            stored: stored(255, BitRate::Kbit250),
            ..Sources::default()
        };
        assert_eq!(
            chosen(sources),
            ((255, Source::Store), (250, Source::Store))
        );
    }

    #[test]
    fn a_bit_rate_that_the_board_cannot_make_is_passed_over() {
        use BitRate::{Kbit20, Kbit50, Kbit500, Kbit800, Kbit1000};
        let sources = Sources {
            build: wish(1, Kbit800),
            switches: wish(2, Kbit20),
            stored: stored(3, Kbit50),
            ..Sources::default()
        };
        let timing = |supported: &[BitRate]| {
            let Chosen { value, source } = sources.choose(supported).bit_timing;
            (value.bit_rate().unwrap(), source)
        };
        assert_eq!(
            timing(&[Kbit1000, Kbit50, Kbit20]),
            (Kbit20, Source::Switches)
        );
        assert_eq!(timing(&[Kbit1000, Kbit50]), (Kbit50, Source::Store));
        assert_eq!(timing(&[Kbit500, Kbit1000]), (Kbit1000, Source::Factory));
        assert_eq!(timing(&[Kbit500]), (Kbit500, Source::Factory));
        assert_eq!(timing(&[]), (Kbit1000, Source::Factory));
    }
}
