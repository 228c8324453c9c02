//! The whole chain of the physical optics against profiles that Mitsuba 3.9.1 traced.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../examples/chain.rs"]
#[expect(dead_code, reason = "the example's own main")]
mod chain;

#[test]
fn profiles_across_cracks_are_those_that_were_traced() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../validation/mitsuba/profiles.json"
    );
    let off = chain::compare_all(path, false).unwrap();
    assert!(off.is_empty(), "off: {off:?}");
}
