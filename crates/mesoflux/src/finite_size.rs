//! What the finite box takes from a diffusion coefficient, where the viscosity is measured beside.

use crate::route::Outcome;
use mesoflux_io::input::Input;
use mesoflux_io::results::EstimateRecord;
use std::f64::consts::PI;

/// ξ of a cubic box (Yeh & Hummer, J. Phys. Chem. B 108, 15873 (2004), eq. 12).
const CUBIC_LATTICE_SUM: f64 = 2.837_297;

/// Gives every diffusion coefficient of a point the correction D(∞) − D(L) = ξ kT/(6πηL) with the first shear viscosity that was measured
/// at the same point; only for cubic boxes.
///
/// The estimate itself stays what the box gives.
pub(crate) fn report(input: &Input, estimates: &mut [(EstimateRecord, Option<Outcome>)]) {
    let viscosity = estimates
        .iter()
        .map(|(estimate, _)| estimate)
        .filter(|estimate| estimate.quantity == "shear_viscosity")
        .find_map(|estimate| {
            Some((estimate.method, estimate.value.filter(|value| *value > 0.0)?, estimate.standard_error?))
        });
    let (Some((method, viscosity, error)), Ok(region)) = (viscosity, input.region()) else {
        return;
    };
    let [side, b, c] = region.sides();
    if side != b || side != c {
        return;
    }
    let correction = CUBIC_LATTICE_SUM * input.dynamics.temperature / (6.0 * PI * viscosity * side);
    let correction_error = correction * error / viscosity;
    for estimate in estimates
        .iter_mut()
        .map(|(estimate, _)| estimate)
        .filter(|estimate| estimate.quantity == "diffusion_coefficient")
    {
        if let (Some(value), Some(error)) = (estimate.value, estimate.standard_error) {
            let numbers = [
                ("finite_size_correction", correction),
                ("finite_size_correction_standard_error", correction_error),
                ("infinite_system_value", value + correction),
                ("infinite_system_standard_error", error.hypot(correction_error)),
            ];
            estimate.conditions.extend(numbers.map(|(key, number)| (key.to_owned(), number.into())));
            estimate.conditions.insert("finite_size_viscosity".to_owned(), method.into());
        }
    }
}
