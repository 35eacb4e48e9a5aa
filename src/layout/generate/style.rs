//! How what is generated becomes features.

use super::error::GenerateError;
use crate::{
    geometry::{Detail, Elevation, Shape},
    layout::{Attribute, AttributeSet, Feature, Role, Side, Value, Weight},
};
use std::sync::Arc;

/// What the features of one generator have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Their attributes.
    pub attributes: Arc<AttributeSet>,
    /// Fractal detail of their shapes.
    pub detail: Option<Detail>,
    /// Which of two features in conflict stays: the greater.
    pub precedence: i32,
}

impl Style {
    /// A feature along a line or round a ring (whose first vertex is not repeated).
    pub(super) fn feature(&self, line: &[[f64; 3]], closed: bool, attributes: &Arc<AttributeSet>, detail: Option<Detail>) -> Result<Feature, GenerateError> {
        let line: Vec<[f64; 3]> = line.iter().chain(line.first().filter(|_| closed)).copied().collect();
        let elevation = Elevation::Vertices(line.iter().map(|p| p[2]).collect());
        let flat = line.iter().map(|p| [p[0], p[1]]).collect();
        let shape = if closed { Shape::polygon(vec![flat], elevation)? } else { Shape::line(flat, elevation)? };
        let shape = if let Some(detail) = detail { shape.detailed(detail)? } else { shape };
        let mut feature = Feature::new(shape, Arc::clone(attributes))?;
        feature.precedence = self.precedence;
        Ok(feature)
    }

    /// The attributes for `amount` times the water: widths of channels and of profiles grow with its square root, depths with its power 0.4 (L. B. Leopold and
    /// T. Maddock 1953), in steps of a quarter of an octave so that few sets are needed.
    pub(super) fn widened(&self, amount: f64) -> Result<Arc<AttributeSet>, GenerateError> {
        let octaves = libm::floor(2.0 * libm::log2(amount.max(1.0))) / 4.0;
        let (wide, deep) = (libm::exp2(octaves), libm::exp2(0.8 * octaves));
        let widen = |attribute: &Attribute| {
            let mut attribute = attribute.clone();
            if let Role::Channel { half_width } = &mut attribute.role {
                *half_width *= wide;
            }
            if let Value::Profile(points) = &mut attribute.value {
                for [distance, depth] in points {
                    (*distance, *depth) = (*distance * wide, *depth * deep);
                }
                attribute.range *= wide;
            }
            attribute
        };
        Ok(Arc::new(AttributeSet::new(self.attributes.iter().map(widen).collect())?))
    }
}

/// The styles of the layouts "ridges and rivers" and "ridges, rivers and lakes".
#[derive(Clone, Debug, PartialEq)]
pub struct Styles {
    /// The land and the sea around it.
    pub land: Style,
    /// Rivers at their source; they grow with the water.
    pub rivers: Style,
    /// Lakes.
    pub lakes: Style,
    /// Ridges.
    pub ridges: Style,
}

impl Styles {
    /// Styles that suit rivers `spacing` metres apart and a sea at elevation 0: rivers and ridges reach as far as the next of their kind, and valleys have flat
    /// floors about a tenth as wide, so that samples a twentieth of the spacing apart find their way down.
    ///
    /// # Errors
    /// If the spacing is not 1 … 1,000,000 m.
    pub fn for_spacing(spacing: f64, seed: u64) -> Result<Self, GenerateError> {
        Self::for_sea(spacing, seed, 0.0)
    }

    /// Styles of mountains on land, as heights above what lies beneath: as [`Styles::for_spacing`], without sea and water.
    ///
    /// # Errors
    /// If the spacing is not 1 … 1,000,000 m.
    pub fn for_massif(spacing: f64, seed: u64) -> Result<Self, GenerateError> {
        let mut styles = Self::for_spacing(spacing, seed)?;
        let without = |style: &mut Style, gone: &dyn Fn(&Attribute) -> bool| -> Result<(), GenerateError> {
            let kept = style.attributes.iter().filter(|attribute| !gone(attribute)).cloned().collect();
            style.attributes = Arc::new(AttributeSet::new(kept)?);
            Ok(())
        };
        let is_sand = |attribute: &Attribute| attribute.value == Value::Name("sand".into());
        without(&mut styles.land, &|attribute| attribute.side == Side::Outside || is_sand(attribute))?;
        without(&mut styles.rivers, &|attribute| *attribute.name == *"water_depth")?;
        Ok(styles)
    }

    /// As [`Styles::for_spacing`], with the sea at another elevation in metres.
    ///
    /// # Errors
    /// If the spacing is not 1 … 1,000,000 m or the sea's elevation not -10,000 … 32,767 m.
    pub fn for_sea(spacing: f64, seed: u64, sea_level: f64) -> Result<Self, GenerateError> {
        super::error::check("styles.spacing", spacing, 1.0..=1e6)?;
        super::error::check("styles.sea_level", sea_level, -10_000.0..=32_767.0)?;
        let valley = Weight::Smooth { width: 0.1 * spacing };
        let floor = |half_width: f64| Attribute::elevation(Weight::Smooth { width: 0.08 * spacing }, 0.2 * spacing).as_channel(half_width);
        let bed = 0.003 * spacing;
        let depth = |profile: &[[f64; 2]], range: f64| Attribute::water_depth(profile, Weight::Linear, range);
        // It also says what samples see that are too far apart for rivers and ridges: about the mean height of the land.
        let sea = Value::Profile([-4.0, 0.0, 4.0].map(|d| [d * spacing, sea_level - 0.1 * spacing * d]).into());
        let style = |attributes: Vec<Attribute>, iterations: u8, displacement: f64, precedence: i32| -> Result<Style, GenerateError> {
            let detail = Some(Detail::new(iterations, displacement, seed)?);
            Ok(Style { attributes: Arc::new(AttributeSet::new(attributes)?), detail, precedence })
        };
        let slope = || Attribute::elevation(valley.clone(), spacing);
        // Grass weighs 1 on all the land; what is heavier near its own shape shows there.
        let ground = |name: &str, width: f64| Attribute::material(name, Weight::Sharp { width: width * spacing, nearest: 0.001 }, 0.5 * spacing);
        let grass = Attribute::material("grass", Weight::Linear, 0.1 * spacing);
        let coast = vec![
            Attribute::new("elevation", sea, valley.clone(), f64::INFINITY).on(Side::Outside),
            floor(0.0).on(Side::Edge),
            grass,
            ground("sand", 0.06).on(Side::Edge),
        ];
        let pond = [[-0.2 * spacing, 0.06 * spacing], [0.0, 0.0]];
        Ok(Styles {
            land: style(coast, 5, 0.12, 0)?,
            // Lakes have the rank of rivers: where the two meet, their levels agree, and neither bends the other's.
            rivers: style(vec![slope(), floor(bed), depth(&[[0.0, 0.3 * bed], [bed, 0.0]], bed), ground("gravel", 0.012)], 8, 0.09, 20)?,
            lakes: style(vec![slope(), floor(0.0), depth(&pond, 1.0).as_channel(0.0), ground("silt", 0.02)], 5, 0.09, 30)?,
            ridges: style(
                vec![Attribute::elevation(Weight::Sharp { width: 0.02 * spacing, nearest: 0.02 * spacing }, spacing), ground("rock", 0.12)],
                6,
                0.12,
                10,
            )?,
        })
    }
}
