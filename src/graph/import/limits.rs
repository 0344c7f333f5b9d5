//! How much a reader takes, so that memory is bounded by the bytes that are really there.

/// Largest file (bytes): 1 GiB. Reason: fifty times the largest lattice known to us (a million struts as 3MF text); a file
/// of this size still fits the memory of a small machine. Guessed.
pub const FILE_BYTES: u64 = 1 << 30;
/// Most nodes, and most struts, of one lattice. Reason: ten million struts take about 1 GB here and far more as a solid.
/// It bounds what a short file can multiply to (instances of instances). Guessed.
pub const PIECES: usize = 10_000_000;
/// Most faults and most notes listed. Reason: more than anyone reads; a file of nothing but faults must not fill the memory.
pub const LISTED: usize = 10_000;
/// Most characters of the source shown in a message. Reason: one line of a terminal; a hostile text must not fill the screen.
pub const SHOWN: usize = 60;
/// Most bytes unpacked from a packed file: sixteen megabytes and a hundred times the packed size, at most half a gigabyte.
/// Reason: lattices as XML pack to a tenth or less, at best a thirtieth; bombs to a thousandth. Guessed.
pub fn unpacked(packed: usize) -> u64 {
    ((16 << 20) + 100 * packed as u64).min(512 << 20)
}
/// Deepest nesting of XML elements. Reason: the formats need ten.
pub const XML_DEPTH: usize = 64;
/// Deepest nesting of 3MF components. Reason: real files need three; a ring would not end.
pub const COMPONENT_DEPTH: usize = 16;
/// Most instances of 3MF objects. Reason: components of components multiply; a build plate holds some hundreds. Guessed.
pub const INSTANCES: usize = 100_000;
/// Bytes looked at to find the format. Reason: comments come first in most formats, rarely more than a page of them.
pub const SNIFFED: usize = 4096;
/// Ends nearer than this are one node, in formats that give ends and not nodes (as a fraction of the bounding box's
/// diagonal). Reason: coordinates are written with six digits or more; far below any strut. Guessed.
pub const ONE_END: f64 = 1e-6;
