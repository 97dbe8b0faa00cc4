//! How a set-point is taken: what it was given as, and where that is.

use super::set_point::SetPoint;
use super::{ProfilePosition, Progress, RELATIVE_TO, longest_stop, rest};
use crate::actuator::Actuator;
use crate::commands;
use crate::controlword::{CHANGE_IMMEDIATELY, CHANGE_ON_SET_POINT, RELATIVE};
use crate::modes::{Context, Types};
use crate::motor::REACH;
use crate::objects::Objects;
use crate::units::Rotation;

impl ProfilePosition {
    /// Takes the set-point in the commands, if there is room. Returns whether it did.
    pub(super) fn take(&mut self, context: &mut Context<'_, impl Types>) -> bool {
        let given = context.commands.set_point();
        let controlword = given.controlword;
        let immediately = controlword & CHANGE_IMMEDIATELY != 0;
        let waits = !immediately && self.progress == Progress::UnderWay;
        self.travel = *context.travel;
        let mut set_point = self.read(given, context, waits);
        if !waits {
            self.next = None;
            self.begin(set_point, context);
        } else if self.has_room(context) {
            set_point.blends = controlword & CHANGE_ON_SET_POINT != 0;
            self.next = Some(set_point);
            if let Some(current) = self.current {
                let blended = self.blended(current, context.motor);
                if blended != current {
                    self.current = Some(blended);
                    self.starts_anew = true;
                }
            }
        } else {
            return false;
        }
        true
    }

    /// Whether a set-point can wait. One that waits may have to make room, unless the motion is made for it already.
    fn has_room(&self, context: &Context<'_, impl Types>) -> bool {
        let replaces = context.habits().third_set_point_replaces;
        self.next.is_none_or(|next| replaces && !next.blends)
    }

    /// A set-point within all limits.
    fn read(
        &self,
        given: commands::SetPoint,
        context: &mut Context<'_, impl Types>,
        waits: bool,
    ) -> SetPoint {
        let here = self.base(context, waits);
        let mut set_point = SetPoint::new(
            given,
            (here, self.wanted(given, context, waits, here)),
            context.configuration.profile.ramps,
        );
        set_point.limit_profile(context);
        self.aim(&mut set_point, context, waits);
        set_point
    }

    /// Gives a set-point its target within the software limits, and within what one motion can lead.
    pub(super) fn aim(
        &self,
        set_point: &mut SetPoint,
        context: &Context<'_, impl Types>,
        waits: bool,
    ) {
        let here = self.base(context, waits);
        let (start, stop) = if waits {
            (self.target, 0)
        } else {
            let committed = context.motor.committed_position();
            // In motion, the distance to stop and to come back is part of it.
            (committed, longest_stop(context, set_point))
        };
        let reach = REACH.saturating_sub(stop.saturating_mul(4));
        let reach = (start.saturating_sub(reach), start.saturating_add(reach));
        if waits {
            // What a limit has left of the target before it.
            set_point.begins_at(here);
        }
        set_point.aim(context, here, reach);
    }

    /// Where the motor should be, or will be when a set-point that waits begins, in units of the user.
    fn base(&self, context: &Context<'_, impl Types>, waits: bool) -> i64 {
        if waits {
            self.previous(context)
        } else {
            let units = context.units();
            context.frame.position(context.demand.position, units)
        }
    }

    /// The previous target in units of the user.
    fn previous(&self, context: &Context<'_, impl Types>) -> i64 {
        let units = context.units();
        self.user
            .unwrap_or_else(|| context.frame.position(self.target, units))
    }

    /// The target that is asked for, in units of the user, on the count that goes on behind the ends of 607Bh. `here` is its base.
    fn wanted<P: Types>(
        &self,
        given: commands::SetPoint,
        context: &mut Context<'_, P>,
        waits: bool,
        here: i64,
    ) -> i64 {
        let units = context.units();
        let asked = i64::from(given.target_position);
        let options = if P::Objects::DRIVE.positioning_options {
            given.positioning_option
        } else {
            0
        };
        if given.controlword & RELATIVE != 0 {
            let base = match options & RELATIVE_TO {
                1 => here,
                2 if !waits => context.frame.position(context.position, units),
                _ => self.previous(context),
            };
            return base.saturating_add(asked);
        }
        let rotation = Rotation::of(options);
        if waits || rotation == Rotation::Linear {
            return units.range().target(asked, here, rotation);
        }
        let rest = rest(context, given.profile_deceleration);
        let from = match rotation {
            Rotation::Linear | Rotation::Shortest => context.frame.position(rest, units),
            // Half a unit back would be the wrong direction.
            Rotation::Positive => context.frame.position_beyond(rest, units, true),
            Rotation::Negative => context.frame.position_beyond(rest, units, false),
        };
        units.range().target(asked, from, rotation)
    }
}
