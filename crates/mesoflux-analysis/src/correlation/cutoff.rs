//! Where to cut a correlation function off: an average over cutoffs, each weighted by what the data say against it.

use super::evaluation::{Evaluation, Functional, Scatter};

/// Least length of the stretches of time that errors come from, in units of the cutoff.
pub(super) const STRETCH: u64 = 4;
/// Least number of independent stretches times equivalent pairs.
pub(super) const STRETCHES: f64 = 16.0;
/// Functionals are taken at this multiple of the time from which on nothing is left.
const MARGIN: f64 = 2.5;
/// What it costs to keep one more octave, in units of χ².
const PENALTY: f64 = 6.0;
/// Largest weight of cutoffs that the series is too short for.
const LOST: f64 = 0.5;
/// Cutoffs an octave, from 8 samples on.
const PER_OCTAVE: f64 = 4.0;
/// Windows with a smaller share of the weight have no say in how long stretches must be.
const NEGLIGIBLE: f64 = 0.05;
/// How many times longer to run if the decay can't be extrapolated, and at least.
const FACTORS: (f64, f64) = (4.0, 2.0);

/// A functional averaged over cutoffs.
pub(super) struct Choice {
    pub(super) functional: Functional,
    /// Average end of the windows, in samples.
    pub(super) cutoff: f64,
    /// Length of the stretches its scatter is to be taken from, in samples.
    pub(super) stretch: u64,
    /// Mean of the windows' independent stretches.
    pub(super) number: f64,
    /// Variance from cutoff to cutoff.
    between: f64,
}

/// A functional of one cutoff.
struct Candidate {
    end: u64,
    functional: Functional,
    number: f64,
}

/// What the functional gains from T to 2T, in units of its standard error.
struct Increment {
    /// Index of the candidate T.
    index: usize,
    score: f64,
    value: f64,
    standard_error: f64,
}

impl Choice {
    /// Standard error: the scatter of the average, and the variance from cutoff to cutoff.
    pub(super) fn standard_error(&self, evaluation: &Evaluation) -> f64 {
        self.scatter(evaluation).standard_error.hypot(self.between.sqrt())
    }

    /// The time from which on nothing is left, on average.
    pub(super) fn forgotten(&self) -> u64 {
        (self.cutoff / MARGIN) as u64
    }

    fn scatter(&self, evaluation: &Evaluation) -> Scatter {
        evaluation.scatter(&self.functional, self.stretch)
    }
}

/// Averages `functional`(T), which tends to a plateau for long cutoffs T (in samples), over T from `least` to `limit`.
///
/// The hypothesis that nothing is left beyond T predicts that the increments from T' to 2T' vanish for all T' ≥ T. Its weight is
/// exp(−½ Σ_{T' ≥ T} (z² − 6)), the sum being over octaves of T', z the increment in units of its standard error (Student's t turned
/// into a normal score), as in an average over models with a penalty of 3 for every parameter. The functional is
/// taken at 2.5 T: a remainder too small to be seen at T is negligible there.
///
/// The error of C(t) comes from stretches of at least 4 cutoffs, of which there must be 16 (with equivalent pairs counted). If cutoffs that are
/// too long for this have more than half of the weight, the series is too short.
///
/// # Errors
/// The reason why there is no choice.
pub(super) fn choose(
    evaluation: &Evaluation,
    (least, limit): (u64, u64),
    functional: impl Fn(u64) -> Functional,
) -> Result<Choice, String> {
    let measured = |&end: &u64| evaluation.stretches(STRETCH * end) >= STRETCHES;
    let ends: Vec<u64> = ends(limit.min(evaluation.samples)).take_while(measured).filter(|&end| end >= least).collect();
    let candidates: Vec<Candidate> = ends
        .iter()
        .map(|&end| Candidate { end, functional: functional(end), number: evaluation.stretches(STRETCH * end) })
        .collect();
    let increments = increments(evaluation, &candidates);
    let weights = weights(&candidates, &increments);
    let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
    let found: Vec<(&Candidate, f64)> = weights.iter().filter_map(|&(c, w)| Some((&candidates[c?], w))).collect();
    let kept: f64 = found.iter().map(|(_, weight)| weight).sum();
    if found.is_empty() || !(kept >= (1.0 - LOST) * total) || total == 0.0 {
        return Err(refusal(evaluation, &ends, &increments, limit));
    }
    let mut choice = Choice { functional: evaluation.zero(), cutoff: 0.0, stretch: 0, number: 0.0, between: 0.0 };
    for (candidate, weight) in &found {
        let share = weight / kept;
        choice.functional.add(&candidate.functional, share);
        choice.cutoff += share * candidate.end as f64;
        choice.number += share * candidate.number;
        if share > NEGLIGIBLE {
            choice.stretch = choice.stretch.max(STRETCH * candidate.end);
        }
    }
    let deviation = |candidate: &Candidate| candidate.functional.value - choice.functional.value;
    choice.between = found.iter().map(|(candidate, weight)| weight / kept * deviation(candidate).powi(2)).sum();
    Ok(choice)
}

/// Ends of windows in samples, ascending: all numbers below 8, then four an octave, so that their halves are lags, too.
pub(super) fn ends(limit: u64) -> impl Iterator<Item = u64> {
    let octaves = (0..u64::BITS - 5).flat_map(|power| (4..8u64).map(move |quarter| (2 * quarter) << power));
    (1..8).chain(octaves).take_while(move |&end| end <= limit)
}

fn increments(evaluation: &Evaluation, candidates: &[Candidate]) -> Vec<Increment> {
    let doubled = |candidate: &Candidate| candidates.iter().find(|other| other.end >= 2 * candidate.end);
    let pairs =
        candidates.iter().enumerate().map_while(|(index, candidate)| Some((index, candidate, doubled(candidate)?)));
    let increment = |(index, candidate, doubled): (usize, &Candidate, &Candidate)| {
        let mut difference = doubled.functional.clone();
        difference.add(&candidate.functional, -1.0);
        let Scatter { standard_error, number } = evaluation.scatter(&difference, STRETCH * doubled.end);
        // A constant series has neither increments nor errors.
        let t = if difference.value == 0.0 { 0.0 } else { difference.value / standard_error };
        Increment { index, score: normal_score(t, number - 1.0), value: difference.value, standard_error }
    };
    pairs.map(increment).collect()
}

/// For each candidate T with an increment: the candidate at the margin, if the series is long enough for it, and the weight.
fn weights(candidates: &[Candidate], increments: &[Increment]) -> Vec<(Option<usize>, f64)> {
    let mut beyond = 0.0;
    let mut weights = Vec::with_capacity(increments.len());
    for increment in increments.iter().rev() {
        let end = candidates[increment.index].end as f64;
        let per_octave = PER_OCTAVE.min(0.5 * end).max(1.0);
        beyond += (increment.score * increment.score - PENALTY) / per_octave;
        weights.push((candidates.iter().position(|c| c.end as f64 >= MARGIN * end), beyond));
    }
    // Relative to the best, lest they overflow.
    let best = weights.iter().map(|(_, beyond)| *beyond).fold(f64::INFINITY, f64::min);
    weights.iter().map(|&(index, beyond)| (index, (0.5 * (best - beyond)).exp())).collect()
}

/// The normal score of the same probability as Student's `t` (D. L. Wallace, Ann. Math. Stat. 30, 1124 (1959)).
fn normal_score(t: f64, degrees_of_freedom: f64) -> f64 {
    let n = degrees_of_freedom;
    (8.0 * n + 1.0) / (8.0 * n + 3.0) * (n * (t * t / n).ln_1p()).sqrt()
}

/// Why there is no choice, and how much longer to run.
fn refusal(evaluation: &Evaluation, ends: &[u64], increments: &[Increment], limit: u64) -> String {
    let (Some(last), Some(&longest)) = (increments.last(), ends.last()) else {
        let least = STRETCHES * (2 * STRETCH) as f64 * MARGIN;
        let factor = (least / evaluation.samples as f64).max(FACTORS.1);
        return format!(
            "cannot tell yet: {} samples are too few; run about {factor:.0} times longer",
            evaluation.samples
        );
    };
    if limit < evaluation.samples && evaluation.stretches(STRETCH * limit) >= STRETCHES {
        return format!("cannot tell: the correlation hasn't decayed within the longest time allowed, {limit} samples");
    }
    // The increment an octave before tells how fast it decays.
    let end = ends[last.index] as f64;
    let earlier = increments.iter().find(|increment| 2 * ends[increment.index] >= ends[last.index]);
    let decay = earlier.map_or(0.0, |earlier| (earlier.value / last.value).abs().ln());
    let remaining = (last.value / last.standard_error).abs().ln();
    let factor = if decay > 0.0 && remaining > 0.0 {
        MARGIN * end * (1.0 + 0.5 * remaining / decay) / longest as f64
    } else {
        FACTORS.0
    };
    format!(
        "cannot tell yet: the correlation may not have decayed by lag {longest}, the longest that {} samples give an error for; \
         run about {:.0} times longer",
        evaluation.samples,
        factor.max(FACTORS.1)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_have_halves_that_are_lags() {
        assert_eq!(ends(30).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28]);
        assert!(ends(u64::MAX).count() > 200);
    }

    #[test]
    fn normal_scores_have_the_tail_of_student() {
        // P(|t| > 2.776) = 0.05 with 4 degrees of freedom, P(|t| > 3.365) = 0.02 with 5.
        assert!((normal_score(2.776, 4.0) - 1.960).abs() < 0.02);
        assert!((normal_score(-3.365, 5.0) - 2.326).abs() < 0.02);
    }
}
