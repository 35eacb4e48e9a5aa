//! What a programme can be made of: every operation with its arguments, ranges and meaning.

use crate::noise::{Feature, elementary};

/// A function of one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
    /// A Gaussian bell.
    Gauss,
    /// An inclined plane.
    Plane,
    /// A step from 0 to 1.
    Step,
    /// A half sphere.
    Sphere,
    /// A function of one value.
    Unary(Unary),
    /// A function of two values.
    Binary(Binary),
    /// A value held between two others.
    Clamp,
    /// From one value to another by a third.
    Mix,
    /// One of two values by the sign of a third.
    Select,
    /// Steps with flat treads.
    Terrace,
    /// A subtree at a moved point.
    Warp,
    /// Derivative to the east.
    GradientX,
    /// Derivative to the north.
    GradientY,
    /// Length of the gradient.
    Slope,
    /// Mean over a disc.
    Smooth,
    /// Valleys cut into a terrain.
    Erosion,
    /// Blender's gradient noise.
    BlenderNoise,
    /// Perlin's noise of 1985.
    OPerlin,
    /// Perlin's noise of 2002.
    IPerlin,
    /// One value a cell.
    CellNoise,
    /// Distances to random points, measured as the feature says.
    Voronoi(Feature),
    /// The distance to the nearest point, under its general name.
    VoronoiDistance,
    /// Fractional Brownian motion.
    Fbm,
    /// Musgrave's multiplicative multifractal.
    Multifractal,
    /// Musgrave's heterogeneous terrain.
    HeteroTerrain,
    /// Musgrave's hybrid multifractal.
    HybridMultifractal,
    /// Musgrave's ridged multifractal.
    RidgedMultifractal,
    /// Perlin's turbulence.
    Turbulence,
    /// A noise distorted by another.
    DistortedNoise,
    /// A random surface with a given spectrum.
    Spectral,
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
    /// The value where it is left out; `None` if it must be given.
    pub default: Option<f64>,
}

impl Parameter {
    const fn required(name: &'static str, min: f64, max: f64) -> Self {
        Self { name, min, max, default: None }
    }

    const fn optional(name: &'static str, min: f64, max: f64, default: f64) -> Self {
        Self { name, min, max, default: Some(default) }
    }
}

/// A choice that belongs to a node, written `name=value`, or the value alone among the positional arguments.
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
    /// Numbers, which come after the subtrees: those that must be given first.
    pub parameters: &'static [Parameter],
    /// Choices with defaults.
    pub choices: &'static [Choice],
    /// Whether the node has noise lattices of its own and takes `seed=`.
    pub noise: bool,
}

/// The greatest number of a node's own seed.
pub(super) const MAX_SEED: f64 = 4_294_967_295.0;

/// The noises that fractals are made of, as `basis=` names them.
const BASIS_NAMES: &[&str] =
    &["o_perlin", "i_perlin", "blender_noise", "cell_noise", "voronoi_f1", "voronoi_f2", "voronoi_f3", "voronoi_f4", "voronoi_f2f1", "voronoi_crackle"];
const BASES: Choice = Choice { name: "basis", values: BASIS_NAMES };
const FIRST_BASIS: Choice = Choice { name: "basis1", values: BASIS_NAMES };
const SECOND_BASIS: Choice = Choice { name: "basis2", values: BASIS_NAMES };
const METRICS: Choice = Choice { name: "metric", values: &["distance", "squared", "manhattan", "chebychev", "minkowski"] };
const HARD: Choice = Choice { name: "hard", values: &["false", "true"] };
const EIGHT_DIRECTIONS: Choice = Choice { name: "direction", values: &["n", "ne", "e", "se", "s", "sw", "w", "nw"] };
const FOUR_DIRECTIONS: Choice = Choice { name: "direction", values: &["n", "e", "s", "w"] };
const EXPONENT: Parameter = Parameter::optional("exponent", 0.5, 16.0, 2.5);
const CENTRE_X: Parameter = Parameter::optional("centre_x", -1e9, 1e9, 0.0);
const CENTRE_Y: Parameter = Parameter::optional("centre_y", -1e9, 1e9, 0.0);
const REPEAT: Parameter = Parameter::optional("repeat", 0.0, 1e9, 0.0);
const H: Parameter = Parameter::required("H", 0.0, 4.0);
const LACUNARITY: Parameter = Parameter::required("lacunarity", 1.1, 8.0);
const OCTAVES: Parameter = Parameter::required("octaves", 1.0, 32.0);
const OFFSET: Parameter = Parameter::required("offset", 0.0, 8.0);
const GAIN: Parameter = Parameter::required("gain", 0.0, 32.0);
const AMPLITUDE: Parameter = Parameter::required("amplitude", 0.0, 2.0);
const FREQUENCY: Parameter = Parameter::required("frequency", 1.1, 8.0);

const fn leaf(name: &'static str, operation: Operation) -> Signature {
    Signature { name, operation, subtrees: &[], parameters: &[], choices: &[], noise: false }
}

const fn shape(name: &'static str, operation: Operation, parameters: &'static [Parameter], choices: &'static [Choice]) -> Signature {
    Signature { parameters, choices, ..leaf(name, operation) }
}

const fn noise(name: &'static str, operation: Operation, parameters: &'static [Parameter], choices: &'static [Choice]) -> Signature {
    Signature { parameters, choices, noise: true, ..leaf(name, operation) }
}

const fn voronoi(name: &'static str, operation: Operation) -> Signature {
    noise(name, operation, &[EXPONENT], &[METRICS])
}

const fn function(name: &'static str, operation: Operation, subtrees: &'static [&'static str], parameters: &'static [Parameter]) -> Signature {
    Signature { subtrees, parameters, ..leaf(name, operation) }
}

const fn unary(name: &'static str, operation: Unary) -> Signature {
    function(name, Operation::Unary(operation), &["a"], &[])
}

const fn binary(name: &'static str, operation: Binary) -> Signature {
    function(name, Operation::Binary(operation), &["a", "b"], &[])
}

/// Every operation but constants, which are written as bare numbers.
static SIGNATURES: [Signature; 51] = [
    leaf("x", Operation::X),
    leaf("y", Operation::Y),
    shape("gauss", Operation::Gauss, &[Parameter::required("width", 1e-6, 1e6), CENTRE_X, CENTRE_Y, REPEAT], &[]),
    shape("plane", Operation::Plane, &[], &[EIGHT_DIRECTIONS]),
    shape("step", Operation::Step, &[Parameter::optional("softness", 0.0, 1e6, 0.0), REPEAT], &[FOUR_DIRECTIONS]),
    shape("sphere", Operation::Sphere, &[Parameter::required("radius", 1e-6, 1e6), CENTRE_X, CENTRE_Y, REPEAT], &[]),
    noise("blender_noise", Operation::BlenderNoise, &[], &[]),
    noise("o_perlin", Operation::OPerlin, &[], &[]),
    noise("i_perlin", Operation::IPerlin, &[], &[]),
    noise("cell_noise", Operation::CellNoise, &[], &[]),
    voronoi("voronoi_f1", Operation::Voronoi(Feature::F1)),
    voronoi("voronoi_f2", Operation::Voronoi(Feature::F2)),
    voronoi("voronoi_f3", Operation::Voronoi(Feature::F3)),
    voronoi("voronoi_f4", Operation::Voronoi(Feature::F4)),
    voronoi("voronoi_f2f1", Operation::Voronoi(Feature::F2F1)),
    voronoi("voronoi_crackle", Operation::Voronoi(Feature::Crackle)),
    voronoi("voronoi", Operation::VoronoiDistance),
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
    function("clamp", Operation::Clamp, &["a", "low", "high"], &[]),
    function("mix", Operation::Mix, &["a", "b", "t"], &[]),
    function("select", Operation::Select, &["mask", "a", "b"], &[]),
    function("terrace", Operation::Terrace, &["h"], &[Parameter::required("n", 0.01, 10_000.0), Parameter::required("sharpness", 0.0, 0.99)]),
    function("warp", Operation::Warp, &["h", "dx", "dy"], &[]),
    function("gradient_x", Operation::GradientX, &["h"], &[]),
    function("gradient_y", Operation::GradientY, &["h"], &[]),
    function("slope", Operation::Slope, &["h"], &[]),
    function("smooth", Operation::Smooth, &["h"], &[Parameter::required("r", 1e-6, 1e6)]),
    Signature {
        noise: true,
        ..function(
            "erosion",
            Operation::Erosion,
            &["h"],
            &[
                Parameter::optional("strength", 0.0, 1.0, 1.0),
                Parameter::optional("scale", 1e-6, 1e6, 0.4),
                Parameter::optional("octaves", 1.0, 5.0, 3.0),
                Parameter::optional("depth", 0.0, 0.9, 0.7),
            ],
        )
    },
    noise("fbm", Operation::Fbm, &[H, LACUNARITY, OCTAVES], &[BASES]),
    noise("multifractal", Operation::Multifractal, &[H, LACUNARITY, OCTAVES], &[BASES]),
    noise("hetero_terrain", Operation::HeteroTerrain, &[H, LACUNARITY, OCTAVES, OFFSET], &[BASES]),
    noise("hybrid_multifractal", Operation::HybridMultifractal, &[H, LACUNARITY, OCTAVES, OFFSET, GAIN], &[BASES]),
    noise("ridged_multifractal", Operation::RidgedMultifractal, &[H, LACUNARITY, OCTAVES, OFFSET, GAIN], &[BASES]),
    noise("turbulence", Operation::Turbulence, &[OCTAVES, AMPLITUDE, FREQUENCY], &[HARD, BASES]),
    noise("distorted_noise", Operation::DistortedNoise, &[Parameter::required("distortion", 0.0, 10.0)], &[FIRST_BASIS, SECOND_BASIS]),
    noise("spectral", Operation::Spectral, &[Parameter::required("beta", 1.0, 3.0), Parameter::optional("octaves", 1.0, 32.0, 10.0)], &[]),
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
        let subtrees = self.subtrees.iter().map(|&name| name.to_owned());
        let parameters =
            self.parameters.iter().map(|parameter| parameter.default.map_or(parameter.name.to_owned(), |default| format!("{}={default}", parameter.name)));
        let choices = self.choices.iter().map(|choice| format!("{}={}", choice.name, choice.values[0]));
        let all: Vec<_> = subtrees.chain(parameters).chain(choices).collect();
        if all.is_empty() { self.name.to_owned() } else { format!("{}({})", self.name, all.join(", ")) }
    }
}
