//! From the sums of a block to the samples of a surface.

use super::Evaluation;
use crate::layout::{
    FieldKind, FieldSurface, LayoutSurface,
    block::{RUN, Run, Values},
    kernels::{Merge, Sums},
    reference::Stage,
    term::above_zero,
};

impl Evaluation<'_> {
    /// Merges the sums and writes the block into a surface.
    pub(super) fn write(&mut self, columns: usize, base: Option<&[f32]>, surface: &mut LayoutSurface) {
        let [elevation, depth] = ["elevation", "water_depth"].map(|name| self.layout.field(name));
        let mut ground = Values::new(0.0);
        if let Some(base) = base {
            for Run { first, place, count } in self.block.runs(columns) {
                let (ground, base) = (&mut ground.0[first..first + count], &base[place..place + count]);
                ground.iter_mut().zip(base).for_each(|(ground, &base)| *ground = base.into());
            }
        }
        self.merge(elevation, 0, base.is_some(), &mut ground);
        let mut water = Values::new(0.0);
        self.merge(depth, 0, true, &mut water);
        self.submerge(&mut ground, &mut water);
        for run in self.block.runs(columns) {
            run.write(&ground, &mut surface.elevation);
            run.write(&water, &mut surface.water_depth);
            if !surface.water_cover.is_empty() {
                run.write(&self.cover, &mut surface.water_cover);
            }
        }
        for (out, &field) in surface.fields.iter_mut().zip(&self.selection.fields) {
            match (out, &self.layout.fields[field].kind) {
                (FieldSurface::Numbers(out), FieldKind::Numbers(components)) => self.write_numbers(field, *components, columns, out),
                (FieldSurface::Names { heaviest, fractions }, FieldKind::Names(names)) => self.write_names(field, names.len(), columns, heaviest, fractions),
                _ => {}
            }
        }
    }

    /// Takes the depth of water from the ground, and fills what lies below the sea's surface.
    fn submerge(&self, ground: &mut Values, water: &mut Values) {
        let sea_level = self.layout.options.sea_level;
        for (ground, water) in ground.0.iter_mut().zip(&mut water.0) {
            let depth = above_zero(*water);
            let height = *ground - depth;
            let sea = sea_level.map_or(0.0, |level| level - height);
            (*ground, *water) = (height, if sea > depth { sea } else { depth });
        }
    }

    /// Merges one component over what is below.
    fn merge(&self, field: usize, component: usize, below: bool, values: &mut Values) {
        let stages = self.sums.range((field, Stage::Level(0))..(field + 1, Stage::Level(0)));
        let stages: Vec<(bool, &Sums)> = stages.map(|(&(_, stage), sums)| (matches!(stage, Stage::Level(1..)), sums)).collect();
        self.isa.run(Merge { stages: &stages, component, mix: self.layout.options.mix, below, values });
    }

    fn write_numbers(&self, field: usize, components: usize, columns: usize, out: &mut [f32]) {
        let defaults = self.layout.options.defaults.get(&*self.layout.fields[field].name);
        for k in 0..components {
            let mut values = Values::new(defaults.map_or(0.0, |values| values[k]));
            self.merge(field, k, defaults.is_some(), &mut values);
            for Run { first, place, count } in self.block.runs(columns) {
                let out = out[place * components..(place + count) * components].chunks_exact_mut(components);
                out.zip(&values.0[first..]).for_each(|(out, &value)| out[k] = value as f32);
            }
        }
    }

    fn write_names(&self, field: usize, names: usize, columns: usize, heaviest: &mut [u16], fractions: &mut [f32]) {
        let stages = self.sums.range((field, Stage::Level(0))..(field + 1, Stage::Level(0)));
        let weighted: Vec<(usize, &Values)> =
            stages.filter_map(|(&(_, stage), sums)| if let Stage::Name(name) = stage { Some((name, &*sums.weight)) } else { None }).collect();
        for Run { first, place, count } in self.block.runs(columns) {
            let (mut most, mut total, mut found) = ([0.0; RUN], [0.0; RUN], [0; RUN]);
            for &(name, weights) in &weighted {
                for (k, &weight) in weights.0[first..first + RUN].iter().enumerate() {
                    total[k] += weight;
                    let more = weight > most[k];
                    most[k] = if more { weight } else { most[k] };
                    found[k] = if more { name as u16 + 1 } else { found[k] };
                }
            }
            heaviest[place..place + count].copy_from_slice(&found[..count]);
            if fractions.is_empty() {
                continue;
            }
            let shares = fractions[place * names..(place + count) * names].chunks_exact_mut(names);
            for (k, shares) in shares.enumerate().filter(|(k, _)| total[*k] > 0.0) {
                for &(name, weights) in &weighted {
                    shares[name] = (weights.0[first + k] / total[k]) as f32;
                }
            }
        }
    }
}
