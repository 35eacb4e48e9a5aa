//! `terrane gallery`.

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use image::{RgbImage, imageops};
use std::{
    fs,
    io::{Write, stdout},
    path::PathBuf,
};
use terrane::{
    geometry::{Filter, Stop, Window},
    paths::{Drawing, PRESET_DRAWINGS, Plan},
    tile::preview,
};

/// Pictures in a row of a contact sheet, pixels a side of one there, and between them.
const ROW: usize = 6;
const SIDE: u32 = 256;
const GAP: u32 = 6;

/// Behind the pictures.
const GROUND: [u8; 3] = [255; 3];

#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// Drawings by path costs
    Paths,
}

#[derive(Args)]
pub(crate) struct GalleryArguments {
    /// What is drawn
    #[arg(value_enum)]
    subject: Subject,
    /// The folder to write to: a picture a drawing, their documents, and all pictures on one sheet
    #[arg(short, long)]
    output: PathBuf,
    /// Drawings of your own in the place of those that ship
    files: Vec<PathBuf>,
}

/// Draws what ships with the program, or drawings of the user's own.
pub(crate) fn gallery(arguments: &GalleryArguments) -> anyhow::Result<()> {
    let Subject::Paths = arguments.subject;
    fs::create_dir_all(&arguments.output).with_context(|| format!("making {}", arguments.output.display()))?;
    let mut pictures = Vec::new();
    for (name, json) in drawings(&arguments.files)? {
        let drawing = Drawing::parse(&json).with_context(|| name.clone())?;
        let plan = Plan::new(&drawing).with_context(|| name.clone())?;
        let heights = plan.heights(&Stop::never(), &|_| {});
        let settled = heights.settled;
        let [columns, rows] = drawing.size.map(|n| n as f64);
        let [x, y] = drawing.origin.map(|c| c - drawing.spacing / 2.0);
        let bbox = [x, y, x + columns * drawing.spacing, y + rows * drawing.spacing];
        let window = Window::area(bbox, drawing.spacing, Filter::Exact, 1 << 26)?;
        let picture = preview(&heights.raster(&drawing), &window, -1.0)?;
        fs::write(arguments.output.join(format!("{name}.png")), &picture)?;
        fs::write(arguments.output.join(format!("{name}.json")), &json)?;
        let strokes = plan.strokes();
        writeln!(
            stdout(),
            "{name}: {} × {} nodes, {strokes} strokes, {} nodes a stroke",
            drawing.size[0],
            drawing.size[1],
            settled.nodes / strokes.max(1) as u64
        )?;
        pictures.push(image::load_from_memory(&picture)?.to_rgb8());
    }
    if pictures.is_empty() {
        bail!("there is nothing to draw");
    }
    sheet(&pictures).save(arguments.output.join("sheet.png"))?;
    Ok(())
}

/// Name and document of every drawing.
fn drawings(files: &[PathBuf]) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    if files.is_empty() {
        return Ok(PRESET_DRAWINGS.iter().map(|preset| (preset.name.to_owned(), preset.json.as_bytes().to_vec())).collect());
    }
    let read = |file: &PathBuf| {
        let name = file.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        Ok((name, fs::read(file).with_context(|| format!("reading {}", file.display()))?))
    };
    files.iter().map(read).collect()
}

/// All pictures side by side.
fn sheet(pictures: &[RgbImage]) -> RgbImage {
    let columns = pictures.len().min(ROW);
    let rows = pictures.len().div_ceil(ROW);
    let extent = |count: usize| count as u32 * (SIDE + GAP) + GAP;
    let mut sheet = RgbImage::from_pixel(extent(columns), extent(rows), image::Rgb(GROUND));
    for (i, picture) in pictures.iter().enumerate() {
        let small = imageops::resize(picture, SIDE, SIDE, imageops::FilterType::Triangle);
        let place = |n: usize| i64::from(GAP) + n as i64 * i64::from(SIDE + GAP);
        imageops::replace(&mut sheet, &small, place(i % ROW), place(i / ROW));
    }
    sheet
}
