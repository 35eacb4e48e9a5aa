//! What text and JSON have in common before names and arguments are understood.

use std::ops::Range;

/// Most arguments a call may be written with; no operation takes more.
pub(super) const MAX_ARGUMENTS: usize = 16;

/// Something written, and where.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Syntax {
    pub kind: Kind,
    /// Characters of the text; `None` in JSON.
    pub span: Option<Range<usize>>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    Number(f64),
    /// A call, or a name without arguments.
    Call(Call),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Call {
    pub name: String,
    pub name_span: Option<Range<usize>>,
    pub positional: Vec<Syntax>,
    pub named: Vec<Named>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    pub name: String,
    pub name_span: Option<Range<usize>>,
    pub value: Syntax,
}
