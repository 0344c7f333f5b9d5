//! The JSON form: what is read, what is refused and with which path, and what is written.

use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::json::{self, Units};
use lattice_brep::graph::{Input, Strut};
use lattice_brep::ids::NodeId;
use proptest::prelude::*;

const SOUND: &str = r#"{"units":"mm","nodes":[[0,0,0],[1,2,3]],"struts":[{"a":0,"b":1,"ra":0.5,"rb":0.25}]}"#;

fn sound(text: &str) -> Input {
    let (input, faults) = json::read(text.as_bytes());
    assert_eq!(faults, vec![], "{text}");
    input
}

/// The faults as (path, found), in the order they are told.
fn refused(text: &str) -> Vec<(String, String)> {
    json::read(text.as_bytes()).1.into_iter().map(|f| (f.path, f.found)).collect()
}

fn one(path: &str, found: &str) -> Vec<(String, String)> {
    vec![(path.to_owned(), found.to_owned())]
}

#[test]
fn sound_text_is_read_as_it_stands() {
    let input = sound(SOUND);
    assert_eq!(input.name, None);
    assert_eq!(input.nodes.iter().map(|p| p.to_array()).collect::<Vec<_>>(), [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]);
    assert_eq!(input.struts, [Strut { a: NodeId(0), b: NodeId(1), ra: 0.5, rb: 0.25 }]);
    assert_eq!(sound(&format!("\u{feff}{}", SOUND.replacen('{', r#"{"name":"lever","#, 1))).name.as_deref(), Some("lever"));
}

#[test]
fn lengths_become_millimetres() {
    for (units, one) in [("um", 0.001), ("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", 25.4), ("ft", 304.8)] {
        let input = sound(&SOUND.replace("\"mm\"", &format!("{units:?}")));
        assert_eq!(input.nodes[1].x, one, "{units}");
        assert_eq!(input.struts[0].ra, 0.5 * one, "{units}");
    }
    assert_eq!(sound(&SOUND.replace(r#""units":"mm","#, "")).nodes[1].x, 1.0);
    assert_eq!(refused(&SOUND.replace("\"mm\"", "\"furlong\"")), one("units", "\"furlong\""));
}

#[test]
fn minus_zero_becomes_zero() {
    assert!(sound(&SOUND.replace("[0,0,0]", "[-0.0,0,0]")).nodes[0].x.is_sign_positive());
    assert!(Units::In.mm(-0.0).is_sign_positive());
}

#[test]
fn not_json_names_the_place_where_it_ends() {
    let found = |text: &str| {
        let faults = refused(text);
        assert_eq!(faults.len(), 1, "{text}");
        faults.into_iter().next().unwrap()
    };
    assert_eq!(found("solid part"), ("document".into(), "expected value at line 1 column 1".into()));
    assert_eq!(found(""), ("document".into(), "EOF while parsing a value at line 1 column 0".into()));
    assert_eq!(found(&format!("{SOUND} x")), ("document".into(), format!("trailing characters at line 1 column {}", SOUND.len() + 2)));
    let (path, found) = found(&SOUND[..60]);
    assert!(path.starts_with("struts") && found.starts_with("EOF while parsing"), "{path}: {found}");
    let (_, faults) = json::read(b"{\"nodes\":\xff}");
    assert_eq!((faults.len(), faults[0].path.as_str(), faults[0].found.as_str()), (1, "document", "a byte that is not UTF-8 at position 9"));
}

#[test]
fn deep_nesting_is_refused_and_does_not_overflow_the_stack() {
    let faults = refused(&"[".repeat(1_000_000));
    assert_eq!(faults.len(), 1);
}

#[test]
fn missing_fields_are_all_named() {
    assert_eq!(refused("{}"), [one("nodes", "nothing"), one("struts", "nothing")].concat());
    let text = r#"{"nodes":[[0,0,0],[1,2]],"struts":[{"a":0,"ra":1,"rb":1},{"a":0,"b":1}]}"#;
    let expected = [one("nodes[1]", "2 values"), one("struts[0].b", "nothing"), one("struts[1].ra", "nothing"), one("struts[1].rb", "nothing")];
    assert_eq!(refused(text), expected.concat());
}

#[test]
fn unknown_fields_are_refused() {
    assert_eq!(refused(&SOUND.replacen('{', r#"{"colour":1,"#, 1)), one("colour", "an unknown field"));
    assert_eq!(
        refused(&SOUND.replace("\"rb\"", "\"r b\n\"").replace('\n', "\\n")),
        [one("struts[0].r b\\n", "an unknown field"), one("struts[0].rb", "nothing")].concat()
    );
}

#[test]
fn duplicate_fields_are_refused() {
    let faults = refused(&SOUND.replace("\"ra\":0.5", "\"ra\":0.5,\"ra\":0.6"));
    assert_eq!(faults.len(), 1);
    assert!(faults[0].0.starts_with("struts[0]") && faults[0].1.contains("duplicate field `ra`"), "{faults:?}");
}

#[test]
fn wrong_types_are_all_named() {
    assert_eq!(refused("[1]"), one("document", "an array of 1"));
    assert_eq!(refused(r#"{"nodes":7,"struts":{}}"#), [one("nodes", "7"), one("struts", "an object")].concat());
    let text = r#"{"name":5,"nodes":[[0,"x",null],7],"struts":[{"a":-1,"b":1.5,"ra":"thick","rb":[1]},3,{"a":4294967296,"b":0,"ra":1,"rb":1}]}"#;
    let expected = [
        one("name", "5"),
        one("nodes[0][1]", "\"x\""),
        one("nodes[0][2]", "null"),
        one("nodes[1]", "7"),
        one("struts[0].a", "-1"),
        one("struts[0].b", "1.5"),
        one("struts[0].ra", "\"thick\""),
        one("struts[0].rb", "an array of 1"),
        one("struts[1]", "3"),
        one("struts[2].a", "4294967296"),
    ];
    assert_eq!(refused(text), expected.concat());
}

#[test]
fn numbers_that_json_does_not_have_are_named_each_with_its_path() {
    let text = r#"{"name":"NaN \" \\","nodes":[[NaN,0,1e999],[1,-Infinity,3]],"struts":[{"a":0,"b":1,"ra":Infinity,"rb":-1e400}]}"#;
    let expected = [
        one("nodes[0][0]", "\"NaN\""),
        one("nodes[0][2]", "\"1e999\""),
        one("nodes[1][1]", "\"-Infinity\""),
        one("struts[0].ra", "\"Infinity\""),
        one("struts[0].rb", "\"-1e400\""),
    ];
    assert_eq!(refused(text), expected.concat());
    assert_eq!(json::read(text.as_bytes()).0.name.as_deref(), Some("NaN \" \\"));
}

#[test]
fn what_is_found_is_cut_short() {
    let faults = refused(&SOUND.replace("0.25", &format!("{:?}", "é".repeat(10_000))));
    assert_eq!(faults[0].0, "struts[0].rb");
    assert_eq!(faults[0].1.chars().count(), 63);
}

#[test]
fn schema_names_every_field_and_refuses_others() {
    let schema: serde_json::Value = serde_json::from_str(&json::schema()).unwrap();
    assert_eq!(schema["required"], serde_json::json!(["nodes", "struts"]));
    assert_eq!(schema["additionalProperties"], false);
    assert_eq!(schema["$defs"]["Strut"]["required"], serde_json::json!(["a", "b", "ra", "rb"]));
    assert_eq!(schema["$defs"]["Strut"]["additionalProperties"], false);
    assert_eq!(schema["$defs"]["Strut"]["properties"]["ra"]["exclusiveMinimum"], 0);
    let units: Vec<&str> = schema["$defs"]["Units"]["oneOf"].as_array().unwrap().iter().map(|u| u["const"].as_str().unwrap()).collect();
    assert_eq!(units, ["um", "mm", "cm", "m", "in", "ft"]);
}

#[test]
fn written_graph_reads_back_bit_for_bit() {
    for cell in Cell::ALL {
        let graph = generate(cell, 10.0 / 3.0, [2, 1, 3], 0.1).unwrap();
        let mut text = Vec::new();
        json::write(&graph, Some("quote \" and \\ é"), &mut text).unwrap();
        let input = sound(std::str::from_utf8(&text).unwrap());
        assert_eq!(input.nodes, graph.nodes(), "{}", cell.name());
        assert_eq!(input.struts, graph.struts(), "{}", cell.name());
        assert_eq!(input.name.as_deref(), Some("quote \" and \\ é"));
    }
}

#[test]
fn written_text_has_one_node_or_strut_a_line() {
    let graph = generate(Cell::Cubic, 1.0, [1, 1, 1], 0.125).unwrap();
    let mut text = Vec::new();
    json::write(&graph, None, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.starts_with("{\"units\":\"mm\",\n\"nodes\":[\n[0.0,0.0,0.0],\n[1.0,0.0,0.0],\n"), "{text}");
    assert!(text.ends_with("{\"a\":6,\"b\":7,\"ra\":0.125,\"rb\":0.125}\n]}\n"), "{text}");
    assert_eq!(text.lines().count(), 5 + 8 + 12);
}

proptest! {
    #[test]
    fn spoilt_text_is_read_or_refused_without_panic(at in 0..SOUND.len(), spoil in r#"[\\"\[\]{}:,0-9a-zNé+.\-]{0,6}"#, cut in 0..8usize) {
        let end = (at + cut).min(SOUND.len());
        let text = format!("{}{spoil}{}", &SOUND[..at], &SOUND[end..]);
        let (input, faults) = json::read(text.as_bytes());
        // Whatever is refused leaves the checks something they can look at, and a path to every fault.
        prop_assert!(faults.iter().all(|f| !f.path.is_empty() && !f.found.is_empty() && !f.wanted.is_empty()));
        if faults.is_empty() {
            prop_assert!(serde_json::from_str::<serde_json::Value>(&text).is_ok());
        }
        let _ = lattice_brep::graph::check::admit(input, faults, Default::default());
    }
}
