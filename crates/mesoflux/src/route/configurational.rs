//! The configurational temperature kT = ⟨|∇U|²⟩/⟨∇²U⟩ (Rugh 1997; Butler, Ayton, Jepps & Evans 1998).

use super::average::StateRecorder;
use super::{Outcome, Record, Route, RouteError, RouteRecorder};
use mesoflux_core::observable::Thermodynamics;
use mesoflux_io::input::Input;

/// The ratio of two averages, its error by the delta method on the joint series.
pub(super) struct Configurational;

impl Route for Configurational {
    fn method(&self) -> &'static str {
        "configurational"
    }

    fn recorder(&self, input: &Input) -> Result<Box<dyn RouteRecorder>, RouteError> {
        StateRecorder::boxed(input, 2, |system| {
            let state = Thermodynamics::of(system);
            vec![state.force_squared, state.laplacian]
        })
    }

    fn estimate(&self, _input: &Input, records: &[Record]) -> Result<Outcome, RouteError> {
        Ok(Outcome::of(records[0].series()?.ratio(0, 1)))
    }
}
