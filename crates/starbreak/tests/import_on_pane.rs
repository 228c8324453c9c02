//! A network that was drawn over a frame, put on the pane before the camera.
#![expect(clippy::unwrap_used, reason = "a test that cannot read has failed")]

use starbreak::glass::{CrackNetwork, LengthUnit};
use starbreak::import::parse_network;
use starbreak::{Error, Recipe, Settings, pipeline};

const SIZE: (u32, u32) = (1242, 375);

fn drawn() -> CrackNetwork {
    let text = r#"<svg xmlns="http://www.w3.org/2000/svg" width="621" height="375"><path class="ring" d="M300 150L330 200L310 240M290 200H350" stroke="red"/><circle class="impact" cx="310" cy="190" r="3"/></svg>"#;
    parse_network(text).unwrap()
}

fn settings(sets: &[&str]) -> Settings {
    let mut recipe = Recipe::preset("windshield-star").unwrap();
    for set in sets {
        recipe.set(set).unwrap();
    }
    recipe.settings().unwrap()
}

#[test]
fn what_was_drawn_appears_where_it_was_drawn() {
    let (drawn, settings) = (drawn(), settings(&[]));
    let placed = pipeline::onto_pane(&settings, &drawn, SIZE).unwrap();
    placed.check_invariants().unwrap();
    assert_eq!(placed.data().unit, LengthUnit::Mm, "unit");
    assert_eq!(
        placed.data().segments.kind,
        drawn.data().segments.kind,
        "kinds"
    );
    let view = pipeline::view_of_network(&settings, &placed, SIZE).unwrap();
    let seen = |x: f64, y: f64| view.project([x, y]).unwrap();
    assert_eq!(placed.n_segments(), drawn.n_segments(), "segments");
    for idx in 0..drawn.n_segments() {
        let [a, b, c, d] = drawn.ends(idx);
        let [e, f, g, h] = placed.ends(idx);
        // The page is half as wide as the frame.
        for ([x, y], [u, v]) in [([2.0 * a, b], seen(e, f)), ([2.0 * c, d], seen(g, h))] {
            let off = (u - x).hypot(v - y);
            // Nodes lie on a lattice of some 2⁻²⁶ of the pane, 10⁻⁴ px here.
            assert!(off < 1e-3, "segment {idx} at ({u}, {v}) for ({x}, {y})");
        }
    }
    let [hit, drawn_hit] = [&placed, &drawn].map(|network| &network.data().impacts[0]);
    let [u, v] = seen(hit.x, hit.y);
    let off = (u - 2.0 * drawn_hit.x).hypot(v - drawn_hit.y);
    assert!(off < 1e-3, "the impact at ({u}, {v})");
    // A line of 120 px at f = 721.5 px: some 10 to 100 mm on a pane 0.2 to 1 m away.
    let length = placed.summary().total_length;
    assert!((10.0..500.0).contains(&length), "{length} mm of cracks");
    let again = pipeline::onto_pane(&settings, &placed, SIZE).unwrap();
    assert_eq!(again, placed, "a network in mm stays as it is");
}

#[test]
fn cracks_that_no_glass_is_behind_are_refused() {
    let corner = settings(&["glass.axis_at=[0,0]"]);
    let refused = pipeline::onto_pane(&corner, &drawn(), SIZE).unwrap_err();
    assert!(matches!(refused, Error::CracksOffGlass { .. }), "{refused}");
    let paper = Recipe::preset("paper").unwrap().settings().unwrap();
    let refused = pipeline::onto_pane(&paper, &drawn(), SIZE).unwrap_err();
    assert!(matches!(refused, Error::NoMount), "{refused}");
}
