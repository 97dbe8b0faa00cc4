//! The walk-through of the documentation, played to the virtual drive.
//!
//! Its listings are what `candump` shows. What the master sends there is sent, and the drive must answer as written and say
//! nothing else. The `cansend` commands of the page must send just these frames, in this order.

use canopen::{BitRate, Duration, Frame};
use master::Master;
use master::bus::simulated::Bus;
use sim::drive::Setup;
use tests::drive::AxisDrive;
use tests::line::Line;
use tests::notation::{Pattern, frame, show};

const PAGE: &str = include_str!("../../docs/commissioning.md");

/// The lines of the blocks of code with this tag, without those of the frames of a fastscan.
fn blocks(tag: &str) -> Vec<Vec<&'static str>> {
    let mut blocks = Vec::new();
    let mut lines = PAGE.lines();
    while let Some(line) = lines.next() {
        if line.strip_prefix("```") == Some(tag) {
            let block = lines.by_ref().take_while(|line| *line != "```");
            blocks.push(block.collect());
        }
    }
    blocks
}

/// A listing of which only parts are shown.
fn is_extract(block: &[&str]) -> bool {
    block.contains(&"...")
}

/// A frame as the cases write it, from a line of candump with a remark behind it.
fn notation(line: &str) -> String {
    let words: Vec<_> = line.split_whitespace().collect();
    let [_, id, length, rest @ ..] = &words[..] else {
        panic!("no line of candump: {line}");
    };
    let count: usize = length.trim_matches(['[', ']']).parse().expect("a length");
    format!("{id} {length} {}", rest[..count].join(" "))
}

/// The bit rate at the beginning of a text.
fn bit_rate(text: &str) -> BitRate {
    let number = text.split(' ').next().and_then(|word| word.parse().ok());
    let of_table_0 = BitRate::ALL.into_iter();
    let mut found = of_table_0.filter(|rate| Some(rate.kbit_per_second()) == number);
    found.next().expect("a bit rate in kbit/s")
}

/// Whether a master sends it.
fn is_of_the_master(frame: &Frame) -> bool {
    matches!(frame.standard_id(), Some(0x000 | 0x7E5 | 0x601..=0x67F))
}

#[test]
fn the_listings_are_what_the_drive_does() {
    let drive = AxisDrive::new(Setup::unconfigured(1));
    let mut bench = Line::new(drive, 10);
    let listings = blocks("candump");
    let listings = listings.iter().filter(|block| !is_extract(block));
    for line in listings.flatten() {
        if line.starts_with("# power") {
            bench.silence(100);
            bench.axis().power_cycle();
        } else if let Some(switch) = line.strip_prefix("# 1 s of silence, ") {
            bench.silence(1_000);
            bench.set_bit_rate(bit_rate(switch));
            bench.silence(1_000);
        } else {
            let text = notation(line);
            let frame = frame(&text);
            if is_of_the_master(&frame) {
                bench.silence(20);
                bench.send_frame(frame);
            } else {
                bench.expect(&text);
            }
        }
    }
    bench.silence(1_000);
}

#[test]
fn the_parts_of_a_fastscan_are_in_a_fastscan() {
    let mut master = Master::new(Bus::new(BitRate::Kbit1000));
    master
        .bus_mut()
        .attach(AxisDrive::new(Setup::unconfigured(1)));
    master.run_for(Duration::from_ticks(10_000));
    master.lss_fastscan().unwrap().unwrap();
    let mut trace = master.bus().trace().iter();
    let listings = blocks("candump");
    let [extract] = &*listings
        .iter()
        .filter(|block| is_extract(block))
        .collect::<Vec<_>>()
    else {
        panic!("one listing is an extract");
    };
    for part in extract.split(|line| *line == "...") {
        let mut frames = part.iter().map(|line| notation(line));
        let first = Pattern::new(&frames.next().expect("a part is not empty"));
        assert!(trace.any(|logged| first.matches(&logged.frame)), "{part:?}");
        for text in frames {
            let next = trace.next().expect("the scan goes on").frame;
            assert!(
                Pattern::new(&text).matches(&next),
                "{text}: {}",
                show(&next)
            );
        }
    }
    assert!(
        trace.next().is_none(),
        "the last part is the end of the scan"
    );
}

/// CANopenLinux configures a device only behind a fastscan or a selective switch (ERROR:102), and does not activate bit rates.
#[test]
fn cocomm_configures_what_it_has_chosen() {
    let commands = blocks("sh");
    let lines = commands.iter().flatten();
    let lines: Vec<_> = lines
        .filter_map(|line| line.strip_prefix("cocomm "))
        .collect();
    assert!(lines.len() > 6);
    for line in lines {
        let mut is_chosen = false;
        for command in line.split('"').skip(1).step_by(2) {
            let name = command.split(' ').next().unwrap_or_default();
            match name {
                "_lss_fastscan" | "lss_switch_sel" => is_chosen = true,
                "lss_set_node" | "lss_get_node" | "lss_conf_bitrate" | "lss_store" => {
                    assert!(is_chosen, "{line}");
                }
                "lss_switch_glob" => {
                    assert_eq!(command, "lss_switch_glob 0", "{line}");
                    is_chosen = false;
                }
                _ => assert_ne!(name, "lss_activate_bitrate", "{line}"),
            }
        }
    }
}

#[test]
fn the_commands_send_what_the_listings_show() {
    let commands = blocks("sh");
    let sent: Vec<_> = commands
        .iter()
        .flatten()
        .filter_map(|line| line.strip_prefix("cansend can0 "))
        .map(|command| {
            let (id, bytes) = command.split_once('#').expect("an identifier and bytes");
            let bytes: Vec<_> = bytes
                .as_bytes()
                .chunks(2)
                .map(String::from_utf8_lossy)
                .collect();
            frame(&format!("{id} [{}] {}", bytes.len(), bytes.join(" ")))
        })
        .collect();
    let listings = blocks("candump");
    let shown: Vec<_> = listings
        .iter()
        .filter(|block| !is_extract(block))
        .flatten()
        .filter(|line| !line.starts_with('#'))
        .map(|line| frame(&notation(line)))
        .filter(is_of_the_master)
        .collect();
    assert_eq!(sent, shown);
    assert!(shown.len() > 20);
}
