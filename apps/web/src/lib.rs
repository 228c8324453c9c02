//! The playground's half in Rust: a session that breaks the glass before one picture, by the same chain as
//! the command, and the desk over which a page talks to it.
//!
//! It is: questions in JSON with bytes, answers in JSON with bytes ([`Session::answer`]).
//! It is not: a place for formulas, or for anything of the page; it knows no browser.

#[expect(
    unsafe_code,
    reason = "names that a page can call; no pointer is read here"
)]
mod desk;
mod file;
mod question;
mod session;
mod trouble;

pub use question::{Hit, Question, Scene};
pub use session::{Answer, Session};
pub use trouble::Trouble;
