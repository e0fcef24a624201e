//! The multiple-tau correlator: correlations over many decades of time in bounded memory, with what their errors need.

use super::sums::{DelayLine, LagSums};
use crate::error::{AnalysisError, require_finite, require_length};
use crate::segments::{Segment, Segments};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Streaming auto- and cross-correlations of sampled channels, `C_ab(t) = ⟨x_a(t) x_b(0)⟩`.
///
/// **Order.** A pair is `[later, earlier]`: `[a, b]` correlates channel a at time t with channel b at time 0, t ≥ 0. In a
/// stationary state `C_ba(t) = C_ab(−t)`, which needn't equal `C_ab(t)`.
///
/// **Pairs are equivalent.** All pairs of one correlator estimate the same function (the components of an isotropic fluid's
/// stress, say) and are averaged with equal weight; their scatter is part of the error. They count as independent of each other,
/// which to second order needs the cross-correlations between pairs to vanish. Different functions need different correlators.
///
/// **Levels.** Level ℓ holds averages over blocks of 2^ℓ samples and their products at lags of k blocks: 0 ≤ k < 16 at level 0,
/// 8 ≤ k < 16 above. The correlation of averages over B samples at lag kB is the correlation of the samples smeared with a
/// triangle of half-width B. Triangles weighted with w(kB) add up to the piecewise-linear function through these points, so
/// integrals `Σ_t w(t) C(t)` with such a w have *exactly* the expectation of those over all lags of the samples: smearing costs nothing.
///
/// **Segments.** Sums are kept apart for up to 64 stretches of time (as many for merged replicas): when they are full, neighbors are joined. Products
/// across their borders are kept. The scatter of segments gives the errors, whatever the law of the series.
///
/// **Memory** O(64 · 8 log₂(n) · pairs) numbers for n samples; time for one sample O(32 · pairs).
///
/// Source: J. Ramírez, S. K. Sukumaran, B. Vorselaars and A. E. Likhtman, J. Chem. Phys. 133, 154103 (2010).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MultipleTau {
    channels: usize,
    /// The pairs asked for, and after them channels with themselves whose memory is the least that a cutoff must reach.
    pub(super) pairs: Vec<[usize; 2]>,
    /// How many of them were asked for.
    pub(super) equivalent: usize,
    pub(super) spacing: f64,
    /// Whether all pairs share one sum.
    pub(super) pooled: bool,
    /// By channel, whether its mean is unknown and to be subtracted.
    pub(super) mean_removed: Vec<bool>,
    /// The first sample in channels whose mean is removed, else zero: all sums are relative to it. Empty before.
    pub(super) origin: Vec<f64>,
    lines: Vec<DelayLine>,
    pub(super) segments: Segments<LagSums>,
}

impl MultipleTau {
    /// An empty correlator of samples of `channels` numbers, `spacing` apart in time, for ordered pairs `[later, earlier]` of channels.
    ///
    /// # Errors
    /// If there are no channels or pairs, a pair names a channel that isn't there, or the spacing isn't positive and finite.
    pub fn new(channels: usize, pairs: &[[usize; 2]], spacing: f64) -> Result<Self, AnalysisError> {
        if channels == 0 {
            return Err(AnalysisError::OutOfRange { name: "channels", value: 0.0, requirement: "at least 1" });
        }
        if pairs.is_empty() {
            return Err(AnalysisError::OutOfRange { name: "pairs", value: 0.0, requirement: "at least 1" });
        }
        if let Some(&channel) = pairs.as_flattened().iter().find(|&&channel| channel >= channels) {
            let value = channel as f64;
            return Err(AnalysisError::OutOfRange { name: "channel of a pair", value, requirement: "below channels" });
        }
        if !(spacing > 0.0 && spacing.is_finite()) {
            let requirement = "positive and finite";
            return Err(AnalysisError::OutOfRange { name: "spacing", value: spacing, requirement });
        }
        let unequal = pairs.iter().filter(|[later, earlier]| later != earlier).flatten();
        let own: Vec<[usize; 2]> = unequal.map(|&channel| [channel; 2]).collect::<BTreeSet<_>>().into_iter().collect();
        Ok(Self {
            channels,
            pairs: [pairs, &own].concat(),
            equivalent: pairs.len(),
            spacing,
            pooled: false,
            mean_removed: vec![false; channels],
            origin: Vec::new(),
            lines: Vec::new(),
            segments: Segments::new(),
        })
    }

    /// The autocorrelation of one channel.
    ///
    /// # Errors
    /// If the spacing isn't positive and finite.
    pub fn autocorrelation(spacing: f64) -> Result<Self, AnalysisError> {
        Self::new(1, &[[0, 0]], spacing)
    }

    /// Has integrals cut off no earlier than the autocorrelation of these channels has decayed, as far as the data show it.
    ///
    /// For pairs that drown in noise: the total stress of a fluid with strong friction, say, whose decay its noise hides, and would let a sum
    /// over the noise alone seem to be the whole. A channel that has the same slow part without the noise shows how long it lasts.
    ///
    /// # Errors
    /// If there is no such channel, something was recorded already, or all channels are pooled.
    pub fn remembered_by(mut self, channels: impl IntoIterator<Item = usize>) -> Result<Self, AnalysisError> {
        if self.pooled || !self.origin.is_empty() {
            let reason = "whose memory counts must be decided before the first record, and not for pooled channels";
            return Err(AnalysisError::Underdetermined(reason));
        }
        for channel in channels {
            if channel >= self.channels {
                let value = channel as f64;
                return Err(AnalysisError::OutOfRange { name: "channel", value, requirement: "below channels" });
            }
            self.pairs.push([channel; 2]);
        }
        Ok(self)
    }

    /// The mean autocorrelation of many channels, all in one sum, such as the velocities of all particles.
    ///
    /// Its errors come from segments of time alone. Means are known to be zero: they can't be removed.
    ///
    /// # Errors
    /// If there are no channels, or the spacing isn't positive and finite.
    pub fn pooled(channels: usize, spacing: f64) -> Result<Self, AnalysisError> {
        let pairs: Vec<[usize; 2]> = (0..channels).map(|channel| [channel; 2]).collect();
        Ok(Self { pooled: true, ..Self::new(channels, &pairs, spacing)? })
    }

    /// How many sums of products are kept apart.
    fn slots(&self) -> usize {
        if self.pooled { 1 } else { self.pairs.len() }
    }

    /// Correlates deviations from the mean of a channel, for observables whose mean isn't known to be zero.
    ///
    /// The mean is that of all samples, replicas included. It makes every C(t) too small by the covariance of the two means, which
    /// is estimated from the segments and added; what bias is left is smaller by about the square root of twice their number.
    ///
    /// # Errors
    /// If there is no such channel, something was recorded already, or all channels are pooled.
    pub fn remove_mean(mut self, channel: usize) -> Result<Self, AnalysisError> {
        if self.pooled {
            return Err(AnalysisError::Underdetermined("pooled channels keep their means"));
        }
        if !self.origin.is_empty() {
            return Err(AnalysisError::Underdetermined("removing a mean must be decided before the first record"));
        }
        if let Some(removed) = self.mean_removed.get_mut(channel) {
            *removed = true;
            return Ok(self);
        }
        Err(AnalysisError::OutOfRange { name: "channel", value: channel as f64, requirement: "below channels" })
    }

    /// Whether `state` can be what this correlator once was or will be: of the same kind, its parts fitting together.
    ///
    /// For states from files: using one that doesn't fit may panic.
    pub fn accepts(&self, state: &Self) -> bool {
        let fits = |sums: &LagSums| sums.is_consistent(self.channels, self.slots());
        self.mismatch(state).is_none()
            && state.pairs.len() == self.pairs.len()
            && (state.origin.len() == self.channels || state.origin.is_empty() && state.count() == 0)
            && state.lines.len() <= u64::BITS as usize
            && state.lines.iter().all(|line| line.is_consistent(self.channels))
            && state.segments.are_consistent(fits)
    }

    /// The first parameter in which two correlators differ, and its values.
    fn mismatch(&self, other: &Self) -> Option<(&'static str, f64, f64)> {
        if self.channels != other.channels {
            return Some(("channels", self.channels as f64, other.channels as f64));
        }
        if self.equivalent != other.equivalent {
            return Some(("pairs", self.equivalent as f64, other.equivalent as f64));
        }
        if self.slots() != other.slots() {
            return Some(("sums kept apart", self.slots() as f64, other.slots() as f64));
        }
        if self.spacing != other.spacing {
            return Some(("spacing", self.spacing, other.spacing));
        }
        let channels = self.pairs.as_flattened().iter().zip(other.pairs.as_flattened());
        if let Some((own, theirs)) = channels.into_iter().find(|(own, theirs)| own != theirs) {
            return Some(("channel of a pair", *own as f64, *theirs as f64));
        }
        let removed = self.mean_removed.iter().zip(&other.mean_removed);
        let differing = removed.into_iter().find(|(own, theirs)| own != theirs);
        let lengths = (self.mean_removed.len(), other.mean_removed.len());
        (differing.is_some() || lengths.0 != lengths.1).then(|| {
            let number = |correlator: &Self| correlator.mean_removed.iter().filter(|&&removed| removed).count() as f64;
            ("channels without their mean", number(self), number(other))
        })
    }

    /// Number of samples recorded, over all replicas.
    pub fn count(&self) -> u64 {
        self.segments.count()
    }

    /// Time between samples.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Takes the next sample: one number a channel.
    ///
    /// # Errors
    /// If their number is wrong or one isn't finite; nothing is recorded then.
    pub fn record(&mut self, sample: &[f64]) -> Result<(), AnalysisError> {
        require_length("sample", sample.len(), self.channels)?;
        require_finite("sample", sample)?;
        if self.origin.is_empty() {
            let removed = self.mean_removed.iter().zip(sample);
            self.origin = removed.map(|(&removed, value)| if removed { *value } else { 0.0 }).collect();
        }
        let mut block: Vec<f64> = sample.iter().zip(&self.origin).map(|(value, origin)| value - origin).collect();
        let slots = self.slots();
        let sums = self.segments.open(|| LagSums::new(self.channels));
        sums.add_sample(&block);
        for level in 0.. {
            if level == self.lines.len() {
                self.lines.push(DelayLine::new(self.channels));
            }
            self.lines[level].push(&block);
            sums.add_latest(level, &self.lines[level], &self.pairs, slots);
            if !self.lines[level].completes(&mut block) {
                break;
            }
        }
        Ok(())
    }

    /// Pools a replica: an independent series of the same quantity. No product spans the seam; what is recorded later continues `self`'s series.
    ///
    /// # Errors
    /// If channels, pairs, spacing or the removal of means differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), AnalysisError> {
        if let Some((name, left, right)) = self.mismatch(other) {
            return Err(AnalysisError::Mismatch { name, left, right });
        }
        if other.origin.is_empty() {
            return Ok(());
        }
        if self.origin.is_empty() {
            self.origin.clone_from(&other.origin);
        }
        let offset: Vec<f64> = other.origin.iter().zip(&self.origin).map(|(theirs, own)| theirs - own).collect();
        self.segments.merge(&other.segments, |segment: &mut Segment<LagSums>| {
            if !self.pooled {
                segment.sums.shift(segment.samples, &offset, &self.pairs);
            }
        });
        Ok(())
    }
}
