//! The meaning of a layout at a point, plainly: every feature is asked, every edge of its shape too.

use super::{
    Attribute, Field, FieldKind, FieldSurface, Layout, LayoutSurface, Mix, Role, Selection, Value,
    term::{Cover, Term},
};
use crate::{
    geometry::{Filter, Shape},
    programme::Reference,
};
use std::collections::BTreeMap;

/// Sums of one level, of one rank of channels or of one name.
#[derive(Clone, Debug, Default)]
struct Sums {
    weight: f64,
    /// Of weights times values, one a component.
    values: Vec<f64>,
    /// The largest weight, coverage of level 0, or strength of a channel.
    most: f64,
}

/// Where in the merge of a field sums belong, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stage {
    Level(u8),
    Channel(u8),
    Name(usize),
}

impl Layout {
    /// The terrain at a point as samples `spacing` metres apart see it; `base` is the elevation beneath the layout.
    ///
    /// This is the definition that [`Layout::sample`] is held to; it takes time for every feature of the layout.
    #[must_use]
    pub fn at(&self, p: [f64; 2], spacing: f64, filter: Filter, base: Option<f32>, selection: &Selection) -> LayoutSurface {
        let sums = self.sums(p, spacing, filter);
        let none = BTreeMap::new();
        let of = |i: usize| sums.get(&i).unwrap_or(&none);
        let number = |name: &str, default: Option<f64>| {
            let field = self.fields.iter().position(|field| *field.name == *name);
            self.number(field.map_or(&none, of), 0, default)
        };
        let (elevation, depth) = (number("elevation", base.map(f64::from)), number("water_depth", Some(0.0)));
        let depth = if depth > 0.0 { depth } else { 0.0 };
        let ground = elevation - depth;
        let sea = self.options.sea_level.map_or(0.0, |level| level - ground);
        let depth = if sea > depth { sea } else { depth };
        let mut surface = LayoutSurface::new(self, selection, 1);
        (surface.elevation[0], surface.water_depth[0]) = (ground as f32, depth as f32);
        if let Some(cover) = surface.water_cover.first_mut() {
            *cover = self.cover(p, if filter == Filter::Band { spacing } else { 0.0 }) as f32;
        }
        for (out, &i) in surface.fields.iter_mut().zip(&selection.fields) {
            match out {
                FieldSurface::Numbers(out) => {
                    let defaults = self.options.defaults.get(&*self.fields[i].name);
                    for (k, out) in out.iter_mut().enumerate() {
                        *out = self.number(of(i), k, defaults.map(|values| values[k])) as f32;
                    }
                }
                FieldSurface::Names { heaviest, fractions } => names(of(i), heaviest, fractions),
            }
        }
        surface
    }

    fn sums(&self, p: [f64; 2], spacing: f64, filter: Filter) -> BTreeMap<usize, BTreeMap<Stage, Sums>> {
        let seen = if filter == Filter::Band { spacing } else { 0.0 };
        let mut sums: BTreeMap<usize, BTreeMap<Stage, Sums>> = BTreeMap::new();
        for feature in &self.features {
            let nearest = feature.shape().nearest(p, seen);
            for attribute in feature.attributes().iter() {
                let (term, field) = (Term::new(attribute, seen), self.field(&attribute.name));
                let d = term.distance(nearest.distance);
                let weight = term.weight(d);
                if weight <= 0.0 {
                    continue;
                }
                let stage = stage(&self.fields[field], attribute);
                let sums = sums.entry(field).or_default().entry(stage).or_default();
                let terrain = if let Value::Terrain(value) = &attribute.value {
                    f64::from(Reference::new(value.programme.root(), &value.frame, spacing, filter).at(p[0], p[1]))
                } else {
                    0.0
                };
                sums.weight += weight;
                sums.values.resize(self.fields[field].kind.components(), 0.0);
                for (k, sum) in sums.values.iter_mut().enumerate() {
                    *sum += weight * term.value(k, nearest.distance, nearest.elevation, terrain);
                }
                let most = match (&term.channel, stage) {
                    (Some(channel), _) => term.strength(channel, d),
                    (None, Stage::Level(0)) => term.coverage(d),
                    _ => weight,
                };
                sums.most = sums.most.max(most);
            }
        }
        sums
    }

    /// The largest share that the water of any feature covers.
    fn cover(&self, p: [f64; 2], seen: f64) -> f64 {
        let mut most = 0.0;
        for feature in &self.features {
            let signed = feature.shape().nearest(p, seen).distance;
            for attribute in feature.attributes().iter() {
                let cover = Cover::new(attribute, feature.attributes().reach(), matches!(feature.shape(), Shape::Line(_)), seen);
                most = cover.map_or(0.0, |cover| cover.share(signed)).max(most);
            }
        }
        most
    }

    /// The number of a field that some feature has.
    pub(super) fn field(&self, name: &str) -> usize {
        self.fields.partition_point(|field| *field.name < *name)
    }

    /// One component of a merged value.
    fn number(&self, sums: &BTreeMap<Stage, Sums>, component: usize, default: Option<f64>) -> f64 {
        let mut value = default;
        for (stage, sums) in sums {
            let average = sums.values[component] / sums.weight;
            let share = match (stage, self.options.mix) {
                (Stage::Level(1..), Mix::Sum) => sums.weight.min(1.0),
                _ => sums.most.min(1.0),
            };
            value = Some(value.map_or(average, |below| below + (average - below) * share));
        }
        value.unwrap_or(0.0)
    }
}

/// Where an attribute of a field belongs.
pub(super) fn stage(field: &Field, attribute: &Attribute) -> Stage {
    let priority = attribute.priority;
    match (&field.kind, &attribute.value, attribute.role) {
        (FieldKind::Names(names), Value::Name(name), _) => Stage::Name(names.partition_point(|known| *known < *name)),
        (_, _, Role::Channel { .. }) => Stage::Channel(priority),
        (_, _, Role::Level) => Stage::Level(priority),
    }
}

fn names(sums: &BTreeMap<Stage, Sums>, heaviest: &mut [u16], fractions: &mut [f32]) {
    let (mut most, mut total) = (0.0, 0.0);
    for (stage, sums) in sums {
        total += sums.weight;
        if let (Stage::Name(name), true) = (stage, sums.weight > most) {
            (most, heaviest[0]) = (sums.weight, *name as u16 + 1);
        }
    }
    for (stage, sums) in sums {
        if let (Stage::Name(name), Some(_)) = (stage, fractions.first()) {
            fractions[*name] = (sums.weight / total) as f32;
        }
    }
}
