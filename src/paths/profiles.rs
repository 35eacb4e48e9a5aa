//! Profiles of drawings, by name.

use super::{
    check::range,
    document::{DrawingError, WrittenProfile},
    picture,
    profile::{Profile, Scaling, Stepping},
};
use crate::{
    geometry::Filter,
    programme::{Frame, Programme, Reference},
};
use std::collections::BTreeMap;

/// Points of a profile that is an expression.
const EXPRESSION_POINTS: usize = 513;

/// A profile and how paths step by it.
#[derive(Clone, Debug)]
pub(super) struct Shaped {
    pub profile: Profile,
    pub stepping: Stepping,
}

/// Profiles by name; number 0 is none.
pub(super) type Profiles = BTreeMap<String, (u16, Shaped)>;

/// Profiles for nodes `spacing` metres apart; how paths step by them is decided for nodes `finest` metres apart.
pub(super) fn profiles(written: &BTreeMap<String, WrittenProfile>, [finest, spacing]: [f64; 2], least_scale: f64) -> Result<Profiles, DrawingError> {
    let mut profiles = Profiles::new();
    for (number, (name, written)) in written.iter().enumerate() {
        let at = format!("/profiles/{name}");
        range(&format!("{at}/width"), written.width, 1e-3..=1e9)?;
        let profile = |points: &[[f64; 2]], field: &str| {
            Profile::new(points, written.width / finest).map_err(|error| DrawingError::new(format!("{at}/{field}"), error.to_string()))
        };
        let profile = match (&written.points, &written.expression, &written.picture) {
            (Some(points), None, None) => profile(points, "points")?,
            (None, Some(text), None) => profile(&expression(text, &at)?, "expression")?,
            (None, None, Some(data)) => profile(&picture::curve(data, &at)?, "picture")?,
            _ => return Err(DrawingError::new(at, "a profile has one of points, expression and picture")),
        };
        let stepping = written.stepping.unwrap_or_else(|| profile.stepping(least_scale));
        profiles.insert(name.clone(), (number as u16 + 1, Shaped { profile: profile.with_width(written.width / spacing), stepping }));
    }
    Ok(profiles)
}

/// The heights of an expression in the distance.
fn expression(text: &str, at: &str) -> Result<Vec<[f64; 2]>, DrawingError> {
    let wrong = |detail: String| DrawingError::new(format!("{at}/expression"), detail);
    let programme = Programme::parse(text).map_err(|error| wrong(error.to_string()))?;
    let frame = Frame { seed: 0, scale: 1.0, origin: [0.0, 0.0] };
    let reference = Reference::new(programme.root(), &frame, 1.0, Filter::Exact);
    let points = (0..EXPRESSION_POINTS).map(|i| i as f64 / (EXPRESSION_POINTS - 1) as f64);
    Ok(points.map(|x| [x, f64::from(reference.at(x, 0.0))]).collect())
}

pub(super) fn scalings(profiles: &Profiles, sea_level_cost: f64, mean: f64, least_scale: f64) -> Vec<Scaling> {
    let mut scalings = vec![Scaling::none(); profiles.len() + 1];
    for (number, shaped) in profiles.values() {
        scalings[usize::from(*number)] = shaped.profile.scaling(shaped.stepping, sea_level_cost, mean, least_scale);
    }
    scalings
}

/// The number of a profile.
pub(super) fn profile_number(profiles: &Profiles, name: &str, at: &str) -> Result<u16, DrawingError> {
    profiles.get(name).map(|(number, _)| *number).ok_or_else(|| {
        let known: Vec<&str> = profiles.keys().map(String::as_str).collect();
        DrawingError::new(at, format!("no profile is called {name:?}; there are {}", if known.is_empty() { "none".to_owned() } else { known.join(", ") }))
    })
}
