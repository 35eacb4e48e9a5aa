//! The drawings that ship with the program: the 26 results of the thesis, and the two pictures by shadows.

/// A drawing that ships with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetDrawing {
    /// Its name.
    pub name: &'static str,
    /// Its document.
    pub json: &'static str,
}

/// Every drawing that ships, by name.
pub const PRESET_DRAWINGS: [PresetDrawing; 26] = [
    PresetDrawing { name: "canyon", json: include_str!("../../data/paths/canyon.json") },
    PresetDrawing { name: "cinder-cone", json: include_str!("../../data/paths/cinder-cone.json") },
    PresetDrawing { name: "crater", json: include_str!("../../data/paths/crater.json") },
    PresetDrawing { name: "edge-detection", json: include_str!("../../data/paths/edge-detection.json") },
    PresetDrawing { name: "edge-weights", json: include_str!("../../data/paths/edge-weights.json") },
    PresetDrawing { name: "edges-and-weights-1", json: include_str!("../../data/paths/edges-and-weights-1.json") },
    PresetDrawing { name: "edges-and-weights-2", json: include_str!("../../data/paths/edges-and-weights-2.json") },
    PresetDrawing { name: "edges-and-weights-3", json: include_str!("../../data/paths/edges-and-weights-3.json") },
    PresetDrawing { name: "edges-and-weights-4", json: include_str!("../../data/paths/edges-and-weights-4.json") },
    PresetDrawing { name: "fault", json: include_str!("../../data/paths/fault.json") },
    PresetDrawing { name: "hills", json: include_str!("../../data/paths/hills.json") },
    PresetDrawing { name: "lambda", json: include_str!("../../data/paths/lambda.json") },
    PresetDrawing { name: "layers", json: include_str!("../../data/paths/layers.json") },
    PresetDrawing { name: "logo", json: include_str!("../../data/paths/logo.json") },
    PresetDrawing { name: "lunar", json: include_str!("../../data/paths/lunar.json") },
    PresetDrawing { name: "mountain-range", json: include_str!("../../data/paths/mountain-range.json") },
    PresetDrawing { name: "musgrave", json: include_str!("../../data/paths/musgrave.json") },
    PresetDrawing { name: "river-terrace", json: include_str!("../../data/paths/river-terrace.json") },
    PresetDrawing { name: "sketch-1", json: include_str!("../../data/paths/sketch-1.json") },
    PresetDrawing { name: "sketch-2", json: include_str!("../../data/paths/sketch-2.json") },
    PresetDrawing { name: "sketch-3", json: include_str!("../../data/paths/sketch-3.json") },
    PresetDrawing { name: "sketch-4", json: include_str!("../../data/paths/sketch-4.json") },
    PresetDrawing { name: "text", json: include_str!("../../data/paths/text.json") },
    PresetDrawing { name: "tower-karst", json: include_str!("../../data/paths/tower-karst.json") },
    PresetDrawing { name: "u-valley", json: include_str!("../../data/paths/u-valley.json") },
    PresetDrawing { name: "v-valley", json: include_str!("../../data/paths/v-valley.json") },
];

/// Every shadow picture that ships, by name.
pub const PRESET_SHADOWS: [PresetDrawing; 2] = [
    PresetDrawing { name: "shadow-face", json: include_str!("../../data/paths/shadow-face.json") },
    PresetDrawing { name: "shadow-text", json: include_str!("../../data/paths/shadow-text.json") },
];
