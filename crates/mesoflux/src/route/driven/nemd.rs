//! Nonequilibrium molecular dynamics: the flux that a constant force drives (Wu & Shang, eqs 8, 9, 90).

use super::transport::Transport;
use super::{DrivenRecord, Unit, Way};
use crate::route::{Response, RunKind};
use mesoflux_analysis::{Estimate, ResponsePoint};
use mesoflux_core::forcing::ForcingChoice;
use mesoflux_io::input::{DrivenRecordings, NemdInput};

/// α from R(η) = αη + βη³ + …; with one magnitude α = R/η.
pub(crate) struct Nemd {
    pub forcing: ForcingChoice,
    pub parameters: NemdInput,
}

impl Way for Nemd {
    const METHOD: &'static str = "nemd";
    const IMPOSED: Unit = Unit { name: "magnitude", unit: "f" };
    const ANSWER: Unit = Unit { name: "flux", unit: "v" };
    const PLACE: usize = DrivenRecord::FLUX;

    fn forcing(&self) -> &ForcingChoice {
        &self.forcing
    }

    fn strengths(&self) -> &[f64] {
        &self.parameters.magnitude.0
    }

    fn recordings(&self) -> DrivenRecordings {
        self.parameters.recordings()
    }

    fn run(&self, magnitude: f64) -> RunKind {
        RunKind::Nemd { forcing: self.forcing.clone(), magnitude }
    }

    fn coefficient(transport: &Transport, slope: Estimate) -> Estimate {
        transport.of_slope(slope)
    }

    /// σ²(R)/η² (eq. 90).
    fn asymptotic_variance(magnitude: f64, _flux: &Estimate, variance: &Estimate) -> Estimate {
        variance.scaled(magnitude.powi(-2))
    }

    fn drawn(point: &ResponsePoint) -> Response {
        Response { forcing: (point.x, 0.0), flux: (point.y, point.standard_error) }
    }
}
