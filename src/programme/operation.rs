//! What a programme can be made of: every operation with its arguments, ranges and meaning.

use crate::noise::elementary;

/// A function of one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unary {
    /// sin a, radians.
    Sin,
    /// cos a, radians.
    Cos,
    /// tan a, radians.
    Tan,
    /// Arc tangent, in [-π/2, π/2].
    Atan,
    /// -a.
    Negative,
    /// |a|.
    Abs,
    /// Protected: 0 if a = 0, else ln |a|.
    Log,
    /// Protected: √|a|.
    Sqrt,
}

impl Unary {
    /// The meaning, before a result that is not finite becomes 0.
    #[inline(always)]
    #[must_use]
    pub fn apply(self, a: f32) -> f32 {
        match self {
            Unary::Sin => elementary::sin(a),
            Unary::Cos => elementary::cos(a),
            Unary::Tan => elementary::tan(a),
            Unary::Atan => elementary::atan(a),
            Unary::Negative => -a,
            Unary::Abs => a.abs(),
            Unary::Log => {
                if a == 0.0 {
                    0.0
                } else {
                    elementary::ln(a.abs())
                }
            }
            Unary::Sqrt => a.abs().sqrt(),
        }
    }
}

/// A function of two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binary {
    /// a + b.
    Plus,
    /// a - b.
    Minus,
    /// a · b.
    Multiply,
    /// Protected: a if b = 0, else a / b.
    Divide,
    /// Protected: 0 where a^b is not a number, infinite or complex.
    Power,
    /// Protected: 0 if b = 0, else a - b ⌊a / b⌋.
    Mod,
    /// b < a ? b : a.
    Min,
    /// b > a ? b : a.
    Max,
}

impl Binary {
    /// The meaning, before a result that is not finite becomes 0.
    #[inline(always)]
    #[must_use]
    pub fn apply(self, a: f32, b: f32) -> f32 {
        match self {
            Binary::Plus => a + b,
            Binary::Minus => a - b,
            Binary::Multiply => a * b,
            Binary::Divide => {
                if b == 0.0 {
                    a
                } else {
                    a / b
                }
            }
            Binary::Power => {
                let power = elementary::pow(a, b);
                if power.is_finite() { power } else { 0.0 }
            }
            Binary::Mod => {
                if b == 0.0 {
                    0.0
                } else {
                    a - b * (a / b).floor()
                }
            }
            Binary::Min => {
                if b < a {
                    b
                } else {
                    a
                }
            }
            Binary::Max => {
                if b > a {
                    b
                } else {
                    a
                }
            }
        }
    }
}

/// What stands at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// A number.
    Constant,
    /// Programme coordinate u, to the east.
    X,
    /// Programme coordinate v, to the north.
    Y,
    /// A function of one value.
    Unary(Unary),
    /// A function of two values.
    Binary(Binary),
    /// Perlin's noise of 1985.
    OPerlin,
    /// Perlin's noise of 2002.
    IPerlin,
    /// One value a cell.
    CellNoise,
    /// Distance to the nearest random point.
    VoronoiF1,
    /// Distance to the second nearest random point.
    VoronoiF2,
    /// Fractional Brownian motion.
    Fbm,
    /// Musgrave's ridged multifractal.
    RidgedMultifractal,
    /// Perlin's turbulence.
    Turbulence,
}

/// A number that belongs to a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, for writing it as `name=value`.
    pub name: &'static str,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
}

/// A choice that belongs to a node, written `name=value`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Its name.
    pub name: &'static str,
    /// What can be chosen; the first is the default.
    pub values: &'static [&'static str],
}

/// How an operation is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signature {
    /// The name in text and JSON.
    pub name: &'static str,
    /// The operation.
    pub operation: Operation,
    /// Names of the subtrees, which come first among the arguments.
    pub subtrees: &'static [&'static str],
    /// Numbers, which come after the subtrees; all are required.
    pub parameters: &'static [Parameter],
    /// Named choices with defaults.
    pub choices: &'static [Choice],
    /// Whether the node has noise lattices of its own and takes `seed=`.
    pub noise: bool,
}

/// The greatest number of a node's own seed.
pub(super) const MAX_SEED: f64 = 4_294_967_295.0;

const BASES: Choice = Choice { name: "basis", values: &["o_perlin", "i_perlin", "cell_noise", "voronoi_f1", "voronoi_f2"] };
const METRICS: Choice = Choice { name: "metric", values: &["distance", "squared", "manhattan", "chebychev"] };
const HARD: Choice = Choice { name: "hard", values: &["false", "true"] };
const H: Parameter = Parameter { name: "H", min: 0.0, max: 4.0 };
const LACUNARITY: Parameter = Parameter { name: "lacunarity", min: 1.1, max: 8.0 };
const OCTAVES: Parameter = Parameter { name: "octaves", min: 1.0, max: 32.0 };
const OFFSET: Parameter = Parameter { name: "offset", min: 0.0, max: 8.0 };
const GAIN: Parameter = Parameter { name: "gain", min: 0.0, max: 32.0 };
const AMPLITUDE: Parameter = Parameter { name: "amplitude", min: 0.0, max: 2.0 };
const FREQUENCY: Parameter = Parameter { name: "frequency", min: 1.1, max: 8.0 };

const fn leaf(name: &'static str, operation: Operation) -> Signature {
    Signature { name, operation, subtrees: &[], parameters: &[], choices: &[], noise: false }
}

const fn noise(name: &'static str, operation: Operation, parameters: &'static [Parameter], choices: &'static [Choice]) -> Signature {
    Signature { parameters, choices, noise: true, ..leaf(name, operation) }
}

const fn unary(name: &'static str, operation: Unary) -> Signature {
    Signature { subtrees: &["a"], ..leaf(name, Operation::Unary(operation)) }
}

const fn binary(name: &'static str, operation: Binary) -> Signature {
    Signature { subtrees: &["a", "b"], ..leaf(name, Operation::Binary(operation)) }
}

/// Every operation but constants, which are written as bare numbers.
static SIGNATURES: [Signature; 26] = [
    leaf("x", Operation::X),
    leaf("y", Operation::Y),
    noise("o_perlin", Operation::OPerlin, &[], &[]),
    noise("i_perlin", Operation::IPerlin, &[], &[]),
    noise("cell_noise", Operation::CellNoise, &[], &[]),
    noise("voronoi_f1", Operation::VoronoiF1, &[], &[METRICS]),
    noise("voronoi_f2", Operation::VoronoiF2, &[], &[METRICS]),
    binary("plus", Binary::Plus),
    binary("minus", Binary::Minus),
    binary("multiply", Binary::Multiply),
    binary("divide", Binary::Divide),
    binary("power", Binary::Power),
    binary("mod", Binary::Mod),
    binary("min", Binary::Min),
    binary("max", Binary::Max),
    unary("sin", Unary::Sin),
    unary("cos", Unary::Cos),
    unary("tan", Unary::Tan),
    unary("atan", Unary::Atan),
    unary("negative", Unary::Negative),
    unary("abs", Unary::Abs),
    unary("log", Unary::Log),
    unary("sqrt", Unary::Sqrt),
    noise("fbm", Operation::Fbm, &[H, LACUNARITY, OCTAVES], &[BASES]),
    noise("ridged_multifractal", Operation::RidgedMultifractal, &[H, LACUNARITY, OCTAVES, OFFSET, GAIN], &[BASES]),
    noise("turbulence", Operation::Turbulence, &[OCTAVES, AMPLITUDE, FREQUENCY], &[HARD, BASES]),
];

impl Signature {
    /// All signatures.
    #[must_use]
    pub fn all() -> &'static [Signature] {
        &SIGNATURES
    }

    /// The signature of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Signature> {
        SIGNATURES.iter().find(|signature| signature.name == name)
    }

    /// The signature of an operation; `None` for a constant.
    #[must_use]
    pub fn of(operation: Operation) -> Option<&'static Signature> {
        SIGNATURES.iter().find(|signature| signature.operation == operation)
    }

    /// How a call is written: `fbm(H, lacunarity, octaves, basis=o_perlin)`.
    #[must_use]
    pub fn usage(&self) -> String {
        let positional = self.subtrees.iter().copied().chain(self.parameters.iter().map(|p| p.name)).map(str::to_owned);
        let choices = self.choices.iter().map(|choice| format!("{}={}", choice.name, choice.values[0]));
        let all: Vec<_> = positional.chain(choices).collect();
        if all.is_empty() { self.name.to_owned() } else { format!("{}({})", self.name, all.join(", ")) }
    }
}
