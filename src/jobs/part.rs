//! A shard of a pyramid as it grows on disk: tiles in their order, batch by batch, each batch with a checksum, so that any end of the program leaves what is whole.

use super::pyramid::{Plan, Shard};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::{
    fs::{File, OpenOptions, TryLockError},
    io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};

/// What files start with; the number goes up when the form changes.
const MAGIC: &str = "terrane part 1";

/// Bytes of a checksum: the first of SHA-256.
const CHECK_BYTES: usize = 8;

/// Most bytes of a tile, and most tiles of a batch; what says more is torn.
const MOST_TILE_BYTES: u32 = 1 << 26;
const MOST_BATCH: u32 = 1 << 16;

/// Why a part cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// It cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Another program writes it.
    #[error("{}: another export writes it", .0.display())]
    InUse(PathBuf),
    /// It is not a part.
    #[error("{}: this is no part of an export", .0.display())]
    Strange(PathBuf),
    /// It is of another pyramid.
    #[error("{}: this is a part of another export ({what} differ); delete it to start anew, or choose another output", path.display())]
    Other {
        /// The file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
    },
}

/// What the first line of a part says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    terrane: String,
    shard: Shard,
    plan: Plan,
}

impl Head {
    /// Whether this program can have written it.
    fn is_sound(&self) -> bool {
        self.terrane == MAGIC && Shard::new(self.shard.number, self.shard.of).is_ok() && self.plan.is_sound()
    }
}

/// A part of a pyramid on disk.
#[derive(Debug)]
pub struct Part {
    path: PathBuf,
    file: File,
    head: Head,
    /// Where the first batch begins.
    start: u64,
    /// Where the last whole batch ends.
    end: u64,
    done: u64,
}

impl Part {
    /// Opens the part of a shard to go on with it, or begins it. What the end of a program tore is cut off.
    ///
    /// # Errors
    /// If the file cannot be written, is in use, or is of something else.
    pub fn resume(path: &Path, plan: &Plan, shard: Shard) -> Result<Self, PartError> {
        let failed = |source| PartError::Io { path: path.to_owned(), source };
        let mut file = OpenOptions::new().create(true).truncate(false).read(true).write(true).open(path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(PartError::InUse(path.to_owned())),
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        let head = Head { terrane: MAGIC.to_owned(), shard, plan: plan.clone() };
        let line = format!("{}\n", serde_json::to_string(&head).map_err(io::Error::other).map_err(failed)?);
        let mut begun = vec![0; line.len()];
        let length = read_some(&mut file, &mut begun).map_err(failed)?;
        // A head that was torn when it was written, or none.
        if length < line.len() && line.as_bytes().starts_with(&begun[..length]) {
            file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(line.as_bytes())).map_err(failed)?;
        }
        let mut part = Self::read(path, file)?;
        if part.head.shard != shard || part.head.plan != *plan {
            return Err(PartError::Other { path: path.to_owned(), what: difference(&part.head, &head) });
        }
        part.file.set_len(part.end).and_then(|()| part.file.seek(SeekFrom::Start(part.end))).map_err(failed)?;
        part.done = part.done.min(part.tiles());
        Ok(part)
    }

    /// Opens a part that there is, for reading.
    ///
    /// # Errors
    /// If the file cannot be read or is no part.
    pub fn open(path: &Path) -> Result<Self, PartError> {
        let file = File::open(path).map_err(|source| PartError::Io { path: path.to_owned(), source })?;
        Self::read(path, file)
    }

    fn read(path: &Path, mut file: File) -> Result<Self, PartError> {
        let failed = |source| PartError::Io { path: path.to_owned(), source };
        file.rewind().map_err(failed)?;
        let mut reader = BufReader::with_capacity(1 << 20, &file);
        let mut line = Vec::new();
        reader.by_ref().take(1 << 20).read_until(b'\n', &mut line).map_err(failed)?;
        let head = serde_json::from_slice(&line).ok().filter(Head::is_sound).ok_or_else(|| PartError::Strange(path.to_owned()))?;
        let start = line.len() as u64;
        let (mut end, mut done) = (start, 0);
        while let Some(batch) = read_batch(&mut reader).map_err(failed)? {
            end += batch.length;
            done += batch.lengths.len() as u64;
        }
        drop(reader);
        Ok(Self { path: path.to_owned(), file, head, start, end, done })
    }

    /// How many tiles are done.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.done
    }

    /// How many tiles the shard has.
    #[must_use]
    pub fn tiles(&self) -> u64 {
        let range = self.shard().range(self.plan().tiles);
        range.end - range.start
    }

    /// Which shard it is.
    #[must_use]
    pub fn shard(&self) -> Shard {
        self.head.shard
    }

    /// What it is a part of.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.head.plan
    }

    /// Where it lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An error of reading or writing it.
    #[must_use]
    pub fn failed(&self, source: io::Error) -> PartError {
        PartError::Io { path: self.path.clone(), source }
    }

    /// Adds the next tiles. Once this returns they outlive the program.
    ///
    /// # Errors
    /// If writing fails; what was there before stays.
    pub fn append(&mut self, tiles: &[Vec<u8>]) -> Result<(), PartError> {
        let mut bytes = (tiles.len() as u32).to_le_bytes().to_vec();
        bytes.extend(tiles.iter().flat_map(|tile| (tile.len() as u32).to_le_bytes()));
        for tile in tiles {
            bytes.extend_from_slice(tile);
        }
        let check = Sha256::digest(&bytes);
        bytes.extend_from_slice(&check[..CHECK_BYTES]);
        self.file.write_all(&bytes).map_err(|source| self.failed(source))?;
        self.end += bytes.len() as u64;
        self.done += tiles.len() as u64;
        Ok(())
    }

    /// Hands all tiles over, in their order.
    ///
    /// # Errors
    /// If reading fails, or whoever takes them does.
    pub fn each<E: From<PartError>>(&self, mut take: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(self.start)).map_err(|source| self.failed(source))?;
        let mut reader = BufReader::with_capacity(1 << 20, file.take(self.end - self.start));
        while let Some(batch) = read_batch(&mut reader).map_err(|source| self.failed(source))? {
            let mut rest = &batch.bytes[..];
            for length in batch.lengths {
                let (tile, after) = rest.split_at(length as usize);
                take(tile)?;
                rest = after;
            }
        }
        Ok(())
    }
}

/// Tiles that were written together.
struct Batch {
    lengths: Vec<u32>,
    bytes: Vec<u8>,
    /// Of all of it in the file.
    length: u64,
}

/// The next batch, if it is whole.
fn read_batch(from: &mut impl Read) -> io::Result<Option<Batch>> {
    let mut all = vec![0; 4];
    let word = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    if read_some(from, &mut all)? < 4 || word(&all) > MOST_BATCH {
        return Ok(None);
    }
    let count = word(&all) as usize;
    let data = 4 + 4 * count;
    all.resize(data, 0);
    if read_some(from, &mut all[4..])? < 4 * count {
        return Ok(None);
    }
    let lengths: Vec<u32> = all[4..].chunks_exact(4).map(word).collect();
    let size: u64 = lengths.iter().map(|length| u64::from(*length)).sum();
    if lengths.iter().any(|length| *length > MOST_TILE_BYTES) {
        return Ok(None);
    }
    let mut check = [0; CHECK_BYTES];
    // Room is made for what there is, not for what a torn batch says.
    if (from.by_ref().take(size).read_to_end(&mut all)? as u64) < size
        || read_some(from, &mut check)? < CHECK_BYTES
        || Sha256::digest(&all)[..CHECK_BYTES] != check
    {
        return Ok(None);
    }
    let length = (all.len() + CHECK_BYTES) as u64;
    Ok(Some(Batch { lengths, bytes: all.split_off(data), length }))
}

/// Fills a buffer as far as there is something; answers how far.
fn read_some(from: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match from.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// What makes two parts ones of different exports.
fn difference(one: &Head, other: &Head) -> &'static str {
    let (a, b) = (&one.plan, &other.plan);
    if a.revision != b.revision {
        "the worlds"
    } else if a.drawn != b.drawn {
        "the tilesets or their options"
    } else if a.levels != b.levels || a.bounds != b.bounds {
        "the levels or the areas"
    } else if one.shard != other.shard {
        "the shards"
    } else {
        "the descriptions"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> Plan {
        let json = r#"{"revision":"a","drawn":"b","levels":[1,2],"blocks":[{"z":1,"columns":[0,0],"rows":[1,1]},{"z":2,"columns":[0,3],"rows":[1,2]}],"tiles":9,
            "extension":"png","title":"t","side":256,"bounds":[0,0,1,1]}"#;
        serde_json::from_str(json).expect("a plan")
    }

    fn tiles(part: &Part) -> Vec<Vec<u8>> {
        let mut all = Vec::new();
        part.each(|tile| {
            all.push(tile.to_vec());
            Ok::<_, PartError>(())
        })
        .expect("read");
        all
    }

    /// Every length that a file can have when a program ends while it writes.
    #[test]
    fn what_is_whole_outlives_a_torn_end() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.part");
        let written = [vec![vec![1; 5], vec![], vec![2; 300]], vec![vec![3; 70]], vec![vec![4; 9], vec![5; 9]]];
        let mut part = Part::resume(&path, &plan(), Shard::WHOLE).expect("begun");
        for batch in &written {
            part.append(batch).expect("written");
        }
        drop(part);
        let whole = std::fs::read(&path).expect("read");
        for length in 0..=whole.len() {
            std::fs::write(&path, &whole[..length]).expect("written");
            let mut part = Part::resume(&path, &plan(), Shard::WHOLE).expect("resumed");
            let done = part.done() as usize;
            assert!([0, 3, 4, 6].contains(&done), "{done} at {length}");
            let mut rest = written.iter().skip([0, 3, 4, 6].iter().position(|count| *count == done).expect("known"));
            rest.try_for_each(|batch| part.append(batch)).expect("written");
            drop(part);
            assert!(std::fs::read(&path).expect("read") == whole, "from {length} bytes on");
        }
        assert_eq!(tiles(&Part::open(&path).expect("opened")), written.concat());
    }

    #[test]
    fn parts_of_other_exports_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.part");
        let part = Part::resume(&path, &plan(), Shard::WHOLE).expect("begun");
        assert!(matches!(Part::resume(&path, &plan(), Shard::WHOLE), Err(PartError::InUse(_))));
        drop(part);
        let other = Plan { levels: [0, 2], ..plan() };
        assert!(matches!(Part::resume(&path, &other, Shard::WHOLE), Err(PartError::Other { what: "the levels or the areas", .. })));
        std::fs::write(&path, "something else").expect("written");
        assert!(matches!(Part::resume(&path, &plan(), Shard::WHOLE), Err(PartError::Strange(_))));
        assert_eq!(std::fs::read(&path).expect("read"), b"something else");
    }
}
