//! `cargo xtask mutate`: breaks the code on purpose, one mutation at a time, and insists that the tests notice.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::help;
use crate::workspace::Workspace;

mod copy;
mod header;
mod report;
mod runner;
mod trial;

use copy::Copy;
use header::Mutation;
use runner::Runner;
use trial::Bench;

/// Where the mutations are, below the root.
const MUTATIONS: &str = "tests/mutations";

/// What the command line asks for.
#[derive(Debug, Default)]
struct Options {
    names: Vec<String>,
    list: bool,
    fail_fast: bool,
}

impl Options {
    fn parse(arguments: &[String]) -> Result<Self, Failure> {
        let mut options = Self::default();
        for argument in arguments {
            match argument.as_str() {
                "--list" => options.list = true,
                "--keep-going" => options.fail_fast = false,
                "--fail-fast" => options.fail_fast = true,
                unknown if unknown.starts_with('-') => {
                    let known = ["--list", "--keep-going", "--fail-fast"];
                    return Err(Failure::usage(help::unknown("option of `mutate`", unknown, &known)));
                }
                // A path, as a shell completes it, names its file.
                name => {
                    let file = name.rsplit('/').next().unwrap_or(name);
                    options.names.push(file.trim_end_matches(".patch").to_string());
                }
            }
        }
        Ok(options)
    }
}

/// Tries the mutations that are asked for, or lists them.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Result<(), Failure> {
    let options = Options::parse(arguments)?;
    let directory = workspace.root.join(MUTATIONS);
    let mutations = select(read_all(&directory)?, &options.names)?;
    if mutations.is_empty() {
        println!("There are no mutations in {MUTATIONS}.");
        return Ok(());
    }
    if options.list {
        print!("{}", report::list(&mutations));
        return Ok(());
    }
    let place = workspace.target.join("mutate");
    let logs = place.join("log");
    fs::create_dir_all(&logs).map_err(|error| Failure::file(&logs, &error))?;
    let _lock = lock(&place)?;
    let rows = Runner {
        copy: Copy::create(&workspace.root, &place.join("tree"))?,
        bench: Bench {
            cargo: PathBuf::from(workspace.cargo().get_program()),
            tree: place.join("tree"),
            target: place.join("target"),
        },
        patches: directory,
        logs,
    }
    .run(&mutations, options.fail_fast)?;
    let table = report::table(&rows);
    let file = place.join("table.md");
    fs::write(&file, &table).map_err(|error| Failure::file(&file, &error))?;
    print!("{table}");
    report::conclude(&rows, &workspace.shorten(&place))
}

/// All mutations, in an order that rebuilds least: by package, then by target. Every wrong header is named at once.
fn read_all(directory: &Path) -> Result<Vec<Mutation>, Failure> {
    let (mut mutations, mut errors) = (Vec::new(), Vec::new());
    let entries = fs::read_dir(directory).map_err(|error| Failure::file(directory, &error))?;
    for entry in entries {
        let path = entry.map_err(|error| Failure::file(directory, &error))?.path();
        if path.extension().is_some_and(|ending| ending == "patch") {
            match Mutation::read(&path) {
                Ok(mutation) => mutations.push(mutation),
                Err(error) => errors.push(error),
            }
        }
    }
    if !errors.is_empty() {
        errors.sort();
        return Err(Failure::usage(errors.join("\nxtask: ")));
    }
    mutations.sort_by_key(|mutation| (mutation.package.clone(), mutation.target.clone(), mutation.name.clone()));
    Ok(mutations)
}

/// The mutations of these names; all where there are no names.
fn select(mutations: Vec<Mutation>, names: &[String]) -> Result<Vec<Mutation>, Failure> {
    let known: Vec<&str> = mutations.iter().map(|mutation| mutation.name.as_str()).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Failure::usage(help::unknown("mutation", unknown, &known)));
    }
    let wanted = |mutation: &Mutation| names.is_empty() || names.contains(&mutation.name);
    Ok(mutations.into_iter().filter(wanted).collect())
}

/// Keeps the copy to one run at a time, as long as the returned file is open.
fn lock(place: &Path) -> Result<File, Failure> {
    let path = place.join("lock");
    let file = File::create(&path).map_err(|error| Failure::file(&path, &error))?;
    file.try_lock().map_err(|_| Failure::task("another `cargo xtask mutate` is running in this target directory"))?;
    Ok(file)
}
