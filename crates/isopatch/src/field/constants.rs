//! Named constants of a formula.

use super::exact::{Exact, parse_decimal};
use super::token::{Function, is_name_part, is_name_start};

/// Named constants, in the order in which they were first set. A later value for a name replaces the earlier one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constants {
    entries: Vec<(String, Exact)>,
}

/// Why a constant can't be set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConstantError {
    /// Not of the form NAME=VALUE.
    #[error("\"{0}\" is not of the form NAME=VALUE")]
    NotAnAssignment(String),
    /// Not a name.
    #[error("\"{0}\" is not a name: a letter, then letters, digits and underscores")]
    NotAName(String),
    /// The name means something already.
    #[error("the constant \"{0}\" would hide the variable, number or function of that name")]
    Reserved(String),
    /// Not a finite number.
    #[error("the value \"{value}\" of the constant \"{name}\" is not a finite number")]
    NotANumber {
        /// The constant.
        name: String,
        /// What was given.
        value: String,
    },
}

impl Constants {
    /// No constants.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets a constant. The exact value is the shortest decimal that reads as `value`: 0.64 is 16/25.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), ConstantError> {
        self.insert(name, &format!("{value:e}"))
    }

    /// Sets a constant from "NAME=VALUE", VALUE a decimal number, taken exactly.
    pub fn assign(&mut self, assignment: &str) -> Result<(), ConstantError> {
        let (name, value) = assignment
            .split_once('=')
            .ok_or_else(|| ConstantError::NotAnAssignment(assignment.to_owned()))?;
        self.insert(name.trim(), value.trim())
    }

    fn insert(&mut self, name: &str, value: &str) -> Result<(), ConstantError> {
        check_name(name)?;
        let (negative, digits) = match value.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, value.strip_prefix('+').unwrap_or(value)),
        };
        let exact = parse_decimal(digits)
            .ok_or_else(|| ConstantError::NotANumber { name: name.to_owned(), value: value.to_owned() })?;
        let exact = if negative { exact.negated() } else { exact };
        match self.entries.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = exact,
            None => self.entries.push((name.to_owned(), exact)),
        }
        Ok(())
    }

    /// The nearest float to the value of a constant.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.entries.iter().find(|(known, _)| known == name).map(|(_, exact)| exact.value())
    }

    /// The names, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|(name, _)| name.as_str())
    }

    pub(super) fn value(&self, index: usize) -> &Exact {
        &self.entries[index].1
    }
}

fn check_name(name: &str) -> Result<(), ConstantError> {
    let mut chars = name.chars();
    if !chars.next().is_some_and(is_name_start) || !chars.all(is_name_part) {
        return Err(ConstantError::NotAName(name.to_owned()));
    }
    if ["x", "y", "z", "pi", "π"].contains(&name) || Function::named(name).is_some() {
        return Err(ConstantError::Reserved(name.to_owned()));
    }
    Ok(())
}
