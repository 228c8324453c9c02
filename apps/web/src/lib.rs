//! The playground's half in Rust: a session that breaks the glass before one picture, by the same chain as
//! the command, seated at the desk over which a page talks to it.
//!
//! It is: questions in JSON with bytes, answers in JSON with bytes ([`Session::answer`]).
//! It is not: a place for formulas, or for anything of the page; it knows no browser.

mod file;
mod question;
mod session;
mod trouble;

pub use question::{Hit, Question, Scene};
pub use session::Session;
pub use trouble::Trouble;

/// Seats a session at the desk; the page calls it once.
#[expect(unsafe_code, reason = "a name that a page can call")]
#[unsafe(no_mangle)]
pub extern "C" fn take_seat() {
    starbreak_web_desk::seat(Session::default());
}
