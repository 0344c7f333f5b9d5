//! `Model` of units and their instances ▶ Part 21 text of an assembly: units placed in nested sub-assemblies ("blocks").
//!
//! OCC's XDE reader takes a time that grows with the square of what stands in one assembly, and with the square of how often one product is
//! placed. So no block has many members, and each block has its own product of a unit; all products of a unit share one geometry.

use super::groups::{Member, groups};
use super::options::StepOptions;
use super::template::fill;
use super::text::{push_list, push_real};
use super::write::{Facts, StepError, Written, check, decimals, has_extras, numbers, preamble, write_solids};
use crate::brep::{Instance, Model};
use glam::DVec3;
use std::collections::HashMap;
use std::io::Write;

/// Most that stands directly in one block. Measured: docs/decisions/0007-assembly.md.
const MOST_MEMBERS: usize = 256;

/// A product with its shape, one more product of the same geometry, and a place in a block, and how many entities each has.
pub(super) const PART: (&str, u64) = (include_str!("../../step_templates/assembly_part.txt"), 7);
const AGAIN: (&str, u64) = (include_str!("../../step_templates/assembly_again.txt"), 8);
pub(super) const MEMBER: (&str, u64) = (include_str!("../../step_templates/assembly_member.txt"), 7);

/// Write an assembly: each solid of the model is a part of its own, placed where its instances stand.
pub fn write_assembly(model: &Model, instances: &[Instance], facts: &Facts, options: &StepOptions, mut out: impl Write + Send) -> Result<Written, StepError> {
    check(&model.solids, facts, options)?;
    if !has_extras(options.schema) {
        return Err(StepError::NoAssembly);
    }
    let (numbers, next) = numbers(&model.solids);
    let blocks = groups(&instances.iter().map(|i| i.at).collect::<Vec<_>>(), MOST_MEMBERS);
    let products = Products::new(&blocks, instances, model.solids.len(), next);
    let members: usize = blocks.iter().map(Vec::len).sum();
    let first_of = |member: usize| products.next + MEMBER.1 * member as u64;
    // a line for every few, as in shells
    let placement = |k: usize| format!("{},#{}", if k % 16 == 15 { "\n" } else { "" }, first_of(k) + 1);
    let mut before = 0;
    let mut placements = blocks.iter().map(|block| {
        before += block.len();
        (before - block.len()..before).map(placement).collect::<String>()
    });
    let decimals = decimals(&model.solids, options);
    let of_whole = placements.next().expect("the whole is a block");
    out.write_all(preamble("SHAPE_REPRESENTATION", &of_whole, &numbers, facts, decimals, options).as_bytes())?;
    write_solids(&mut out, &model.solids, &numbers, "unit", decimals, options)?;

    for (k, (ids, uses)) in numbers.iter().zip(&products.of_units).enumerate() {
        let (name, items) = (format!("'unit_{}'", k + 1), format!(",#{}", ids.brep));
        let values = [("name", &name[..]), ("kind", "ADVANCED_BREP_SHAPE_REPRESENTATION"), ("items", &items)];
        out.write_all(numbered(PART, uses[0].first, &values).as_bytes())?;
        let geometry = uses[0].shape.to_string();
        for (n, again) in (2..).zip(&uses[1..]) {
            let name = format!("'unit_{}_{n}'", k + 1);
            out.write_all(numbered(AGAIN, again.first, &[("name", &name), ("geometry", &geometry)]).as_bytes())?;
        }
    }
    for (g, items) in (1..).zip(placements) {
        let name = format!("'block_{g}'");
        let values = [("name", &name[..]), ("kind", "SHAPE_REPRESENTATION"), ("items", &items)];
        out.write_all(numbered(PART, products.of_blocks[g].first, &values).as_bytes())?;
    }
    let of_blocks = blocks.iter().zip(&products.of_blocks);
    for (k, ((whole, &member), placed)) in of_blocks.flat_map(|(block, whole)| block.iter().map(move |m| (whole, m))).zip(&products.placed).enumerate() {
        let (name, at) = match member {
            Member::Instance(i) => (format!("node_{}", instances[i].node.0), instances[i].at),
            Member::Group(g) => (format!("block_{g}"), DVec3::ZERO),
        };
        out.write_all(member_text(first_of(k), k + 1, &name, at, *placed, *whole).as_bytes())?;
    }
    out.write_all(include_str!("../../step_templates/footer.txt").as_bytes())?;
    out.flush()?;
    Ok(Written { last_entity: first_of(members) - 1 })
}

/// Numbers of a product's entities, as in the templates.
#[derive(Clone, Copy)]
pub(super) struct Product {
    pub first: u64,
    pub definition: u64,
    pub shape: u64,
}

impl Product {
    /// By the templates.
    pub(super) fn at(first: u64) -> Product {
        Product { first, definition: first + 3, shape: first + 6 }
    }
}

/// What stands in an assembly, at a place (mm).
pub(super) fn member_text(first: u64, number: usize, name: &str, at: DVec3, placed: Product, whole: Product) -> String {
    let mut place = vec![];
    push_list(&mut place, at.to_array(), push_real);
    let place = String::from_utf8(place).expect("reals are ASCII");
    let ids = [number as u64, placed.definition, placed.shape, whole.definition, whole.shape].map(|id| id.to_string());
    let names = ["number", "definition", "shape", "whole", "whole_shape"];
    let ids = names.iter().zip(&ids).map(|(&name, id)| (name, &id[..]));
    let values: Vec<(&str, &str)> = [("at", &place[..]), ("name", name)].into_iter().chain(ids).collect();
    numbered(MEMBER, first, &values)
}

/// The file's own product: the whole assembly.
pub(super) const WHOLE: Product = Product { first: 4, definition: 8, shape: 11 };

/// The numbers of all products, and the next free one.
struct Products {
    /// By unit, then one for each block that places it. The first holds the geometry.
    of_units: Vec<Vec<Product>>,
    of_blocks: Vec<Product>,
    /// By member, of all blocks in turn: what is placed there.
    placed: Vec<Product>,
    next: u64,
}

impl Products {
    fn new(blocks: &[Vec<Member>], instances: &[Instance], units: usize, mut next: u64) -> Self {
        // in the order of units, each with its blocks in their order
        let mut users: Vec<Vec<usize>> = vec![vec![]; units];
        let unit_of = |member: &Member| if let Member::Instance(i) = *member { Some(instances[i].unit as usize) } else { None };
        for (b, block) in blocks.iter().enumerate() {
            for unit in block.iter().filter_map(unit_of) {
                if users[unit].last() != Some(&b) {
                    users[unit].push(b);
                }
            }
        }
        let mut take = |count: u64| {
            next += count;
            Product::at(next - count)
        };
        let of_unit = |blocks: &Vec<usize>| (0..blocks.len()).map(|n| take(if n == 0 { PART.1 } else { AGAIN.1 })).collect();
        let of_units: Vec<Vec<Product>> = users.iter().map(of_unit).collect();
        let of_blocks: Vec<Product> = std::iter::once(WHOLE).chain((1..blocks.len()).map(|_| take(PART.1))).collect();
        let by_use: HashMap<(usize, usize), Product> =
            users.iter().zip(&of_units).enumerate().flat_map(|(unit, (blocks, made))| blocks.iter().zip(made).map(move |(&b, &p)| ((unit, b), p))).collect();
        let placed = |(b, member): (usize, &Member)| match *member {
            Member::Instance(i) => by_use[&(instances[i].unit as usize, b)],
            Member::Group(g) => of_blocks[g],
        };
        let placed = blocks.iter().enumerate().flat_map(|(b, block)| block.iter().map(move |m| (b, m))).map(placed).collect();
        Products { of_units, placed, of_blocks, next }
    }
}

/// A template whose entities `{1}`, `{2}`, ... are numbered from `first` on.
pub(super) fn numbered((template, count): (&str, u64), first: u64, values: &[(&str, &str)]) -> String {
    let numbers: Vec<(String, String)> = (1..=count).map(|k| (k.to_string(), (first + k - 1).to_string())).collect();
    let all: Vec<(&str, &str)> = numbers.iter().map(|(name, id)| (&name[..], &id[..])).chain(values.iter().copied()).collect();
    fill(template, &all)
}
