//! glTF 2.0 as one binary file: what Blender, Unity, Unreal and Godot open, textures' coordinates and normals included.
//!
//! The range of positions stands at the front of the file, so nothing can be written before all is evaluated: the heights of a mesh, 16 MiB at most, are kept until then.

use super::{Area, lattice::Lattice, writer::Encoder};
use crate::{geometry::Surface, tile::EncodeError};
use serde_json::{Value, json};

/// Vertices whose bytes are made at a time.
const PIECE_VERTICES: usize = 1 << 16;

/// Digits of an f32 written as JSON, at most.
const DIGITS: usize = 24;

/// What follows the description, in this order, each row by row; and the bytes of it a vertex or a cell between vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Positions,
    Normals,
    Texture,
    Triangles,
}

impl Section {
    const ALL: [Section; 4] = [Section::Positions, Section::Normals, Section::Texture, Section::Triangles];

    /// The length of all of it in bytes.
    fn length(self, lattice: &Lattice) -> usize {
        let vertices = lattice.columns * lattice.rows;
        match self {
            Section::Positions | Section::Normals => vertices * 12,
            Section::Texture => vertices * 8,
            Section::Triangles => (lattice.columns - 1) * (lattice.rows - 1) * 24,
        }
    }
}

/// Writes a mesh once it has its last row.
pub(super) struct Glb {
    lattice: Lattice,
    covered: [f64; 4],
    /// With the apron.
    heights: Surface,
    /// The section and the row of it that come next; `None` before the first.
    next: Option<(usize, usize)>,
}

impl Glb {
    pub(super) fn of(area: &Area) -> Self {
        let lattice = Lattice::of(area);
        Self { lattice, covered: area.covered(), heights: Surface { columns: lattice.columns + 2, ..Surface::default() }, next: None }
    }

    /// The bytes of all sections.
    fn sections(&self) -> usize {
        Section::ALL.iter().map(|section| section.length(&self.lattice)).sum()
    }

    /// The description for a range of heights.
    fn description(&self, low: f32, high: f32) -> String {
        let lattice = &self.lattice;
        let (vertices, x, z) = (lattice.columns * lattice.rows, lattice.x(lattice.columns - 1), lattice.z(lattice.rows - 1));
        let mut offset = 0;
        let views: Vec<Value> = Section::ALL
            .iter()
            .map(|section| {
                let target = if *section == Section::Triangles { 34963 } else { 34962 };
                let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": section.length(lattice), "target": target});
                offset += section.length(lattice);
                view
            })
            .collect();
        json!({
            "asset": {"version": "2.0", "generator": "Terrane"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": "terrain", "mesh": 0, "extras": {"origin": lattice.origin, "area": self.covered, "spacing": lattice.spacing}}],
            "meshes": [{"name": "terrain", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0, "mode": 4}]}],
            "materials": [{"name": "ground", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.45, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}}],
            "buffers": [{"byteLength": self.sections()}],
            "bufferViews": views,
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3", "min": [-x, low, -z], "max": [x, high, z]},
                {"bufferView": 1, "componentType": 5126, "count": vertices, "type": "VEC3"},
                {"bufferView": 2, "componentType": 5126, "count": vertices, "type": "VEC2"},
                {"bufferView": 3, "componentType": 5125, "count": Section::Triangles.length(lattice) / 4, "type": "SCALAR"},
            ],
        })
        .to_string()
    }

    /// The length of the description with the spaces after it: the same for all heights, so that the file's length is known before they are.
    fn room(&self) -> usize {
        (self.description(0.0, 0.0).len() + 2 * DIGITS).next_multiple_of(4)
    }

    /// Least and greatest height of a vertex.
    fn range(&self) -> (f32, f32) {
        let inner = (1..=self.lattice.rows).flat_map(|row| &self.heights.row(row)[1..=self.lattice.columns]);
        inner.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &height| (low.min(height), high.max(height)))
    }

    /// The file's header, the description, and the header of what follows.
    fn front(&self) -> Vec<u8> {
        let ((low, high), room, sections) = (self.range(), self.room(), self.sections());
        let words = |words: [u32; 2]| words.into_iter().flat_map(u32::to_le_bytes);
        let mut out = b"glTF".to_vec();
        out.extend(words([2, (28 + room + sections) as u32]));
        out.extend((room as u32).to_le_bytes().into_iter().chain(*b"JSON"));
        out.extend_from_slice(self.description(low, high).as_bytes());
        out.resize(20 + room, b' ');
        out.extend((sections as u32).to_le_bytes().into_iter().chain(*b"BIN\0"));
        out
    }

    /// A row of a section.
    fn row(&self, section: Section, row: usize, out: &mut Vec<u8>) {
        let lattice = &self.lattice;
        let (z, v) = (lattice.z(row), row as f32 / (lattice.rows - 1) as f32);
        let mut floats = |floats: &[f32]| out.extend(floats.iter().flat_map(|float| float.to_le_bytes()));
        match section {
            Section::Positions => (0..lattice.columns).for_each(|column| floats(&[lattice.x(column), self.heights.at(row + 1, column + 1), z])),
            Section::Normals => (0..lattice.columns).for_each(|column| floats(&lattice.normal(&self.heights, row + 1, column + 1))),
            Section::Texture => (0..lattice.columns).for_each(|column| floats(&[column as f32 / (lattice.columns - 1) as f32, v])),
            Section::Triangles if row + 1 == lattice.rows => {}
            Section::Triangles => out.extend(lattice.triangles(row).flatten().flat_map(u32::to_le_bytes)),
        }
    }
}

impl Encoder for Glb {
    fn length(&self) -> Option<u64> {
        Some((28 + self.room() + self.sections()) as u64)
    }

    fn rows(&mut self, heights: &[f32], _: &mut Vec<u8>) -> Result<(), EncodeError> {
        self.heights.elevation.reserve_exact(self.heights.columns * (self.lattice.rows + 2) - self.heights.elevation.len());
        self.heights.elevation.extend_from_slice(heights);
        self.heights.rows += heights.len() / self.heights.columns;
        Ok(())
    }

    fn tail(&mut self) -> Result<Option<Vec<u8>>, EncodeError> {
        let Some((section, row)) = self.next else {
            self.next = Some((0, 0));
            return Ok(Some(self.front()));
        };
        let Some(&which) = Section::ALL.get(section) else { return Ok(None) };
        let end = self.lattice.rows.min(row + PIECE_VERTICES.div_ceil(self.lattice.columns));
        let mut out = Vec::new();
        (row..end).for_each(|row| self.row(which, row, &mut out));
        self.next = Some(if end == self.lattice.rows { (section + 1, 0) } else { (section, end) });
        Ok(Some(out))
    }
}
