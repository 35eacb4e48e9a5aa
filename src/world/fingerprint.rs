//! What can influence a tile's bytes, hashed before the tile is evaluated.

use super::{Document, World};
use crate::geometry::{Filter, Grid, Rectangle, Samples, Tile, Window};
use sha2::{Digest, Sha256};
use std::fmt;

/// The identity of a tile's bytes: strong `ETag` and cache key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fingerprint([u8; 16]);

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl Fingerprint {
    /// Of what a text says in full.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let mut own = [0; 16];
        own.copy_from_slice(&Sha256::digest(text)[..16]);
        Self(own)
    }
}

impl From<Fingerprint> for u128 {
    fn from(fingerprint: Fingerprint) -> Self {
        Self::from_le_bytes(fingerprint.0)
    }
}

/// The hash of what is the same for all tiles of a world.
#[derive(Clone, Debug)]
pub(super) struct Prefix(Sha256);

impl Prefix {
    /// Title, description and attribution do not influence tiles; how a programme is spelt does not either.
    pub(super) fn new(document: &Document) -> Self {
        let base = &document.base;
        let mut hash = Sha256::new();
        hash.update(format!("terrane tile 1\ngenerator {}\nseed {}\nprogramme {}\n", document.generator, document.seed, base.programme));
        let numbers =
            [document.elevation.min, document.elevation.max, document.sea_level, base.scale, base.origin[0], base.origin[1], base.amplitude, base.datum];
        for number in numbers {
            // -0 and 0 are one number.
            hash.update((number + 0.0).to_bits().to_le_bytes());
        }
        Self(hash)
    }
}

impl World {
    /// The fingerprint of a tile that is made from samples in an area, those of neighbours that it needs among them; `form` names tileset, extension, options and
    /// encoder version. Of layers only what can reach the area is taken in.
    #[must_use]
    pub fn fingerprint(&self, form: &str, area: &Rectangle, grid: Grid, tile: Tile, samples: Samples, filter: Filter) -> Fingerprint {
        let (registration, side) = match samples {
            Samples::Centres(n) => ("centres", n),
            Samples::Vertices(n) => ("vertices", n),
        };
        let what = format!("{form}\n{registration} {side}\n{}\n{} {} {} {}", filter.name(), grid.name(), tile.z, tile.x, tile.y);
        let spacing = grid.window(tile, samples, filter).ok().map(|window| window.spacing());
        self.named(&what, area, spacing.map(|spacing| (spacing, filter)))
    }

    /// The fingerprint of the view that [`Survey`](super::Survey) finds, `pixels` a side; `form` names what is drawn and the encoder's version.
    #[must_use]
    pub fn view_fingerprint(&self, form: &str, pixels: usize) -> Fingerprint {
        self.identify(&format!("{form}\nview {pixels}"), &Rectangle::EVERYTHING)
    }

    /// The identity of something drawn from an area of this world that `what` describes in full, at whatever spacing.
    #[must_use]
    pub fn identify(&self, what: &str, area: &Rectangle) -> Fingerprint {
        self.named(what, area, None)
    }

    /// The identity of something drawn from the samples of a window that `what` describes in full.
    #[must_use]
    pub fn identify_window(&self, what: &str, window: &Window) -> Fingerprint {
        self.named(what, &window.bounds(), Some((window.spacing(), window.filter)))
    }

    /// What ground that evolves adds to the form of a tile that is drawn from a second window, too, such as a mask of water finer than its heights; empty without such ground.
    #[must_use]
    pub fn seen_in(&self, window: &Window) -> String {
        let evolving = self.layers().filter(|layer| layer.generation().is_some());
        evolving
            .filter_map(|layer| layer.content_in(&window.bounds(), Some((window.spacing(), window.filter))))
            .fold(String::new(), |all, layer| all + "\n" + &layer)
    }

    fn named(&self, what: &str, area: &Rectangle, samples: Option<(f64, Filter)>) -> Fingerprint {
        let mut hash = self.prefix.0.clone();
        hash.update(what);
        for layer in self.layers().filter_map(|layer| layer.content_in(area, samples)) {
            hash.update(format!("\n{layer}"));
        }
        let digest = hash.finalize();
        Fingerprint(core::array::from_fn(|i| digest[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fingerprint(json: &str, form: &str, x: i64, samples: Samples, filter: Filter) -> Fingerprint {
        let world = World::new(Document::parse(json.as_bytes()).expect("valid"));
        world.fingerprint(form, &Rectangle::EVERYTHING, Grid::Web, Tile { z: 9, x, y: 0 }, samples, filter)
    }

    #[test]
    fn only_what_can_change_bytes_changes_the_fingerprint() {
        let json = |title: &str, programme: &str, datum: f64| {
            format!(r#"{{"seed":1,"title":"{title}","base":{{"programme":"{programme}","scale":10,"datum":{datum}}}}}"#)
        };
        let of = |json: &str| fingerprint(json, "terrarium.png 1", 4, Samples::Centres(256), Filter::Band);
        let one = of(&json("a", "fbm(1,2,8)", 0.0));
        assert_eq!(one, of(&json("b", "fbm( 1.0, 2, octaves=8 )", -0.0)));
        assert_ne!(one, of(&json("a", "fbm(1,2,7)", 0.0)));
        assert_ne!(one, of(&json("a", "fbm(1,2,8)", 1.0)));
        let base = json("a", "fbm(1,2,8)", 0.0);
        assert_ne!(one, fingerprint(&base, "terrarium.png 2", 4, Samples::Centres(256), Filter::Band));
        assert_ne!(one, fingerprint(&base, "terrarium.png 1", 5, Samples::Centres(256), Filter::Band));
        assert_ne!(one, fingerprint(&base, "terrarium.png 1", 4, Samples::Vertices(256), Filter::Band));
        assert_ne!(one, fingerprint(&base, "terrarium.png 1", 4, Samples::Centres(256), Filter::Exact));
        assert_eq!(one.to_string().len(), 32);
        let world = World::new(Document::parse(base.as_bytes()).expect("valid"));
        assert_ne!(world.view_fingerprint("preview.png 1", 256), world.view_fingerprint("preview.png 1", 255));
    }
}
