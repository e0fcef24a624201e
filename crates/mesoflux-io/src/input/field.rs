//! `[field.NAME]`, and what expressions must fulfil wherever a user types one.

use super::Input;
use super::validate::Invalid;
use mesoflux_core::boundary::PeriodicBox;
use mesoflux_core::expression::{ExpressionError, Place};
use mesoflux_core::field::expression::ExpressionField;
use mesoflux_core::field::{Field, Fields};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `[field.NAME]`: an external field. It breaks the conservation of momentum along the axes on which its energy depends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldInput {
    /// The energy of a particle, an expression in its place x, y, z in the box, whose sides are lx, ly, lz.
    pub energy: String,
    /// Numbers by the names that the expression gives them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// The species that feel it; all if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub species: Option<Vec<String>>,
}

impl Input {
    /// The external fields.
    ///
    /// # Errors
    /// A field that can't be.
    pub fn fields(&self, region: &PeriodicBox) -> Result<Fields, Invalid> {
        let species = self.species();
        let mut fields = Vec::new();
        for (name, field) in &self.field {
            let path = format!("field.{name}");
            for (index, unknown) in field.species.iter().flatten().enumerate() {
                if !species.iter().any(|(known, _)| known == unknown) {
                    let known: Vec<&str> = species.iter().map(|(name, _)| name.as_str()).collect();
                    let requirement = format!("must be {}", super::wording::one_of(&known));
                    let path = format!("{path}.species.{index}");
                    return Err(Invalid::new(path, format!("{unknown:?}"), requirement));
                }
            }
            let feels = |name: &String| field.species.as_ref().is_none_or(|chosen| chosen.contains(name));
            let law = ExpressionField::new(&field.energy, &field.parameters, region)
                .map_err(|error| wrong_expression(&path, "energy", &error))?;
            fields.push(Field { law, felt_by: species.iter().map(|(name, _)| feels(name)).collect() });
        }
        Ok(Fields::from(fields))
    }

    /// What breaks the conservation of momentum, which a reader of the results must know; nothing where nothing does.
    pub fn remark_on_momentum(&self) -> Option<String> {
        let conserved = self.fields(&self.region().ok()?).ok()?.conserved();
        let conserving = self.integrator_conserves_momentum();
        let axes = ["x", "y", "z"].into_iter().zip(conserved);
        let broken: Vec<&str> = axes.filter(|(_, fixed)| !(*fixed && conserving)).map(|(axis, _)| axis).collect();
        let thermostat = (!conserving).then(|| "dynamics.thermostat.langevin".to_owned());
        let names: Vec<String> = self.field.keys().map(|name| format!("field.{name}")).chain(thermostat).collect();
        (!broken.is_empty()).then(|| {
            format!("{} acts: the total momentum along {} is not conserved", names.join(" and "), broken.join(", "))
        })
    }

    /// Fields that can be, of species that there are.
    pub(super) fn validate_fields(&self) -> Result<(), Invalid> {
        let region = self.region().map_err(|error| Invalid::new("system", "", error))?;
        self.fields(&region).map(|_| ())
    }
}

/// The fault of an expression at `path.key`, or of one of its parameters.
pub(super) fn wrong_expression(path: &str, key: &str, error: &ExpressionError) -> Invalid {
    let whole = || Invalid::new(format!("{path}.{key}"), format!("\"{}\"", error.text), &error.requirement);
    let invalid = match &error.place {
        Place::Parameter(name) => Invalid::new(format!("{path}.parameters.{name}"), "", &error.requirement),
        Place::Whole => whole(),
        Place::Text(range) => whole().within(range.clone(), error.caret()),
    };
    let nearest = error.unknown.as_ref().and_then(|unknown| super::diagnostic::nearest(&unknown.name, &unknown.known));
    let meant = || nearest.map(|name| format!("did you mean `{name}`?"));
    invalid.helped(error.help.clone().or_else(meant))
}
