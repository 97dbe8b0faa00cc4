//! The objects that show touch probes and readings.

use crate::objects::Objects;
use crate::periphery::{Latched, Readings};

/// Writes them. They change seldom: the device comes here only if they have.
#[cold]
#[inline(never)]
pub(super) fn show<D: Objects>(dictionary: &mut D, latched: &Latched, readings: &Readings) {
    dictionary.set_touch_probe_status(latched.status);
    let [a, b, c, d] = latched.positions;
    dictionary.set_touch_probe_1_positive_edge(a);
    dictionary.set_touch_probe_1_negative_edge(b);
    dictionary.set_touch_probe_2_positive_edge(c);
    dictionary.set_touch_probe_2_negative_edge(d);
    let [a, b, c, d] = latched.times;
    dictionary.set_touch_probe_1_positive_time(a);
    dictionary.set_touch_probe_1_negative_time(b);
    dictionary.set_touch_probe_2_positive_time(c);
    dictionary.set_touch_probe_2_negative_time(d);
    let [a, b, c, d] = latched.counters;
    dictionary.set_touch_probe_1_positive_count(a);
    dictionary.set_touch_probe_1_negative_count(b);
    dictionary.set_touch_probe_2_positive_count(c);
    dictionary.set_touch_probe_2_negative_count(d);
    dictionary.set_dc_link_voltage(readings.supply_voltage);
    let [auxiliary, battery] = readings.other_supplies;
    dictionary.set_auxiliary_voltage(auxiliary);
    dictionary.set_battery_voltage(battery);
    dictionary.set_temperature(readings.temperature);
    dictionary.set_analogue_input_raw(readings.analogue.raw);
    dictionary.set_analogue_input_voltage(readings.analogue.voltage);
    dictionary.set_analogue_input_filtered(readings.analogue.filtered);
}
