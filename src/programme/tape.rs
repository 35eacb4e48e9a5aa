//! A programme as a list of instructions over registers.

use super::{
    Frame,
    evaluate::Evaluation,
    node::Node,
    operation::{Binary, Operation, Unary},
};
use crate::{geometry::Window, noise::Isa};

/// One step of a tape. Registers hold a block of samples each.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Instruction {
    /// Fills register `to` with a number.
    Constant { to: usize, value: f32 },
    /// Programme coordinate u.
    X { to: usize },
    /// Programme coordinate v.
    Y { to: usize },
    /// The noise of number `noise`.
    Noise { to: usize, noise: usize },
    /// In place.
    Unary { operation: Unary, at: usize },
    /// Register `at` and the next one, into `at`.
    Binary { operation: Binary, at: usize },
    /// Register `at` and a number.
    BinaryRight { operation: Binary, at: usize, right: f32 },
    /// A number and register `at`.
    BinaryLeft { operation: Binary, left: f32, at: usize },
}

/// A compiled programme.
///
/// ```
/// use terrane::{geometry::{Filter, Window}, programme::{Frame, Programme, Tape}};
/// let tape = Tape::compile(Programme::parse("multiply(2, x)")?.root());
/// let frame = Frame { seed: 7, scale: 100.0, origin: [0.0, 0.0] };
/// let window = Window::area([0.0, 0.0, 300.0, 100.0], 100.0, Filter::Band, 100)?;
/// let mut heights = [0.0; 3];
/// tape.evaluate(&frame, &window, &mut heights);
/// assert_eq!(heights, [1.0, 3.0, 5.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Tape {
    pub(super) instructions: Vec<Instruction>,
    /// Nodes with noise, in the order of the programme's text.
    pub(super) noises: Vec<Node>,
    /// Registers needed.
    pub(super) registers: usize,
    /// Results of folded constants that were not finite: they count once a sample.
    pub(super) folded_non_finite: u64,
}

impl Tape {
    /// Compiles a programme. Subtrees of constants alone are evaluated here, by the same functions, to the same bits.
    #[must_use]
    pub fn compile(root: &Node) -> Self {
        let mut tape = Self { instructions: Vec::new(), noises: Vec::new(), registers: 1, folded_non_finite: 0 };
        if let Operand::Number(value) = tape.node(root, 0) {
            tape.instructions.push(Instruction::Constant { to: 0, value });
        }
        tape
    }

    /// Evaluates a window into `out`, row by row from north to south; answers how many node results were not finite and became 0.
    ///
    /// # Panics
    /// If `out` has not one element a sample.
    pub fn evaluate(&self, frame: &Frame, window: &Window, out: &mut [f32]) -> u64 {
        self.evaluate_on(Isa::active(), frame, window, out)
    }

    /// As [`Tape::evaluate`], on a given instruction set: the same bits, in another time.
    ///
    /// # Panics
    /// If `out` has not one element a sample.
    pub fn evaluate_on(&self, isa: Isa, frame: &Frame, window: &Window, out: &mut [f32]) -> u64 {
        assert_eq!(out.len(), window.samples(), "one element a sample");
        Evaluation::new(isa, self, frame, window).run(window, out)
    }

    /// Compiles a node so that its value lands in register `to`, unless it is a number.
    fn node(&mut self, node: &Node, to: usize) -> Operand {
        self.registers = self.registers.max(to + 1);
        match node.operation {
            Operation::Constant => return self.number(node.value.parameters[0] as f32),
            Operation::X => self.instructions.push(Instruction::X { to }),
            Operation::Y => self.instructions.push(Instruction::Y { to }),
            Operation::Unary(operation) => return self.unary(operation, node, to),
            Operation::Binary(operation) => return self.binary(operation, node, to),
            _ => {
                self.instructions.push(Instruction::Noise { to, noise: self.noises.len() });
                self.noises.push(node.clone());
            }
        }
        Operand::Register
    }

    fn unary(&mut self, operation: Unary, node: &Node, to: usize) -> Operand {
        if let Operand::Number(value) = self.node(&node.children[0], to) {
            return self.number(operation.apply(value));
        }
        self.instructions.push(Instruction::Unary { operation, at: to });
        Operand::Register
    }

    fn binary(&mut self, operation: Binary, node: &Node, to: usize) -> Operand {
        let left = self.node(&node.children[0], to);
        let right = self.node(&node.children[1], if left == Operand::Register { to + 1 } else { to });
        self.instructions.push(match (left, right) {
            (Operand::Number(left), Operand::Number(right)) => return self.number(operation.apply(left, right)),
            (Operand::Number(left), Operand::Register) => Instruction::BinaryLeft { operation, left, at: to },
            (Operand::Register, Operand::Number(right)) => Instruction::BinaryRight { operation, at: to, right },
            (Operand::Register, Operand::Register) => Instruction::Binary { operation, at: to },
        });
        Operand::Register
    }

    fn number(&mut self, value: f32) -> Operand {
        if value.is_finite() {
            return Operand::Number(value);
        }
        self.folded_non_finite += 1;
        Operand::Number(0.0)
    }
}

/// Where a compiled node's value is.
#[derive(Clone, Copy, PartialEq)]
enum Operand {
    Number(f32),
    Register,
}
