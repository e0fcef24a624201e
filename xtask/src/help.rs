//! The help text, and the nearest names when one is mistyped.

/// What `cargo xtask help` prints.
pub const TEXT: &str = "\
The tasks of the mesoflux workspace.

Usage: cargo xtask TASK [OPTIONS]

  test                 everything that must hold: formatting, lints, documentation, tests
      --quick          formatting, lints and unit tests only
      --seeds N        the physics tests with seeds 1 to N: their z-scores must look normal (long)

  mutate [NAME...]     breaks the code on purpose, in a copy, and insists that the tests notice
      --list           what each mutation breaks, and which tests must turn red
      --keep-going     go on after a mutation that no test noticed (the default)
      --fail-fast      stop there instead

  bench                speed beside LAMMPS on the same work, of kernels, of sizes; writes benches/
      --work NAME...   against LAMMPS: groot-warren, ideal-16, ideal-32, lj-dpd
      --ours           ABOBA and velocity Verlet, Norton and NEMD, one thread and two
      --kernels        time a pair of each kernel, and what a step is made of
      --scale          from 10^3 to 10^7 particles
      --rounds N       how often everything is timed in turn (5; fewer are shown, not written)
      --seconds S      how long one timing takes (4)
      --lammps PATH    its executable, or none; else MESOFLUX_LAMMPS, else `lmp` on the path

  help                 this page

Mutations are the files tests/mutations/NAME.patch; tests/mutations/README.md says how to add one.
Exit codes: 0 all is well; 2 the command line or a mutation file is wrong; 4 a file could not be
read or written; otherwise the code of the step that failed.
";

/// The names of the tasks.
pub const TASKS: [&str; 4] = ["test", "mutate", "bench", "help"];

/// The message for a name that does not exist, with the names that come nearest to it.
pub fn unknown(kind: &str, given: &str, known: &[&str]) -> String {
    let near = nearest(given, known);
    if near.is_empty() {
        format!("no {kind} `{given}`; there are: {}", known.join(", "))
    } else {
        format!("no {kind} `{given}`; did you mean {}?", near.join(" or "))
    }
}

/// The known names within about a third of the given name's length, or that begin with it, nearest first.
fn nearest<'a>(given: &str, known: &[&'a str]) -> Vec<&'a str> {
    let limit = given.chars().count() / 3 + 1;
    let mut near: Vec<(usize, &str)> = known
        .iter()
        .map(|name| if name.starts_with(given) { (0, *name) } else { (edit_distance(given, name), *name) })
        .filter(|(distance, _)| *distance <= limit)
        .collect();
    near.sort_unstable();
    near.into_iter().map(|(_, name)| name).take(3).collect()
}

/// How many single-character insertions, deletions and replacements lead from one name to the other.
fn edit_distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut previous: Vec<usize> = (0..=to.len()).collect();
    for (row, character) in from.chars().enumerate() {
        let mut current = vec![row + 1];
        for (column, other) in to.iter().enumerate() {
            let replaced = previous[column] + usize::from(character != *other);
            current.push(replaced.min(previous[column + 1] + 1).min(current[column] + 1));
        }
        previous = current;
    }
    previous[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_textbook() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("abc", "c"), 2);
        assert_eq!(edit_distance("same", "same"), 0);
    }

    #[test]
    fn a_mistyped_task_is_answered_with_the_nearest() {
        assert_eq!(unknown("task", "mutte", &TASKS), "no task `mutte`; did you mean mutate?");
        assert_eq!(unknown("task", "mut", &TASKS), "no task `mut`; did you mean mutate?");
        assert_eq!(unknown("task", "paint", &TASKS), "no task `paint`; there are: test, mutate, bench, help");
    }

    #[test]
    fn the_help_names_every_task_in_short_lines() {
        assert!(TASKS.iter().all(|task| TEXT.contains(&format!("\n  {task} "))));
        assert!(TEXT.lines().all(|line| line.len() <= 100));
    }
}
