//! The JSON form: `{"units":"mm","nodes":[[x,y,z],...],"struts":[{"a":i,"b":j,"ra":r,"rb":r},...]}`.
//!
//! A sound text goes straight into `Document`. Only when that fails is it read again piece by piece (`survey`), so that
//! every fault of form is found with its path, and the rest of the content can still be checked.

use super::import::LISTED;
use super::{Graph, Input, Strut};
use crate::error::Fault;
use crate::ids::NodeId;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;
use std::io::{self, Write};

/// Unit of all lengths in the document. Lengths become millimetres when they are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Units {
    /// Micrometre.
    Um,
    /// Millimetre.
    #[default]
    Mm,
    /// Centimetre.
    Cm,
    /// Metre.
    M,
    /// Inch (25.4 mm).
    In,
    /// Foot (304.8 mm).
    Ft,
}

impl Units {
    /// A length in this unit, in mm. Also turns -0 into 0, so that equal graphs have equal bits.
    pub fn mm(self, length: f64) -> f64 {
        let mm = match self {
            Units::Um => length / 1000.0,
            Units::Mm => length,
            Units::Cm => length * 10.0,
            Units::M => length * 1000.0,
            Units::In => length * 25.4,
            Units::Ft => length * 304.8,
        };
        mm + 0.0
    }
}

/// A lattice: nodes, and struts between them with a radius at each end.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Lattice graph", rename = "Lattice")]
struct Document {
    /// Unit of all lengths; millimetres unless said otherwise.
    #[serde(default)]
    units: Units,
    /// Name of the part.
    #[serde(default)]
    name: Option<String>,
    /// Node positions [x, y, z]. Node 0 is the first.
    nodes: Vec<[f64; 3]>,
    /// The struts.
    struts: Vec<StrutForm>,
}

/// A strut between nodes `a` and `b`.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Strut")]
struct StrutForm {
    /// Index of the node at the first end.
    a: u32,
    /// Index of the node at the second end.
    b: u32,
    /// Radius at the first end.
    #[schemars(extend("exclusiveMinimum" = 0))]
    ra: f64,
    /// Radius at the second end.
    #[schemars(extend("exclusiveMinimum" = 0))]
    rb: f64,
}

/// The JSON Schema of the form, as text.
pub fn schema() -> String {
    let mut text = serde_json::to_string_pretty(&schemars::schema_for!(Document)).expect("a schema is plain JSON");
    text.push('\n');
    text
}

/// Read the form; also all faults of form. With faults, the pieces that could not be read are NaN or
/// out of range in the `Input`, and the faults name their paths.
pub fn read(bytes: &[u8]) -> (Input, Vec<Fault>) {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.strip_prefix('\u{feff}').unwrap_or(text),
        Err(e) => {
            let fault = Fault::new("document", format!("a byte that is not UTF-8 at position {}", e.valid_up_to()), "JSON in UTF-8");
            return (Input::default(), vec![fault]);
        }
    };
    let mut parser = serde_json::Deserializer::from_str(text);
    let read: Result<Document, _> = serde_path_to_error::deserialize(&mut parser);
    match read {
        Ok(document) => match parser.end() {
            Ok(()) => (document.into_input(), Vec::new()),
            Err(e) => (Input::default(), vec![first_fault("document", &e)]),
        },
        Err(e) => {
            let path = match e.path().to_string() {
                root if root == "." => "document".to_owned(),
                path => path,
            };
            let first = first_fault(&path, e.inner());
            let Ok(value) = serde_json::from_str::<Value>(&quote_non_finite(text)) else {
                return (Input::default(), vec![first]);
            };
            let (input, mut faults) = Survey::default().document(&value);
            // A field given twice is lost in a `Value`: the first reading alone has seen it.
            if faults.is_empty() || first.found.contains("duplicate field") {
                faults.push(first);
            }
            (input, faults)
        }
    }
}

/// Write the form: in mm, one node or strut a line, floats as the shortest text that reads back the same.
pub fn write(graph: &Graph, name: Option<&str>, out: &mut dyn Write) -> io::Result<()> {
    write_parts(graph.nodes(), graph.struts(), name, out)
}

/// As `write`, unchecked. All numbers are finite: a reader has found no fault of form.
pub fn write_input(input: &Input, out: &mut dyn Write) -> io::Result<()> {
    write_parts(&input.nodes, &input.struts, input.name.as_deref(), out)
}

fn write_parts(nodes: &[DVec3], struts: &[Strut], name: Option<&str>, out: &mut dyn Write) -> io::Result<()> {
    let mut float = zmij::Buffer::new();
    write!(out, "{{\"units\":\"mm\",")?;
    if let Some(name) = name {
        write!(out, "\"name\":{},", Value::from(name))?;
    }
    write!(out, "\n\"nodes\":[")?;
    for (k, p) in nodes.iter().enumerate() {
        write!(out, "{}\n[", if k == 0 { "" } else { "," })?;
        for (axis, &x) in p.as_ref().iter().enumerate() {
            write!(out, "{}{}", if axis == 0 { "" } else { "," }, float.format_finite(x))?;
        }
        write!(out, "]")?;
    }
    write!(out, "\n],\n\"struts\":[")?;
    for (k, s) in struts.iter().enumerate() {
        let comma = if k == 0 { "" } else { "," };
        write!(out, "{comma}\n{{\"a\":{},\"b\":{},\"ra\":{}", s.a.0, s.b.0, float.format_finite(s.ra))?;
        write!(out, ",\"rb\":{}}}", float.format_finite(s.rb))?;
    }
    writeln!(out, "\n]}}")
}

impl Document {
    fn into_input(self) -> Input {
        let mm = |length| self.units.mm(length);
        let strut = |s: &StrutForm| Strut { a: NodeId(s.a), b: NodeId(s.b), ra: mm(s.ra), rb: mm(s.rb) };
        Input { nodes: self.nodes.iter().map(|p| DVec3::from_array(p.map(mm))).collect(), struts: self.struts.iter().map(strut).collect(), name: self.name }
    }
}

/// The fault at which serde gave up.
fn first_fault(path: &str, error: &serde_json::Error) -> Fault {
    let wanted = match error.classify() {
        serde_json::error::Category::Data => "the form that `lattice-brep schema` prints",
        _ => "JSON",
    };
    Fault::new(if path.is_empty() { "document" } else { path }, error.to_string(), wanted)
}

/// `NaN`, `Infinity` and numbers beyond the range of a double are not JSON, but programs write them.
/// As strings they survive parsing, and each is then found with its path.
fn quote_non_finite(text: &str) -> String {
    let bytes = text.as_bytes();
    let in_token = |c: u8| c.is_ascii_alphanumeric() || matches!(c, b'+' | b'-' | b'.');
    let mut quoted = String::with_capacity(text.len() + 16);
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        if bytes[at] == b'"' {
            at += 1;
            while at < bytes.len() && bytes[at] != b'"' {
                at += if bytes[at] == b'\\' { 2 } else { 1 };
            }
            at = (at + 1).min(bytes.len());
            while !text.is_char_boundary(at) {
                at += 1;
            }
            quoted.push_str(&text[start..at]);
        } else if in_token(bytes[at]) {
            while at < bytes.len() && in_token(bytes[at]) {
                at += 1;
            }
            let token = &text[start..at];
            if token.parse::<f64>().is_ok_and(|x| !x.is_finite()) {
                quoted.push('"');
                quoted.push_str(token);
                quoted.push('"');
            } else {
                quoted.push_str(token);
            }
        } else {
            while at < bytes.len() && bytes[at] != b'"' && !in_token(bytes[at]) {
                at += 1;
            }
            quoted.push_str(&text[start..at]);
        }
    }
    quoted
}

/// Reads a document piece by piece and goes on after each fault.
#[derive(Default)]
struct Survey {
    units: Units,
    faults: Vec<Fault>,
    /// Faults beyond `LISTED`.
    not_listed: usize,
}

impl Survey {
    fn document(mut self, value: &Value) -> (Input, Vec<Fault>) {
        let mut input = Input::default();
        let Some(object) = value.as_object() else {
            self.fault("document", value, "an object with nodes and struts");
            return (input, self.faults);
        };
        self.known_fields("", object, &["units", "name", "nodes", "struts"]);
        if let Some(units) = object.get("units") {
            match Units::deserialize(units) {
                Ok(units) => self.units = units,
                Err(_) => self.fault("units", units, "one of um, mm, cm, m, in, ft"),
            }
        }
        match object.get("name") {
            None | Some(Value::Null) => {}
            Some(Value::String(name)) => input.name = Some(name.clone()),
            Some(other) => self.fault("name", other, "a string"),
        }
        match object.get("nodes") {
            Some(Value::Array(nodes)) => input.nodes = nodes.iter().enumerate().map(|(k, v)| self.node(k, v)).collect(),
            other => self.absent_or_wrong("nodes", other, "an array of nodes [x, y, z]"),
        }
        match object.get("struts") {
            Some(Value::Array(struts)) => input.struts = struts.iter().enumerate().map(|(k, v)| self.strut(k, v)).collect(),
            other => self.absent_or_wrong("struts", other, "an array of struts"),
        }
        if self.not_listed > 0 {
            self.faults.push(Fault::new("document", format!("{} more faults", self.not_listed), "none"));
            // what is left of such a text would only be refused once more, piece by piece
            input = Input::default();
        }
        (input, self.faults)
    }

    fn tell(&mut self, fault: Fault) {
        if self.faults.len() < LISTED {
            self.faults.push(fault);
        } else {
            self.not_listed += 1;
        }
    }

    fn node(&mut self, k: usize, value: &Value) -> DVec3 {
        match value {
            Value::Array(x) if x.len() == 3 => DVec3::from_array([0, 1, 2].map(|axis| self.length(|| format!("nodes[{k}][{axis}]"), Some(&x[axis])))),
            Value::Array(x) => {
                self.tell(Fault::new(format!("nodes[{k}]"), format!("{} values", x.len()), "three numbers [x, y, z]"));
                DVec3::NAN
            }
            other => {
                self.fault(&format!("nodes[{k}]"), other, "three numbers [x, y, z]");
                DVec3::NAN
            }
        }
    }

    fn strut(&mut self, k: usize, value: &Value) -> Strut {
        let path = format!("struts[{k}]");
        let Some(object) = value.as_object() else {
            self.fault(&path, value, "an object with a, b, ra, rb");
            return Strut { a: NodeId(u32::MAX), b: NodeId(u32::MAX), ra: f64::NAN, rb: f64::NAN };
        };
        self.known_fields(&format!("{path}."), object, &["a", "b", "ra", "rb"]);
        let a = self.node_index(&format!("{path}.a"), object.get("a"));
        let b = self.node_index(&format!("{path}.b"), object.get("b"));
        let ra = self.length(|| format!("{path}.ra"), object.get("ra"));
        let rb = self.length(|| format!("{path}.rb"), object.get("rb"));
        Strut { a, b, ra, rb }
    }

    fn node_index(&mut self, path: &str, value: Option<&Value>) -> NodeId {
        match value.and_then(Value::as_u64).and_then(|i| u32::try_from(i).ok()) {
            Some(i) => NodeId(i),
            None => {
                self.absent_or_wrong(path, value, "the index of a node");
                NodeId(u32::MAX)
            }
        }
    }

    /// A length in mm; NaN where there is none.
    fn length(&mut self, path: impl Fn() -> String, value: Option<&Value>) -> f64 {
        match value.and_then(Value::as_f64) {
            Some(x) => self.units.mm(x),
            None => {
                self.absent_or_wrong(&path(), value, "a finite number");
                f64::NAN
            }
        }
    }

    fn known_fields(&mut self, prefix: &str, object: &serde_json::Map<String, Value>, known: &[&str]) {
        for key in object.keys().filter(|key| !known.contains(&key.as_str())) {
            let name = if key.is_empty() { "\"\"".to_owned() } else { shortened(&key.escape_debug().to_string()) };
            let path = format!("{prefix}{name}");
            self.tell(Fault::new(path, "an unknown field", format!("only {}", known.join(", "))));
        }
    }

    fn absent_or_wrong(&mut self, path: &str, value: Option<&Value>, wanted: &str) {
        match value {
            None => self.tell(Fault::new(path, "nothing", wanted)),
            Some(value) => self.fault(path, value, wanted),
        }
    }

    fn fault(&mut self, path: &str, value: &Value, wanted: &str) {
        let found = match value {
            Value::Array(x) => format!("an array of {}", x.len()),
            Value::Object(_) => "an object".to_owned(),
            other => shortened(&other.to_string()),
        };
        self.tell(Fault::new(path, found, wanted));
    }
}

/// At most 60 characters, so that a hostile text cannot fill the screen.
fn shortened(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
