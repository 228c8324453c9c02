//! Drawings in SVG to networks: a drawing worked out by hand, our own drawings back, and input
//! that means harm.
#![expect(clippy::unwrap_used, reason = "a test that cannot read has failed")]

use std::collections::BTreeMap;
use std::f64::consts::PI;

use starbreak::glass::{CrackNetwork, LengthUnit, SegmentKind};
use starbreak::import::parse_network;
use starbreak::{PRESETS, Recipe, Seed};

fn svg(attributes: &str, content: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" {attributes}>{content}</svg>"
    )
}

/// Content on a page of 200 × 100 px.
fn page(content: &str) -> CrackNetwork {
    let text = svg("width=\"200\" height=\"100\"", content);
    let network = parse_network(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    network.check_invariants().unwrap();
    network
}

#[expect(clippy::cast_possible_truncation, reason = "a place on a small page")]
fn whole(value: f64) -> i64 {
    value.floor() as i64
}

fn thousandths(value: f64) -> i64 {
    whole(value * 1e3 + 0.5)
}

/// Ends of all segments, sorted, each from its lower end, to a thousandth.
fn ends(network: &CrackNetwork) -> Vec<[i64; 4]> {
    let mut all: Vec<[i64; 4]> = (0..network.n_segments())
        .map(|idx| {
            let [a, b, c, d] = network.ends(idx).map(thousandths);
            if (a, b) <= (c, d) {
                [a, b, c, d]
            } else {
                [c, d, a, b]
            }
        })
        .collect();
    all.sort_unstable();
    all
}

fn lengths(network: &CrackNetwork) -> BTreeMap<SegmentKind, f64> {
    let mut lengths = BTreeMap::new();
    for (idx, kind) in network.data().segments.kind.iter().enumerate() {
        let [a, b, c, d] = network.ends(idx);
        *lengths.entry(*kind).or_insert(0.0) += (c - a).hypot(d - b);
    }
    lengths
}

#[test]
fn every_preset_reads_back_from_its_own_drawing() {
    for (name, _) in PRESETS {
        for seed in 0..4 {
            let settings = Recipe::preset(name).unwrap().settings().unwrap();
            let network = starbreak::simulate(&settings, (1242, 375), Seed(seed))
                .unwrap()
                .network;
            let what = format!("{name}, seed {seed}");
            let again =
                parse_network(&network.to_svg()).unwrap_or_else(|error| panic!("{what}: {error}"));
            again.check_invariants().unwrap();
            assert_reads_back(&network, &again, &what);
        }
    }
}

fn assert_reads_back(network: &CrackNetwork, again: &CrackNetwork, what: &str) {
    assert_eq!(again.data().unit, network.data().unit, "{what}");
    assert_eq!(
        again.data().pane.width.to_bits(),
        network.data().pane.width.to_bits(),
        "{what}: width"
    );
    assert_eq!(
        again.data().pane.height.to_bits(),
        network.data().pane.height.to_bits(),
        "{what}: height"
    );
    let impacts = |network: &CrackNetwork| -> Vec<[i64; 2]> {
        let at = thousandths;
        network
            .data()
            .impacts
            .iter()
            .map(|impact| [at(impact.x), at(impact.y)])
            .collect()
    };
    assert_eq!(
        impacts(again).len(),
        impacts(network).len(),
        "{what}: impacts"
    );
    for (read, written) in again.data().impacts.iter().zip(&network.data().impacts) {
        let off = (read.x - written.x).hypot(read.y - written.y);
        assert!(off <= 1e-3, "{what}: an impact is off by {off}");
    }
    // Every segment is there, of its kind, and nothing else is.
    for (one, other, missing) in [(network, again, "read"), (again, network, "written")] {
        let index = Index::of(other);
        for (idx, kind) in one.data().segments.kind.iter().enumerate() {
            let [a, b, c, d] = one.ends(idx);
            for [x, y] in [[a, b], [0.5 * (a + c), 0.5 * (b + d)], [c, d]] {
                let off = index.distance(other, [x, y], *kind);
                assert!(
                    off <= 1e-3,
                    "{what}: {kind:?} {idx} at ({x}, {y}) is {off} off what was {missing}"
                );
            }
        }
    }
}

/// Segments by squares of the plane.
struct Index {
    cell: f64,
    by_cell: BTreeMap<[i64; 2], Vec<usize>>,
}

impl Index {
    fn of(network: &CrackNetwork) -> Self {
        let cell = network.data().pane.width.max(network.data().pane.height) / 256.0;
        let mut by_cell: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        for idx in 0..network.n_segments() {
            let [a, b, c, d] = network.ends(idx);
            let at = |value: f64| whole(value / cell);
            for x in at(a.min(c) - 0.01)..=at(a.max(c) + 0.01) {
                for y in at(b.min(d) - 0.01)..=at(b.max(d) + 0.01) {
                    by_cell.entry([x, y]).or_default().push(idx);
                }
            }
        }
        Self { cell, by_cell }
    }

    /// To the nearest segment of this kind.
    fn distance(&self, network: &CrackNetwork, [x, y]: [f64; 2], kind: SegmentKind) -> f64 {
        let at = |value: f64| whole(value / self.cell);
        let near = self.by_cell.get(&[at(x), at(y)]).into_iter().flatten();
        near.filter(|idx| network.data().segments.kind[**idx] == kind)
            .map(|idx| {
                let [a, b, c, d] = network.ends(*idx);
                let (dx, dy) = (c - a, d - b);
                let t = (((x - a) * dx + (y - b) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
                (a + t * dx - x).hypot(b + t * dy - y)
            })
            .fold(f64::INFINITY, f64::min)
    }
}

const LINE: &str = "stroke=\"black\"";

#[test]
fn nested_transforms_are_applied_from_the_inside_out() {
    // Scaled first, then moved: (5, 5) → (10, 10) → (20, 30).
    let nested = page(&format!(
        "<g transform=\"translate(10 20)\"><g transform=\"scale(2)\"><line x1=\"5\" y1=\"5\" x2=\"20\" y2=\"5\" {LINE}/></g></g>"
    ));
    assert_eq!(ends(&nested), [[20_000, 30_000, 50_000, 30_000]], "nested");
    // A quarter turn about (100, 50): (x, y) → (150 − y, x − 50).
    let turned = page(&format!(
        "<polyline transform=\"rotate(90 100 50)\" points=\"100,50 110,50 110,60\" {LINE}/>"
    ));
    assert_eq!(
        ends(&turned),
        [
            [90_000, 60_000, 100_000, 60_000],
            [100_000, 50_000, 100_000, 60_000]
        ],
        "turned"
    );
    // x′ = x + 2y + 5, y′ = 3x + y + 6.
    let sheared = page(&format!(
        "<g transform=\"matrix(1 3 2 1 5 6)\"><path d=\"M1 2 L10 3\" {LINE}/></g>"
    ));
    assert_eq!(
        ends(&sheared),
        [[10_000, 11_000, 21_000, 39_000]],
        "sheared"
    );
}

#[test]
fn relative_and_smooth_commands_are_what_they_stand_for() {
    let path = |d: &str| ends(&page(&format!("<path d=\"{d}\" {LINE}/>")));
    let relative =
        path("m10 10 l20 0 0 10 h-5 v5 q5 5 10 0 t10 0 c1 2 3 4 5 6 s5 5 9 9 a5 5 0 0 1 5 5 z");
    let absolute = path(
        "M10 10 L30 10 L30 20 L25 20 L25 25 Q30 30 35 25 Q40 20 45 25 C46 27 48 29 50 31 C52 33 55 36 59 40 A5 5 0 0 1 64 45 L10 10",
    );
    assert!(relative.len() > 20, "{} segments", relative.len());
    assert_eq!(relative, absolute, "the same path");
}

#[test]
fn chords_lie_within_the_flatness_of_their_curve() {
    let circle = page(&format!(
        "<circle class=\"cone\" cx=\"75\" cy=\"25\" r=\"10\" transform=\"scale(2)\" {LINE}/>"
    ));
    for idx in 0..circle.n_segments() {
        let [a, b, c, d] = circle.ends(idx);
        let corner = (a - 150.0).hypot(b - 50.0);
        let middle = (0.5 * (a + c) - 150.0).hypot(0.5 * (b + d) - 50.0);
        assert!((corner - 20.0).abs() < 1e-5, "a corner at {corner}");
        assert!(
            (19.98 - 1e-5..20.0).contains(&middle),
            "a chord at {middle}"
        );
    }
    let around = lengths(&circle)[&SegmentKind::Cone];
    // A sagitta of 0.02 at r = 20 makes chords short by a share of 0.02/(3·20).
    let short = 1.0 - around / (2.0 * PI * 20.0);
    assert!((0.0..3.4e-4).contains(&short), "short by {short}");
    // p(t) = (40(3t² − 2t³), 90 − 60t(1 − t)), the largest bend of a hand-drawn arc.
    let curve = page(&format!("<path d=\"M0 90 C0 70 40 70 40 90\" {LINE}/>"));
    let at = |t: f64| {
        [
            40.0 * (3.0 * t * t - 2.0 * t * t * t),
            90.0 - 60.0 * t * (1.0 - t),
        ]
    };
    for idx in 0..curve.n_segments() {
        let [a, b, c, d] = curve.ends(idx);
        for [x, y] in [[a, b], [0.5 * (a + c), 0.5 * (b + d)], [c, d]] {
            let off = (0..=4000)
                .map(|k| at(f64::from(k) / 4000.0))
                .map(|[u, v]| (u - x).hypot(v - y))
                .fold(f64::INFINITY, f64::min);
            assert!(off < 0.03, "({x}, {y}) is {off} off the curve");
        }
    }
    // Three quarters of a circle of radius 10, then the quarter that is left.
    for (flags, length) in [
        ("1 1", 15.0 * PI),
        ("0 1", 5.0 * PI),
        ("1 0", 15.0 * PI),
        ("0 0", 5.0 * PI),
    ] {
        let arc = page(&format!(
            "<path d=\"M50 50 A10 10 0 {flags} 60 60\" {LINE}/>"
        ));
        let got = lengths(&arc)[&SegmentKind::Radial];
        assert!(
            (got - length).abs() < 1e-3 * length,
            "{flags}: {got} for {length}"
        );
    }
}

#[test]
fn the_page_says_unit_and_size() {
    let line = format!("<line x1=\"20\" y1=\"40\" x2=\"180\" y2=\"40\" {LINE}/>");
    let cases = [
        (
            "width=\"200\" height=\"100\"",
            LengthUnit::Px,
            [200.0, 100.0],
            [20.0, 40.0, 180.0],
        ),
        (
            "width=\"100mm\" height=\"50mm\" viewBox=\"0 0 200 100\"",
            LengthUnit::Mm,
            [100.0, 50.0],
            [10.0, 20.0, 90.0],
        ),
        (
            "width=\"10cm\" viewBox=\"0 0 200 100\"",
            LengthUnit::Mm,
            [100.0, 50.0],
            [10.0, 20.0, 90.0],
        ),
        (
            "width=\"96mm\" height=\"48mm\"",
            LengthUnit::Mm,
            [96.0, 48.0],
            [20.0 * 25.4 / 96.0, 40.0 * 25.4 / 96.0, 180.0 * 25.4 / 96.0],
        ),
        (
            "viewBox=\"10 10 200 100\"",
            LengthUnit::Px,
            [200.0, 100.0],
            [10.0, 30.0, 170.0],
        ),
        // Fitted into the middle: scale ½, 25 px to the left and right free.
        (
            "width=\"150\" height=\"50\" viewBox=\"0 0 200 100\"",
            LengthUnit::Px,
            [150.0, 50.0],
            [35.0, 20.0, 115.0],
        ),
        (
            "width=\"400\" height=\"50\" viewBox=\"0 0 200 100\" preserveAspectRatio=\"none\"",
            LengthUnit::Px,
            [400.0, 50.0],
            [40.0, 20.0, 360.0],
        ),
    ];
    for (attributes, unit, [width, height], [x0, y, x1]) in cases {
        let network = parse_network(&svg(attributes, &line)).unwrap();
        let data = network.data();
        assert_eq!(data.unit, unit, "{attributes}");
        assert_eq!(
            [data.pane.width, data.pane.height].map(thousandths),
            [width, height].map(thousandths),
            "{attributes}"
        );
        let got = network.ends(0);
        let off = [x0, y, x1, y]
            .iter()
            .zip(got)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(off < 1e-5, "{attributes}: {got:?}");
    }
}

#[test]
fn lines_that_cross_or_touch_get_a_common_node() {
    let cross = page(&format!("<path d=\"M40 50 H60 M50 40 V60\" {LINE}/>"));
    assert_eq!(
        (cross.n_segments(), cross.data().nodes.x.len()),
        (4, 5),
        "a cross"
    );
    let touch = page(&format!("<path d=\"M40 50 H60 M50 49.9995 V10\" {LINE}/>"));
    assert_eq!(
        (touch.n_segments(), touch.data().nodes.x.len()),
        (3, 4),
        "an end within reach"
    );
    let apart = page(&format!("<path d=\"M40 50 H60 M50 49.99 V10\" {LINE}/>"));
    assert_eq!(
        (apart.n_segments(), apart.data().nodes.x.len()),
        (2, 4),
        "an end out of reach"
    );
    let twice = page(&format!(
        "<path d=\"M40 50 H60 M50 50 H80 M60 50 H40\" {LINE}/>"
    ));
    assert_eq!(
        ends(&twice),
        [
            [40_000, 50_000, 50_000, 50_000],
            [50_000, 50_000, 60_000, 50_000],
            [60_000, 50_000, 80_000, 50_000]
        ],
        "on top of each other"
    );
    let closed = page(&format!("<polygon points=\"10,10 90,10 50,90\" {LINE}/>"));
    assert_eq!(closed.summary().n_fragments, Some(2), "a piece comes off");
}

#[test]
fn names_say_kinds_and_impacts() {
    let network = page(&format!(
        "<g id=\"Ring-2\" {LINE}><path d=\"M1 1 h4\"/><path class=\"big fork\" d=\"M1 2 h3\"/></g>\
         <g xmlns:i=\"http://www.inkscape.org/namespaces/inkscape\" i:label=\"edge 7\" id=\"layer1\" {LINE}><path id=\"path12\" d=\"M1 3 h5\"/></g>\
         <path d=\"M50 50 h7\" {LINE}/>\
         <path d=\"M50 60 h9 L50 50\" {LINE}/>\
         <circle class=\"impact\" cx=\"25\" cy=\"25\" r=\"3\" transform=\"scale(2)\"/>\
         <g id=\"impact_3\"><ellipse cx=\"120\" cy=\"20\" rx=\"3\" ry=\"2\" fill=\"red\"/></g>"
    ));
    let length = |kind| thousandths(lengths(&network)[&kind]);
    assert_eq!(length(SegmentKind::Ring), 4000, "by the group");
    assert_eq!(length(SegmentKind::Fork), 3000, "by a class");
    assert_eq!(length(SegmentKind::Edge), 5000, "by a label");
    let impacts: Vec<[i64; 2]> = network
        .data()
        .impacts
        .iter()
        .map(|hit| [hit.x, hit.y].map(thousandths))
        .collect();
    assert_eq!(impacts, [[50_000, 50_000], [120_000, 20_000]], "impacts");
    // One starts at the impact, the other was drawn towards it.
    assert_eq!(network.summary().n_radial, 2, "arms");
}

#[test]
fn only_visible_strokes_count() {
    let shown = "<path d=\"M10 10 h10\" stroke=\"#000\"/>";
    let hidden = [
        "<rect width=\"100%\" height=\"100%\" fill=\"#14181d\" stroke=\"red\"/>",
        "<path d=\"M20 20 h10\" fill=\"red\"/>",
        "<path d=\"M20 20 h10\" stroke=\"none\"/>",
        "<path d=\"M20 20 h10\" stroke=\"red\" stroke-width=\"0\"/>",
        "<g display=\"none\"><path d=\"M20 20 h10\" stroke=\"red\"/></g>",
        "<g style=\"visibility:hidden\"><path d=\"M20 20 h10\" stroke=\"red\"/></g>",
        "<style>.off{stroke:none}</style><path class=\"off\" d=\"M20 20 h10\" stroke=\"red\"/>",
        "<style>path{stroke:red !important} .off{stroke:none!important}</style><path class=\"off\" d=\"M20 20 h10\" style=\"stroke:red\"/>",
        "<defs><path d=\"M20 20 h10\" stroke=\"red\"/></defs>",
        "<symbol><path d=\"M20 20 h10\" stroke=\"red\"/></symbol>",
        "<switch><foreignObject requiredExtensions=\"x\"><path d=\"M20 20 h10\" stroke=\"red\"/></foreignObject></switch>",
        "<path d=\"M-20 20 h10\" stroke=\"red\"/>",
        "<text stroke=\"red\" x=\"20\" y=\"20\">crack</text>",
    ];
    for other in hidden {
        let network = page(&format!(
            "{other}<g class=\"x\">{}</g>",
            shown.replace("#000", "#000\" style=\"stroke:blue!important")
        ));
        assert_eq!(
            ends(&network),
            [[10_000, 10_000, 20_000, 10_000]],
            "{other}"
        );
    }
    let inherited = page(
        "<g style=\"stroke:red\" visibility=\"hidden\"><path visibility=\"visible\" d=\"M10 10 h10\"/></g>",
    );
    assert_eq!(
        inherited.n_segments(),
        1,
        "stroke and visibility are inherited, and may be set anew"
    );
}

#[test]
fn clips_and_uses_are_resolved() {
    let clip = |shape: &str| {
        format!(
            "<clipPath id=\"c\">{shape}</clipPath><g clip-path=\"url(#c)\"><path d=\"M0 50 H200\" {LINE}/></g>"
        )
    };
    let cut = |content: &str| ends(&page(content));
    assert_eq!(
        cut(&clip(
            "<rect x=\"30\" y=\"0\" width=\"40\" height=\"100\"/>"
        )),
        [[30_000, 50_000, 70_000, 50_000]],
        "rect"
    );
    assert_eq!(
        cut(&clip(
            "<path clip-rule=\"evenodd\" d=\"M0 0H100V100H0Z M40 0H60V100H40Z\"/>"
        )),
        [
            [0, 50_000, 40_000, 50_000],
            [60_000, 50_000, 100_000, 50_000]
        ],
        "a hole"
    );
    let round = cut(&clip("<circle cx=\"100\" cy=\"50\" r=\"20\"/>"));
    assert!(
        (round[0][0] - 80_000).abs() < 25 && (round[0][2] - 120_000).abs() < 25,
        "circle: {round:?}"
    );
    // Off the page on both sides.
    assert_eq!(
        cut(&format!("<path d=\"M-50 -50 L150 150\" {LINE}/>")),
        [[0, 0, 100_000, 100_000]],
        "page"
    );
    let used = format!(
        "<defs><path id=\"p\" class=\"ring\" d=\"M0 0 h10\" {LINE}/></defs><use xlink:href=\"#p\" x=\"5\" y=\"7\"/><use href=\"#p\" transform=\"translate(50 50) scale(2)\"/>"
    );
    let network = page(&used);
    assert_eq!(
        ends(&network),
        [
            [5_000, 7_000, 15_000, 7_000],
            [50_000, 50_000, 70_000, 50_000]
        ],
        "use"
    );
    assert!(
        network
            .data()
            .segments
            .kind
            .iter()
            .all(|kind| *kind == SegmentKind::Ring),
        "kinds of what is used"
    );
    let symbol = format!(
        "<symbol id=\"s\" viewBox=\"0 0 10 10\"><path d=\"M0 5 h20\" {LINE}/></symbol><use href=\"#s\" x=\"100\" y=\"0\" width=\"50\" height=\"50\"/>"
    );
    assert_eq!(
        cut(&symbol),
        [[100_000, 25_000, 150_000, 25_000]],
        "symbol, cut at its viewport"
    );
}

#[test]
fn a_drawing_that_is_none_is_refused_in_one_line() {
    let bomb = format!(
        "<!DOCTYPE svg [<!ENTITY a \"{}\">{}]><svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">&i;</svg>",
        "<path d='M0 0h1' stroke='red'/>".repeat(20),
        ('b'..='i')
            .map(|c| format!(
                "<!ENTITY {c} \"{}\">",
                format!("&{};", char::from(c as u8 - 1)).repeat(20)
            ))
            .collect::<String>()
    );
    let uses = format!(
        "{}<use href=\"#u20\"/>",
        (1..=20)
            .map(|k| format!(
                "<g id=\"u{k}\"><use href=\"#u{}\"/><use href=\"#u{}\"/></g>",
                k - 1,
                k - 1
            ))
            .collect::<String>()
    );
    let fan: String = (0..3000)
        .map(|k| {
            format!(
                "M0 {}L200 {}",
                f64::from(k) / 30.0,
                100.0 - f64::from(k) / 30.0
            )
        })
        .collect();
    let rules = format!(
        "<style>{}</style>{}",
        "x g g g g path{stroke:red}".repeat(3),
        "<g>".repeat(60) + &"<path d=\"M0 0h1\"/>".repeat(3000) + &"</g>".repeat(60)
    );
    let clip_edges: String = (0..20_000)
        .map(|k| format!("L{} {}", k % 200, k % 100))
        .collect();
    let clips = format!(
        "<clipPath id=\"c\"><path d=\"M0 0{clip_edges}\"/></clipPath><path clip-path=\"url(#c)\" d=\"M0 0{clip_edges}\" {LINE}/>"
    );
    let whole = |text: &str| text.to_owned();
    let drawn = |content: &str| svg("width=\"200\" height=\"100\"", content);
    let sized = |attributes: &str| svg(attributes, &format!("<path d=\"M0 0h1\" {LINE}/>"));
    let line = |d: &str| drawn(&format!("<path d=\"{d}\" {LINE}/>"));
    let cases = [
        (whole(""), "neither an SVG"),
        (whole("PNG"), "neither an SVG"),
        (whole("{}"), "not a crack network"),
        (whole("<svg"), "not valid XML"),
        (whole("<html/>"), "its root is <html>"),
        (
            whole("<svg xmlns=\"http://www.w3.org/1999/xhtml\"/>"),
            "its root is <svg>",
        ),
        (bomb, "out of entities"),
        (
            whole(
                "<!DOCTYPE svg [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><svg xmlns=\"http://www.w3.org/2000/svg\">&x;</svg>",
            ),
            "not valid XML",
        ),
        (drawn(&"<g>".repeat(100_000)), "not valid XML"),
        (
            drawn(&format!("{}{}", "<g>".repeat(2000), "</g>".repeat(2000))),
            "nested deeper than 64",
        ),
        (drawn(""), "has no cracks"),
        (
            drawn(&format!("<rect width=\"9\" height=\"9\" {LINE}/>")),
            "has no cracks",
        ),
        (sized(""), "no viewBox"),
        (sized("width=\"0\" height=\"0\""), "no usable size"),
        (sized("width=\"-1\" height=\"1\""), "no usable size"),
        (sized("width=\"NaN\" height=\"1\""), "no usable size"),
        (sized("width=\"1e300\" height=\"1e300\""), "no usable size"),
        (sized("width=\"5em\" height=\"5em\""), "no usable size"),
        (sized("width=\"5mm\" height=\"5\""), "different kinds"),
        (sized("viewBox=\"0 0 0 0\""), "viewBox"),
        (sized("viewBox=\"0 0 nan 5\""), "viewBox"),
        (
            sized("width=\"9\" height=\"9\" transform=\"scale(2)\""),
            "transform of the whole",
        ),
        (line("M0 0 L1"), "<path>: d:"),
        (line("M0 0 L1 nan"), "<path>: d:"),
        (line("M0 0 L1e400 1"), "<path>:"),
        (line("M0 0 L1e300 1e300"), "far off the page"),
        (line("M0 0 C1e300 1e300 -1e300 1e300 5 5"), "1048576 points"),
        (line(&fan), "meet more than"),
        (
            line(&format!("M0 0{}", "h1h-1".repeat(600_000))),
            "1048576 points",
        ),
        (
            drawn("<g transform=\"rotate(a)\"><path d=\"M0 0h1\" stroke=\"red\"/></g>"),
            "transform = \"rotate(a)\"",
        ),
        (
            drawn("<path transform=\"scale(1e308) scale(1e308)\" d=\"M1 1h1\" stroke=\"red\"/>"),
            "not a number",
        ),
        (
            drawn(
                "<path transform=\"scale(2)\" style=\"transform-origin:5px 5px\" d=\"M1 1h1\" stroke=\"red\"/>",
            ),
            "transform-origin",
        ),
        (
            drawn("<circle cx=\"5ex\" r=\"5\" stroke=\"red\"/>"),
            "cx = \"5ex\"",
        ),
        (
            drawn("<polyline points=\"1,2 3\" stroke=\"red\"/>"),
            "3 numbers",
        ),
        (
            drawn("<path class=\"impact\" d=\"M0 0h1\" stroke=\"red\"/>"),
            "named impact",
        ),
        (
            drawn("<use href=\"other.svg#p\"/>"),
            "not to a part of this drawing",
        ),
        (drawn("<g id=\"u\"><use href=\"#u\"/></g>"), "nested deeper"),
        (drawn(&uses), "1000000 elements"),
        (drawn(&rules), "questions of style rules"),
        (drawn(&clips), "edge of a clip path"),
        (
            drawn("<g clip-path=\"circle(5px)\"><path d=\"M0 0h1\" stroke=\"red\"/></g>"),
            "release the clip",
        ),
        (
            drawn(
                "<clipPath id=\"c\" clipPathUnits=\"objectBoundingBox\"/><path clip-path=\"url(#c)\" d=\"M0 0h1\" stroke=\"red\"/>",
            ),
            "release the clip",
        ),
        (
            drawn(
                "<clipPath id=\"c\"><text>a</text></clipPath><path clip-path=\"url(#c)\" d=\"M0 0h1\" stroke=\"red\"/>",
            ),
            "release the clip",
        ),
    ];
    let mut complaints = Vec::new();
    for (text, named) in cases {
        let shown: String = text.chars().take(200).collect();
        match parse_network(&text) {
            Ok(network) => complaints.push(format!("{shown}: {} segments", network.n_segments())),
            Err(error) => {
                let message = error.to_string();
                if !message.contains(named)
                    || message.contains(char::is_control)
                    || message.len() > 800
                {
                    complaints.push(format!("{shown}: {message:?} for {named:?}"));
                }
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}
