//! What must hold for any file that is taken as a part of an export. The tests of the package run it over the corpus.

use std::{fs, path::Path};
use terrane::jobs::{Archive, Part, PartError, merge};

pub(crate) fn check(data: &[u8]) {
    let folder = tempfile::tempdir_in(if Path::new("/dev/shm").is_dir() { Path::new("/dev/shm") } else { Path::new(".") }).expect("a folder");
    let (path, archive) = (folder.path().join("part"), folder.path().join("a.pmtiles"));
    fs::write(&path, data).expect("room for a file");
    let part = match Part::open(&path) {
        Ok(part) => part,
        Err(PartError::Strange(_)) => return,
        Err(error) => panic!("{error}"),
    };
    let mut tiles = 0;
    part.each(|tile| {
        assert!(tile.len() < data.len());
        tiles += 1;
        Ok::<(), PartError>(())
    })
    .expect("what was found whole can be read");
    assert_eq!(tiles, part.done());
    let is_whole = part.done() == part.tiles() && part.shard().of == 1;
    let merged = merge(vec![part], Archive::PmTiles, &archive, &mut |_| {});
    assert!(merged.is_ok() == is_whole, "{merged:?}");
}
