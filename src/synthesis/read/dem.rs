//! ASCII DEM of the United States Geological Survey ("Standards for Digital Elevation Models", part 2, 1998): one record A about the whole, then a record B
//! a profile, from west to east, whose elevations run from south to north. Records are blocks of 1,024 bytes, with or without line ends between them.

use super::{File, Format, Numbers, Place, Sample, SampleError, Unit, degrees};

/// Bytes of a block.
const BLOCK: usize = 1024;

/// Elevations of a profile in its first block, and in one that goes on.
const FIRST: usize = 146;
const NEXT: usize = 170;

/// Where nothing is known; some producers write the second one.
const VOIDS: [f64; 2] = [-32_767.0, -32_768.0];

/// Blocks of a file.
struct Blocks<'a> {
    file: &'a File<'a>,
    /// Bytes from one block to the next.
    step: usize,
}

impl<'a> Blocks<'a> {
    fn new(file: &'a File<'a>) -> Self {
        let step = match file.bytes.get(BLOCK..BLOCK + 2) {
            Some(b"\r\n") => BLOCK + 2,
            Some([b'\n', _]) => BLOCK + 1,
            _ => BLOCK,
        };
        Self { file, step }
    }

    /// The bytes of a field of a block. Trailing blanks of the last block may be missing.
    fn field(&self, block: usize, at: usize, length: usize) -> Result<&'a [u8], SampleError> {
        let start = block * self.step + at;
        self.file
            .bytes
            .get(start..start + length)
            .ok_or_else(|| self.file.error(Place::Record(block + 1), format!("the file is cut short at byte {}", self.file.bytes.len())))
    }

    /// A number in Fortran's writing, blank: `None`.
    fn blank_or_number(&self, block: usize, at: usize, length: usize) -> Result<Option<f64>, SampleError> {
        let field = self.field(block, at, length)?;
        let text: String = String::from_utf8_lossy(field).trim().chars().map(|c| if matches!(c, 'D' | 'd') { 'E' } else { c }).collect();
        if text.is_empty() {
            return Ok(None);
        }
        text.parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
            .map(Some)
            .ok_or_else(|| self.file.error(Place::Record(block + 1), format!("bytes {} … {} must be a number, are {text:?}", at + 1, at + length)))
    }

    fn number(&self, block: usize, at: usize, length: usize, what: &str) -> Result<f64, SampleError> {
        let blank = || self.file.error(Place::Record(block + 1), format!("{what} (bytes {} … {}) is blank", at + 1, at + length));
        self.blank_or_number(block, at, length)?.ok_or_else(blank)
    }

    fn count(&self, block: usize, at: usize, what: &str, most: usize) -> Result<usize, SampleError> {
        let number = self.number(block, at, 6, what)?;
        if number.fract() != 0.0 || !(1.0..=most as f64).contains(&number) {
            return Err(self.file.error(Place::Record(block + 1), format!("{what} must be 1 … {most}, is {number}")));
        }
        Ok(number as usize)
    }
}

/// What record A says.
struct Head {
    profiles: usize,
    /// Ground units between profiles, between elevations, and elevation units a number.
    resolution: [f64; 3],
    /// Metres a ground unit, or `None` for arc-seconds.
    ground: Option<f64>,
    unit: Unit,
    /// In ground units, of the middle.
    latitude: f64,
}

fn head(blocks: &Blocks) -> Result<Head, SampleError> {
    let error = |detail: String| blocks.file.error(Place::Record(1), detail);
    let ground = match blocks.number(0, 528, 6, "the unit of the ground")? {
        1.0 => Some(Unit::Feet.metres()),
        2.0 => Some(1.0),
        3.0 => None,
        code => return Err(error(format!("the unit of the ground (bytes 529 … 534) must be 1 (feet), 2 (metres) or 3 (arc-seconds), is {code}"))),
    };
    let unit = match blocks.number(0, 534, 6, "the unit of elevations")? {
        1.0 => Unit::Feet,
        2.0 => Unit::Metres,
        code => return Err(error(format!("the unit of elevations (bytes 535 … 540) must be 1 (feet) or 2 (metres), is {code}"))),
    };
    if let Some(angle) = blocks.blank_or_number(0, 786, 24)?
        && angle.abs() > 1e-6
    {
        return Err(error(format!("the profiles are turned by {angle} radians (bytes 787 … 810): they must run from south to north")));
    }
    let [mut x, mut y, mut z] = [0.0; 3];
    for (i, resolution) in [&mut x, &mut y, &mut z].into_iter().enumerate() {
        *resolution = blocks.number(0, 816 + 12 * i, 12, "a resolution")?;
        if !(1e-6..=1e6).contains(resolution) {
            return Err(error(format!("a resolution (bytes {} … {}) must be above 0, is {resolution}", 817 + 12 * i, 828 + 12 * i)));
        }
    }
    let profiles = blocks.count(0, 858, "the number of profiles", 100_000)?;
    let (south, north) = (blocks.number(0, 546 + 24, 24, "a corner")?, blocks.number(0, 546 + 3 * 24, 24, "a corner")?);
    Ok(Head { profiles, resolution: [x, y, z], ground, unit, latitude: f64::midpoint(south, north) / 3600.0 })
}

/// A profile: where it begins, and where its elevations are.
struct Profile {
    block: usize,
    count: usize,
    south: f64,
    datum: f64,
}

impl Profile {
    /// Blocks that it takes.
    fn blocks(&self) -> usize {
        1 + self.count.saturating_sub(FIRST).div_ceil(NEXT)
    }

    /// The number of an elevation from the south.
    fn elevation(&self, blocks: &Blocks, number: usize) -> Result<f64, SampleError> {
        let (block, at) = match number.checked_sub(FIRST) {
            None => (self.block, 144 + 6 * number),
            Some(rest) => (self.block + 1 + rest / NEXT, 6 * (rest % NEXT)),
        };
        blocks.number(block, at, 6, "an elevation")
    }
}

fn profiles(blocks: &Blocks, head: &Head) -> Result<Vec<Profile>, SampleError> {
    // Each has a block; all memory that is asked for stands in the file.
    blocks.file.expands(Place::Record(1), head.profiles * blocks.step, 1)?;
    let mut block = 1;
    let mut profiles = Vec::with_capacity(head.profiles);
    for _ in 0..head.profiles {
        let count = blocks.count(block, 12, "the number of elevations", 1_000_000)?;
        let south = blocks.number(block, 48, 24, "the southern end")?;
        let datum = blocks.blank_or_number(block, 72, 24)?.unwrap_or(0.0);
        let profile = Profile { block, count, south, datum };
        block += profile.blocks();
        profiles.push(profile);
    }
    Ok(profiles)
}

pub(super) fn read(file: &File) -> Result<Sample, SampleError> {
    let blocks = Blocks::new(file);
    let head = head(&blocks)?;
    let profiles = profiles(&blocks, &head)?;
    let [x, y, z] = head.resolution;
    let south = profiles.iter().map(|profile| profile.south).fold(f64::INFINITY, f64::min);
    let first = |profile: &Profile| libm::round((profile.south - south) / y) as usize;
    let rows = profiles.iter().map(|profile| first(profile).saturating_add(profile.count)).max().unwrap_or(0);
    let columns = profiles.len();
    let cells = file.cells(Place::Record(1), columns, rows)?;
    // Profiles of one quadrangle overlap in most of their rows.
    file.expands(Place::Record(1), cells, 8)?;
    let mut values = vec![VOIDS[0] as f32; cells];
    for (column, profile) in profiles.iter().enumerate() {
        for number in 0..profile.count {
            let value = profile.elevation(&blocks, number)?;
            if !VOIDS.contains(&value) {
                values[(rows - 1 - first(profile) - number) * columns + column] = (value * z + profile.datum) as f32;
            }
        }
    }
    let mut notes = Vec::new();
    let own = match head.ground {
        _ if file.hints.spacing.is_some() => None,
        Some(metres) => Some([x * metres, y * metres]),
        None => {
            let (spacing, note) = degrees::spacing(file, [x / 3600.0, y / 3600.0], head.latitude)?;
            notes.push(note);
            Some(spacing)
        }
    };
    let spacing = file.spacing(own)?;
    file.finish(Format::UsgsDem, Numbers { columns, rows, spacing, values, void: Some(VOIDS[0]), unit: Some(head.unit), notes })
}
