//! Relief: land and sea in the colours of their height, shaded by the light of a morning in the north-west.

use super::{material_colour, water};
use crate::{
    analysis,
    geometry::{Legend, Surface},
};

/// Colours of the land, from its foot to its top.
const LAND: [(f64, [u8; 3]); 7] = [
    (0.0, [0x5f, 0x8a, 0x5a]),
    (0.12, [0x86, 0xa8, 0x67]),
    (0.3, [0xc2, 0xc1, 0x84]),
    (0.5, [0xb8, 0x9a, 0x6b]),
    (0.7, [0x8f, 0x75, 0x60]),
    (0.86, [0xb7, 0xac, 0xa6]),
    (1.0, [0xf7, 0xf7, 0xf5]),
];

/// Metres above the sea where the land's colours end in snow; lower land ends in an earlier colour, and high land begins in a later one.
const SNOW_HEIGHT: f64 = 2_600.0;

/// Metres below the sea that the sea's colours are spread over at most.
const MOST_DEPTH: f64 = 2_000.0;

/// How much of a material's own colour the land takes on, and the colour of rivers and lakes.
const MATERIAL: f32 = 0.4;
const FRESH_WATER: [f32; 3] = [78.0, 138.0, 180.0];

/// The part of the land's colours that flat land gets at least.
const LEAST_COLOURS: f64 = 0.45;

/// Colours of the sea, from its deepest place to the shore.
const SEA: [(f64, [u8; 3]); 3] = [(0.0, [0x12, 0x3a, 0x5c]), (0.6, [0x2f, 0x6f, 0x9f]), (1.0, [0x8f, 0xc1, 0xd9])];

/// Least height in metres that the colours of land and sea are spread over.
const LEAST_SPREAD: f64 = 1.0;

/// Metres below the sea's surface where the shore's own colour ends and land begins.
const SHORE: f64 = 0.01;

/// Weight and direction (east, north, up) of the lights. The first gives the form; the others keep slopes that lie along it from looking flat.
const LIGHTS: [(f32, [f32; 3]); 3] = [
    // Azimuth 315°, altitude 45°.
    (0.62, [-0.5, 0.5, core::f32::consts::FRAC_1_SQRT_2]),
    // Azimuth 270° and 0°, altitude 45°.
    (0.19, [-core::f32::consts::FRAC_1_SQRT_2, 0.0, core::f32::consts::FRAC_1_SQRT_2]),
    (0.19, [0.0, core::f32::consts::FRAC_1_SQRT_2, core::f32::consts::FRAC_1_SQRT_2]),
];

/// What slopes turn to that face away from the light, and how far; likewise those that face it.
const SHADOW: ([f32; 3], f32) = ([28.0, 32.0, 58.0], 0.84);
const GLOW: ([f32; 3], f32) = ([255.0, 250.0, 232.0], 0.7);

/// How much of the light reaches the floor of the sea.
const UNDER_WATER: f32 = 0.35;

/// Colours over elevation: the sea's from its depth to the shore, the land's from its foot to its top.
///
/// ```
/// use terrane::tile::Ramp;
/// let ramp = Ramp::over(0.0, [-400.0, 2_600.0]);
/// assert_eq!(ramp.stops().next(), Some((-400.01, [0x12, 0x3a, 0x5c])));
/// assert_eq!(ramp.stops().last(), Some((2_600.0, [0xf7, 0xf7, 0xf5])));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    sea_level: f32,
    sea: Vec<(f64, [u8; 3])>,
    land: Vec<(f64, [u8; 3])>,
}

impl Ramp {
    /// Spreads the colours over elevations from `low` to `high`, in metres. Low hills stay green, high plains are dry; only land that reaches 2,600 m above the sea
    /// wears snow.
    #[must_use]
    pub fn over(sea_level: f64, [low, high]: [f64; 2]) -> Self {
        let depth = (sea_level - low).max(LEAST_SPREAD);
        let sea = if low < sea_level { SEA.iter().map(|(at, colour)| (sea_level - depth * (1.0 - at) - SHORE, *colour)).collect() } else { Vec::new() };
        let foot = low.max(sea_level);
        let height = (high - foot).max(LEAST_SPREAD);
        let first = ((foot - sea_level) / SNOW_HEIGHT).min(1.0 - LEAST_COLOURS);
        let used = (height / SNOW_HEIGHT).min(1.0 - first).max(LEAST_COLOURS);
        let land = LAND.iter().map(|(at, _)| (foot + height * at, between(&LAND, first + at * used).map(|c| c.round() as u8))).collect();
        Self { sea_level: sea_level as f32, sea, land }
    }

    /// The colours of tiles, the same for all of a source: over what its range leaves of 2,000 m below and 2,600 m above the sea.
    #[must_use]
    pub fn of(legend: &Legend) -> Self {
        let Legend { sea_level, range: [low, high], .. } = *legend;
        Self::over(sea_level, [low.max(sea_level - MOST_DEPTH), high.min(sea_level + SNOW_HEIGHT).max(low)])
    }

    /// Elevation and colour of every stop, elevations ascending; between them colours are interpolated.
    pub fn stops(&self) -> impl Iterator<Item = (f64, [u8; 3])> + '_ {
        self.sea.iter().chain(&self.land).copied()
    }
}

/// The colour at a place of a list of stops; beyond its ends, that of the end.
fn between(stops: &[(f64, [u8; 3])], at: f64) -> [f64; 3] {
    let above = stops.iter().position(|(place, _)| *place >= at).unwrap_or(stops.len() - 1).max(1);
    let ((from, low), (to, high)) = (stops[above - 1], stops[above]);
    let t = ((at - from) / (to - from)).clamp(0.0, 1.0);
    core::array::from_fn(|i| f64::from(low[i]) + t * (f64::from(high[i]) - f64::from(low[i])))
}

/// Red, green and blue of every sample within an apron of one; `spacing` in metres, or less to make the light see higher mountains.
///
/// Between land and sea a pixel takes of both as much as it covers: elevation over slope is the distance to the shore.
pub(super) fn draw(surface: &Surface, spacing: f64, ramp: &Ramp) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(surface.elevation.len() * 3);
    for row in 1..surface.rows - 1 {
        for column in 1..surface.columns - 1 {
            let gradient = analysis::gradient(surface, row, column, spacing);
            let colour = colour(surface.at(row, column), gradient, spacing as f32, ramp);
            bytes.extend(colour.map(|c| (c + 0.5) as u8));
        }
    }
    bytes
}

/// As [`draw`], with water where the surface knows of it and in the colours of its materials.
pub(super) fn draw_with(surface: &Surface, spacing: f64, ramp: &Ramp, legend: &Legend) -> Vec<u8> {
    let materials: Vec<[f32; 3]> = legend.materials.iter().map(|name| material_colour(name).map(f32::from)).collect();
    let mut bytes = Vec::with_capacity(surface.elevation.len() * 3);
    for row in 1..surface.rows - 1 {
        for column in 1..surface.columns - 1 {
            let [east, north] = analysis::gradient(surface, row, column, spacing);
            let (at, elevation, light) = (row * surface.columns + column, surface.at(row, column), light(east, north));
            let tint = |stops: &[_]| between(stops, f64::from(elevation)).map(|c| c as f32);
            let own = surface.material.get(at).and_then(|&number| materials.get(usize::from(number).checked_sub(1)?));
            let ground = tint(&ramp.land);
            let land = shade(own.map_or(ground, |&own| mix(ground, own, MATERIAL)), light);
            let share = water::share(surface, [row, column], spacing as f32, ramp.sea_level);
            let sea = !ramp.sea.is_empty() && elevation < ramp.sea_level;
            let (water, light) = if sea { (tint(&ramp.sea), light * UNDER_WATER) } else { (FRESH_WATER, 0.0) };
            let colour = if share > 0.0 { mix(land, shade(water, light), share) } else { land };
            bytes.extend(colour.map(|c| (c + 0.5) as u8));
        }
    }
    bytes
}

fn colour(elevation: f32, [east, north]: [f32; 2], spacing: f32, ramp: &Ramp) -> [f32; 3] {
    let light = light(east, north);
    let tint = |stops: &[_]| between(stops, f64::from(elevation)).map(|c| c as f32);
    let land = || shade(tint(&ramp.land), light);
    if ramp.sea.is_empty() {
        return land();
    }
    let rise = (east * east + north * north).sqrt() * spacing;
    let dry = ((elevation - ramp.sea_level) / rise.max(f32::MIN_POSITIVE) + 0.5).clamp(0.0, 1.0);
    // A flat beach at the sea's very level is neither: it is dry.
    match dry {
        d if d >= 1.0 => land(),
        d if d <= 0.0 => shade(tint(&ramp.sea), light * UNDER_WATER),
        d => mix(shade(tint(&ramp.sea), light * UNDER_WATER), land(), d),
    }
}

/// How much more (up to about 0.4) or less (down to -1) light a slope gets than flat ground.
fn light(east: f32, north: f32) -> f32 {
    let length = (1.0 + east * east + north * north).sqrt();
    let (mut lit, mut flat) = (0.0, 0.0);
    for (weight, [to_east, to_north, up]) in LIGHTS {
        // The normal is (-dz/dx, -dz/dy, 1) over its length.
        lit += weight * ((up - east * to_east - north * to_north) / length).max(0.0);
        flat += weight * up;
    }
    lit / flat - 1.0
}

fn shade(colour: [f32; 3], light: f32) -> [f32; 3] {
    if light < 0.0 { mix(colour, SHADOW.0, -light * SHADOW.1) } else { mix(colour, GLOW.0, light * GLOW.1) }
}

fn mix(from: [f32; 3], to: [f32; 3], part: f32) -> [f32; 3] {
    core::array::from_fn(|i| from[i] + (to[i] - from[i]) * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(elevation: f32, dx: f32, dy: f32, ramp: &Ramp) -> [u8; 3] {
        let elevation = (0..9_u8).map(|i| elevation + dx * (f32::from(i % 3) - 1.0) - dy * (f32::from(i / 3) - 1.0)).collect();
        draw(&Surface { columns: 3, rows: 3, elevation, ..Surface::default() }, 1.0, ramp).try_into().expect("one pixel")
    }

    #[test]
    fn flat_ground_has_the_ramp_s_own_colour() {
        let ramp = Ramp::over(0.0, [-1_000.0, 2_600.0]);
        assert_eq!(pixel(-1_000.0, 0.0, 0.0, &ramp), SEA[0].1);
        assert_eq!(pixel(-5_000.0, 0.0, 0.0, &ramp), SEA[0].1);
        assert_eq!(pixel(2_600.0, 0.0, 0.0, &ramp), LAND[6].1);
        assert_eq!(pixel(9_000.0, 0.0, 0.0, &ramp), LAND[6].1);
        assert_eq!(pixel(1_300.0, 0.0, 0.0, &ramp), LAND[3].1);
        let shore = Ramp::over(10.0, [10.0, 2_610.0]);
        assert_eq!(pixel(-50.0, 0.0, 0.0, &shore), LAND[0].1, "without a sea there is no blue");
        let high = Ramp::over(0.0, [780.0, 2_600.0]);
        assert_eq!((pixel(780.0, 0.0, 0.0, &high), pixel(2_600.0, 0.0, 0.0, &high)), (LAND[2].1, LAND[6].1), "high plains are not green");
        let summit = Ramp::over(0.0, [20_000.0, 20_001.0]);
        assert!(summit.stops().is_sorted_by(|a, b| a.0 < b.0) && summit.stops().last().is_some_and(|(_, colour)| colour == LAND[6].1));
    }

    #[test]
    fn slopes_to_the_north_west_are_bright_and_others_dark() {
        let ramp = Ramp::over(0.0, [0.0, 2_600.0]);
        let sum = |dx, dy| pixel(1_000.0, dx, dy, &ramp).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!(sum(0.5, -0.5) > sum(0.0, 0.0) && sum(0.0, 0.0) > sum(-0.5, 0.5));
        assert!(sum(-0.5, 0.5) > sum(-5.0, 5.0));
        assert_eq!(pixel(1_000.0, f32::NAN, 0.0, &ramp).len(), 3, "what is not a number is drawn somehow");
    }

    #[test]
    fn the_shore_is_drawn_without_steps() {
        let ramp = Ramp::over(0.0, [-100.0, 100.0]);
        let blue = |elevation| i32::from(pixel(elevation, 1.0, 0.0, &ramp)[2]);
        let (sea, shore, land) = (blue(-0.6), blue(0.0), blue(0.6));
        assert!(sea > shore && shore > land && (2 * shore - sea - land).abs() <= 2, "{sea} {shore} {land}");
    }
}
