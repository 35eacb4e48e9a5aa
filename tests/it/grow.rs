//! Random programmes of every operation, reproducible from a number.

use terrane::{
    noise::mix,
    programme::{Parameter, Programme, Signature},
};

/// A stream of random numbers.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// A whole number below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// A number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / 9_007_199_254_740_992.0
    }
}

/// A programme of at most `depth` levels that the limits of size and cost allow.
pub(crate) fn programme(random: &mut Random, depth: usize) -> Programme {
    loop {
        let text = expression(random, depth);
        // Nested averages may become too large.
        if let Ok(programme) = Programme::parse(&text)
            && programme.check_cost().is_ok()
        {
            return programme;
        }
    }
}

fn expression(random: &mut Random, depth: usize) -> String {
    if random.below(6) == 0 {
        return number(random);
    }
    let fits = |signature: &&Signature| depth > 1 || signature.subtrees.is_empty();
    let all: Vec<&Signature> = Signature::all().iter().filter(fits).collect();
    let mut signature = all[random.below(all.len())];
    // An average multiplies what is below it by 19: rare, or nothing else would fit the budget.
    while signature.name == "smooth" && random.below(4) > 0 {
        signature = all[random.below(all.len())];
    }
    let mut arguments: Vec<String> = signature.subtrees.iter().map(|_| expression(random, depth - 1)).collect();
    for p in signature.parameters {
        match p.default {
            None => arguments.push(parameter(random, p)),
            Some(_) if random.below(3) == 0 => arguments.push(format!("{}={}", p.name, parameter(random, p))),
            Some(_) => {}
        }
    }
    for choice in signature.choices {
        if random.below(2) == 0 {
            arguments.push(format!("{}={}", choice.name, choice.values[random.below(choice.values.len())]));
        }
    }
    if signature.noise && random.below(4) == 0 {
        arguments.push(format!("seed={}", random.below(3)));
    }
    if arguments.is_empty() { signature.name.to_owned() } else { format!("{}({})", signature.name, arguments.join(", ")) }
}

fn number(random: &mut Random) -> String {
    match random.below(8) {
        0 => "0".to_owned(),
        1 => "-0".to_owned(),
        2 => format!("{:e}", (random.unit() - 0.5) * 1e30),
        3 => format!("{:e}", (random.unit() - 0.5) * 1e-30),
        4 => random.below(10).to_string(),
        _ => format!("{}", (random.unit() - 0.5) * 10.0),
    }
}

/// A value in the range that the parameter is used in: whole ranges would be nearly all of them extreme.
fn parameter(random: &mut Random, parameter: &Parameter) -> String {
    let (low, high) = (parameter.min.max(-10.0), parameter.max.min(if parameter.name == "octaves" { 9.0 } else { 10.0 }));
    let value = match random.below(8) {
        0 => low,
        1 if parameter.name == "octaves" => (low + random.unit() * (high - low)).floor(),
        _ => low + random.unit() * (high - low),
    };
    format!("{value}")
}
