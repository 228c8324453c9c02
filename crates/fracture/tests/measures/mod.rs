//! Measures of broken panes that tests and the table of laws share.

pub(crate) mod network;
pub(crate) mod panes;
pub(crate) mod star;
