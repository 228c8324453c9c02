//! Drawings, networks and recipes that are small files and large work: an early refusal, or little
//! time.

use std::time::{Duration, Instant};

use starbreak::import::parse_network;
use starbreak::{MAX_RECIPE_BYTES, Recipe};

const LINE: &str = "<path stroke=\"red\" d=\"M1 1L9 9\"/>";

fn drawn(before: &str, content: &str) -> String {
    format!(
        "{before}<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"200\" height=\"100\">{content}{LINE}</svg>"
    )
}

/// What is said of a text, in a time that any machine has.
fn refusal(text: &str) -> String {
    let started = Instant::now();
    let result = parse_network(text);
    let took = started.elapsed();
    assert!(took < Duration::from_secs(5), "{took:?}");
    match result {
        Ok(_) => "nothing".to_owned(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn entities_do_not_fill_the_memory() {
    let entity = |bytes: usize, n: usize| {
        let declared = format!("<!DOCTYPE svg [<!ENTITY a \"{}\">]>", "x".repeat(bytes));
        let used = format!("<text>{}</text>", "&a;".repeat(n));
        drawn(&declared, &used)
    };
    assert_eq!(refusal(&entity(60, 1000)), "nothing", "as Illustrator's");
    // 110 kB that become 1 GB.
    let said = refusal(&entity(55_000, 18_000));
    assert!(
        said.contains("more than 16777216 bytes out of entities"),
        "{said}"
    );
}

#[test]
fn attributes_take_little_time() {
    let many = |n: usize| {
        let attributes: String = (0..n).map(|k| format!(" a{k}=\"1\"")).collect();
        drawn("", &format!("<g{attributes}/>"))
    };
    assert_eq!(refusal(&many(256)), "nothing", "as many as there may be");
    let said = refusal(&many(80_000));
    assert!(
        said.contains("more than 256 attributes of one element"),
        "{said}"
    );
}

#[test]
fn rules_for_everything_are_questions_too() {
    let rules = "*{stroke:red}".repeat(5000);
    let paths = "<path d=\"M0 0h1\"/>".repeat(20_000);
    let said = refusal(&drawn("", &format!("<style>{rules}</style>{paths}")));
    assert!(said.contains("questions of style rules"), "{said}");
    let values = "stroke:red;".repeat(8000);
    let said = refusal(&drawn("", &format!("<style>*{{{values}}}</style>{paths}")));
    assert!(said.contains("questions of style rules"), "{said}");
}

#[test]
fn long_styles_are_not_parsed_by_the_square() {
    let rules = "*{stroke:red}".repeat(100_000);
    let said = refusal(&drawn("", &format!("<style>{rules}</style>")));
    assert!(
        said.contains("more than 131072 bytes of style sheets"),
        "{said}"
    );
    let values = "stroke:red;".repeat(100_000);
    let said = refusal(&drawn(
        "",
        &format!("<path d=\"M0 0h1\" style=\"{values}\"/>"),
    ));
    assert!(
        said.contains("more than 4096 bytes in the style of one element"),
        "{said}"
    );
}

#[test]
fn a_network_has_no_more_impacts_than_a_recipe() {
    let network = |n: usize| {
        let impacts = vec![r#"{"x":150.0,"y":100.0}"#; n].join(",");
        format!(
            r#"{{"schema":"starbreak.crack-network/1","generator":{{"name":"a test","version":"1"}},"model":"physics",
            "unit":"mm","pane":{{"width":300.0,"height":200.0,"thickness_mm":3.15,"kind":"annealed"}},
            "impacts":[{impacts}],"nodes":{{"x":[150.0,200.0],"y":[100.0,120.0]}},
            "segments":{{"from":[0],"to":[1],"kind":["radial"]}}}}"#
        )
    };
    assert_eq!(
        refusal(&network(1000)),
        "nothing",
        "as many as there may be"
    );
    let said = refusal(&network(20_000));
    assert!(said.contains("20000 impacts; expected 1000"), "{said}");
}

#[test]
fn a_recipe_is_not_longer_than_a_recipe() {
    let text = format!("schema = 1\nx = [{}]", "1,".repeat(MAX_RECIPE_BYTES));
    let said = match Recipe::parse("big.toml", &text) {
        Ok(_) => "nothing".to_owned(),
        Err(error) => error.to_string(),
    };
    assert!(
        said.contains("big.toml is longer than 1048576 bytes"),
        "{said}"
    );
}
