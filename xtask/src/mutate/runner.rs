//! Tries mutations one after the other, after the tests have passed without any.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::copy::Copy;
use super::header::Mutation;
use super::report::Row;
use super::trial::{self, Bench, Outcome, Verdict};
use crate::failure::Failure;

/// What the trials need.
#[derive(Debug)]
pub struct Runner {
    /// The copy that is broken.
    pub copy: Copy,
    /// Cargo in that copy.
    pub bench: Bench,
    /// The directory of the patches.
    pub patches: PathBuf,
    /// The directory of the logs.
    pub logs: PathBuf,
}

impl Runner {
    /// Runs all the named tests without any mutation, then with each.
    pub fn run(&self, mutations: &[Mutation], fail_fast: bool) -> Result<Vec<Row>, Failure> {
        eprintln!("==> the tests without mutations");
        let objections = self.check_unmutated(mutations)?;
        let mut rows: Vec<Row> = Vec::new();
        for mutation in mutations {
            let stopped = fail_fast && rows.iter().any(|row| row.verdict != Verdict::Red);
            eprintln!("==> {}: {}", mutation.name, mutation.what);
            let verdicts = match objections.get(&mutation.name) {
                _ if stopped => same_for_all(mutation, Verdict::NotTried),
                Some(objections) => objections.clone(),
                None => self.try_mutation(mutation)?,
            };
            for (test, (verdict, time)) in mutation.tests.iter().zip(verdicts) {
                eprintln!("    {verdict}: {test}");
                rows.push(Row::new(mutation, test, verdict, time));
            }
        }
        self.copy.restore()?;
        Ok(rows)
    }

    /// The mutations that cannot be tried, with a verdict for each of their tests: those with a test that is not
    /// exactly one, or not green in the code as it is.
    fn check_unmutated(&self, mutations: &[Mutation]) -> Result<BTreeMap<String, Vec<(Verdict, Duration)>>, Failure> {
        let log = self.new_log("_unmutated")?;
        let (mut listed, mut judged) = (BTreeMap::new(), BTreeMap::new());
        let mut objections = BTreeMap::new();
        for mutation in mutations {
            let group = (&mutation.package, &mutation.target);
            let listed = match listed.entry(group) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(self.bench.list(mutation, &log)?),
            };
            let mut verdicts = Vec::new();
            for test in &mutation.tests {
                let begin = Instant::now();
                let verdict = match judged.entry((group, test, mutation.timeout)) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(new) => *new.insert(self.judge_unmutated(mutation, test, listed.as_deref(), &log)?),
                };
                verdicts.push((verdict, begin.elapsed()));
            }
            if verdicts.iter().any(|(verdict, _)| verdict.is_some()) {
                // The mutation is not tried with a part of its tests only.
                let fill = |(verdict, time): (Option<Verdict>, Duration)| (verdict.unwrap_or(Verdict::NotTried), time);
                objections.insert(mutation.name.clone(), verdicts.into_iter().map(fill).collect());
            }
        }
        Ok(objections)
    }

    /// What is wrong with one test in the code as it is; `None` where it exists once and is green.
    fn judge_unmutated(
        &self,
        mutation: &Mutation,
        test: &str,
        listed: Option<&[String]>,
        log: &Path,
    ) -> Result<Option<Verdict>, Failure> {
        let Some(listed) = listed else {
            return Ok(Some(Verdict::DoesNotCompileUnmutated));
        };
        match listed.iter().filter(|name| *name == test).count() {
            0 => return Ok(Some(Verdict::NoSuchTest)),
            1 => {}
            _ => return Ok(Some(Verdict::SeveralTests)),
        }
        Ok(match self.bench.run_test(mutation, test, log)? {
            Outcome::Green => None,
            Outcome::Red => Some(Verdict::RedUnmutated),
            Outcome::Hangs => Some(Verdict::HangsUnmutated),
            Outcome::Unknown => Some(Verdict::DidNotRun),
        })
    }

    /// Breaks the copy, builds it and runs the tests. The time of the first test includes the build.
    fn try_mutation(&self, mutation: &Mutation) -> Result<Vec<(Verdict, Duration)>, Failure> {
        let mut begin = Instant::now();
        let log = self.new_log(&mutation.name)?;
        self.copy.restore()?;
        let patch = self.patches.join(format!("{}.patch", mutation.name));
        let (ending, _) = trial::run(&mut self.copy.patch_command(&patch), &log, None)?;
        if !ending.success() || !self.copy.differs()? {
            return Ok(same_for_all(mutation, Verdict::DoesNotApply));
        }
        if !self.bench.builds(mutation, &log)? {
            return Ok(same_for_all(mutation, Verdict::DoesNotCompile));
        }
        let mut verdicts = Vec::new();
        for test in &mutation.tests {
            let verdict = match self.bench.run_test(mutation, test, &log)? {
                Outcome::Red => Verdict::Red,
                Outcome::Green => Verdict::StillGreen,
                Outcome::Hangs => Verdict::Hangs,
                Outcome::Unknown => Verdict::DidNotRun,
            };
            verdicts.push((verdict, begin.elapsed()));
            begin = Instant::now();
        }
        Ok(verdicts)
    }

    /// An empty log of that name.
    fn new_log(&self, name: &str) -> Result<PathBuf, Failure> {
        let path = self.logs.join(format!("{name}.txt"));
        File::create(&path).map_err(|error| Failure::file(&path, &error))?;
        Ok(path)
    }
}

/// The same verdict for all tests of a mutation that ran none of them.
fn same_for_all(mutation: &Mutation, verdict: Verdict) -> Vec<(Verdict, Duration)> {
    vec![(verdict, Duration::ZERO); mutation.tests.len()]
}
