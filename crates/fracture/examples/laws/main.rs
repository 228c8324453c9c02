//! The table of laws: what is published or known in closed form, and what comes out.
//!
//! `cargo run --release --package starbreak-fracture --example laws [GROUP]...` with the groups
//! plate, tips, dice, broken, stars; all of them without one. Ends with 1 if a law does not hold.
#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

use std::error::Error;
use std::process::ExitCode;

mod broken;
mod dice;
mod plate;
mod stars;
mod table;
mod tips;

#[path = "../../tests/measures/dice.rs"]
mod areas;
#[path = "../../tests/measures/mod.rs"]
mod measures;

use table::Measure;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let groups: [(&str, Measure); 5] = [
        ("plate", plate::rows),
        ("tips", tips::rows),
        ("dice", dice::rows),
        ("broken", broken::rows),
        ("stars", stars::rows),
    ];
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let mut rows = Vec::new();
    for (name, make) in groups {
        if asked.is_empty() || asked.iter().any(|group| group == name) {
            rows.extend(make()?);
        }
    }
    print!("{}", table::text(&rows));
    let n_failed = rows.iter().filter(|row: &&table::Row| row.fails()).count();
    println!("{n_failed} of {} rows fail", rows.len());
    Ok(if n_failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
