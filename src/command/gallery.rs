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
    paths::{Drawing, Heights, Light, PRESET_DRAWINGS, PRESET_SHADOWS, PathsDocument, Plan, ShadowDrawing, ShadowPlan, cast},
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
    /// Drawings by path costs, and pictures by shadows
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
        let (picture, figures) = match PathsDocument::parse(&json).with_context(|| name.clone())? {
            PathsDocument::Drawing(drawing) => drawn(&drawing).with_context(|| name.clone())?,
            PathsDocument::Shadow(drawing) => lit(&drawing).with_context(|| name.clone())?,
        };
        picture.save(arguments.output.join(format!("{name}.png")))?;
        fs::write(arguments.output.join(format!("{name}.json")), &json)?;
        writeln!(stdout(), "{name}: {figures}")?;
        pictures.push(picture);
    }
    if pictures.is_empty() {
        bail!("there is nothing to draw");
    }
    sheet(&pictures).save(arguments.output.join("sheet.png"))?;
    Ok(())
}

/// A drawing as a relief picture, and its figures.
fn drawn(drawing: &Drawing) -> anyhow::Result<(RgbImage, String)> {
    let plan = Plan::new(drawing)?;
    let heights = plan.heights(&Stop::never(), &|_| {});
    let settled = heights.settled;
    let [columns, rows] = drawing.size;
    let [x, y] = drawing.origin.map(|c| c - drawing.spacing / 2.0);
    let bbox = [x, y, x + columns as f64 * drawing.spacing, y + rows as f64 * drawing.spacing];
    let window = Window::area(bbox, drawing.spacing, Filter::Exact, 1 << 26)?;
    let picture = preview(&heights.raster(drawing), &window, -1.0)?;
    let strokes = plan.strokes();
    let figures = format!("{columns} × {rows} nodes, {strokes} strokes, {} nodes a stroke", settled.nodes / strokes.max(1) as u64);
    Ok((image::load_from_memory(&picture)?.to_rgb8(), figures))
}

/// A shadow picture under its light, and how to light it elsewhere.
fn lit(drawing: &ShadowDrawing) -> anyhow::Result<(RgbImage, String)> {
    let plan = ShadowPlan::new(drawing)?;
    let (light, heights) = (plan.light(), plan.heights(&Stop::never()));
    let (shaded, wanted) = (cast(&heights, drawing.spacing, &light), plan.wanted());
    let count = |of: fn((&bool, &bool)) -> bool| wanted.iter().zip(&shaded).filter(|(a, b)| of((*a, *b))).count() as f64;
    let overlap = count(|(a, b)| *a && *b) / count(|(a, b)| *a || *b);
    let [columns, rows] = drawing.size;
    let figures = format!(
        "{columns} × {rows} nodes, sun at azimuth {}°, altitude {}°: {:.1} % of the wanted and the cast shadow are the same",
        light.azimuth,
        light.altitude(),
        100.0 * overlap
    );
    Ok((sunlit(&heights, &shaded, drawing.spacing, &light), figures))
}

/// Heights in sunlight, grey-green to sand; shadows are dark and blue.
fn sunlit(heights: &Heights, shaded: &[bool], spacing: f64, light: &Light) -> RgbImage {
    const LOW: [f64; 3] = [128.0, 150.0, 104.0];
    const HIGH: [f64; 3] = [232.0, 212.0, 176.0];
    const SHADOW: [f64; 3] = [0.3, 0.34, 0.46];
    let (columns, rows) = (heights.columns, heights.rows);
    let at = |column: usize, row: usize| f64::from(heights.metres[row.min(rows - 1) * columns + column.min(columns - 1)]);
    let [low, high] =
        heights.metres.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], height| [low.min(*height), high.max(*height)]).map(f64::from);
    let [east, north] = light.direction();
    let altitude = light.altitude().to_radians();
    RgbImage::from_fn(columns as u32, rows as u32, |x, y| {
        let (x, y) = (x as usize, y as usize);
        let rise_east = (at(x + 1, y) - at(x.saturating_sub(1), y)) / (2.0 * spacing);
        let rise_north = (at(x, y.saturating_sub(1)) - at(x, y + 1)) / (2.0 * spacing);
        let facing =
            (altitude.sin() + (rise_east * east + rise_north * north) * altitude.cos()) / (1.0 + rise_east * rise_east + rise_north * rise_north).sqrt();
        // Level ground is as bright under a low sun as under a high one.
        let bright = if shaded[y * columns + x] { SHADOW } else { [(0.45 + 0.4 * facing / altitude.sin()).clamp(0.5_f64, 1.08); 3] };
        let share = ((at(x, y) - low) / (high - low).max(f64::MIN_POSITIVE)).sqrt();
        image::Rgb([0, 1, 2].map(|c| ((LOW[c] + (HIGH[c] - LOW[c]) * share) * bright[c]).clamp(0.0, 255.0) as u8))
    })
}

/// Name and document of every drawing.
fn drawings(files: &[PathBuf]) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    if files.is_empty() {
        return Ok(PRESET_DRAWINGS.iter().chain(&PRESET_SHADOWS).map(|preset| (preset.name.to_owned(), preset.json.as_bytes().to_vec())).collect());
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
