//! Light: its direction, and the rays along which it goes over a lattice.
//!
//! The lattice is not turned (Rusnell 2009, Algorithm 4, step 3, rotates the picture, which blurs it). Its nodes are dealt out to digital rays instead: one step along the axis that the
//! light follows most, and where rounding says so one along the other. Every node lies on just one of them, at most half a node from where light goes.

use super::super::lattice::Frame;
use core::f64::consts::FRAC_1_SQRT_2;
use rayon::prelude::*;

/// Parallel light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it comes from, degrees clockwise from north, 0 … 359.
    pub azimuth: u16,
    /// Degrees from the vertical.
    pub tilt: f64,
}

impl Light {
    /// Degrees above the horizon: what viewers ask for.
    #[must_use]
    pub fn altitude(&self) -> f64 {
        90.0 - self.tilt
    }

    /// Metres a metre that it falls by over the ground: 1 / tan θ.
    #[must_use]
    pub fn fall(&self) -> f64 {
        1.0 / libm::tan(self.tilt.to_radians())
    }

    /// Where it goes, east and north: a unit vector.
    #[must_use]
    pub fn direction(&self) -> [f64; 2] {
        compass(self.azimuth).map(|c| -c)
    }
}

/// The unit vector of an azimuth, east and north: azimuths that mirror or turn into each other have just the same components.
fn compass(azimuth: u16) -> [f64; 2] {
    let [quarter, rest] = [azimuth / 90, azimuth % 90];
    let of = |degrees: u16| f64::from(degrees).to_radians();
    let [sine, cosine] = match rest {
        0..45 => [libm::sin(of(rest)), libm::cos(of(rest))],
        45 => [FRAC_1_SQRT_2; 2],
        _ => [libm::cos(of(90 - rest)), libm::sin(of(90 - rest))],
    };
    match quarter {
        0 => [sine, cosine],
        1 => [cosine, -sine],
        2 => [-sine, -cosine],
        _ => [-cosine, sine],
    }
}

/// How rays of a direction go over a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Course {
    /// Whether they follow columns most (eastward or westward), else rows.
    eastward: bool,
    /// Whether places along that axis fall.
    backward: bool,
    /// Nodes along the other axis a step.
    ratio: f64,
    /// The length of a step in nodes.
    step: f64,
}

impl Course {
    fn of(azimuth: u16) -> Self {
        let [east, north] = compass(azimuth).map(|c| -c);
        let eastward = east.abs() >= north.abs();
        let [along, across] = if eastward { [east, north] } else { [north, east] };
        Self { eastward, backward: along < 0.0, ratio: across / along, step: 1.0 / along.abs() }
    }

    /// Nodes across after so many along.
    fn shift(&self, along: usize) -> i64 {
        (along as f64 * self.ratio + 0.5).floor() as i64
    }

    /// Nodes along and across of a frame.
    fn extent(&self, frame: &Frame) -> [usize; 2] {
        if self.eastward { [frame.columns, frame.rows] } else { [frame.rows, frame.columns] }
    }
}

/// All digital rays of a direction over a frame.
#[derive(Clone, Debug)]
pub(super) struct Rays {
    slots: Vec<u32>,
    ends: Vec<usize>,
    /// The length of a step in nodes.
    pub step: f64,
}

impl Rays {
    pub(super) fn new(frame: &Frame, azimuth: u16) -> Self {
        let course = Course::of(azimuth);
        let [along, across] = course.extent(frame);
        let shifts: Vec<i64> = (0..along).map(|i| course.shift(i)).collect();
        let [low, high] = shifts.iter().fold([0, 0], |[low, high]: [i64; 2], shift| [low.min(*shift), high.max(*shift)]);
        let mut rays = Self { slots: Vec::with_capacity(along * across), ends: Vec::new(), step: course.step };
        for ray in -high..across as i64 - low {
            let node = |i: usize| {
                let j = usize::try_from(ray + shifts[i]).ok().filter(|j| *j < across)?;
                let [column, row] = if course.eastward { [i, j] } else { [j, i] };
                Some(((row + 1) * frame.stride() + column + 1) as u32)
            };
            if course.backward {
                rays.slots.extend((0..along).rev().filter_map(node));
            } else {
                rays.slots.extend((0..along).filter_map(node));
            }
            rays.ends.push(rays.slots.len());
        }
        rays
    }

    /// The slots of every ray, in the order in which light passes them.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = core::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.slots[start..*end])
    }
}

/// The ways from nodes towards the light, a step along the axis that it follows most at a time: they pass between two nodes of every line across.
#[derive(Clone, Copy, Debug)]
pub(super) struct Towards {
    frame: Frame,
    course: Course,
}

impl Towards {
    pub(super) fn new(frame: &Frame, azimuth: u16) -> Self {
        Self { frame: *frame, course: Course::of(azimuth) }
    }

    /// The slots of all nodes, line after line, those nearest to the light first.
    pub(super) fn lines(&self) -> impl DoubleEndedIterator<Item = impl Iterator<Item = usize>> {
        let Self { frame, course } = *self;
        let [along, across] = course.extent(&frame);
        (0..along).map(move |i| {
            let i = if course.backward { along - 1 - i } else { i };
            (0..across).map(move |j| {
                let [column, row] = if course.eastward { [i, j] } else { [j, i] };
                (row + 1) * frame.stride() + column + 1
            })
        })
    }

    /// The places that a slot's way passes, from its first step on, up to the frame's edge: two slots and the share of the second.
    pub(super) fn way(&self, slot: usize) -> impl Iterator<Item = ([usize; 2], f64)> {
        let Self { frame, course } = *self;
        let [along, across] = course.extent(&frame);
        let (row, column) = (slot / frame.stride() - 1, slot % frame.stride() - 1);
        let [i, j] = if course.eastward { [column, row] } else { [row, column] };
        let [left, ratio] = if course.backward { [along - 1 - i, 0] } else { [i, 1] };
        let ratio = if ratio == 0 { course.ratio } else { -course.ratio };
        (1..=left).map_while(move |step| {
            let i = if course.backward { i + step } else { i - step };
            let place = j as f64 + step as f64 * ratio;
            let first = place.floor();
            let share = place - first;
            if first < 0.0 || place > (across - 1) as f64 {
                return None;
            }
            let slot = |j: usize| {
                let [column, row] = if course.eastward { [i, j] } else { [j, i] };
                (row + 1) * frame.stride() + column + 1
            };
            let first = first as usize;
            Some(([slot(first), slot((first + 1).min(across - 1))], share))
        })
    }
}

/// A picture's shadow, as lines along which runs are counted side by side.
struct Lines {
    /// 1 where there is shadow.
    rows: Vec<Vec<u32>>,
    columns: Vec<Vec<u32>>,
}

impl Lines {
    /// The longest unbroken shadow along the rays of a direction, in nodes.
    fn longest(&self, azimuth: u16) -> f64 {
        let course = Course::of(azimuth);
        let lines = if course.eastward { &self.columns } else { &self.rows };
        let across = lines.first().map_or(0, Vec::len);
        let last = course.shift(lines.len().saturating_sub(1));
        let most_shift = last.max(0);
        // How many nodes of every ray are in shadow up to here without a break.
        let mut runs = vec![0_u32; across + last.unsigned_abs() as usize + 1];
        let mut most = 0;
        for (i, line) in lines.iter().enumerate() {
            let first = (most_shift - course.shift(i)) as usize;
            for (run, shadow) in runs[first..first + across].iter_mut().zip(line) {
                *run = (*run + 1) * shadow;
                most = most.max(*run);
            }
        }
        f64::from(most) * course.step
    }
}

/// Among 360 azimuths that under which the longest shadow of a picture is shortest; of equal ones the least. Opposite ones have the same rays, so the first 180 decide.
pub(super) fn shortest(frame: &Frame, shadow: &[bool]) -> u16 {
    let own: Vec<Vec<u32>> = frame.rows_of_slots().map(|row| shadow[row].iter().map(|shadow| u32::from(*shadow)).collect()).collect();
    let columns = (0..frame.columns).map(|column| own.iter().map(|row| row[column]).collect()).collect();
    let lines = Lines { rows: own, columns };
    let lengths: Vec<f64> = (0..180_u16).into_par_iter().map(|azimuth| lines.longest(azimuth)).collect();
    let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    lengths.iter().position(|length| *length == least).unwrap_or_default() as u16
}
