//! Motion tasks: 1 to 200 in flash, 201 to 300 in RAM, 0 in the O_ parameters; one at a time is carried out, and leads to the next.
//!
//! The manual leaves the coding of O_C open but for bit 3. It is that of its series: bit 0 relative, bit 1 to the actual position and not to the
//! last target, bit 3 another task follows (O_FN), bit 4 without a stop, bit 6 after a delay (O_FT, ms). O_ACC and O_DEC are the times from
//! rest to O_V and back, in ms; 0 leaves the ramps of 6083h and 6084h.
//!
//! Tasks in flash lie in an object of our own, 5100h, sixteen bytes each and eight in an entry: they are stored and loaded as parameters are.

use canopen::Instant;
use canopen::od::{self, Dictionary};
use cia402::behaviour::{number, put_number};
use cia402::commands::Commands;
use cia402::controlword::{CHANGE_IMMEDIATELY, CHANGE_ON_SET_POINT, HALT, NEW_SET_POINT, RELATIVE};
use cia402::units::Units;

use super::Seen;

/// The last task in flash, and the last of all.
pub(super) const FLASH: u16 = 200;
pub(super) const LAST: u16 = 300;

/// The object with the tasks in flash.
const MEMORY: u16 = 0x5100;
/// Bytes of a task, and tasks in an entry.
const SIZE: usize = 16;
const EACH: u16 = 8;

/// O_C.
const IS_RELATIVE: u16 = 1 << 0;
const TO_ACTUAL: u16 = 1 << 1;
const HAS_NEXT: u16 = 1 << 3;
const WITHOUT_STOP: u16 = 1 << 4;
const WITH_DELAY: u16 = 1 << 6;
/// The bits that mean something.
pub(super) const CONTROL: i64 = 0x5B;

/// So many control ticks after a set-point was given the statusword tells of it.
const SETTLED: u8 = 3;

/// 6041h.
const ACKNOWLEDGE: u16 = 1 << 12;
const REACHED: u16 = 1 << 10;

/// A motion task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Task {
    target: i32,
    speed: u32,
    /// ms.
    acceleration: u16,
    deceleration: u16,
    control: u16,
    next: u16,
    /// ms.
    delay: u16,
}

impl Task {
    /// Task 0.
    fn direct<D: Dictionary>(dictionary: &D) -> Self {
        let short = |index| u16::try_from(number(dictionary, index, 1)).unwrap_or(u16::MAX);
        Self {
            target: i32::try_from(number(dictionary, 0x35BE, 1)).unwrap_or(0),
            speed: u32::try_from(number(dictionary, 0x35BF, 1)).unwrap_or(0),
            acceleration: short(0x35B7),
            deceleration: short(0x35BA),
            control: short(0x35B9),
            next: short(0x35BC).min(LAST),
            delay: short(0x35BD),
        }
    }

    /// Puts it into the O_ parameters.
    fn show<D: Dictionary>(&self, dictionary: &mut D) {
        for (index, value) in [
            (0x35BE, i64::from(self.target)),
            (0x35BF, self.speed.into()),
            (0x35B7, self.acceleration.into()),
            (0x35BA, self.deceleration.into()),
            (0x35B9, self.control.into()),
            (0x35BC, self.next.into()),
            (0x35BD, self.delay.into()),
        ] {
            put_number(dictionary, index, 1, value);
        }
    }

    /// From the lowest byte: target, speed, both times, the next task (nine bits) and its coding (seven), delay.
    fn bytes(&self) -> [u8; SIZE] {
        let next = self.next & 0x1FF | self.control << 9;
        let all = u128::from(self.target.cast_unsigned())
            | u128::from(self.speed) << 32
            | u128::from(self.acceleration) << 64
            | u128::from(self.deceleration) << 80
            | u128::from(next) << 96
            | u128::from(self.delay) << 112;
        all.to_le_bytes()
    }

    fn of(bytes: [u8; SIZE]) -> Self {
        let all = u128::from_le_bytes(bytes);
        let next = (all >> 96) as u16;
        Self {
            target: all as i32,
            speed: (all >> 32) as u32,
            acceleration: (all >> 64) as u16,
            deceleration: (all >> 80) as u16,
            control: next >> 9,
            next: next & 0x1FF,
            delay: (all >> 112) as u16,
        }
    }

    /// Whether there is one: without a speed no task moves.
    const fn is_there(&self) -> bool {
        self.speed != 0
    }

    /// The ramp from rest to the speed in so many ms, not shorter than PTMIN.
    fn ramp(&self, time: u16, least: u16, otherwise: u32, units: &Units) -> u32 {
        let time = if time == 0 { 0 } else { time.max(least) };
        match u64::from(time) {
            0 => otherwise,
            time => {
                let ramp = u64::from(self.speed).saturating_mul(1_000).div_ceil(time);
                units.acceleration(u32::try_from(ramp).unwrap_or(u32::MAX))
            }
        }
    }
}

/// Where the sequence is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum TaskState {
    #[default]
    Idle,
    /// It waits for profile position, and is then given.
    Given,
    /// On its way; for so many ticks.
    UnderWay(u8),
    /// The next one waits in the drive, for so many ticks.
    Blends(u8),
    /// The next one begins then.
    Pauses(Instant),
    /// STOP: the motor slows down.
    Stops,
    /// It stands, and stays where it is: for so many ticks.
    Parks(u8),
}

/// All tasks.
#[derive(Debug)]
pub(super) struct Tasks {
    ram: [Task; (LAST - FLASH) as usize],
    state: TaskState,
    number: u16,
    task: Task,
    /// The one that waits in the drive.
    next: (u16, Task),
    /// It is to be handed to the drive with the next commands.
    hands_over: bool,
    /// Started by an edge of the controlword, and not by a command: the mode is the master's.
    is_by_edge: bool,
    /// An edge that starts nothing hands nothing over.
    swallows: bool,
    /// The last start by an edge was of this task, and nothing was written for a direct set-point since.
    repeats: u16,
}

impl Default for Tasks {
    fn default() -> Self {
        Self {
            ram: [Task::default(); (LAST - FLASH) as usize],
            state: TaskState::Idle,
            number: 0,
            task: Task::default(),
            next: (0, Task::default()),
            hands_over: false,
            is_by_edge: false,
            swallows: false,
            repeats: 0,
        }
    }
}

/// Why a task does not start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Faulty {
    /// n08: there is none of this number.
    Task,
    /// n09: it goes to a position, and nobody knows where zero is.
    Reference,
}

impl Tasks {
    /// The task of this number, empty if there is none.
    pub(super) fn get<D: Dictionary>(&self, dictionary: &D, number: u16) -> Task {
        match number {
            0 => Task::direct(dictionary),
            1..=FLASH => place(number)
                .and_then(|(sub, at)| {
                    let entry = od::find::<D>(MEMORY, sub).ok()?;
                    od::value(dictionary, entry).get(at..)?.first_chunk()
                })
                .map_or_else(Task::default, |bytes| Task::of(*bytes)),
            _ => {
                let place = usize::from(number.saturating_sub(FLASH).saturating_sub(1));
                self.ram.get(place).copied().unwrap_or_default()
            }
        }
    }

    /// Puts a task in its place.
    pub(super) fn put<D: Dictionary>(&mut self, dictionary: &mut D, number: u16, task: Task) {
        match number {
            0 => task.show(dictionary),
            1..=FLASH => {
                let Some((sub, at)) = place(number) else {
                    return;
                };
                let Ok(entry) = od::find::<D>(MEMORY, sub) else {
                    return;
                };
                let mut all = [0; SIZE * EACH as usize];
                for (to, from) in all.iter_mut().zip(od::value(dictionary, entry)) {
                    *to = *from;
                }
                if let Some(own) = all.get_mut(at..).and_then(|own| own.first_chunk_mut()) {
                    *own = task.bytes();
                }
                od::put(dictionary, entry, &all);
            }
            _ => {
                let place = usize::from(number.saturating_sub(FLASH).saturating_sub(1));
                if let Some(own) = self.ram.get_mut(place) {
                    *own = task;
                }
            }
        }
    }

    /// Copies a task: 2082h.
    pub(super) fn copy<D: Dictionary>(&mut self, dictionary: &mut D, from: u16, to: u16) {
        let task = self.get(dictionary, from);
        self.put(dictionary, to, task);
    }

    /// Forgets those in flash.
    pub(super) fn forget_flash<D: Dictionary>(&mut self, dictionary: &mut D) {
        for number in (1..=FLASH).step_by(usize::from(EACH)) {
            let entry = place(number).and_then(|(sub, _)| od::find::<D>(MEMORY, sub).ok());
            if let Some(entry) = entry {
                od::put(dictionary, entry, &[0; SIZE * EACH as usize]);
            }
        }
    }

    /// Forgets all of them.
    pub(super) fn forget<D: Dictionary>(&mut self, dictionary: &mut D) {
        self.forget_flash(dictionary);
        self.ram.fill(Task::default());
    }

    /// Starts a task: the drive gets it with the next commands.
    pub(super) fn start<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        number: u16,
        seen: &Seen,
        is_by_edge: bool,
    ) -> Result<(), Faulty> {
        let task = self.get(dictionary, number);
        self.state = TaskState::Idle;
        self.swallows = is_by_edge;
        if !task.is_there() {
            return Err(Faulty::Task);
        }
        if task.control & IS_RELATIVE == 0 && !seen.is_referenced {
            return Err(Faulty::Reference);
        }
        self.swallows = false;
        (self.number, self.task) = (number, task);
        self.state = TaskState::Given;
        self.is_by_edge = is_by_edge;
        self.hands_over = true;
        if is_by_edge {
            self.repeats = number;
        }
        show(dictionary, number, task.target);
        Ok(())
    }

    /// STOP.
    pub(super) fn stop(&mut self) {
        if self.state != TaskState::Idle {
            self.state = TaskState::Stops;
        }
    }

    /// What is under way is another's from now on.
    pub(super) const fn cancel(&mut self) {
        self.state = TaskState::Idle;
        self.hands_over = false;
    }

    /// Whether a command has begun one: the mode of operation waits for its end.
    pub(super) const fn takes_mode(&self) -> bool {
        !self.is_by_edge && !matches!(self.state, TaskState::Idle)
    }

    /// The task that an edge without a number in 2080h begins again; 0 for a direct set-point.
    pub(super) const fn repeated(&self) -> u16 {
        self.repeats
    }

    /// Something of a direct set-point was written.
    pub(super) const fn is_direct(&mut self) {
        self.repeats = 0;
    }

    /// A tick has passed. Returns whether the commands are others now.
    pub(super) fn tick<D: Dictionary>(&mut self, dictionary: &mut D, seen: &Seen) -> bool {
        if self.state == TaskState::Idle {
            return false;
        }
        if !seen.is_enabled {
            // Quick stop and the like cancel it.
            self.cancel();
            return true;
        }
        let before = self.state;
        match &mut self.state {
            TaskState::Idle => {}
            TaskState::Given => return self.hands_over,
            TaskState::UnderWay(ticks) | TaskState::Blends(ticks) if *ticks < SETTLED => {
                *ticks += 1;
            }
            TaskState::UnderWay(_) => self.look_ahead(dictionary, seen),
            TaskState::Blends(_) => {
                if seen.statusword & ACKNOWLEDGE == 0 {
                    // What waited has begun.
                    (self.number, self.task) = self.next;
                    show(dictionary, self.number, self.task.target);
                    self.state = TaskState::UnderWay(SETTLED);
                }
            }
            TaskState::Pauses(until) => {
                if seen.at >= *until {
                    (self.number, self.task) = self.next;
                    show(dictionary, self.number, self.task.target);
                    self.state = TaskState::Given;
                    self.hands_over = true;
                }
            }
            TaskState::Stops => {
                if !seen.is_moving {
                    self.state = TaskState::Parks(0);
                    self.hands_over = true;
                }
            }
            TaskState::Parks(_) => self.cancel(),
        }
        self.state != before
    }

    /// What follows a task that is on its way.
    fn look_ahead<D: Dictionary>(&mut self, dictionary: &D, seen: &Seen) {
        let is_reached = seen.statusword & REACHED != 0 && !seen.is_moving;
        let follows = self.task.control & HAS_NEXT != 0;
        let next = follows.then(|| self.get(dictionary, self.task.next));
        let Some(next) = next.filter(Task::is_there) else {
            if is_reached {
                self.cancel();
            }
            return;
        };
        self.next = (self.task.next, next);
        if self.task.control & WITHOUT_STOP != 0 {
            if !is_reached {
                self.state = TaskState::Blends(0);
                self.hands_over = true;
            } else {
                self.state = TaskState::Pauses(seen.at);
            }
        } else if is_reached {
            let delay = if self.task.control & WITH_DELAY != 0 {
                self.task.delay
            } else {
                0
            };
            let delay = canopen::Duration::from_ticks(u64::from(delay) * 1_000);
            self.state = TaskState::Pauses(seen.at.checked_add_duration(delay).unwrap_or(seen.at));
        }
    }

    /// Puts a task into the commands.
    pub(super) fn command<D: Dictionary>(
        &mut self,
        dictionary: &D,
        units: &Units,
        seen: &Seen,
        commands: &mut Commands,
    ) {
        if self.takes_mode() {
            commands.mode = 1;
        }
        if core::mem::take(&mut self.swallows) {
            commands.rising &= !NEW_SET_POINT;
        }
        if self.state == TaskState::Idle {
            // Of a direct set-point too O_C says what a relative one counts from.
            let is_to_actual = number(dictionary, 0x35B9, 1) & i64::from(TO_ACTUAL) != 0;
            commands.positioning_option = if is_to_actual { 2 } else { 0 };
        }
        if matches!(self.state, TaskState::Stops) {
            commands.controlword |= HALT;
        }
        if matches!(self.state, TaskState::Blends(_)) {
            // Bit 12 of the statusword tells when the one that waits begins.
            commands.controlword &= !NEW_SET_POINT;
        }
        if !self.hands_over {
            return;
        }
        let word = &mut commands.controlword;
        match self.state {
            // An edge hands nothing over in the tick that begins a mode.
            TaskState::Given if seen.mode == 1 || self.is_by_edge => {
                self.state = TaskState::UnderWay(0);
                *word |= CHANGE_IMMEDIATELY;
                *word &= !CHANGE_ON_SET_POINT;
                self.fill(self.task, dictionary, units, commands);
            }
            TaskState::Blends(_) => {
                *word &= !CHANGE_IMMEDIATELY;
                *word |= CHANGE_ON_SET_POINT;
                self.fill(self.next.1, dictionary, units, commands);
            }
            TaskState::Parks(_) => {
                *word |= CHANGE_IMMEDIATELY | RELATIVE;
                commands.positioning_option = 1;
                commands.target_position = 0;
            }
            _ => return,
        }
        self.hands_over = false;
        commands.controlword |= NEW_SET_POINT;
        commands.rising |= NEW_SET_POINT;
    }

    fn fill<D: Dictionary>(
        &self,
        task: Task,
        dictionary: &D,
        units: &Units,
        commands: &mut Commands,
    ) {
        let word = &mut commands.controlword;
        if task.control & IS_RELATIVE != 0 {
            *word |= RELATIVE;
        } else {
            *word &= !RELATIVE;
        }
        commands.positioning_option = if task.control & TO_ACTUAL != 0 { 2 } else { 0 };
        commands.target_position = task.target;
        let override_percent = match number(dictionary, 0x35B6, 1) {
            percent @ 1..=100 => percent as u64,
            _ => 100,
        };
        let speed = u64::from(task.speed) * override_percent / 100;
        commands.profile_velocity = units.speed(u32::try_from(speed).unwrap_or(u32::MAX).max(1));
        let least = u16::try_from(number(dictionary, 0x35D6, 1)).unwrap_or(0);
        commands.profile_acceleration = task.ramp(
            task.acceleration,
            least,
            commands.profile_acceleration,
            units,
        );
        commands.profile_deceleration = task.ramp(
            task.deceleration,
            least,
            commands.profile_deceleration,
            units,
        );
    }
}

/// The entry of 5100h with a task in flash, and where it begins there.
fn place(number: u16) -> Option<(u8, usize)> {
    let place = number.checked_sub(1)?;
    let sub = u8::try_from(place / EACH + 1).ok()?;
    Some((sub, usize::from(place % EACH) * SIZE))
}

/// 2081h and PTARGET: what was started last.
fn show<D: Dictionary>(dictionary: &mut D, number: u16, target: i32) {
    put_number(dictionary, 0x2081, 0, number.into());
    put_number(dictionary, 0x3654, 1, target.into());
}
