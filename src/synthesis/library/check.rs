//! What a library must say.

use super::{Library, LibraryError, LibraryProblem, LibrarySample, TerrainType};
use std::collections::BTreeSet;

/// Most types, and most samples of one.
const MOST: usize = 256;

/// Characters of titles at most; descriptions have ten times as many.
const TITLE: usize = 200;

/// Problems found so far.
struct Checks(Vec<LibraryProblem>);

impl Checks {
    fn add(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.0.push(LibraryProblem { pointer: pointer.into(), detail: detail.into() });
    }

    fn expect(&mut self, holds: bool, pointer: impl Into<String>, detail: impl FnOnce() -> String) {
        if !holds {
            self.add(pointer, detail());
        }
    }
}

/// Reads the structure.
pub(super) fn read(json: &[u8]) -> Result<Library, LibraryError> {
    let one = |pointer: String, detail: String| LibraryError(vec![LibraryProblem { pointer, detail }]);
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let library = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let steps = error.path().iter().filter_map(|segment| match segment {
            serde_path_to_error::Segment::Seq { index } => Some(index.to_string()),
            serde_path_to_error::Segment::Map { key } => Some(key.replace('~', "~0").replace('/', "~1")),
            _ => None,
        });
        let pointer: String = steps.map(|step| format!("/{step}")).collect();
        let text = error.inner().to_string();
        let detail = if error.inner().is_data() { text.rsplit_once(" at line ").map_or(text.as_str(), |(detail, _)| detail) } else { &text };
        // The field that is missing has its own place.
        let missing = detail.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')).map_or_else(String::new, |field| format!("/{field}"));
        one(pointer + &missing, near(detail))
    })?;
    deserializer.end().map_err(|error| one(String::new(), error.to_string()))?;
    Ok(library)
}

/// An unknown field with the one that was probably meant.
fn near(detail: &str) -> String {
    let mut names = detail.split('`').skip(1).step_by(2);
    let named = names.next().unwrap_or_default();
    let nearest = names.map(|name| (strsim::damerau_levenshtein(named, name), name)).min_by_key(|(distance, _)| *distance);
    match nearest.filter(|(distance, _)| detail.starts_with("unknown") && named.len() <= 64 && *distance <= (named.len() / 3).max(1)) {
        Some((_, name)) => format!("{detail} (did you mean `{name}`?)"),
        None => detail.to_owned(),
    }
}

/// Refuses a library that cannot be meant, with all that is wrong.
pub(super) fn check(library: &Library) -> Result<(), LibraryError> {
    let mut checks = Checks(Vec::new());
    for (pointer, text, most) in [("/title", &library.title, TITLE), ("/description", &library.description, 10 * TITLE)] {
        let count = text.as_ref().map_or(0, |text| text.chars().count());
        checks.expect(count <= most, pointer, || format!("must be at most {most} characters, has {count}"));
    }
    let count = library.types.len();
    checks.expect((1..=MOST).contains(&count), "/types", || format!("must be 1 … {MOST} types, are {count}"));
    let mut names = BTreeSet::new();
    for (i, kind) in library.types.iter().enumerate() {
        check_type(&mut checks, &format!("/types/{i}"), kind);
        checks.expect(names.insert(kind.name.as_str()), format!("/types/{i}/name"), || format!("two types are called {:?}", kind.name));
    }
    smoothness(&mut checks, "/smoothness", library.smoothness);
    let mut pairs = BTreeSet::new();
    for (i, seam) in library.seams.iter().enumerate() {
        let [one, other] = &seam.between;
        for (end, name) in [one, other].into_iter().enumerate() {
            let known = || library.types.iter().take(16).map(|kind| kind.name.as_str()).collect::<Vec<_>>().join(", ");
            checks.expect(names.contains(name.as_str()), format!("/seams/{i}/between/{end}"), || format!("no type is called {name:?}; there are {}", known()));
        }
        checks.expect(one != other, format!("/seams/{i}/between"), || "a seam lies between two different types".to_owned());
        checks
            .expect(pairs.insert((one.min(other), one.max(other))), format!("/seams/{i}/between"), || format!("a seam of {one} and {other} is there already"));
        smoothness(&mut checks, &format!("/seams/{i}/smoothness"), seam.smoothness);
    }
    if checks.0.is_empty() { Ok(()) } else { Err(LibraryError(checks.0)) }
}

fn smoothness(checks: &mut Checks, pointer: &str, smoothness: f64) {
    checks.expect((0.0..=1.0).contains(&smoothness), pointer, || format!("must be 0 … 1, is {smoothness}"));
}

fn check_type(checks: &mut Checks, at: &str, kind: &TerrainType) {
    let named = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit();
    let name = kind.name.as_bytes();
    let right = name.len() <= 63 && name.first().is_some_and(|first| named(*first)) && name.iter().all(|c| named(*c) || *c == b'-');
    checks.expect(right, format!("{at}/name"), || "must be 1 to 63 of a … z, 0 … 9 and -, and not begin with -".to_owned());
    let colour = kind.colour.strip_prefix('#').is_some_and(|digits| digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
    checks.expect(colour, format!("{at}/colour"), || "must be like #8a7f5c".to_owned());
    let count = kind.samples.len();
    checks.expect((1..=MOST).contains(&count), format!("{at}/samples"), || format!("must be 1 … {MOST} samples, are {count}"));
    for (i, sample) in kind.samples.iter().enumerate() {
        check_sample(checks, &format!("{at}/samples/{i}"), sample);
    }
}

fn check_sample(checks: &mut Checks, at: &str, sample: &LibrarySample) {
    checks.expect(sample.file.is_some() || sample.sha256.is_some(), at, || "must have `file` or `sha256`".to_owned());
    if let Some(file) = &sample.file {
        let inside = file.len() <= 1024 && !file.contains(['\\', '\0', ':']) && file.split('/').all(|part| !matches!(part, "" | "." | ".."));
        checks.expect(inside, format!("{at}/file"), || "must be a path of names joined by /, below the library".to_owned());
    }
    if let Some(hash) = &sample.sha256 {
        let right = hash.len() == 64 && hash.bytes().all(|digit| digit.is_ascii_digit() || (b'a'..=b'f').contains(&digit));
        checks.expect(right, format!("{at}/sha256"), || "must be 64 digits of 0 … 9 and a … f".to_owned());
    }
    let finite = |numbers: [f64; 2]| numbers.iter().all(|number| number.is_finite());
    if let Some(spacing) = sample.spacing {
        let [least, greatest] = super::super::grid::SPACINGS;
        let right = spacing.iter().all(|spacing| (least..=greatest).contains(spacing));
        checks.expect(right, format!("{at}/spacing"), || format!("must be two numbers of {least} … {greatest} metres"));
    }
    if let Some(range) = sample.range {
        checks.expect(finite(range) && range[0] < range[1], format!("{at}/range"), || "must be two numbers of metres, the lower first".to_owned());
        checks.expect(sample.unit.is_none(), format!("{at}/range"), || "stands in the place of `unit`: say one of them".to_owned());
    }
    if let Some(latitude) = sample.latitude {
        checks.expect((-90.0..=90.0).contains(&latitude), format!("{at}/latitude"), || format!("must be -90 … 90 degrees, is {latitude}"));
    }
    if let Some(crop) = sample.crop {
        checks.expect(crop.columns > 0 && crop.rows > 0, format!("{at}/crop"), || "must have columns and rows".to_owned());
    }
}
