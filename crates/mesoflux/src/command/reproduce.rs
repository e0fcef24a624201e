//! `mesoflux reproduce STUDY[/ITEM]`.

use super::session::{Failure, Options, RESULTS, STATES, Session, Workplace, planned, print, shell_word, work_in};
use crate::plan::Plan;
use crate::study::claim::Data;
use crate::study::collect::{self, Finished};
use crate::study::definition::{ItemInput, SeriesInput};
use crate::study::point::StudyPoint;
use crate::study::runs::FinishedRuns;
use crate::study::verdict::{Judged, replaced};
use crate::study::{Study, StudyError, drawing, library, report};
use clap::Args;
use mesoflux_io::directory::{DirectoryError, Lock, OutputDirectory};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// A study or one of its items, e.g. wu-shang or wu-shang/figure-3; or the directory of a study of your own
    #[arg(value_name = "STUDY[/ITEM]")]
    study: String,
    /// Shorter runs: minutes in place of days, with larger errors
    #[arg(long)]
    quick: bool,
    /// Directory for runs, data, figures and verdicts; one of the same study is gone on with [default: named after the study]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
}

/// The studies and their items, for the help.
pub(super) fn catalog() -> String {
    let mut text = String::new();
    for study in library::names().into_iter().filter_map(|name| library::published(name).ok().flatten()) {
        text += &format!("{}: {}\n", study.name, study.definition.title);
        let width = study.definition.item.names().iter().map(|name| name.len()).max().unwrap_or(0);
        for (name, item) in &study.definition.item {
            text += &format!("  {name:<width$}  {}\n", item.title);
        }
        text.push('\n');
    }
    text + "Runs are kept by a hash of their input: a second call goes on where the first stopped, and items share runs.\n\
            A study is a directory with study.toml, claims.toml and inputs/; the published ones are in studies/ of the source."
}

/// Inputs and what they do, by the inputs' names.
type Points = BTreeMap<String, (StudyPoint, Plan)>;

pub(super) fn reproduce(arguments: &Arguments) -> Result<(), Failure> {
    let (study, item) = library::find(&arguments.study)?;
    let items: Vec<&(String, ItemInput)> =
        study.definition.item.iter().filter(|(name, _)| item.as_ref().is_none_or(|item| item == name)).collect();
    // Every input must be right before the first one runs.
    let mut points = Points::new();
    for name in items.iter().flat_map(|(_, item)| item.inputs()) {
        let point = StudyPoint::new(&study, &name, arguments.quick)?;
        let plan = planned(&point.file, &arguments.options)?;
        points.insert(name, (point, plan));
    }
    items.iter().try_for_each(|(name, item)| check_estimates(name, item, &points))?;
    let place = Place::open(&study, arguments)?;
    let session = Session::begin(&arguments.options)?;
    let mut finished = Finished::new();
    let mut judged = place.verdicts()?;
    for (name, item) in items {
        for input in item.inputs() {
            if let Entry::Vacant(place_for) = finished.entry(input) {
                let (point, plan) = &points[place_for.key()];
                let runs = place.run(name, point, plan, &session, &arguments.options);
                place_for.insert(runs.map_err(|failure| failure.resumable(&place.command))?);
            }
        }
        let data = collect::series(item, &finished)?;
        let claims = study.claims.iter().map(|(_, claim)| claim).filter(|claim| claim.item == *name);
        let new = claims.map(|claim| claim.judge(claim.measured.measure(&data))).collect();
        judged = replaced(judged, name, new, &study.definition.item.names());
        place.write(&study, (name, item), &data, &judged).map_err(|failure| failure.resumable(&place.command))?;
    }
    if arguments.options.json {
        return print(&(serde_json::to_string_pretty(&judged)? + "\n"));
    }
    if arguments.options.quiet {
        return Ok(());
    }
    judged.retain(|entry| item.as_ref().is_none_or(|item| *item == entry.item));
    let notes =
        judged.iter().filter_map(|entry| Some(format!("{}, {}: {}\n", entry.item, entry.claim, entry.note.as_ref()?)));
    let mut notes: String = notes.collect();
    let warnings = report::alike(judged.iter().flat_map(|entry| &entry.warnings));
    if !warnings.is_empty() {
        notes += &format!("the runs warn of {} kinds of things: see README.md there\n", warnings.len());
    }
    let directory = place.directory.path().display();
    print(&format!(
        "{}\n\n{}{notes}\nfigures, data and verdicts in {directory}\n",
        study.definition.title,
        report::table(&judged)
    ))
}

/// An estimate that no input measures is better refused now than after the runs.
fn check_estimates(name: &str, item: &ItemInput, points: &Points) -> Result<(), Failure> {
    for (series, input) in &item.series {
        let SeriesInput::Estimates(wanted) = input else { continue };
        for (point, plan) in wanted.input.0.iter().filter_map(|input| points.get(input)) {
            let mut measured = plan.points.iter().flat_map(|point| &point.measurements);
            if !measured.any(|own| format!("{}/{}", own.name, own.route.method()) == wanted.of) {
                return Err(Failure::Refused(format!(
                    "item.{name}.series.{series}: of = \"{}\": the input {} measures no such thing: must be MEASUREMENT/METHOD",
                    wanted.of, point.name
                )));
            }
        }
    }
    Ok(())
}

/// The verdicts.
const VERDICTS: &str = "verdicts.json";
/// The page that shows them.
const PAGE: &str = "README.md";
/// Which study a directory is of.
const STUDY: &str = "study.json";
/// The directory of the runs.
const POINTS: &str = "points";

/// What `study.json` says.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Mark {
    study: String,
    quick: bool,
}

/// The directory of a study while this process works in it, and nobody else.
struct Place {
    directory: OutputDirectory,
    points: OutputDirectory,
    /// What to type to go on.
    command: String,
    _lock: Lock,
}

impl Place {
    fn open(study: &Study, arguments: &Arguments) -> Result<Self, Failure> {
        let mark = Mark { study: study.name.clone(), quick: arguments.quick };
        let wanted = arguments.out.clone().unwrap_or_else(|| {
            PathBuf::from(if mark.quick { format!("{}-quick", mark.study) } else { mark.study.clone() })
        });
        let written = wanted.join(STUDY);
        if written.exists() {
            let text = std::fs::read(&written).map_err(|source| unreadable(&written, source))?;
            let found: Mark = serde_json::from_slice(&text).map_err(|error| unreadable(&written, error.into()))?;
            if found != mark {
                let form = |mark: &Mark| format!("{}{}", mark.study, if mark.quick { " --quick" } else { "" });
                let place = wanted.display();
                return Err(Failure::Refused(format!(
                    "{place}: holds {}: must be new, empty, or hold {}; choose another with --out",
                    form(&found),
                    form(&mark)
                )));
            }
        } else if std::fs::read_dir(&wanted).is_ok_and(|mut entries| entries.next().is_some()) {
            return Err(Failure::Refused(format!(
                "{}: holds something that is no study of mesoflux: must be new, empty, or a study's directory; choose another with --out",
                wanted.display()
            )));
        }
        let directory = OutputDirectory::explicit(&wanted, true)?;
        directory.write(STUDY, (serde_json::to_string(&mark)? + "\n").as_bytes())?;
        let points = OutputDirectory::explicit(&wanted.join(POINTS), true)?;
        let lock = points.lock("lock").map_err(|error| match error {
            DirectoryError::InUse { holder, .. } => {
                DirectoryError::InUse { path: wanted.display().to_string(), holder }
            }
            other => other,
        })?;
        directory.remove_unfinished()?;
        let mut command = format!("mesoflux reproduce {}", shell_word(Path::new(&arguments.study)));
        if arguments.quick {
            command += " --quick";
        }
        if let Some(out) = &arguments.out {
            command += &format!(" --out {}", shell_word(out));
        }
        Ok(Self { directory, points, command, _lock: lock })
    }

    /// The finished runs of an input: those of before, or from the states that are there, or from the beginning.
    fn run(
        &self,
        item: &str,
        point: &StudyPoint,
        plan: &Plan,
        session: &Session,
        options: &Options,
    ) -> Result<FinishedRuns, Failure> {
        let path = self.points.path().join(&point.directory);
        let runs = plan.tasks().len();
        if is_complete(&path) {
            options.remark(&format!("{item}: {}: {runs} runs are there", point.name));
            return Ok(FinishedRuns::read(&point.file, &path)?);
        }
        if session.is_over() {
            return Err(Failure::Stopped(self.command.clone()));
        }
        let begun = path.join(STATES).exists();
        options.remark(&format!("{item}: {}: {runs} runs {}", point.name, if begun { "go on" } else { "begin" }));
        let workplace = Workplace::open(OutputDirectory::explicit(&path, true)?)?;
        workplace.write_input(&point.file)?;
        let done = work_in(&workplace, &point.file, plan, session)?;
        if !done.results.complete {
            return Err(Failure::Stopped(self.command.clone()));
        }
        Ok(FinishedRuns::read(&point.file, &path)?)
    }

    /// The verdicts that are there.
    fn verdicts(&self) -> Result<Vec<Judged>, Failure> {
        let path = self.directory.path().join(VERDICTS);
        if !path.exists() {
            return Ok(Vec::new());
        }
        let text = std::fs::read(&path).map_err(|source| unreadable(&path, source))?;
        Ok(serde_json::from_slice(&text).map_err(|error| unreadable(&path, error.into()))?)
    }

    /// Writes the data and the figure of an item, and all verdicts.
    fn write(
        &self,
        study: &Study,
        (item, input): (&str, &ItemInput),
        data: &Data,
        judged: &[Judged],
    ) -> Result<(), Failure> {
        let folder = OutputDirectory::explicit(&self.directory.path().join(item), true)?;
        for (name, series) in data {
            folder.write(&format!("{name}.csv"), series.csv().as_bytes())?;
        }
        if let Some(figure) = drawing::figure(input, data) {
            self.directory.write(&format!("{item}.svg"), figure.svg().as_bytes())?;
        }
        let drawn = study.definition.item.names().into_iter().map(str::to_owned);
        let drawn: Vec<String> =
            drawn.filter(|name| self.directory.path().join(format!("{name}.svg")).exists()).collect();
        self.directory.write(VERDICTS, (serde_json::to_string_pretty(judged)? + "\n").as_bytes())?;
        let page = report::page(study, judged, &self.command, &drawn);
        Ok(self.directory.write(PAGE, page.as_bytes())?)
    }
}

/// Whether all runs in a directory have come to their ends.
fn is_complete(directory: &Path) -> bool {
    let results = std::fs::read(directory.join(RESULTS)).ok();
    let results: Option<serde_json::Value> = results.and_then(|text| serde_json::from_slice(&text).ok());
    results.is_some_and(|results| results["complete"] == true)
}

fn unreadable(path: &Path, source: std::io::Error) -> StudyError {
    StudyError::Read { name: path.display().to_string(), source }
}
