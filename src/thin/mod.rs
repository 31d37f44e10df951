//! Long rows of samples in little room.
//!
//! | module | what stays | for |
//! |---|---|---|
//! | `extremes` | of each stretch the smallest and the largest | drawing a row that is at hand |
//! | `row` | the same, of a row that is still growing | drawing a log of any length |
//! | `sampled` | every second, fourth, … by number | percentiles, and comparing two rows at the same instants |

mod extremes;
mod row;
mod sampled;

pub(crate) use extremes::keep_extremes;
pub(crate) use row::Thinned;
pub(crate) use sampled::Sampled;
