//! Features one a line, read some thousand at a time on all threads.
//!
//! What is unusual in any way, a problem above all, is left to the one reader that reads everything in order, from the beginning of the batch it stands in: so
//! what is read and what is said of it are the same.

use super::read::{Reader, TopSeed};
use rayon::prelude::*;
use serde::de::{DeserializeSeed, IgnoredAny};
use std::io::{self, Read};

/// Bytes of a batch, about.
const BATCH: usize = 1 << 20;

/// Batches that are read at once.
const AT_ONCE: usize = 8;

/// What whole lines leave to be read in order.
pub(super) struct Rest {
    /// What was read of the source beyond the lines that were taken in.
    pub bytes: Vec<u8>,
    /// Whether that is all there is.
    pub ended: bool,
    /// How many lines were taken in.
    pub lines: usize,
}

/// Takes in the features of whole lines as long as nothing is unusual.
///
/// # Errors
/// If the source cannot be read.
pub(super) fn read(reader: &mut Reader, source: &mut impl Read) -> io::Result<Rest> {
    let (mut bytes, mut lines) = (Vec::new(), 0);
    loop {
        let ended = fill(source, &mut bytes)?;
        if lines == 0 && (is_one_line(&bytes, ended) || !begins_with_value(&bytes)) {
            return Ok(Rest { bytes, ended, lines });
        }
        let batches = cut(&bytes, ended);
        let read: Vec<Option<Reader>> = match batches[..] {
            [one] => vec![alone(one)],
            _ => batches.par_iter().map(|batch| alone(batch)).collect(),
        };
        let mut taken = 0;
        for (batch, read) in batches.iter().zip(read) {
            if !read.is_some_and(|read| reader.absorb(read)) {
                break;
            }
            taken += batch.len();
            lines += batch.split(|&byte| byte == b'\n').count() - 1;
        }
        let whole = taken == batches.iter().map(|batch| batch.len()).sum::<usize>();
        bytes.drain(..taken);
        if ended || !whole || taken == 0 {
            return Ok(Rest { bytes, ended, lines });
        }
    }
}

/// Reads until there is enough for all threads; `true` at the source's end.
fn fill(source: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<bool> {
    let more = (BATCH * AT_ONCE).saturating_sub(bytes.len());
    Ok(source.take(more as u64).read_to_end(bytes)? < more)
}

/// Whether there is but one line, which is not worth being read twice when something is wrong with it.
fn is_one_line(bytes: &[u8], ended: bool) -> bool {
    ended && !bytes.trim_ascii().contains(&b'\n')
}

/// Whether the first line that is not empty is one JSON object.
fn begins_with_value(bytes: &[u8]) -> bool {
    let first = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).find(|line| !line.is_empty());
    first.is_some_and(|line| line.starts_with(b"{") && serde_json::from_slice::<IgnoredAny>(line).is_ok())
}

/// Batches of whole lines; what follows the last line's end is left out unless the source has ended.
fn cut(bytes: &[u8], ended: bool) -> Vec<&[u8]> {
    let end = if ended { bytes.len() } else { bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1) };
    let (mut rest, mut batches) = (&bytes[..end], Vec::new());
    while !rest.is_empty() {
        let next = rest.iter().skip(BATCH).position(|&byte| byte == b'\n').map_or(rest.len(), |end| BATCH + end + 1);
        let (batch, after) = rest.split_at(next);
        batches.push(batch);
        rest = after;
    }
    batches
}

/// The features of a batch as if there were no others; `None` if a line is anything but one good value.
fn alone(batch: &[u8]) -> Option<Reader> {
    let mut reader = Reader::default();
    for line in batch.split(|&byte| byte == b'\n').filter(|line| !line.trim_ascii().is_empty()) {
        let mut deserializer = serde_json::Deserializer::from_slice(line);
        TopSeed(&mut reader).deserialize(&mut deserializer).ok()?;
        deserializer.end().ok()?;
        if reader.problems.count() > 0 {
            return None;
        }
    }
    Some(reader)
}

#[cfg(test)]
mod tests {
    use super::super::{Collection, ReadError};

    fn line(i: usize, rest: &str) -> String {
        format!(r#"{{"type":"Feature","id":{i},"geometry":{{"type":"Point","coordinates":[{i},1,2]}},"properties":{{"attributes":[]{rest}}}}}"#)
    }

    fn many(count: usize) -> Vec<String> {
        (0..count).map(|i| line(i, &format!(r#","name":"{}""#, "n".repeat(i % 300)))).collect()
    }

    /// Text in a `FeatureCollection`, which is read in order.
    fn in_order(lines: &[String]) -> Result<Collection, ReadError> {
        Collection::parse(&format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, lines.join(",")))
    }

    #[test]
    fn batches_give_what_one_reader_gives() {
        let lines = many(60_000);
        let text = lines.join("\n");
        assert!(text.len() > super::BATCH * super::AT_ONCE, "more than all threads take at once");
        let expected = in_order(&lines).expect("valid").features;
        for text in [text.clone(), format!("{text}\n"), format!("\n \n{}\n\n", lines.join("\r\n\n")), format!("\u{1e}{}\n", lines.join("\n\u{1e}"))] {
            assert_eq!(Collection::parse(&text).expect("valid").features, expected);
        }
        // A value over several lines in the midst of others.
        let broken = lines.iter().enumerate().map(|(i, line)| if i == 40_000 { line.replace(',', ",\n") } else { line.clone() });
        assert_eq!(Collection::parse(&broken.collect::<Vec<_>>().join("\n")).expect("valid").features, expected);
    }

    #[test]
    fn problems_are_told_with_their_place_in_the_whole() {
        let mut lines = many(60_000);
        lines[50_001] = line(50_001, r#","precedence":0.5"#);
        let problems: Vec<_> = Collection::parse(&lines.join("\n")).expect_err("wrong").into();
        assert_eq!(problems.len(), 1);
        assert_eq!(problems[0].pointer, "/50001/properties/precedence");
        assert!(problems[0].detail.starts_with("feature 50001: "), "{}", problems[0].detail);
        lines[50_001] = r#"{"type":"Feature","#.to_owned();
        let problems: Vec<_> = Collection::parse(&lines.join("\n")).expect_err("wrong").into();
        assert!(problems[0].detail.contains("line 50003 column 1") && problems[0].pointer == "/50001", "{:?}", problems[0]);
        lines[50_001] = line(7, "");
        let problems: Vec<_> = Collection::parse(&lines.join("\n")).expect_err("wrong").into();
        assert_eq!(problems[0].detail, "feature \"7\": feature number 7 has this id already");
    }
}
