//! Promises of what is bred.

mod breeding;
mod fitness;
