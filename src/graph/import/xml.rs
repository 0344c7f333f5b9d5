//! XML as the lattice formats need it: elements and attributes by local name. Refused: a DTD, entities of its own, other encodings
//! than UTF-8, nesting beyond `limits::XML_DEPTH`. Everything borrows from the text, so nothing grows beyond it.

use super::{limits, text};
use crate::error::Fault;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::name::ResolveResult;
use quick_xml::reader::NsReader;
use std::borrow::Cow;

/// The next thing in the text. An empty element is opened and closed.
pub enum Piece<'a> {
    Open(Tag<'a>),
    Text(Cow<'a, str>),
    /// The innermost open element ends; its local name, empty if its namespace is not one of those asked for.
    Close(Cow<'static, str>),
}

pub struct Tag<'a> {
    start: BytesStart<'a>,
    /// The namespace is one of those asked for, or there is none.
    is_known: bool,
}

impl Tag<'_> {
    /// The local name; empty if the namespace is not one of those asked for.
    pub fn name(&self) -> &str {
        let name = &self.start[..self.start.find(|c: char| c.is_ascii_whitespace() || c == '/').unwrap_or(self.start.len())];
        if self.is_known { name.rsplit(':').next().unwrap_or_default() } else { "" }
    }

    /// The value of an attribute of this local name, without blanks around it.
    pub fn get(&self, name: &str) -> Option<Cow<'_, str>> {
        let mut attributes = self.start.attributes();
        let mut all = attributes.with_checks(false).flatten();
        let value = all.find(|a| a.key.local_name().as_ref() == name)?.normalized_value(XmlVersion::Implicit1_0).ok()?;
        Some(match value {
            Cow::Borrowed(value) => Cow::Borrowed(value.trim()),
            Cow::Owned(value) => Cow::Owned(value.trim().to_owned()),
        })
    }
}

pub struct Xml<'a> {
    reader: NsReader<&'a [u8]>,
    text: &'a str,
    /// Parts of the names of the namespaces whose elements are wanted; none: all.
    spaces: &'static [&'static str],
    /// What stands before a place in a fault: the name of the file within the file, or nothing.
    file: String,
    open: Vec<Cow<'static, str>>,
}

/// The bytes as text, or what is wrong with them.
pub fn decode<'a>(bytes: &'a [u8], file: &str) -> Result<&'a str, Fault> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes)
        .map_err(|e| Fault::new(format!("{file}document"), format!("a byte that is not UTF-8 at position {}", e.valid_up_to()), "XML in UTF-8"))
}

impl<'a> Xml<'a> {
    pub fn new(text: &'a str, spaces: &'static [&'static str], file: String) -> Self {
        let mut reader = NsReader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Xml { reader, text, spaces, file, open: Vec::new() }
    }

    /// The place reached, as line and column.
    fn fault(&self, found: impl Into<String>, wanted: impl Into<String>) -> Fault {
        let at = (self.reader.error_position().max(self.reader.buffer_position()) as usize).min(self.text.len());
        let before = &self.text.as_bytes()[..at];
        let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
        let column = at - before.iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1) + 1;
        Fault::new(format!("{}line {line}, column {column}", self.file), found, wanted)
    }

    /// `None` at the end of the document. After a fault there is nothing more to read.
    pub fn next(&mut self) -> Result<Option<Piece<'a>>, Fault> {
        loop {
            let event = match self.reader.read_resolved_event() {
                Ok((space, event)) => {
                    let is_known = match space {
                        ResolveResult::Bound(space) => self.spaces.is_empty() || self.spaces.iter().any(|part| space.as_ref().contains(part)),
                        ResolveResult::Unbound | ResolveResult::Unknown(_) => true,
                    };
                    (is_known, event)
                }
                Err(e) => return Err(self.fault(text::shown(&e.to_string()), "well-formed XML")),
            };
            match event {
                (is_known, Event::Start(start)) => {
                    let broken = start.attributes().with_checks(false).find_map(|a| match a {
                        Err(e) => Some(e.to_string()),
                        Ok(a) => a.normalized_value(XmlVersion::Implicit1_0).err().map(|e| e.to_string()),
                    });
                    if let Some(broken) = broken {
                        return Err(self.fault(text::shown(&broken), "well-formed attributes, without entities of their own"));
                    }
                    let tag = Tag { start, is_known };
                    self.open.push(known_name(tag.name()));
                    if self.open.len() > limits::XML_DEPTH {
                        return Err(self.fault(format!("elements nested {} deep", self.open.len()), format!("at most {}", limits::XML_DEPTH)));
                    }
                    return Ok(Some(Piece::Open(tag)));
                }
                (_, Event::End(_)) => return Ok(Some(Piece::Close(self.open.pop().unwrap_or_default()))),
                (_, Event::Text(t)) => return Ok(Some(Piece::Text(t.into_inner()))),
                (_, Event::CData(t)) => return Ok(Some(Piece::Text(t.into_inner()))),
                (_, Event::GeneralRef(r)) => {
                    let character = if r.is_char_ref() { r.resolve_char_ref().ok().flatten().map(|c| c.to_string()) } else { predefined(&r.into_inner()) };
                    match character {
                        Some(character) => return Ok(Some(Piece::Text(Cow::Owned(character)))),
                        None => return Err(self.fault("an entity", "text without entities of its own")),
                    }
                }
                (_, Event::DocType(_)) => return Err(self.fault("a DTD (<!DOCTYPE)", "XML without DTD and entities")),
                (_, Event::Decl(decl)) => {
                    let encoding = decl.encoding().and_then(Result::ok).map(|e| e.to_ascii_lowercase());
                    if encoding.as_deref().is_some_and(|e| !["utf-8", "utf8", "us-ascii", "ascii"].contains(&e)) {
                        return Err(self.fault(format!("encoding {}", text::shown(&encoding.unwrap_or_default())), "UTF-8"));
                    }
                }
                (_, Event::Comment(_) | Event::PI(_) | Event::Empty(_)) => {}
                (_, Event::Eof) if self.open.is_empty() => return Ok(None),
                (_, Event::Eof) => return Err(self.fault("the end of the text", format!("an end of <{}>", text::shown(&self.open[self.open.len() - 1])))),
            }
        }
    }
}

fn predefined(name: &str) -> Option<String> {
    quick_xml::escape::resolve_predefined_entity(name).map(str::to_owned)
}

/// The names that come by the million need no memory of their own.
fn known_name(name: &str) -> Cow<'static, str> {
    const OFTEN: [&str; 8] = ["vertex", "beam", "triangle", "node", "ball", "ref", "vertices", "beams"];
    OFTEN.iter().find(|n| **n == name).map_or_else(|| Cow::Owned(name.to_owned()), |n| Cow::Borrowed(*n))
}

/// The root element's local name, for telling formats apart; looks no further than the first element.
pub fn root(head: &str) -> Option<String> {
    let mut rest = head;
    loop {
        rest = &rest[rest.find('<')? + 1..];
        rest = match rest {
            r if r.starts_with('?') => &r[r.find("?>")?..],
            r if r.starts_with("!--") => &r[r.find("-->")?..],
            r if r.starts_with('!') => &r[1..],
            r => {
                let name = &r[..r.find(|c: char| c.is_whitespace() || c == '>' || c == '/').unwrap_or(r.len())];
                return Some(name.rsplit(':').next().unwrap_or_default().to_owned());
            }
        };
    }
}
