//! The desk: a page lays a question on it, and finds the answer there.
//!
//! WebAssembly passes numbers alone. So the page asks for room, writes into it, calls, and reads where the
//! answer lies; no pointer is ever read on this side.

use std::cell::RefCell;

use serde_json::json;

use crate::{Answer, Session};

#[derive(Default)]
struct Desk {
    session: Session,
    question: Vec<u8>,
    bytes_in: Vec<u8>,
    answer: Vec<u8>,
    bytes_out: Vec<u8>,
}

thread_local! {
    static DESK: RefCell<Desk> = RefCell::default();
}

/// Makes room for the words of a question and tells where; the page has it until it calls.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn room_for_question(n_bytes: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| room(&mut desk.question, n_bytes))
}

/// The same for the bytes that come with it.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn room_for_bytes(n_bytes: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| room(&mut desk.bytes_in, n_bytes))
}

fn room(place: &mut Vec<u8>, n_bytes: usize) -> *mut u8 {
    place.clear();
    place.resize(n_bytes, 0);
    place.as_mut_ptr()
}

/// Answers what lies there; the words are then `{"answer": …}` or `{"trouble": "…"}`. Tells how long they are.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn ask() -> usize {
    DESK.with_borrow_mut(|desk| {
        let question = std::mem::take(&mut desk.question);
        let bytes = std::mem::take(&mut desk.bytes_in);
        let words = String::from_utf8_lossy(&question);
        let words = match desk.session.answer(&words, &bytes) {
            Ok(Answer { words, bytes }) => {
                desk.bytes_out = bytes;
                json!({ "answer": words })
            }
            Err(trouble) => {
                desk.bytes_out.clear();
                json!({ "trouble": trouble.to_string() })
            }
        };
        desk.answer = words.to_string().into_bytes();
        desk.answer.len()
    })
}

/// Where the words of the answer lie.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn words_at() -> *const u8 {
    DESK.with_borrow(|desk| desk.answer.as_ptr())
}

/// Where its bytes lie.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn bytes_at() -> *const u8 {
    DESK.with_borrow(|desk| desk.bytes_out.as_ptr())
}

/// How many there are.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn n_bytes() -> usize {
    DESK.with_borrow(|desk| desk.bytes_out.len())
}
