//! The report: whole, self-contained, well-formed, and no name breaks out of it.
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "a test, over small made-up numbers"
)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use starbreak_eval::evaluation::{
    Estimate, Group, GroupKind, PairedMetric, ScopeKind, Study, Warning,
};
use starbreak_eval::report::{csv, html, json, latex, numbers, read_json};

use crate::plausible;

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
        *warning = Warning::Classes(HOSTILE.to_owned());
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
            for object in &mut clip.objects {
                object.name.insert_str(0, HOSTILE);
                object.class.insert_str(0, HOSTILE);
            }
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
    let other = text.replacen("starbreak.evaluation/2", "starbreak.evaluation/9", 1);
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
        assert!(rows.iter().all(|row| row.len() == 17), "17 fields each");
        assert!(n_numbers > 300, "{n_numbers} numbers");
    }
}

#[test]
fn a_clean_curve_lies_with_gaps_over_a_wider_cracked_one() {
    let page = html(&plausible::study(&[3])).unwrap();
    let document = parsed(&page);
    let mut n_charts = 0;
    for chart in document
        .descendants()
        .filter(|e| e.tag_name().name() == "svg")
    {
        let lines: Vec<_> = chart
            .descendants()
            .filter(|e| e.tag_name().name() == "path")
            .collect();
        let place = |ink: &str, is_solid: bool| {
            lines.iter().position(|line| {
                line.attribute("stroke") == Some(ink)
                    && line.attribute("stroke-dasharray").is_none() == is_solid
            })
        };
        let title = chart.first_element_child().and_then(|title| title.text());
        if !title.is_some_and(|title| title.ends_with("drive 0005")) {
            continue;
        }
        n_charts += 1;
        let cracked = place("var(--cracked)", true).unwrap();
        let clean = place("var(--clean)", false).unwrap();
        assert!(cracked < clean, "{title:?}: clean is drawn last");
        let width = |place: usize| -> f64 {
            let width = lines.get(place).unwrap().attribute("stroke-width");
            width.unwrap().parse().unwrap()
        };
        assert!(
            width(cracked) >= 1.5 * width(clean),
            "{title:?}: cracked is wider"
        );
        assert_eq!(
            place("var(--clean)", true),
            None,
            "{title:?}: clean has gaps"
        );
    }
    assert_eq!(
        n_charts, 4,
        "over time and of what is lost, of two detectors"
    );
}

#[test]
fn no_two_numbers_have_the_same_name() {
    let mut study = plausible::study(&[2, 3]);
    for one in &mut study.evaluations {
        // Bins of a dose that is nearly the same for all objects.
        let doses = &mut one.failures.as_mut().unwrap().dose_responses;
        for (place, bin) in (0_u32..).zip(&mut doses.last_mut().unwrap().bins) {
            bin.low = 0.3 + 1e-6 * f64::from(place);
            bin.high = 0.3 + 1e-6 * f64::from(place + 1);
        }
    }
    let all = numbers(&study);
    let mut known = BTreeSet::new();
    let name = |one: &starbreak_eval::report::Number| {
        let tau = one.tau.map(|tau| tau.to_string());
        let what = (
            one.detector.clone(),
            one.condition.clone(),
            one.metric.clone(),
        );
        (what, one.scope, tau, one.group_kind, one.class.clone())
    };
    let repeated: Vec<_> = all
        .iter()
        .map(name)
        .filter(|name| !known.insert(name.clone()))
        .collect();
    assert!(repeated.is_empty(), "{repeated:?}");
    let classes = all.iter().filter(|one| one.metric == "ap50");
    assert!(classes.count() > 10, "AP of all and of classes is there");
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
fn a_column_of_latex_says_what_a_study_comes_to() {
    let study = plausible::study(&[3, 5]);
    let text = latex(&study);
    let column = text.split("\\begin{table*}").next().unwrap();
    assert!(column.contains("\\label{tab:starbreak}"), "to refer to");
    let rows: Vec<Vec<&str>> = column
        .lines()
        .filter_map(|line| line.strip_suffix(" \\\\"))
        .map(|line| line.trim().split(" & ").collect())
        .filter(|cells: &Vec<&str>| cells.len() > 1)
        .collect();
    let detectors: BTreeSet<&str> = study
        .evaluations
        .iter()
        .map(|one| one.detector.as_str())
        .collect();
    assert_eq!(
        rows.len(),
        1 + 2 * detectors.len(),
        "a head, and each condition: {rows:?}"
    );
    assert!(rows.iter().all(|cells| cells.len() == 6), "{rows:?}");
    let row = study.evaluations[0]
        .paired
        .iter()
        .find(|row| {
            row.metric == PairedMetric::Ap50
                && row.group.kind == GroupKind::All
                && row.scope.kind == ScopeKind::InRegion
        })
        .unwrap();
    let row_scope = row.scope.clone();
    let percent = |value: Option<f64>| format!("{:.1}", value.unwrap() * 100.0);
    assert_eq!(rows[1][1], row.n_objects.to_string(), "objects");
    assert_eq!(rows[1][2], percent(row.clean.value), "clean, alone");
    let [low, high] = row.delta.interval().unwrap();
    let difference = format!(
        "{} {{\\scriptsize [{}, {}]}}",
        percent(row.delta.value),
        percent(Some(low)),
        percent(Some(high))
    );
    assert_eq!(rows[1][4], difference, "with its interval");
    let p: f64 = rows[1][5].trim_start_matches("$<$").parse().unwrap();
    assert!((p - row.p_holm.unwrap()).abs() < 1.1e-3, "p {p}");

    // KITTI has no AP of all classes, and AP50 is not its number.
    let mut of_kitti = study;
    of_kitti.provenance.settings.protocol = "kitti".to_owned();
    let mut car = of_kitti.evaluations[0].paired[0].clone();
    car.scope = row_scope;
    car.metric = PairedMetric::KittiAp40;
    car.group = Group {
        kind: GroupKind::Class,
        name: "Car".to_owned(),
    };
    of_kitti.evaluations[0].paired.push(car);
    let text = latex(&of_kitti);
    let column = text.split("\\begin{table*}").next().unwrap();
    let rows: Vec<&str> = column.lines().filter(|line| line.contains(" & ")).collect();
    assert_eq!(rows.len(), 2, "a head, and the one class: {rows:?}");
    assert!(rows[1].contains(", Car &"), "{rows:?}");
}

#[test]
fn the_latex_table_is_balanced_and_rectangular() {
    for study in [plausible::study(&[3, 5]), hostile()] {
        let whole = latex(&study);
        let text = &whole[whole.find("\\begin{table*}").unwrap()..];
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
        let columns = |row: &str| {
            let n_wide = row.matches("\\multicolumn{3}").count();
            row.replace("\\&", "").matches(" & ").count() + 2 * n_wide
        };
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

#[test]
fn the_latex_table_gives_each_condition_its_own_objects_and_clean_value() {
    let mut study = plausible::study(&[1, 3]);
    for (place, one) in study.evaluations.iter_mut().enumerate() {
        // Two of the same name, with objects and a clean AP of their own.
        one.condition.name = "star".to_owned();
        for row in &mut one.paired {
            row.n_objects += 1000 * (1 + place as u64);
            row.clean.value = row.clean.value.map(|_| 0.111 * (1 + place) as f64);
            row.cracked.value = row.cracked.value.map(|_| 0.05 + 0.1 * place as f64);
        }
    }
    let text = latex(&study);
    assert!(
        text.contains("{star}") && text.contains("{star (2)}"),
        "two of the same name stay two"
    );
    let all = text.lines().find(|line| line.contains("& all &")).unwrap();
    let cells: Vec<&str> = all.split(" & ").collect();
    let begins = |place: usize, with: &str| {
        let cell = cells.get(place).copied().unwrap_or("");
        assert!(cell.starts_with(with), "cell {place} is {cell}, not {with}");
    };
    for (place, with) in [(4, "11.1"), (5, "5.0"), (7, "22.2"), (8, "15.0")] {
        begins(place, with);
    }
    let n_of = |place: usize| cells.get(place).unwrap().parse::<u64>().unwrap() / 1000;
    assert_eq!([n_of(3), n_of(6)], [1, 2], "each its own objects");

    let many = latex(&plausible::study(&[1, 2, 3, 4, 5]));
    assert!(
        many.contains("\\label{tab:starbreak-classes-3}"),
        "each has its label"
    );
    let n_tables = many.matches("\\begin{table*}").count();
    assert_eq!(n_tables, 3, "two conditions side by side, of five");
    assert!(many.contains("Table 3 of 3."), "the parts are numbered");
    for severity in 1..=5 {
        let head = format!("{{windshield-star, severity {severity}}}");
        assert_eq!(many.matches(&head).count(), 1, "{head} stands once");
    }
}

#[test]
fn a_span_says_how_many_conditions_have_a_number() {
    let mut study = plausible::study(&[1, 2, 3, 4, 5]);
    let one = study.evaluations.first_mut().unwrap();
    for row in &mut one.paired {
        row.delta.value = None;
    }
    let page = html(&study).unwrap();
    let facts = page.split(">Summary</h2>").nth(1).unwrap();
    let facts = facts.split("</section>").next().unwrap();
    let said: Vec<&str> = facts.split("<li>").skip(1).collect();
    assert!(
        said.iter()
            .any(|fact| fact.contains("(4 of 5 conditions have a number)")),
        "one of five has none: {said:?}"
    );
    let others = said.iter().filter(|fact| !fact.contains("4 of 5"));
    assert!(
        others.clone().count() > 0 && others.clone().all(|fact| !fact.contains("have a number")),
        "where all have one, nothing is said: {said:?}"
    );
}

#[test]
fn csv_says_only_what_is_there() {
    let mut study = plausible::study(&[2]);
    let one = study.evaluations.first_mut().unwrap();
    one.subsets = vec![starbreak_eval::SubsetRow {
        subset: "coverage 0.05 to 0.2".to_owned(),
        group: Group::all(),
        n_objects: 61,
        n_images: 20,
        clean_ap50: Estimate::of(0.41, 61),
        cracked_ap50: Some(Estimate::of(0.32, 61)),
    }];
    let rate = &mut one.failures.as_mut().unwrap().rates;
    rate.first_mut().unwrap().failure_rate = Estimate::with_interval(0.25, [0.125, 0.5], 88);
    one.paired.first_mut().unwrap().delta = Estimate::of(0.625, 77);
    let rows = rows_of(&csv(&study));
    let field = |row: &Vec<String>, place: usize| row.get(place).cloned().unwrap_or_default();
    let find = |metric: &str, value: &str| {
        let row = rows
            .iter()
            .find(|row| field(row, 6) == metric && field(row, 9) == value);
        row.cloned()
            .unwrap_or_else(|| panic!("no row {metric} of {value}"))
    };
    let subset = find("ap50[coverage 0.05 to 0.2]", &(0.32 - 0.41).to_string());
    assert_eq!(field(&subset, 14), "61", "its objects");
    let rate_row = find("failure_rate", "0.25");
    assert_eq!(
        [field(&rate_row, 10), field(&rate_row, 11)],
        ["0.125", "0.5"],
        "its interval"
    );
    for row in rows.iter().skip(1) {
        let [low, high, method] = [10, 11, 15].map(|place| field(row, place));
        assert!(
            !method.contains("95 %") || !(low.is_empty() || high.is_empty()),
            "an interval that is not there: {row:?}"
        );
        assert!(
            field(row, 9).is_empty() || field(row, 14) != "0" || method == "count",
            "a number that rests on nothing, and no count of it: {row:?}"
        );
    }
    let ap50 = find("ap50", "0.625");
    assert_eq!(field(&ap50, 15), "no interval", "a value alone");
}
