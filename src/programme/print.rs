//! Canonical text.

use super::{node::Node, operation::Signature};
use std::fmt;

/// Writes the canonical text: arguments in the order of the signature, defaults left out, terminals without parentheses.
impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(signature) = Signature::of(self.operation) else { return write!(f, "{}", self.value.parameters[0]) };
        f.write_str(signature.name)?;
        let mut separator = "(";
        for child in &self.children {
            write!(f, "{separator}{child}")?;
            separator = ", ";
        }
        for (parameter, number) in signature.parameters.iter().zip(&self.value.parameters) {
            match parameter.default {
                None => write!(f, "{separator}{number}")?,
                Some(default) if default != *number => write!(f, "{separator}{}={number}", parameter.name)?,
                Some(_) => continue,
            }
            separator = ", ";
        }
        for (choice, &chosen) in signature.choices.iter().zip(&self.value.choices) {
            if chosen != 0 {
                write!(f, "{separator}{}={}", choice.name, choice.values[chosen])?;
                separator = ", ";
            }
        }
        if let Some(seed) = self.value.seed {
            write!(f, "{separator}seed={seed}")?;
            separator = ", ";
        }
        f.write_str(if separator == "(" { "" } else { ")" })
    }
}
