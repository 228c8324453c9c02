//! The report: whole, self-contained, well-formed, and no name breaks out of it.
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a test, over small made-up numbers"
)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use starbreak_eval::evaluation::{Group, GroupKind, Study};
use starbreak_eval::report::{csv, html, json, latex, numbers, read_json};

#[path = "report/plausible.rs"]
mod plausible;

/// What would like to be more than a name.
const HOSTILE: &str = "</title></script><script>alert(1)</script>\"'><img src=x onerror=alert(1)>&amp;{{ 7*7 }}\u{0}\u{202e}";

/// A study in which every name from outside is hostile.
fn hostile() -> Study {
    let mut study = plausible::study(&[2]);
    study.title = HOSTILE.to_owned();
    study.dataset = HOSTILE.to_owned();
    study.provenance.command = Some(HOSTILE.to_owned());
    study.provenance.recipe = Some(HOSTILE.to_owned());
    for input in &mut study.provenance.inputs {
        input.path = HOSTILE.to_owned();
    }
    for warning in &mut study.warnings {
        warning.text = HOSTILE.to_owned();
    }
    for set in study.divergence.iter_mut().flat_map(|one| &mut one.sets) {
        set.insert_str(0, HOSTILE);
    }
    let spoil = |group: &mut Group| {
        if group.kind != GroupKind::All {
            group.name.insert_str(0, HOSTILE);
        }
    };
    for one in &mut study.evaluations {
        one.detector.insert_str(0, HOSTILE);
        one.condition.name = HOSTILE.to_owned();
        one.paired.iter_mut().for_each(|row| spoil(&mut row.group));
        for clip in &mut one.timelines {
            clip.clip = HOSTILE.to_owned();
        }
        for worst in &mut one.worst {
            worst.image = HOSTILE.to_owned();
            for shown in &mut worst.boxes {
                shown.class = HOSTILE.to_owned();
                shown.box_px.width = f64::NAN;
            }
        }
        let failures = one.failures.as_mut().unwrap();
        failures
            .rates
            .iter_mut()
            .for_each(|row| spoil(&mut row.group));
        for dose in &mut failures.dose_responses {
            dose.fact = HOSTILE.to_owned();
        }
    }
    study
}

fn parsed(page: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..roxmltree::ParsingOptions::default()
    };
    roxmltree::Document::parse_with_options(page, options).unwrap()
}

/// What is wrong with the form of a page.
fn faults(page: &str) -> Vec<String> {
    let document = parsed(page);
    let mut faults = Vec::new();
    let mut ids = BTreeSet::new();
    let elements: Vec<_> = document
        .descendants()
        .filter(roxmltree::Node::is_element)
        .collect();
    for element in &elements {
        if let Some(id) = element.attribute("id")
            && !ids.insert(id.to_owned())
        {
            faults.push(format!("two elements have the id {id}"));
        }
        for attribute in element.attributes() {
            let (name, value) = (attribute.name(), attribute.value());
            if name.starts_with("on") {
                faults.push(format!("{name} runs a script"));
            }
            let is_address = ["href", "src", "data", "action", "poster", "srcset"].contains(&name);
            if is_address
                && !value.starts_with('#')
                && !value.starts_with("data:image/jpeg;base64,")
            {
                faults.push(format!("{name} leads out: {value}"));
            }
        }
        let name = element.tag_name().name();
        if ["link", "iframe", "object", "embed", "base", "form", "img"].contains(&name) {
            faults.push(format!("there is an element {name}"));
        }
        if name == "svg" {
            let has_title = element
                .first_element_child()
                .is_some_and(|c| c.has_tag_name(("http://www.w3.org/2000/svg", "title")));
            if !has_title || element.attribute("role") != Some("img") {
                faults.push("an svg has no title or role".to_owned());
            }
        }
        if name == "table" {
            let has = |what: &str| element.descendants().any(|c| c.tag_name().name() == what);
            if !has("caption") || !has("thead") || !has("th") {
                faults.push("a table has no caption or headings".to_owned());
            }
            let lengths: BTreeSet<usize> = element
                .descendants()
                .filter(|c| c.tag_name().name() == "tr")
                .map(|row| row.children().filter(roxmltree::Node::is_element).count())
                .collect();
            if lengths.len() != 1 {
                faults.push(format!("a table has rows of {lengths:?} cells"));
            }
        }
    }
    for element in &elements {
        for name in ["aria-labelledby", "href"] {
            let named = element.attribute(name).unwrap_or("");
            let is_here = named.starts_with('#') || name == "aria-labelledby";
            for id in named
                .trim_start_matches('#')
                .split_whitespace()
                .filter(|_| is_here)
            {
                if !ids.contains(id) {
                    faults.push(format!("{name} names {id}, which is not there"));
                }
            }
        }
    }
    let scripts = elements
        .iter()
        .filter(|e| e.tag_name().name() == "script")
        .count();
    if scripts != 1 {
        faults.push(format!("there are {scripts} scripts"));
    }
    for (word, allowed) in [
        ("http://", "=\"http://www.w3.org/"),
        ("https://", "nowhere"),
        ("url(", "url(#"),
        ("@import", "nowhere"),
    ] {
        let (n_found, n_allowed) = (page.matches(word).count(), page.matches(allowed).count());
        if n_found > n_allowed {
            faults.push(format!(
                "{word} stands in it {n_found} times, {n_allowed} of them within the page"
            ));
        }
    }
    for named in page.split("url(#").skip(1) {
        let id = named.split(')').next().unwrap_or("");
        if !ids.contains(id) {
            faults.push(format!("url(#{id}) names nothing"));
        }
    }
    faults
}

#[test]
fn the_page_is_whole_and_needs_nothing_else() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (name, study) in [
        ("report-2.html", plausible::study(&[3])),
        ("report-10.html", plausible::study(&[1, 2, 3, 4, 5])),
    ] {
        let page = html(&study).unwrap();
        fs::write(folder.join(name), &page).unwrap();
        let none: [String; 0] = [];
        assert_eq!(faults(&page), none, "{name}");
    }
    fs::write(folder.join("table.tex"), latex(&plausible::study(&[3, 5]))).unwrap();
    fs::write(folder.join("numbers.csv"), csv(&plausible::study(&[3]))).unwrap();
}

#[test]
fn faults_are_seen() {
    let page = html(&plausible::study(&[3])).unwrap();
    for (find, put) in [
        ("id=\"overview\"", "id=\"e0\""),
        ("<main id=\"main\">", "<main id=\"main\" onclick=\"f()\">"),
        (
            "<main id=\"main\">",
            "<main id=\"main\"><img src=\"a.png\"/>",
        ),
        ("href=\"#overview\"", "href=\"https://example.com/\""),
        (" role=\"img\"", ""),
        ("<caption>", "<caption/><tr><td>1</td></tr><caption>"),
    ] {
        assert!(page.contains(find), "{find} is in the page");
        let spoiled = page.replacen(find, put, 1);
        let spoiled = match find {
            "<caption>" => {
                spoiled.replacen("<caption/><tr><td>1</td></tr>", "<tr><td>1</td></tr>", 1)
            }
            _ => spoiled,
        };
        assert!(!faults(&spoiled).is_empty(), "{find} -> {put} is a fault");
    }
}

#[test]
fn no_name_breaks_out_of_the_page() {
    let page = html(&hostile()).unwrap();
    let none: [String; 0] = [];
    assert_eq!(faults(&page), none, "as whole as with tame names");
    let document = parsed(&page);
    let title = document
        .descendants()
        .find(|e| e.tag_name().name() == "title")
        .unwrap();
    let shown = HOSTILE.replace(['\u{0}', '\u{202e}'], "\u{fffd}");
    assert_eq!(title.text(), Some(shown.as_str()), "shown letter by letter");
    assert!(page.contains("{{ 7*7 }}"), "names are no templates");
    assert!(
        !page.contains('\u{202e}'),
        "nothing turns the direction of reading"
    );
}

#[test]
fn a_study_comes_back_from_its_json() {
    let mut study = plausible::study(&[1, 4]);
    let text = json(&study).unwrap();
    // Pictures are not numbers.
    for worst in study.evaluations.iter_mut().flat_map(|one| &mut one.worst) {
        worst.pictures = None;
    }
    assert_eq!(read_json(&text).unwrap(), study, "the same");
    let other = text.replacen("starbreak.evaluation/1", "starbreak.evaluation/9", 1);
    let said = read_json(&other).unwrap_err().to_string();
    assert!(
        said.contains("starbreak.evaluation/9"),
        "another version is refused: {said}"
    );
    let said = read_json("[1, 2").unwrap_err().to_string();
    assert!(!said.contains('\n'), "one line: {said}");
}

#[test]
fn csv_has_a_row_per_number_and_the_same_fields_in_each() {
    for study in [plausible::study(&[3]), hostile()] {
        let text = csv(&study);
        let n_numbers = numbers(&study).len();
        let rows = rows_of(&text);
        assert_eq!(
            rows.len(),
            n_numbers + 1,
            "one row per number, and the heading"
        );
        assert!(rows.iter().all(|row| row.len() == 13), "13 fields each");
        assert!(n_numbers > 500, "{n_numbers} numbers");
    }
}

/// The fields of each row by RFC 4180.
fn rows_of(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut field) = (Vec::new(), Vec::new(), String::new());
    let mut is_quoted = false;
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if is_quoted && letters.peek() == Some(&'"') => {
                field.push('"');
                letters.next();
            }
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => row.push(std::mem::take(&mut field)),
            '\n' if !is_quoted => {
                row.push(std::mem::take(&mut field));
                rows.push(std::mem::take(&mut row));
            }
            other => field.push(other),
        }
    }
    assert!(!is_quoted && field.is_empty(), "the last row ends");
    rows
}

#[test]
fn the_latex_table_is_balanced_and_rectangular() {
    for study in [plausible::study(&[3, 5]), hostile()] {
        let text = latex(&study);
        let plain = text.replace("\\{", "").replace("\\}", "");
        assert_eq!(
            plain.matches('{').count(),
            plain.matches('}').count(),
            "braces"
        );
        for word in ["table*", "tabular"] {
            assert_eq!(
                text.matches(&format!("\\begin{{{word}}}")).count(),
                1,
                "begin {word}"
            );
            assert_eq!(
                text.matches(&format!("\\end{{{word}}}")).count(),
                1,
                "end {word}"
            );
        }
        let columns = |row: &str| row.replace("\\&", "").matches(" & ").count();
        let rows: Vec<usize> = text
            .lines()
            .filter(|l| l.ends_with("\\\\"))
            .map(columns)
            .collect();
        assert!(rows.len() > 8, "{} rows", rows.len());
        assert!(
            rows.iter().all(|n| Some(n) == rows.first()),
            "columns: {rows:?}"
        );
        let n_columns = rows.first().map_or(0, |n| n + 1);
        let rule = format!("\\cmidrule{{2-{n_columns}}}");
        assert!(text.contains(&rule), "a rule to the last column: {rule}");
        assert!(
            text.contains("--\\textsuperscript{1}"),
            "a refused number has its note"
        );
    }
}
