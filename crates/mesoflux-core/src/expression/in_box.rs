//! Functions of a place in a periodic box: names for its sides, and what such a function must fulfil.

use super::ExpressionError;
use std::collections::BTreeMap;

/// A function is looked at in so many places along each axis before it is used, both faces among them.
const SAMPLES: u32 = 17;

/// And in as many between, at a share of their distance that is no simple fraction: a wave that is zero at all of the first is seen.
const SHIFT: f64 = 0.382;

/// The names of the sides of the box.
const SIDES: [&str; 3] = ["lx", "ly", "lz"];

/// Parameters by their names, the sides of the box and further constants among them.
///
/// # Errors
/// A parameter with one of their names.
pub(crate) fn with_constants(
    text: &str,
    parameters: &BTreeMap<String, f64>,
    sides: [f64; 3],
    further: &[(&str, f64)],
) -> Result<BTreeMap<String, f64>, ExpressionError> {
    let mut constants = parameters.clone();
    for (name, value) in SIDES.into_iter().zip(sides).chain(further.iter().copied()) {
        if constants.insert(name.to_owned(), value).is_some() {
            return Err(ExpressionError::taken_name(text, name));
        }
    }
    Ok(constants)
}

/// A function of a place and its name.
pub(crate) type Named<'a, T> = (&'a str, &'a dyn Fn(&[f64; 3]) -> T);

/// Looks in many places at a function and at the slopes that are needed of it: all must be finite, the function the same on opposite
/// faces of the box.
///
/// # Errors
/// The place where one is not.
pub(crate) fn check(
    text: &str,
    sides: [f64; 3],
    (what, function): Named<f64>,
    (slope, slopes): Named<[f64; 3]>,
) -> Result<(), ExpressionError> {
    let coordinate = |axis: usize, k: u32| sides[axis] * f64::from(k) / f64::from(SAMPLES - 1);
    let between = |axis: usize, k: u32| sides[axis] * (f64::from(k) + SHIFT) / f64::from(SAMPLES);
    let mut largest = 0.0f64;
    for number in 0..2 * SAMPLES.pow(3) {
        let at = [number % SAMPLES, number / SAMPLES % SAMPLES, number / SAMPLES.pow(2) % SAMPLES];
        let is_first = number < SAMPLES.pow(3);
        let [x, y, z] =
            std::array::from_fn(|axis| if is_first { coordinate(axis, at[axis]) } else { between(axis, at[axis]) });
        let (value, [a, b, c]) = (function(&[x, y, z]), slopes(&[x, y, z]));
        for (name, value) in [(what, value), (slope, a), (slope, b), (slope, c)] {
            if !value.is_finite() {
                let requirement = format!("must be finite, but at x = {x}, y = {y}, z = {z} the {name} is {value}");
                return Err(ExpressionError::whole(text, requirement));
            }
        }
        largest = largest.max(value.abs());
    }
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for number in 0..SAMPLES.pow(2) {
            let mut low = [0.0; 3];
            low[(axis + 1) % 3] = coordinate((axis + 1) % 3, number % SAMPLES);
            low[(axis + 2) % 3] = coordinate((axis + 2) % 3, number / SAMPLES);
            let mut high = low;
            high[axis] = sides[axis];
            let jump = function(&low) - function(&high);
            if jump.abs() > 1e-9 * largest {
                let (side, [x, y, z]) = (sides[axis], high);
                let requirement = format!(
                    "must be the same on opposite faces of the box, but the {what} jumps by {jump:.3e} from {name} = {side} to \
                     {name} = 0 (at x = {x}, y = {y}, z = {z})"
                );
                let mut error = ExpressionError::whole(text, requirement);
                error.help = Some(format!("the sides of the box are lx, ly, lz: cos(2*pi*{name}/l{name}) is periodic"));
                return Err(error);
            }
        }
    }
    Ok(())
}
