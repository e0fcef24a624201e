//! Sums kept apart by stretches of time, in bounded number: their scatter gives errors of correlated series.

use serde::{Deserialize, Serialize};

/// Most segments of the run being recorded, and of all replicas merged into it.
const SEGMENTS: usize = 64;

/// What is summed over a stretch of time.
pub(crate) trait Sums: Clone {
    /// Takes up what was summed over another stretch.
    fn add(&mut self, other: &Self);
}

/// One stretch of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Segment<S> {
    /// Which run it is part of: only segments of one run are neighbors in time.
    run: u64,
    /// Samples recorded.
    pub(crate) samples: u64,
    pub(crate) sums: S,
}

/// The segments of a run and of the replicas merged into it. When there are 64, neighbors are joined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Segments<S> {
    /// Of the run being recorded; the last one is open.
    own: Vec<Segment<S>>,
    /// Samples in each of these but the last.
    length: u64,
    merged: Vec<Segment<S>>,
    /// Runs merged so far.
    runs: u64,
}

/// The lengths of segments in order of time, and how they join into longer stretches.
pub(crate) struct Stretches {
    /// Samples and run of each segment.
    segments: Vec<(u64, u64)>,
    pub(crate) samples: u64,
}

/// Consecutive segments: the index after the last one, and the samples.
pub(crate) type Group = (usize, u64);

impl<S: Sums> Segments<S> {
    pub(crate) fn new() -> Self {
        Self { own: Vec::new(), length: 1, merged: Vec::new(), runs: 0 }
    }

    /// The segment that takes the next sample, already counted; a new one has the sums `empty`.
    pub(crate) fn open(&mut self, empty: impl FnOnce() -> S) -> &mut S {
        if self.own.last().is_none_or(|last| last.samples >= self.length) {
            if self.own.len() >= SEGMENTS {
                bound(&mut self.own, SEGMENTS / 2);
                self.length *= 2;
            }
            self.own.push(Segment { run: 0, samples: 0, sums: empty() });
        }
        let last = self.own.len() - 1;
        let open = &mut self.own[last];
        open.samples += 1;
        &mut open.sums
    }

    /// Adds the segments of another recording, each after `convert`.
    pub(crate) fn merge(&mut self, other: &Self, convert: impl Fn(&mut Segment<S>)) {
        for segment in other.iter() {
            let mut segment = segment.clone();
            convert(&mut segment);
            // Run 0 is the one being recorded; the other's merged runs are numbered from 1.
            segment.run += self.runs + 1;
            self.merged.push(segment);
        }
        self.runs += other.runs + 1;
        bound(&mut self.merged, SEGMENTS);
    }

    /// All segments; those of one run stand together in order of time.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Segment<S>> {
        self.merged.iter().chain(&self.own)
    }

    /// Samples recorded, over all replicas.
    pub(crate) fn count(&self) -> u64 {
        self.iter().map(|segment| segment.samples).sum()
    }

    /// For states from files: whether numbers can be right and `fits` holds for all sums.
    pub(crate) fn are_consistent(&self, fits: impl Fn(&S) -> bool) -> bool {
        // So many samples as still are whole numbers; nobody records more.
        let plausible = |segment: &Segment<S>| segment.samples < 1 << f64::MANTISSA_DIGITS && fits(&segment.sums);
        self.own.len() <= SEGMENTS && self.merged.len() <= SEGMENTS && self.length > 0 && self.iter().all(plausible)
    }

    pub(crate) fn stretches(&self) -> Stretches {
        let segments = self.iter().map(|segment| (segment.samples, segment.run)).collect();
        Stretches { segments, samples: self.count() }
    }
}

/// Joins neighbors, the shortest first and those of one run before others, until at most `limit` segments are left.
fn bound<S: Sums>(segments: &mut Vec<Segment<S>>, limit: usize) {
    while segments.len() > limit {
        let cost = |index: &usize| {
            let (left, right) = (&segments[*index], &segments[index + 1]);
            (left.run != right.run, left.samples + right.samples)
        };
        let Some(index) = (0..segments.len() - 1).min_by_key(cost) else { return };
        let right = segments.remove(index + 1);
        segments[index].samples += right.samples;
        segments[index].sums.add(&right.sums);
    }
}

impl Stretches {
    /// Number of segments.
    pub(crate) fn len(&self) -> usize {
        self.segments.len()
    }

    /// Consecutive segments of one run joined until they have `length` samples.
    ///
    /// What is left at the end of a run joins the stretch before; a run that is shorter than `length` is a stretch.
    pub(crate) fn of_length(&self, length: u64) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        let mut start = 0;
        for run in self.segments.chunk_by(|left, right| left.1 == right.1) {
            let mut open = 0;
            for (index, (samples, _)) in run.iter().enumerate() {
                open += samples;
                if open >= length {
                    groups.push((start + index + 1, open));
                    open = 0;
                }
            }
            let end = start + run.len();
            match groups.last_mut() {
                _ if open == 0 => {}
                Some(last) if last.0 > start => *last = (end, last.1 + open),
                _ => groups.push((end, open)),
            }
            start = end;
        }
        groups
    }

    /// (Σn)²/Σn² for stretches of n samples: their number if they are equal.
    pub(crate) fn number(&self, groups: &[Group]) -> f64 {
        let squares: f64 = groups.iter().map(|&(_, samples)| (samples as f64).powi(2)).sum();
        if squares == 0.0 { 0.0 } else { (self.samples as f64).powi(2) / squares }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Sums for u64 {
        fn add(&mut self, other: &Self) {
            *self += other;
        }
    }

    fn recorded(samples: u64) -> Segments<u64> {
        let mut segments = Segments::new();
        (0..samples).for_each(|value| *segments.open(|| 0) += value);
        segments
    }

    #[test]
    fn nothing_is_lost_and_segments_stay_equal() {
        let segments = recorded(1000);
        assert_eq!((segments.count(), segments.iter().map(|s| s.sums).sum::<u64>()), (1000, 499_500));
        let lengths: Vec<u64> = segments.iter().map(|segment| segment.samples).collect();
        assert!(lengths.len() > 32 && lengths[..lengths.len() - 1].iter().all(|&length| length == 16), "{lengths:?}");
    }

    #[test]
    fn stretches_stay_within_runs() {
        let mut segments = recorded(100);
        segments.merge(&recorded(10), |_| ());
        segments.merge(&recorded(70), |_| ());
        let stretches = segments.stretches();
        let samples: Vec<u64> = stretches.of_length(32).iter().map(|group| group.1).collect();
        assert_eq!(samples, [10, 32, 38, 32, 32, 36]);
        assert!((stretches.number(&stretches.of_length(1000)) - 32_400.0 / 15_000.0).abs() < 1e-12);
    }

    #[test]
    fn replicas_are_bounded_and_joined_within_runs_first() {
        let mut segments = recorded(64);
        (0..10).for_each(|_| segments.merge(&recorded(64), |_| ()));
        assert_eq!((segments.merged.len(), segments.count()), (64, 704));
        // Each run is still apart from the others.
        assert!(segments.stretches().of_length(64).iter().all(|group| group.1 == 64));
    }
}
