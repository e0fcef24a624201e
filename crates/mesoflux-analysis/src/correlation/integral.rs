//! Green–Kubo integrals, Helfand slopes and tables of a correlation function, each with its error.

use super::MultipleTau;
use super::cutoff::{Choice, STRETCH, STRETCHES, choose};
use super::evaluation::{Evaluation, Functional};
use crate::estimate::Estimate;
use serde::{Deserialize, Serialize};

/// How samples of C make an integral.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quadrature {
    /// spacing · (½C(0) + Σ_{k ≥ 1} C(k)): exact for a quantity summed up from sample to sample, such as the momentum flux of whole
    /// time steps with its random part, where it is half the asymptotic variance of the mean, whatever the spacing.
    #[default]
    Summed,
    /// spacing · (⅜C(0) + ⁷⁄₆C(1) + ²³⁄₂₄C(2) + Σ_{k ≥ 3} C(k)): Gregory's end correction of fourth order, for a quantity read at
    /// instants whose correlation is smooth for t > 0 and may begin with a slope.
    Smooth,
}

/// What an integral is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IntegralOptions {
    /// What the samples are.
    pub quadrature: Quadrature,
    /// Windows end at this time at the latest, for functions that are wrong beyond it, such as by a finite size.
    pub longest_time: Option<f64>,
}

/// A time integral of a correlation function.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Integral {
    /// ∫₀^∞ C(t) dt.
    pub estimate: Estimate,
    /// Where the windows end that it was taken from, on average; `None` if it can't be told.
    pub cutoff: Option<f64>,
    /// The time of decay ∫ t C dt/∫ C dt: the exponential correlation time of a single exponential.
    pub decay_time: Estimate,
}

/// One lag of a correlation function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorrelationPoint {
    /// Lag in units of time.
    pub time: f64,
    /// C at this lag, averaged over a triangle of half-width 2^ℓ samples at level ℓ.
    pub correlation: Estimate,
    /// C at this lag over C(0): their fluctuations in common don't count.
    pub normalized: Estimate,
    /// ∫ w C dt with the window of [`MultipleTau::integral`] that ends at this lag.
    pub integral: Estimate,
    /// ½⟨ΔG_a ΔG_b⟩ with ΔG = ∫ x dt over a time of this length (equal pairs: half the mean squared Helfand displacement).
    pub helfand: Estimate,
}

impl MultipleTau {
    /// The Green–Kubo integral `∫₀^∞ C(t) dt = spacing · Σ_t w(t) C(t)`, the first weights as the options say.
    ///
    /// **Window.** w is 1 up to T/2 and falls linearly to zero at T. Trials with T from one sample up, four an octave, are averaged
    /// with weights that say how well the data agree with nothing being left beyond T/2.5: the increment from T' to 2T' must vanish for all
    /// T' ≥ T/2.5. Weights are exp(−½ Σ (z² − 6)) over octaves of T', z being increments in units of their errors.
    ///
    /// **Error.** The scatter of stretches of at least 4 T, and the variance from cutoff to cutoff. `effective_samples` is the number of these
    /// stretches, equivalent pairs counted.
    ///
    /// **Cross-correlations** are cut off no earlier than the autocorrelations of their channels let it seem that these have forgotten; other
    /// correlations no earlier than the channels of [`remembered_by`](Self::remembered_by).
    ///
    /// **Cannot tell** if cutoffs for which fewer than 16 stretches remain have more than half of the weight: about 700 decay times
    /// of a single exponential and a single pair.
    ///
    /// **What it can't see.** A slow part of the correlation that is lost in the noise of the data: its integral isn't in the error.
    ///
    /// Sources: average over cutoffs, W. I. Jay and E. T. Neil, Phys. Rev. D 103, 114502 (2021).
    pub fn integral(&self, options: &IntegralOptions) -> Integral {
        let evaluation = self.evaluation();
        let window = |end: u64| evaluation.window(end, |lag| taper(lag, end) * options.quadrature.weight(lag));
        match self.range(options.longest_time).and_then(|range| choose(&evaluation, range, window)) {
            Ok(choice) => self.integral_of(&evaluation, &choice),
            Err(reason) => Integral::unknown(&reason),
        }
    }

    /// The Helfand (Einstein) form of the integral of an autocorrelation: the slope of `½⟨ΔG(t)²⟩` with `ΔG(t) = ∫₀ᵗ x dt'`.
    ///
    /// The slope of the least-squares line through lags from T/2 to T. `½⟨ΔG(t)²⟩ = ∫₀ᵗ (t − t') C(t') dt'`, so this is one more window
    /// on the correlation function: 1 up to T/2, then falling smoothly to zero at T. Choice of T, errors and
    /// refusal as for [`integral`](Self::integral). `longest_time` is the upper limit of the line, below the time in which momentum
    /// diffuses through the box, L²/(4π²ν).
    ///
    /// Pairs must be equal channels, or come with their reverse: the product of two displacements knows no order.
    ///
    /// Source: D. C. Malaspina, M. Lísal, J. P. Larentzos, J. K. Brennan, A. D. Mackie and J. Bonet Avalos, as used by Naseri et al., eqs 59 and 60.
    pub fn helfand_slope(&self, longest_time: Option<f64>) -> Integral {
        if !self.is_symmetric() {
            return Integral::unknown("a Helfand slope needs pairs of equal channels, or each with its reverse");
        }
        let evaluation = self.evaluation();
        match self
            .range(longest_time)
            .and_then(|range| choose(&evaluation, range, |end| helfand_slope(&evaluation, end)))
        {
            Ok(choice) => self.integral_of(&evaluation, &choice),
            Err(reason) => Integral::unknown(&reason),
        }
    }

    /// The correlation function and its running integrals at all lags for which there are 16 stretches of 4 lags.
    ///
    /// Points of neighboring lags are strongly correlated. Every estimate here is for one fixed lag: nothing is chosen or extrapolated.
    pub fn table(&self, quadrature: Quadrature) -> Vec<CorrelationPoint> {
        let evaluation = self.evaluation();
        let estimate = |functional: &Functional, lag: u64, scale: f64| {
            let scatter = evaluation.scatter(functional, STRETCH * lag.max(1));
            Estimate::new(scale * functional.value, scale * scatter.standard_error, scatter.number)
        };
        let symmetric = self.is_symmetric();
        let variance = evaluation.window(1, |_| 1.0);
        let normalized = |correlation: &Functional, lag: u64| {
            let mut ratio = correlation.clone();
            ratio.add(&variance, -correlation.value / variance.value);
            ratio.value = correlation.value;
            estimate(&ratio, lag, variance.value.recip())
        };
        let measured =
            evaluation.lags().take_while(|(lag, _)| evaluation.stretches(STRETCH * lag.max(&1)) >= STRETCHES);
        let point = |(lag, correlation): (u64, &Functional)| {
            let integral = evaluation.window(lag, |t| taper(t, lag) * quadrature.weight(t));
            let helfand = evaluation.window(lag, |t| (lag - t) as f64 * Quadrature::Summed.weight(t));
            CorrelationPoint {
                time: lag as f64 * self.spacing,
                correlation: estimate(correlation, lag, 1.0),
                normalized: normalized(correlation, lag),
                integral: estimate(&integral, lag, self.spacing),
                helfand: if symmetric {
                    estimate(&helfand, lag, self.spacing * self.spacing)
                } else {
                    Estimate::unknown("a Helfand displacement needs pairs of equal channels, or each with its reverse")
                },
            }
        };
        measured.map(point).collect()
    }

    fn integral_of(&self, evaluation: &Evaluation, choice: &Choice) -> Integral {
        let value = choice.functional.value;
        let estimate =
            Estimate::new(value * self.spacing, choice.standard_error(evaluation) * self.spacing, choice.number);
        let end = choice.cutoff.ceil() as u64;
        let mut moment = evaluation.window(end, |lag| lag as f64 * taper(lag, end));
        let time = moment.value / value;
        moment.add(&choice.functional, -time);
        let error = evaluation.scatter(&moment, choice.stretch).standard_error / value.abs();
        let decay_time = Estimate::new(time * self.spacing, error * self.spacing, choice.number);
        Integral { estimate, cutoff: Some(choice.cutoff * self.spacing), decay_time }
    }

    /// The correlation function of the pairs asked for.
    pub(super) fn evaluation(&self) -> Evaluation {
        Evaluation::new(self, 0..if self.pooled { 1 } else { self.equivalent })
    }

    /// Range of cutoffs in samples: up to the longest time, and from the time on at which the channels of unequal pairs forget.
    ///
    /// A cross-correlation may begin at zero and rise later: that it isn't seen at short times says nothing.
    fn range(&self, longest_time: Option<f64>) -> Result<(u64, u64), String> {
        let longest = longest_time.map_or(u64::MAX, |time| (time / self.spacing) as u64);
        if self.equivalent == self.pairs.len() {
            return Ok((1, longest));
        }
        let own = Evaluation::new(self, self.equivalent..self.pairs.len());
        let choice =
            choose(&own, (1, longest), |end| own.window(end, |lag| taper(lag, end) * Quadrature::Summed.weight(lag)))?;
        Ok((choice.forgotten(), longest))
    }

    /// Whether each pair's reverse is a pair, too.
    fn is_symmetric(&self) -> bool {
        let occurrences =
            |pair: [usize; 2]| self.pairs[..self.equivalent].iter().filter(|other| **other == pair).count();
        self.pairs[..self.equivalent]
            .iter()
            .all(|&[later, earlier]| occurrences([later, earlier]) == occurrences([earlier, later]))
    }
}

impl Integral {
    fn unknown(reason: &str) -> Self {
        Self { estimate: Estimate::unknown(reason), cutoff: None, decay_time: Estimate::unknown(reason) }
    }
}

impl Quadrature {
    /// The weight of C at a lag in samples.
    pub(super) fn weight(self, lag: u64) -> f64 {
        match (self, lag) {
            (Self::Summed, 0) => 0.5,
            (Self::Smooth, 0) => 3.0 / 8.0,
            (Self::Smooth, 1) => 7.0 / 6.0,
            (Self::Smooth, 2) => 23.0 / 24.0,
            _ => 1.0,
        }
    }
}

/// 1 up to half of `end`, then linear to zero at `end`.
pub(super) fn taper(lag: u64, end: u64) -> f64 {
    (2.0 - 2.0 * lag as f64 / end as f64).clamp(0.0, 1.0)
}

/// Slope of the line through ½⟨ΔG²⟩ at lags from half of `end` to `end`, in steps of the level that holds `end`.
fn helfand_slope(evaluation: &Evaluation, end: u64) -> Functional {
    let step = 1 << end.ilog2().saturating_sub(3);
    let lags: Vec<f64> = (end / 2 / step..=end / step).map(|index| (index * step) as f64).collect();
    let mean = lags.iter().sum::<f64>() / lags.len() as f64;
    let spread: f64 = lags.iter().map(|lag| (lag - mean).powi(2)).sum();
    evaluation.window(end, |t| {
        let line: f64 = lags.iter().map(|lag| (lag - mean) / spread * (lag - t as f64).max(0.0)).sum();
        line * Quadrature::Summed.weight(t)
    })
}
