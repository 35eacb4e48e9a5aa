//! From the bytes of a file to elevations.

mod ascii;
mod degrees;
mod dem;
mod geotiff;
mod hgt;
mod lzw;
mod png16;
mod raw;
#[cfg(test)]
mod tests;

use super::{
    grid::{MAX_CELLS, SampleGrid},
    sample::{Format, Hints, Place, Sample, SampleError, Unit},
};

/// A byte of what deflate or LZW compress becomes at most so many.
const MAX_RATIO: usize = 4096;

/// Characters of what a library says at most.
const MAX_QUOTED: usize = 200;

/// The number that stands for a void where a file declares none.
const USUAL_VOID: f64 = -9999.0;

/// A file to be read.
#[derive(Clone, Copy)]
struct File<'a> {
    name: &'a str,
    bytes: &'a [u8],
    hints: &'a Hints,
}

/// Numbers as they stand in a file, and what they mean.
struct Numbers {
    columns: usize,
    rows: usize,
    spacing: [f64; 2],
    values: Vec<f32>,
    /// The number that stands for a void, if one is declared.
    void: Option<f64>,
    /// The file's own unit, if it says one.
    unit: Option<Unit>,
    notes: Vec<String>,
}

impl File<'_> {
    /// What a library finds wrong, in short: some quote whole tables.
    fn wrong(&self, place: Place, error: &dyn std::fmt::Display) -> SampleError {
        let text = error.to_string();
        let short: String = text.chars().take(MAX_QUOTED).collect();
        self.error(place, if short.len() < text.len() { short + " …" } else { short })
    }

    fn error(&self, place: Place, detail: impl Into<String>) -> SampleError {
        SampleError::new(self.name, place, detail)
    }

    /// Columns times rows, if they are not too many.
    fn cells(&self, place: Place, columns: usize, rows: usize) -> Result<usize, SampleError> {
        match columns.checked_mul(rows) {
            Some(0) => Err(self.error(place, format!("must have columns and rows, has {columns} × {rows}"))),
            Some(cells) if cells <= MAX_CELLS => Ok(cells),
            _ => Err(self.error(place, format!("{columns} × {rows} cells are more than {MAX_CELLS}: cut out a part"))),
        }
    }

    /// Refuses a file whose bytes cannot become so many, before memory is asked for.
    fn expands(&self, place: Place, bytes: usize, ratio: usize) -> Result<(), SampleError> {
        if bytes / ratio > self.bytes.len() {
            return Err(self.error(place, format!("{} bytes cannot hold {bytes} bytes of samples: the file is cut short or forged", self.bytes.len())));
        }
        Ok(())
    }

    /// The spacing that was asked for, or that of the file.
    fn spacing(&self, own: Option<[f64; 2]>) -> Result<[f64; 2], SampleError> {
        self.hints.spacing.or(own).ok_or_else(|| self.error(Place::File, "does not say how far its cells are apart: say `spacing`, two numbers in metres"))
    }

    /// Numbers to a checked sample.
    fn finish(&self, format: Format, numbers: Numbers) -> Result<Sample, SampleError> {
        let Numbers { columns, rows, spacing, mut values, void, unit, mut notes } = numbers;
        let unit = self.hints.unit.or(unit);
        if unit.is_none() && self.hints.range.is_none() {
            notes.push("no unit of heights is stated: metres are taken".to_owned());
        }
        let metres = unit.unwrap_or(Unit::Metres).metres();
        let declared = self.hints.void.or(void);
        let stands_for_void = declared.unwrap_or(USUAL_VOID) as f32;
        let mut voids = 0_usize;
        for value in &mut values {
            if *value == stands_for_void || value.is_nan() {
                *value = f32::NAN;
                voids += 1;
            } else {
                *value = self.in_range((f64::from(*value) * metres) as f32, *value);
            }
        }
        if declared.is_none() && voids > 0 {
            notes.push(format!("no number is declared to stand for voids: {USUAL_VOID} is taken, in {voids} cells"));
        }
        let grid = SampleGrid { columns, rows, spacing, heights: values };
        grid.check(self.name)?;
        Ok(Sample { format, grid, notes })
    }

    /// A height by the range of numbers that was asked for, if one was.
    fn in_range(&self, metres: f32, number: f32) -> f32 {
        match self.hints.range {
            Some([low, high]) => (low + f64::from(number) / 65_535.0 * (high - low)) as f32,
            None => metres,
        }
    }
}

/// Which format a file has, by what was asked for, its first bytes, or its name.
fn recognise(file: &File) -> Result<Format, SampleError> {
    if let Some(format) = file.hints.format {
        return Ok(format);
    }
    let starts = |magic: &[u8]| file.bytes.starts_with(magic);
    if starts(b"II*\0") || starts(b"MM\0*") || starts(b"II+\0") || starts(b"MM\0+") {
        return Ok(Format::Geotiff);
    }
    if starts(b"\x89PNG") {
        return Ok(Format::Png16);
    }
    let words = file.bytes.iter().position(|byte| !byte.is_ascii_whitespace()).map_or(&[][..], |start| &file.bytes[start..]);
    if words.get(..5).is_some_and(|word| [b"ncols", b"nrows"].iter().any(|key| word.eq_ignore_ascii_case(*key))) {
        return Ok(Format::AsciiGrid);
    }
    match file.name.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase().as_str() {
        "tif" | "tiff" => Ok(Format::Geotiff),
        "hgt" => Ok(Format::Hgt),
        "dem" => Ok(Format::UsgsDem),
        "asc" | "agr" => Ok(Format::AsciiGrid),
        "png" => Ok(Format::Png16),
        "raw" | "r16" | "r32" | "bin" => Ok(Format::Raw),
        _ => Err(file.error(Place::File, "no format is recognised: say `format`, one of geotiff, hgt, usgs-dem, ascii-grid, png16, raw")),
    }
}

/// Reads a file of elevations.
///
/// `name` is what the file is called: its ending can say the format, that of an HGT file its latitude, and errors begin with it.
///
/// # Errors
/// If the format is not recognised, something that it cannot say was not said, the file is cut short, too large or not what it claims to be, or its
/// elevations are absurd. Memory is asked for only when the file is long enough to hold what it claims.
pub fn read(name: &str, bytes: &[u8], hints: &Hints) -> Result<Sample, SampleError> {
    let file = File { name, bytes, hints };
    check_hints(&file)?;
    match recognise(&file)? {
        Format::Geotiff => geotiff::read(&file),
        Format::Hgt => hgt::read(&file),
        Format::UsgsDem => dem::read(&file),
        Format::AsciiGrid => ascii::read(&file),
        Format::Png16 => png16::read(&file),
        Format::Raw => raw::read(&file),
    }
}

/// Refuses what nobody can mean.
fn check_hints(file: &File) -> Result<(), SampleError> {
    let hints = file.hints;
    if let Some([low, high]) = hints.range
        && (hints.unit.is_some() || !low.is_finite() || !high.is_finite() || low >= high)
    {
        return Err(file.error(Place::File, "`range` must be two numbers of metres, the lower first, and stands in the place of `unit`"));
    }
    if hints.latitude.is_some_and(|latitude| !(-90.0..=90.0).contains(&latitude)) {
        return Err(file.error(Place::File, "`latitude` must be -90 … 90 degrees"));
    }
    Ok(())
}
