//! Legacy VTK files, ASCII: unstructured grids and polydata, versions 2 to 5.
//!
//! Words are read one after the other; a keyword says how many numbers follow. Fewer than it says is a fault, and no memory is
//! set aside for more than are there. Words that belong to nothing we need are passed over.

use super::draft::Draft;
use super::grid::{Grid, is_radius};
use super::mesh::Edges;
use super::text;
use std::iter::Peekable;

pub const START: &str = "# vtk DataFile";

struct Words<'t, I: Iterator<Item = (u32, &'t str)>> {
    words: Peekable<I>,
    at: u32,
}

pub fn read(bytes: &[u8], draft: &mut Draft) {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines();
    let form = lines.nth(2).unwrap_or_default().trim().to_ascii_uppercase();
    if form != "ASCII" {
        let found = if form == "BINARY" { "a binary file".to_owned() } else { text::quoted(Some(&form)).to_string() };
        return draft.fault(Draft::line(3), found, "ASCII; or save as .vtu, which may be binary");
    }
    let words = lines.zip(4u32..).flat_map(|(line, at)| line.split_whitespace().map(move |w| (at, w)));
    let mut edges = Edges::default();
    if let Some(grid) = (Words { words: words.peekable(), at: 3 }).grid(draft) {
        grid.pour("", &mut edges, draft);
        edges.note(draft);
    }
}

impl<'t, I: Iterator<Item = (u32, &'t str)>> Words<'t, I> {
    fn next(&mut self) -> Option<&'t str> {
        let (at, word) = self.words.next()?;
        self.at = at;
        Some(word)
    }

    fn count(&mut self, draft: &mut Draft, what: &str) -> Option<usize> {
        let word = self.next();
        let count = word.and_then(|w| w.parse().ok());
        if count.is_none() {
            draft.fault(Draft::line(self.at), text::quoted(word), format!("the number of {what}"));
        }
        count
    }

    /// So many numbers; they end at the first word that is none.
    fn numbers(&mut self, count: usize, what: &str, draft: &mut Draft) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        while numbers.len() < count {
            let Some(number) = self.words.peek().and_then(|(_, w)| w.parse().ok()) else {
                let next = self.words.peek().map(|w| w.1);
                let found = format!("{count} {what} claimed, then {} and {}", numbers.len(), text::quoted(next));
                draft.fault(Draft::line(self.words.peek().map_or(self.at, |w| w.0)), found, "as many as the count says");
                return None;
            };
            self.next();
            numbers.push(number);
        }
        Some(numbers)
    }

    fn grid(mut self, draft: &mut Draft) -> Option<Grid> {
        let mut grid = Grid::default();
        let mut is_polydata = false;
        // whose data follow, and how many
        let mut of_points: Option<(bool, usize)> = None;
        while let Some(word) = self.next() {
            match (word.to_ascii_uppercase().as_str(), of_points) {
                ("DATASET", _) => {
                    let kind = self.next();
                    is_polydata = kind == Some("POLYDATA");
                    if !is_polydata && kind != Some("UNSTRUCTURED_GRID") {
                        draft.fault(Draft::line(self.at), text::quoted(kind), "UNSTRUCTURED_GRID or POLYDATA");
                        return None;
                    }
                }
                ("POINTS", _) => {
                    let count = self.count(draft, "points")?;
                    self.next();
                    grid.points = self.numbers(count.saturating_mul(3), "coordinates", draft)?;
                }
                ("CELLS", _) if !is_polydata => self.cells(&mut grid, None, draft)?,
                ("VERTICES", _) if is_polydata => self.cells(&mut grid, Some(2.0), draft)?,
                ("LINES", _) if is_polydata => self.cells(&mut grid, Some(4.0), draft)?,
                ("POLYGONS", _) if is_polydata => self.cells(&mut grid, Some(7.0), draft)?,
                ("TRIANGLE_STRIPS", _) if is_polydata => self.cells(&mut grid, Some(6.0), draft)?,
                ("CELL_TYPES", _) => {
                    let count = self.count(draft, "cell types")?;
                    grid.types = self.numbers(count, "cell types", draft)?;
                }
                ("POINT_DATA", _) => of_points = Some((true, self.count(draft, "points")?)),
                ("CELL_DATA", _) => of_points = Some((false, self.count(draft, "cells")?)),
                ("SCALARS", Some((of_points, count))) => {
                    let name = self.next().unwrap_or_default();
                    self.next();
                    let components = match self.words.peek().and_then(|w| w.1.parse().ok()) {
                        Some(components) => {
                            self.next();
                            components
                        }
                        None => 1,
                    };
                    if self.words.peek().is_some_and(|w| w.1.eq_ignore_ascii_case("LOOKUP_TABLE")) {
                        self.next();
                        self.next();
                    }
                    self.data(name, components, count, of_points, &mut grid, draft)?;
                }
                ("FIELD", Some((of_points, _))) => {
                    self.next();
                    for _ in 0..self.count(draft, "arrays")? {
                        let Some(name) = self.next() else { break };
                        let (components, count) = (self.count(draft, "components")?, self.count(draft, "values")?);
                        self.next();
                        self.data(name, components, count, of_points, &mut grid, draft)?;
                    }
                }
                _ => {}
            }
        }
        Some(grid)
    }

    fn data(&mut self, name: &str, components: usize, count: usize, of_points: bool, grid: &mut Grid, draft: &mut Draft) -> Option<()> {
        if self.words.peek().is_some_and(|w| w.1.parse::<f64>().is_err()) {
            return Some(()); // an array of strings: passed over word by word
        }
        let values = self.numbers(count.saturating_mul(components), "values", draft)?;
        if is_radius(name) && components == 1 {
            *(if of_points { &mut grid.point_radius } else { &mut grid.cell_radius }) = Some(values);
        }
        Some(())
    }

    /// Cells of one kind (or of the kinds that CELL_TYPES gives). Up to version 4: count and points of each cell; from 5 on: offsets,
    /// one more than cells, then points.
    fn cells(&mut self, grid: &mut Grid, kind: Option<f64>, draft: &mut Draft) -> Option<()> {
        let (first, second) = (self.count(draft, "cells")?, self.count(draft, "values")?);
        let base = grid.connectivity.len() as f64;
        let before = grid.ends.len();
        if self.words.peek().is_some_and(|w| w.1 == "OFFSETS") {
            self.next();
            self.next();
            let offsets = self.numbers(first, "offsets", draft)?;
            if self.next() != Some("CONNECTIVITY") {
                draft.fault(Draft::line(self.at), "no CONNECTIVITY", "CONNECTIVITY after OFFSETS");
                return None;
            }
            self.next();
            grid.connectivity.extend(self.numbers(second, "point numbers", draft)?);
            grid.ends.extend(offsets.iter().skip(1).map(|end| base + end));
        } else {
            let values = self.numbers(second, "values", draft)?;
            let mut rest = &values[..];
            while let Some((&count, more)) = rest.split_first() {
                let cell = if count >= 0.0 { more.get(..count as usize) } else { None };
                let Some(cell) = cell else {
                    draft.fault(Draft::line(self.at), format_args!("a cell of {count} points, then {} values", more.len()), "as many as the count says");
                    return None;
                };
                grid.connectivity.extend(cell);
                grid.ends.push(grid.connectivity.len() as f64);
                rest = &more[cell.len()..];
            }
            if grid.ends.len() - before != first {
                draft.fault(Draft::line(self.at), format_args!("{first} cells claimed, then {}", grid.ends.len() - before), "as many as the count says");
                return None;
            }
        }
        if let Some(kind) = kind {
            grid.types.resize(grid.ends.len(), kind);
        }
        Some(())
    }
}
