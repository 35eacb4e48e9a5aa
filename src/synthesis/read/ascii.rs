//! ESRI ASCII grids: lines of a key and a number, then numbers from north to south.

use super::{File, Format, Numbers, Place, Sample, SampleError, USUAL_VOID, degrees};

/// What stands before the numbers.
#[derive(Default)]
struct Head {
    columns: Option<f64>,
    rows: Option<f64>,
    /// West, and whether that is of the middle of a cell.
    west: Option<(f64, bool)>,
    /// South, likewise.
    south: Option<(f64, bool)>,
    size: [Option<f64>; 2],
    void: Option<f64>,
}

/// Lines of a file with their numbers from 0.
type Lines<'a> = std::iter::Enumerate<std::slice::Split<'a, u8, fn(&u8) -> bool>>;

/// Words of a file with their lines.
struct Words<'a> {
    lines: Lines<'a>,
    rest: &'a [u8],
    /// Of the last word that was taken, from 1.
    line: usize,
}

impl<'a> Words<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let newline: fn(&u8) -> bool = |byte| *byte == b'\n';
        Self { lines: bytes.split(newline).enumerate(), rest: &[], line: 0 }
    }

    /// The next word.
    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            self.rest = self.rest.trim_ascii_start();
            if !self.rest.is_empty() {
                let end = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
                let (word, rest) = self.rest.split_at(end);
                self.rest = rest;
                return Some(word);
            }
            let (line, text) = self.lines.next()?;
            self.rest = text.trim_ascii_start();
            if !self.rest.is_empty() {
                self.line = line + 1;
            }
        }
    }
}

/// A word as a number.
fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok().filter(|number: &f64| !number.is_infinite())
}

/// A word that may be quoted in an error.
fn quoted(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(word).chars().take(24).collect();
    format!("{text:?}")
}

/// Reads keys up to the first word that is a number; that word is given, too.
fn head<'a>(file: &File, words: &mut Words<'a>) -> Result<(Head, Option<&'a [u8]>), SampleError> {
    let mut head = Head::default();
    loop {
        let Some(key) = words.next() else { return Ok((head, None)) };
        if key.first().is_none_or(|first| !first.is_ascii_alphabetic()) || number(key).is_some() {
            return Ok((head, Some(key)));
        }
        let at = Place::Line(words.line);
        let value = words.next().and_then(number).filter(|value| value.is_finite());
        let value = value.ok_or_else(|| file.error(at, format!("{} must be followed by a number", quoted(key))))?;
        match key.to_ascii_lowercase().as_slice() {
            b"ncols" => head.columns = Some(value),
            b"nrows" => head.rows = Some(value),
            b"xllcorner" => head.west = Some((value, false)),
            b"xllcenter" => head.west = Some((value, true)),
            b"yllcorner" => head.south = Some((value, false)),
            b"yllcenter" => head.south = Some((value, true)),
            b"cellsize" => head.size = [Some(value); 2],
            b"dx" => head.size[0] = Some(value),
            b"dy" => head.size[1] = Some(value),
            b"nodata_value" => head.void = Some(value),
            _ => {
                let known = "ncols, nrows, xllcorner or xllcenter, yllcorner or yllcenter, cellsize, nodata_value";
                return Err(file.error(at, format!("{} is no key of such a grid: they are {known}", quoted(key))));
            }
        }
    }
}

/// A count of columns or rows.
fn count(file: &File, line: usize, key: &str, value: Option<f64>) -> Result<usize, SampleError> {
    let value = value.ok_or_else(|| file.error(Place::Line(line), format!("{key} is missing before the numbers")))?;
    if value.fract() != 0.0 || !(1.0..=1e9).contains(&value) {
        return Err(file.error(Place::Line(line), format!("{key} must be a whole number above 0, is {value}")));
    }
    Ok(value as usize)
}

/// Spacings in metres: the format does not say its unit. Cells below a tenth at coordinates that are longitude and latitude are degrees.
fn spacing(file: &File, head: &Head, rows: usize, line: usize, notes: &mut Vec<String>) -> Result<Option<[f64; 2]>, SampleError> {
    if file.hints.spacing.is_some() {
        return Ok(None);
    }
    let [Some(x), Some(y)] = head.size else { return Err(file.error(Place::Line(line), "cellsize is missing before the numbers")) };
    let ((west, _), (south, middle)) = (head.west.unwrap_or_default(), head.south.unwrap_or_default());
    let latitude = south + y * (rows as f64 - f64::from(u8::from(middle))) / 2.0;
    let on_earth = (-180.0..=360.0).contains(&west) && (-90.0..=90.0).contains(&south) && (-90.0..=90.0).contains(&latitude);
    if x.max(y) < 0.1 && on_earth {
        let (metres, note) = degrees::spacing(file, [x, y], latitude)?;
        notes.push(note);
        return Ok(Some(metres));
    }
    Ok(Some([x, y]))
}

pub(super) fn read(file: &File) -> Result<Sample, SampleError> {
    let mut words = Words::new(file.bytes);
    let (head, mut first) = head(file, &mut words)?;
    let line = words.line;
    let (columns, rows) = (count(file, line, "ncols", head.columns)?, count(file, line, "nrows", head.rows)?);
    let cells = file.cells(Place::Line(line), columns, rows)?;
    // A digit and what parts it from the next.
    file.expands(Place::Line(line), cells.saturating_mul(2) - 1, 1)?;
    let mut notes = Vec::new();
    let own = spacing(file, &head, rows, line, &mut notes)?;
    let mut values = Vec::with_capacity(cells);
    while let Some(word) = first.take().or_else(|| words.next()) {
        let at = Place::Line(words.line);
        if values.len() == cells {
            return Err(file.error(at, format!("{} stands after {columns} × {rows} numbers", quoted(word))));
        }
        let value = number(word).ok_or_else(|| file.error(at, format!("must be a number, is {}", quoted(word))))?;
        values.push(value as f32);
    }
    if values.len() < cells {
        let at = Place::Line(words.line);
        return Err(file.error(at, format!("{columns} × {rows} numbers are {cells}, the file ends after {}", values.len())));
    }
    let void = head.void.or(Some(USUAL_VOID));
    file.finish(Format::AsciiGrid, Numbers { columns, rows, spacing: file.spacing(own)?, values, void, unit: None, notes })
}
