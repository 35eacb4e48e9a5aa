//! Programmes as they are bred: their nodes in the order of the text, so that a subtree is a slice.

use crate::programme::{Node, Operation, ParseError, Programme, Signature, Value};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use std::{fmt, ops::Range};

/// A node of a programme without what is below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Gene {
    /// What stands there; a number where there is no signature.
    pub(super) signature: Option<&'static Signature>,
    /// Its parameters, choices and seed.
    pub(super) value: Value,
}

impl Gene {
    /// A number.
    pub(super) fn number(number: f64) -> Self {
        Self { signature: None, value: Value { parameters: vec![number], choices: Vec::new(), seed: None } }
    }

    /// How many subtrees follow it.
    #[must_use]
    pub fn arity(&self) -> usize {
        self.signature.map_or(0, |signature| signature.subtrees.len())
    }
}

/// A terrain programme to be bred: its genes, every one followed by its subtrees.
///
/// ```
/// use terrane::evolve::Genome;
/// let genome = Genome::parse("plus(fbm(1, 2, 8, seed=5), multiply(0.3, x))")?;
/// assert_eq!((genome.size(), genome.depth()), (5, 3));
/// assert_eq!(genome.to_string(), "plus(fbm(1, 2, 8, seed=5), multiply(0.3, x))");
/// # Ok::<(), terrane::programme::ParseError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Genome {
    genes: Vec<Gene>,
}

impl Genome {
    /// Genes that are a tree in the order of its text.
    pub(super) fn new(genes: Vec<Gene>) -> Self {
        Self { genes }
    }

    /// Reads programme text.
    ///
    /// # Errors
    /// If the text is not a programme or breaks a limit; the error names the place.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        Programme::parse(text).map(|programme| Self::of(&programme))
    }

    /// The genes of a programme.
    #[must_use]
    pub fn of(programme: &Programme) -> Self {
        let mut genes = Vec::with_capacity(programme.root().size());
        gather(programme.root(), &mut genes);
        Self { genes }
    }

    /// The programme.
    ///
    /// # Errors
    /// If it breaks a limit of programmes, as what is bred within a [`Budget`](super::Budget) never does.
    pub fn programme(&self) -> Result<Programme, ParseError> {
        Programme::parse(&self.to_string())
    }

    /// The genes in the order of the text.
    #[must_use]
    pub fn genes(&self) -> &[Gene] {
        &self.genes
    }

    pub(super) fn genes_mut(&mut self) -> &mut [Gene] {
        &mut self.genes
    }

    /// Number of nodes.
    #[must_use]
    pub fn size(&self) -> usize {
        self.genes.len()
    }

    /// Nodes on the longest way to a leaf.
    #[must_use]
    pub fn depth(&self) -> usize {
        // Subtrees that are still to come, level by level.
        let (mut open, mut deepest) = (Vec::new(), 0);
        for gene in &self.genes {
            deepest = deepest.max(open.len() + 1);
            open.push(gene.arity());
            while open.last() == Some(&0) {
                open.pop();
                if let Some(left) = open.last_mut() {
                    *left -= 1;
                }
            }
        }
        deepest
    }

    /// The genes of the subtree that begins at a gene.
    #[must_use]
    pub fn subtree(&self, at: usize) -> Range<usize> {
        let (mut end, mut open) = (at, 1);
        while open > 0 && end < self.genes.len() {
            open += self.genes[end].arity();
            open -= 1;
            end += 1;
        }
        at..end
    }

    /// The same with other genes in the place of a subtree.
    pub(super) fn with(&self, subtree: Range<usize>, genes: &[Gene]) -> Self {
        Self { genes: [&self.genes[..subtree.start], genes, &self.genes[subtree.end..]].concat() }
    }
}

fn gather(node: &Node, genes: &mut Vec<Gene>) {
    let signature = if node.operation() == Operation::Constant { None } else { Signature::of(node.operation()) };
    genes.push(Gene { signature, value: node.value().clone() });
    node.children().iter().for_each(|child| gather(child, genes));
}

/// Writes the canonical text.
impl fmt::Display for Genome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Genes whose parentheses are open, with the subtrees that are still to come.
        let mut open: Vec<(&Gene, usize)> = Vec::new();
        for gene in &self.genes {
            match gene.signature {
                None => write!(f, "{}", gene.value.parameters[0])?,
                Some(signature) => f.write_str(signature.name)?,
            }
            if gene.arity() > 0 {
                f.write_str("(")?;
                open.push((gene, gene.arity()));
                continue;
            }
            write_arguments(gene, f)?;
            while let Some((gene, left)) = open.last_mut() {
                *left -= 1;
                if *left > 0 {
                    f.write_str(", ")?;
                    break;
                }
                write_arguments(gene, f)?;
                open.pop();
            }
        }
        Ok(())
    }
}

/// What stands in a gene's parentheses after its subtrees, and their end.
fn write_arguments(gene: &Gene, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let Some(signature) = gene.signature else { return Ok(()) };
    let mut separator = if gene.arity() > 0 { ", " } else { "(" };
    for (parameter, number) in signature.parameters.iter().zip(&gene.value.parameters) {
        match parameter.default {
            None => write!(f, "{separator}{number}")?,
            Some(default) if default != *number => write!(f, "{separator}{}={number}", parameter.name)?,
            Some(_) => continue,
        }
        separator = ", ";
    }
    for (choice, &chosen) in signature.choices.iter().zip(&gene.value.choices).filter(|(_, chosen)| **chosen != 0) {
        write!(f, "{separator}{}={}", choice.name, choice.values[chosen])?;
        separator = ", ";
    }
    if let Some(seed) = gene.value.seed {
        write!(f, "{separator}seed={seed}")?;
        separator = ", ";
    }
    f.write_str(if separator == "(" { "" } else { ")" })
}

/// As programme text.
impl Serialize for Genome {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Genome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).map_err(D::Error::custom)
    }
}
