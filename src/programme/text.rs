//! Programme text: prefix calls such as `plus(fbm(1.0, 1.97, 2, basis=o_perlin), multiply(0.3, x))`.

use super::{
    MAX_DEPTH, MAX_NODES,
    error::ParseError,
    syntax::{Call, Kind, MAX_ARGUMENTS, Named, Syntax},
};
use std::ops::Range;

pub(super) fn parse(text: &str) -> Result<Syntax, ParseError> {
    let mut parser = Parser { characters: text.chars().collect(), at: 0, path: Vec::new(), calls: 0 };
    parser.space();
    if parser.peek().is_none() {
        return Err(parser.error(0..0, "the programme is empty; write an expression such as fbm(1, 2, 8)"));
    }
    let root = parser.expression()?;
    parser.space();
    match parser.peek() {
        None => Ok(root),
        Some(_) => Err(parser.error(parser.at..parser.characters.len(), format!("expected the end of the programme, found {}", parser.found()))),
    }
}

struct Parser {
    characters: Vec<char>,
    at: usize,
    /// Steps from the root to the expression being read.
    path: Vec<String>,
    calls: usize,
}

impl Parser {
    fn peek(&self) -> Option<char> {
        self.characters.get(self.at).copied()
    }

    fn space(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// Skips space, then takes `c` if it comes next.
    fn take(&mut self, c: char) -> bool {
        self.space();
        let found = self.peek() == Some(c);
        self.at += usize::from(found);
        found
    }

    fn error(&self, span: Range<usize>, message: impl Into<String>) -> ParseError {
        ParseError::new(self.path.concat(), Some(span), message)
    }

    /// What comes next, for an error; with the function to write where it is an operator.
    fn found(&self) -> String {
        let Some(c) = self.peek() else { return "the end of the programme".to_owned() };
        let function = match c {
            '+' => "plus",
            '-' => "minus",
            '*' => "multiply",
            '/' => "divide",
            '^' => "power",
            '%' => "mod",
            _ => return format!("{c:?}"),
        };
        format!("{c:?}: operators are written as functions, {function}(a, b)")
    }

    fn here(&self) -> Range<usize> {
        self.at..(self.at + 1).min(self.characters.len()).max(self.at)
    }

    fn expression(&mut self) -> Result<Syntax, ParseError> {
        self.space();
        let start = self.at;
        match self.peek() {
            Some(c) if c.is_ascii_alphabetic() || c == '_' => {
                let name = self.word();
                self.call(name, start..self.at)
            }
            Some(c) if c.is_ascii_digit() || matches!(c, '-' | '+' | '.') => {
                let number = self.number()?;
                Ok(Syntax { kind: Kind::Number(number), span: Some(start..self.at) })
            }
            _ => Err(self.error(self.here(), format!("expected a number, a name or a call such as fbm(1, 2, 8), found {}", self.found()))),
        }
    }

    fn word(&mut self) -> String {
        let start = self.at;
        while self.peek().is_some_and(|c| c.is_ascii_alphanumeric() || c == '_') {
            self.at += 1;
        }
        self.characters[start..self.at].iter().collect()
    }

    fn number(&mut self) -> Result<f64, ParseError> {
        let start = self.at;
        while let Some(c) = self.peek() {
            let signed = matches!(c, '-' | '+') && (self.at == start || matches!(self.characters[self.at - 1], 'e' | 'E'));
            if !(c.is_ascii_alphanumeric() || c == '.' || signed) {
                break;
            }
            self.at += 1;
        }
        let written: String = self.characters[start..self.at].iter().collect();
        match written.parse::<f64>() {
            // "inf" and "nan" would parse, but a number starts with a digit, a sign or a point.
            Ok(number) if number.is_finite() => Ok(number + 0.0),
            Ok(_) => Err(self.error(start..self.at, format!("{written} is too large for a number"))),
            Err(_) => Err(self.error(start..self.at, format!("{written:?} is not a number"))),
        }
    }

    fn call(&mut self, name: String, name_span: Range<usize>) -> Result<Syntax, ParseError> {
        self.calls += 1;
        if self.calls > MAX_NODES {
            return Err(self.error(name_span, format!("more than {MAX_NODES} nodes")));
        }
        if self.path.len() >= MAX_DEPTH {
            return Err(self.error(name_span, format!("nested deeper than {MAX_DEPTH} nodes")));
        }
        let mut call = Call { name, name_span: Some(name_span.clone()), positional: Vec::new(), named: Vec::new() };
        if self.take('(') {
            if !self.take(')') {
                self.arguments(&mut call)?;
            }
        } else {
            // The look past the space after a bare name is not part of it.
            self.at = name_span.end;
        }
        Ok(Syntax { kind: Kind::Call(call), span: Some(name_span.start..self.at) })
    }

    /// Reads arguments up to and with the closing parenthesis.
    fn arguments(&mut self, call: &mut Call) -> Result<(), ParseError> {
        loop {
            self.argument(call)?;
            if self.take(')') {
                return Ok(());
            }
            if !self.take(',') {
                return Err(self.error(self.here(), format!("expected \",\" or \")\" in the arguments of {}, found {}", call.name, self.found())));
            }
        }
    }

    fn argument(&mut self, call: &mut Call) -> Result<(), ParseError> {
        self.space();
        let start = self.at;
        if call.positional.len() + call.named.len() >= MAX_ARGUMENTS {
            return Err(self.error(self.here(), format!("more than {MAX_ARGUMENTS} arguments of {}", call.name)));
        }
        if self.peek().is_some_and(|c| c.is_ascii_alphabetic() || c == '_') {
            let name = self.word();
            let name_span = start..self.at;
            if self.take('=') {
                self.path.push(format!("/{name}"));
                let value = self.expression()?;
                self.path.pop();
                call.named.push(Named { name, name_span: Some(name_span), value });
                return Ok(());
            }
            self.at = start;
        }
        if !call.named.is_empty() {
            return Err(self.error(self.here(), "positional arguments come before named ones"));
        }
        self.path.push(format!("/args/{}", call.positional.len()));
        let value = self.expression()?;
        self.path.pop();
        call.positional.push(value);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::programme::{MAX_DEPTH, Programme};

    /// The canonical text, or the error with the characters it marks.
    fn check(text: &str, expected: &str) {
        let got = match Programme::parse(text) {
            Ok(programme) => programme.to_string(),
            Err(error) => {
                let span = error.span.clone().unwrap_or_default();
                let marked: String = text.chars().skip(span.start).take(span.len()).collect();
                format!("{error} [{marked}]")
            }
        };
        assert_eq!(got, expected, "{text}");
    }

    #[test]
    fn programmes_print_canonically() {
        check("log(log(log(log(log(log(log(fbm(1.0, 1.97, 2))))))))", "log(log(log(log(log(log(log(fbm(1, 1.97, 2))))))))");
        check("plus(fbm(1.0, 1.97, 2, basis=o_perlin), multiply(0.3, x))", "plus(fbm(1, 1.97, 2), multiply(0.3, x))");
        check(" plus (\n x() ,\t-2.5e-1 ) ", "plus(x, -0.25)");
        check("fbm(octaves=8, lacunarity=2, H=0.5)", "fbm(0.5, 2, 8)");
        check("turbulence(4, 0.5, 2, hard=true, basis=voronoi_f1, seed=3)", "turbulence(4, 0.5, 2, hard=true, basis=voronoi_f1, seed=3)");
        check("voronoi_f2(metric=distance)", "voronoi_f2");
        check("minus(b=x, a=y)", "minus(y, x)");
        check("-0", "0");
    }

    #[test]
    fn errors_name_the_place_and_what_would_be_right() {
        check("", "the programme is empty; write an expression such as fbm(1, 2, 8) []");
        check("plus(x, fmb(1, 2, 8))", "at /args/1: unknown function \"fmb\" (did you mean \"fbm\"?) [fmb]");
        check("sin(é)", "at /args/0: expected a number, a name or a call such as fbm(1, 2, 8), found 'é' [é]");
        check("plus(x)", "plus lacks its argument \"b\": plus(a, b) [plus(x)]");
        check("sin(x, y)", "sin takes 1 argument, got 2: sin(a) [sin(x, y)]");
        check("fbm(1, 2, 80)", "at /args/2: octaves must be 1 … 32, got 80 [80]");
        check("fbm(1, x, 8)", "at /args/1: lacunarity must be a number (1.1 … 8), not \"x\": parameters are plain numbers [x]");
        check(
            "fbm(1, 2, 8, basis=perlin)",
            "at /basis: basis must be one of o_perlin, i_perlin, blender_noise, cell_noise, voronoi_f1, voronoi_f2, voronoi_f3, voronoi_f4, voronoi_f2f1, voronoi_crackle, got \"perlin\" (did you mean \"o_perlin\"?) [perlin]",
        );
        check(
            "fbm(1, 2, 8, octave=3)",
            "at /octave: fbm has no argument \"octave\" (did you mean \"octaves\"?): fbm(H, lacunarity, octaves, basis=o_perlin) [octave]",
        );
        check("fbm(1, 2, 8, octaves=3)", "at /octaves: \"octaves\" is given twice [octaves]");
        check("plus(x, y", "expected \",\" or \")\" in the arguments of plus, found the end of the programme []");
        check("x y", "expected the end of the programme, found 'y' [y]");
        check("x + y", "expected the end of the programme, found '+': operators are written as functions, plus(a, b) [+ y]");
        check("sin(x * y)", "expected \",\" or \")\" in the arguments of sin, found '*': operators are written as functions, multiply(a, b) [*]");
        check("plus(1.2.3, x)", "at /args/0: \"1.2.3\" is not a number [1.2.3]");
        check("multiply(1e39, x)", "at /args/0: 1e39 is too large: values are f32, at most ±3.4e38 [1e39]");
        check("1e999", "1e999 is too large for a number [1e999]");
        check("o_perlin(seed=1.5)", "at /seed: seed must be a whole number, got 1.5 [1.5]");
    }

    #[test]
    fn limits_are_errors_and_not_crashes() {
        let nested = |depth: usize| format!("{}x{}", "abs(".repeat(depth), ")".repeat(depth));
        assert!(Programme::parse(&nested(MAX_DEPTH - 1)).is_ok());
        let error = Programme::parse(&nested(MAX_DEPTH)).expect_err("too deep");
        assert_eq!(error.message, "nested deeper than 256 nodes");
        assert!(Programme::parse(&nested(1_000_000)).is_err());
        let wide = |levels: u32| (0..levels).fold("x".to_owned(), |inner, _| format!("plus({inner}, {inner})"));
        assert!(Programme::parse(&wide(11)).is_ok(), "4,095 nodes");
        assert_eq!(Programme::parse(&wide(12)).expect_err("8,191 nodes").message, "more than 4096 nodes");
        let numbers = format!("sin({})", vec!["1"; 100_000].join(","));
        assert_eq!(Programme::parse(&numbers).expect_err("too many").message, "more than 16 arguments of sin");
        let costly = (0..60).fold("x".to_owned(), |inner, _| format!("plus({inner}, ridged_multifractal(1, 2, 32, 1, 2, basis=voronoi_f2))"));
        let costly = Programme::parse(&costly).expect("within the limits of size");
        assert!(costly.check_cost().expect_err("too costly").message.contains("more than the 6500 ns allowed"));
    }
}
