//! Directories that are taken, locked, or can't be written to.

use super::*;

#[test]
fn an_explicit_directory_that_exists_is_refused_unless_forced() {
    let parent = tempfile::tempdir().unwrap();
    let wanted = parent.path().join("out");
    let first = OutputDirectory::explicit(&wanted, false).unwrap();
    first.write("results.json", b"{}").unwrap();
    assert!(matches!(OutputDirectory::explicit(&wanted, false), Err(DirectoryError::Exists(_))));
    let forced = OutputDirectory::explicit(&wanted, true).unwrap();
    forced.write("results.json", b"[]").unwrap();
    assert_eq!(std::fs::read(wanted.join("results.json")).unwrap(), b"[]");
    assert_eq!(std::fs::read_dir(&wanted).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn a_lock_keeps_others_out_and_names_its_holder() {
    let parent = tempfile::tempdir().unwrap();
    let directory = OutputDirectory::explicit(&parent.path().join("out"), false).unwrap();
    let lock = directory.lock("lock").unwrap();
    assert!(lock.warning.is_none());
    let refused = directory.lock("lock").unwrap_err().to_string();
    let holder = format!("process {}", std::process::id());
    assert!(refused.contains("out: is in use by") && refused.contains(&holder), "{refused}");
    drop(lock);
    assert!(directory.lock("lock").is_ok());
}

#[test]
fn what_was_cut_short_is_removed_and_nothing_else() {
    let parent = tempfile::tempdir().unwrap();
    let directory = OutputDirectory::explicit(&parent.path().join("out"), false).unwrap();
    directory.write("whole", b"1").unwrap();
    std::fs::write(directory.path().join(format!("{UNFINISHED}whole")), b"").unwrap();
    directory.remove_unfinished().unwrap();
    let left: Vec<_> = std::fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["whole"]);
}

#[test]
fn a_file_that_can_t_be_written_leaves_the_old_one_and_nothing_half() {
    let parent = tempfile::tempdir().unwrap();
    let directory = OutputDirectory::explicit(&parent.path().join("out"), false).unwrap();
    // A folder in the way can't be replaced by a file.
    std::fs::create_dir(directory.path().join("taken")).unwrap();
    assert!(directory.write("taken", b"1").unwrap_err().to_string().contains("out/taken"));
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
}
