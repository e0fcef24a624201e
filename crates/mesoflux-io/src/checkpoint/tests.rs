//! Checkpoint files that are damaged in every way, and the reserve.

use super::*;

fn read(files: &mut CheckpointFiles, directory: &OutputDirectory) -> Result<Option<Found<u64>>, CheckpointError> {
    let age = |state: &mut StateReader| state.next_value::<u64>();
    let decode = |state: &mut StateReader| match (state.next_value(), state.left()) {
        (Ok(step), 0) => Ok(step),
        _ => Err("has another length".to_owned()),
    };
    files.read(directory.path(), age, decode)
}

fn write(files: &mut CheckpointFiles, directory: &OutputDirectory, step: u64) {
    files.write(directory, |out| crate::stream::write(out, &step)).unwrap();
}

fn flip_a_bit(path: &Path) {
    let mut bytes = std::fs::read(path).unwrap();
    *bytes.last_mut().unwrap() ^= 4;
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn the_newest_whole_state_is_read_and_a_damaged_one_passed_over() {
    let parent = tempfile::tempdir().unwrap();
    let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
    let mut files = CheckpointFiles::new("run");
    assert!(read(&mut files, &directory).unwrap().is_none());
    for step in 1u64..=5 {
        write(&mut files, &directory, step);
    }
    let newest = read(&mut CheckpointFiles::new("run"), &directory).unwrap().unwrap();
    assert_eq!(newest.state, 5);
    // The fifth state went over the third, into the first file.
    flip_a_bit(&directory.path().join("run.a.checkpoint"));
    let mut files = CheckpointFiles::new("run");
    let reserve = read(&mut files, &directory).unwrap().unwrap();
    assert_eq!((reserve.state, reserve.damaged.len()), (4, 1));
    assert!(reserve.path.ends_with("run.b.checkpoint"));
    // What comes next replaces the damaged file, not the whole one.
    write(&mut files, &directory, 6);
    let both = read(&mut CheckpointFiles::new("run"), &directory).unwrap().unwrap();
    assert_eq!((both.state, both.damaged.len()), (6, 0));
}

#[test]
fn a_newer_state_that_can_t_be_understood_is_passed_over() {
    let parent = tempfile::tempdir().unwrap();
    let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
    let mut files = CheckpointFiles::new("run");
    write(&mut files, &directory, 1);
    files.write(&directory, |out| out.write_all(&[9; 20])).unwrap();
    let found = read(&mut files, &directory).unwrap().unwrap();
    assert_eq!((found.state, found.damaged.len()), (1, 1));
}

#[test]
fn where_no_file_is_whole_all_are_named() {
    let parent = tempfile::tempdir().unwrap();
    let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
    let mut files = CheckpointFiles::new("run");
    for step in 1u64..=2 {
        write(&mut files, &directory, step);
    }
    for name in ["run.a.checkpoint", "run.b.checkpoint"] {
        flip_a_bit(&directory.path().join(name));
    }
    let message = read(&mut files, &directory).unwrap_err().to_string();
    for part in ["state/run.a.checkpoint: has the checksum", "state/run.b.checkpoint: has the checksum", "delete"] {
        assert!(message.contains(part), "no {part:?} in {message}");
    }
}

#[test]
fn no_flipped_bit_and_no_truncation_is_accepted() {
    let parent = tempfile::tempdir().unwrap();
    let path = parent.path().join("state");
    let state: Vec<u8> = (0..200).collect();
    write_framed(&mut File::create(&path).unwrap(), |out| out.write_all(&state)).unwrap();
    let good = std::fs::read(&path).unwrap();
    assert_eq!(good[HEADER..], state);
    let accepted = |bytes: &[u8]| length_of_whole(bytes).unwrap().is_ok();
    assert!(accepted(&good));
    for length in 0..good.len() {
        assert!(!accepted(&good[..length]), "truncated to {length} bytes");
    }
    for bit in 0..8 * good.len() {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(!accepted(&bad), "bit {bit} flipped");
    }
    assert!(!accepted(&[good, vec![0]].concat()), "a byte too many");
}

#[test]
fn a_state_that_breaks_off_leaves_the_ones_before_it() {
    let parent = tempfile::tempdir().unwrap();
    let directory = OutputDirectory::explicit(&parent.path().join("state"), false).unwrap();
    let mut files = CheckpointFiles::new("run");
    for step in 1u64..=3 {
        write(&mut files, &directory, step);
    }
    let broken = files.write(&directory, |out| {
        out.write_all(&vec![1; 3 * BLOCK])?;
        Err(io::ErrorKind::StorageFull.into())
    });
    assert!(broken.unwrap_err().to_string().contains("state/run.b.checkpoint: "));
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 2, "nothing half is left");
    assert_eq!(read(&mut files, &directory).unwrap().unwrap().state, 3);
    std::fs::remove_file(directory.path().join("run.a.checkpoint")).unwrap();
    assert_eq!(read(&mut files, &directory).unwrap().unwrap().state, 2);
}
