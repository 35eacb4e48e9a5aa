//! The worlds and the programmes that ship with the program.

/// A document that ships with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Example {
    /// Its name in URLs.
    pub name: &'static str,
    /// Its document.
    pub json: &'static str,
}

/// Every example world.
pub const EXAMPLES: [Example; 12] = [
    Example { name: "alps", json: include_str!("../../data/worlds/alps.json") },
    Example { name: "archipelago", json: include_str!("../../data/worlds/archipelago.json") },
    Example { name: "archipelago-endless", json: include_str!("../../data/worlds/archipelago-endless.json") },
    Example { name: "cordillera", json: include_str!("../../data/worlds/cordillera.json") },
    Example { name: "dunes", json: include_str!("../../data/worlds/dunes.json") },
    Example { name: "eq2", json: include_str!("../../data/worlds/eq2.json") },
    Example { name: "hills", json: include_str!("../../data/worlds/hills.json") },
    Example { name: "living", json: include_str!("../../data/worlds/living.json") },
    Example { name: "mesas", json: include_str!("../../data/worlds/mesas.json") },
    Example { name: "ranges", json: include_str!("../../data/worlds/ranges.json") },
    Example { name: "ridges-and-rivers", json: include_str!("../../data/worlds/ridges-and-rivers.json") },
    Example { name: "ridges-rivers-and-lakes", json: include_str!("../../data/worlds/ridges-rivers-and-lakes.json") },
];

/// Every programme that ships with the library.
pub const PRESETS: [Example; 30] = [
    Example { name: "alps", json: include_str!("../../data/programmes/alps.json") },
    Example { name: "archipelago", json: include_str!("../../data/programmes/archipelago.json") },
    Example { name: "atolls", json: include_str!("../../data/programmes/atolls.json") },
    Example { name: "badlands", json: include_str!("../../data/programmes/badlands.json") },
    Example { name: "basin-and-range", json: include_str!("../../data/programmes/basin-and-range.json") },
    Example { name: "canyonlands", json: include_str!("../../data/programmes/canyonlands.json") },
    Example { name: "craters", json: include_str!("../../data/programmes/craters.json") },
    Example { name: "cuestas", json: include_str!("../../data/programmes/cuestas.json") },
    Example { name: "drumlins", json: include_str!("../../data/programmes/drumlins.json") },
    Example { name: "dunes", json: include_str!("../../data/programmes/dunes.json") },
    Example { name: "eq2", json: include_str!("../../data/programmes/eq2.json") },
    Example { name: "fjords", json: include_str!("../../data/programmes/fjords.json") },
    Example { name: "foothills", json: include_str!("../../data/programmes/foothills.json") },
    Example { name: "glacial-valleys", json: include_str!("../../data/programmes/glacial-valleys.json") },
    Example { name: "gorges", json: include_str!("../../data/programmes/gorges.json") },
    Example { name: "hills", json: include_str!("../../data/programmes/hills.json") },
    Example { name: "inselbergs", json: include_str!("../../data/programmes/inselbergs.json") },
    Example { name: "karst", json: include_str!("../../data/programmes/karst.json") },
    Example { name: "lava-field", json: include_str!("../../data/programmes/lava-field.json") },
    Example { name: "limestone-pavement", json: include_str!("../../data/programmes/limestone-pavement.json") },
    Example { name: "mesas", json: include_str!("../../data/programmes/mesas.json") },
    Example { name: "moors", json: include_str!("../../data/programmes/moors.json") },
    Example { name: "plains", json: include_str!("../../data/programmes/plains.json") },
    Example { name: "polygons", json: include_str!("../../data/programmes/polygons.json") },
    Example { name: "rice-terraces", json: include_str!("../../data/programmes/rice-terraces.json") },
    Example { name: "salt-pan", json: include_str!("../../data/programmes/salt-pan.json") },
    Example { name: "sea-cliffs", json: include_str!("../../data/programmes/sea-cliffs.json") },
    Example { name: "spires", json: include_str!("../../data/programmes/spires.json") },
    Example { name: "star-dunes", json: include_str!("../../data/programmes/star-dunes.json") },
    Example { name: "volcanoes", json: include_str!("../../data/programmes/volcanoes.json") },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Document, Preset, Survey, World};

    #[test]
    fn every_example_is_a_world_with_relief_and_without_surprises() {
        for example in EXAMPLES {
            let document = Document::parse(example.json.as_bytes()).unwrap_or_else(|error| panic!("{}: {error}", example.name));
            assert!(document.title.is_some() && document.description.is_some(), "{}", example.name);
            let survey = Survey::of(&World::new(document));
            assert!(survey.elevations[1] - survey.elevations[0] > 20.0, "{}: {survey:?}", example.name);
        }
    }

    #[test]
    fn every_shipped_programme_can_be_found_and_shows_relief() {
        for shipped in PRESETS {
            let preset = Preset::parse(shipped.json.as_bytes()).unwrap_or_else(|error| panic!("{}: {error}", shipped.name));
            let told = preset.title.is_some() && preset.description.is_some() && !preset.tags.is_empty();
            assert!(told && preset.origin == "shipped with Terrane", "{}", shipped.name);
            let survey = Survey::of(&World::new(preset.document()));
            assert!(survey.elevations[1] - survey.elevations[0] > 20.0, "{}: {survey:?}", shipped.name);
        }
        assert!(PRESETS.is_sorted_by_key(|shipped| shipped.name), "each name once");
    }
}
