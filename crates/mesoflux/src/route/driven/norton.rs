//! Stochastic Norton dynamics: the forcing that a constant flux needs (Wu & Shang, eqs 15, 16, 92).

use super::transport::Transport;
use super::{DrivenRecord, Unit, Way};
use crate::route::{Response, RunKind};
use mesoflux_analysis::{Estimate, ResponsePoint};
use mesoflux_core::forcing::ForcingChoice;
use mesoflux_io::input::{DrivenRecordings, NortonInput};

/// α from λ(r) = r/α + c r³ + …; with one flux α = r/⟨λ⟩, the error by the delta method.
pub(crate) struct Norton {
    pub forcing: ForcingChoice,
    pub parameters: NortonInput,
}

impl Way for Norton {
    const METHOD: &'static str = "norton";
    const IMPOSED: Unit = Unit { name: "flux", unit: "v" };
    const ANSWER: Unit = Unit { name: "forcing", unit: "f" };
    const PLACE: usize = DrivenRecord::FORCING;

    fn forcing(&self) -> &ForcingChoice {
        &self.forcing
    }

    fn strengths(&self) -> &[f64] {
        &self.parameters.flux.0
    }

    fn recordings(&self) -> DrivenRecordings {
        self.parameters.recordings()
    }

    fn run(&self, flux: f64) -> RunKind {
        RunKind::Norton { forcing: self.forcing.clone(), flux, projection: self.parameters.projection }
    }

    fn checks_observable(&self) -> bool {
        self.parameters.check_forcing_observable
    }

    fn coefficient(transport: &Transport, slope: Estimate) -> Estimate {
        transport.of_inverse_slope(slope)
    }

    /// r² σ²(λ)/⟨λ⟩⁴ (eq. 92). Mean and variance count as independent, as they are where λ is normally distributed.
    fn asymptotic_variance(flux: f64, forcing: &Estimate, variance: &Estimate) -> Estimate {
        let (Some(forcing), Some(forcing_error), Some(value), Some(error)) =
            (forcing.value, forcing.standard_error, variance.value, variance.standard_error)
        else {
            return Estimate::default();
        };
        let estimator = flux * flux * value / forcing.powi(4);
        let relative = (error / value).hypot(4.0 * forcing_error / forcing);
        Estimate::new(estimator, estimator * relative, variance.effective_samples)
    }

    fn drawn(point: &ResponsePoint) -> Response {
        Response { forcing: (point.y, point.standard_error), flux: (point.x, 0.0) }
    }
}
