//! The desk: a page lays a question on it, and finds the answer there.
//!
//! WebAssembly passes numbers alone. So the page asks for room, writes into it, calls, and reads where the
//! answer lies; no pointer is ever read on this side. Whoever answers is seated by the module's own `take_seat`.
//!
//! It is: six functions that a page can call, for any module.
//! It is not: anything that knows what is asked.
#![expect(
    unsafe_code,
    reason = "names that a page can call; no pointer is read here"
)]

use std::cell::RefCell;

use serde_json::{Value, json};

/// What a question comes to: words, and bytes with some.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// JSON.
    pub words: Value,
    /// Pixels, a file or numbers, as the question says.
    pub bytes: Vec<u8>,
}

/// Somebody who answers.
pub trait Answers {
    /// The answer to a question in JSON, which may come with bytes.
    ///
    /// # Errors
    /// What is wrong, for a person.
    fn answer(&mut self, words: &str, bytes: Vec<u8>) -> Result<Answer, String>;
}

#[derive(Default)]
struct Desk {
    seated: Option<Box<dyn Answers>>,
    question: Vec<u8>,
    bytes_in: Vec<u8>,
    answer: Vec<u8>,
    bytes_out: Vec<u8>,
}

thread_local! {
    static DESK: RefCell<Desk> = RefCell::default();
}

/// Whoever answers from now on.
pub fn seat(answers: impl Answers + 'static) {
    DESK.with_borrow_mut(|desk| desk.seated = Some(Box::new(answers)));
}

/// Makes room for the words of a question and tells where; the page has it until it calls.
#[unsafe(no_mangle)]
pub extern "C" fn room_for_question(n_bytes: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| room(&mut desk.question, n_bytes))
}

/// The same for the bytes that come with it.
#[unsafe(no_mangle)]
pub extern "C" fn room_for_bytes(n_bytes: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| room(&mut desk.bytes_in, n_bytes))
}

fn room(place: &mut Vec<u8>, n_bytes: usize) -> *mut u8 {
    place.clear();
    place.resize(n_bytes, 0);
    place.as_mut_ptr()
}

/// Answers what lies there; the words are then `{"answer": …}` or `{"trouble": "…"}`. Tells how long they are.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> usize {
    DESK.with_borrow_mut(|desk| {
        let question = std::mem::take(&mut desk.question);
        let bytes = std::mem::take(&mut desk.bytes_in);
        let words = String::from_utf8_lossy(&question);
        let given = match &mut desk.seated {
            Some(seated) => seated.answer(&words, bytes),
            None => Err("nobody is seated at this desk: call `take_seat` first".to_owned()),
        };
        let words = match given {
            Ok(Answer { words, bytes }) => {
                desk.bytes_out = bytes;
                json!({ "answer": words })
            }
            Err(trouble) => {
                desk.bytes_out.clear();
                json!({ "trouble": trouble })
            }
        };
        desk.answer = words.to_string().into_bytes();
        desk.answer.len()
    })
}

/// Where the words of the answer lie.
#[unsafe(no_mangle)]
pub extern "C" fn words_at() -> *const u8 {
    DESK.with_borrow(|desk| desk.answer.as_ptr())
}

/// Where its bytes lie.
#[unsafe(no_mangle)]
pub extern "C" fn bytes_at() -> *const u8 {
    DESK.with_borrow(|desk| desk.bytes_out.as_ptr())
}

/// How many there are.
#[unsafe(no_mangle)]
pub extern "C" fn n_bytes() -> usize {
    DESK.with_borrow(|desk| desk.bytes_out.len())
}
