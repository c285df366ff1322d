use std::fmt;

/// Places that a text names before it only counts.
const NAMED_PLACES: usize = 10;

/// An element of the input mesh, by the numbers that it has there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// A vertex.
    Vertex(u32),
    /// A vertex, and another that takes its place.
    VertexInto(u32, u32),
    /// A face.
    Face(u32),
    /// A face, and an earlier one with the same corners.
    FaceLike(u32, u32),
    /// The edge between two vertices.
    Edge(u32, u32),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vertex(v) => write!(f, "vertex {v}"),
            Self::VertexInto(v, kept) => write!(f, "vertex {v} into {kept}"),
            Self::Face(face) => write!(f, "face {face}"),
            Self::FaceLike(face, kept) => write!(f, "face {face} (as {kept})"),
            Self::Edge(a, b) => write!(f, "edge {a}–{b}"),
        }
    }
}

/// The first ten of some places, as a text.
pub fn place_names(places: &[Place]) -> String {
    let named: Vec<String> = places.iter().take(NAMED_PLACES).map(Place::to_string).collect();
    named.join(", ") + if places.len() > NAMED_PLACES { ", …" } else { "" }
}

/// A kind of change to a mesh, or of departure from a clean one that stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RepairKind {
    /// Vertices at one place became one.
    WeldedVertex,
    /// A face that names a vertex twice became its simple loops, or nothing if it has none.
    RepeatedCorner,
    /// One of several faces with the same corners was dropped. (A wall that two bodies have in common is no case of it.)
    DuplicateFace,
    /// A face without area was dropped.
    FlatFace,
    /// A face without area between two others was dropped, and its middle corner was put into the edge opposite.
    FlatFaceStitched,
    /// A face without area stays: without it there would be a slit.
    FlatFaceKept,
    /// Sheets that meet in an edge of more than two faces were taken apart there.
    CutEdge,
    /// The surface was cut open where no consistent orientation exists.
    TornEdge,
    /// A vertex where several fans of faces meet was given to one of them, the others got copies.
    SplitVertex,
    /// A face was turned over to agree with its neighbours.
    FlippedFace,
    /// A closed component was turned inside out; its first face is named.
    TurnedComponent,
    /// The orientation of a closed component was not tested for lying in another one; its first face is named.
    UntestedNesting,
    /// A vertex that no face uses was dropped.
    UnusedVertex,
}

impl RepairKind {
    /// What was done.
    pub fn what(self) -> &'static str {
        match self {
            Self::WeldedVertex => "vertices welded",
            Self::RepeatedCorner => "faces reduced to their simple loops",
            Self::DuplicateFace => "duplicate faces dropped",
            Self::FlatFace => "faces without area dropped",
            Self::FlatFaceStitched => "faces without area closed into their neighbours",
            Self::FlatFaceKept => "faces without area kept",
            Self::CutEdge => "sheets taken apart at edges",
            Self::TornEdge => "surface cut open at edges",
            Self::SplitVertex => "vertices split",
            Self::FlippedFace => "faces turned over",
            Self::TurnedComponent => "closed components turned inside out",
            Self::UntestedNesting => "closed components turned outward without a test for nesting",
            Self::UnusedVertex => "vertices dropped",
        }
    }

    /// Why it was done.
    pub fn why(self) -> &'static str {
        match self {
            Self::WeldedVertex => "they lie at one place",
            Self::RepeatedCorner => "they name a vertex more than once",
            Self::DuplicateFace => "they have the corners of an earlier face",
            Self::FlatFace => "their corners lie on a line",
            Self::FlatFaceStitched => "their corners lie on a line, and a T-junction would be left",
            Self::FlatFaceKept => "their corners lie on a line, but without them there would be a slit",
            Self::CutEdge => {
                "more than two faces meet there; all are kept, so that a fin becomes an open sheet"
            }
            Self::TornEdge => "the faces on both sides can't be oriented alike",
            Self::SplitVertex => "the faces around them form more than one fan",
            Self::FlippedFace => "they are oriented against their neighbours",
            Self::TurnedComponent => "their normals pointed to the wrong side",
            Self::UntestedNesting => "there are too many components to test",
            Self::UnusedVertex => "no face uses them",
        }
    }
}

/// All repairs of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshRepair {
    /// What was done, and why.
    pub kind: RepairKind,
    /// Where: every place, in the numbers of the input.
    pub places: Vec<Place>,
}

impl MeshRepair {
    /// What was done, with the number of places.
    pub fn what(&self) -> String {
        format!("{}: {}", self.kind.what(), self.places.len())
    }

    /// Where: the first ten places.
    pub fn place(&self) -> String {
        place_names(&self.places)
    }

    /// For which reason.
    pub fn why(&self) -> &'static str {
        self.kind.why()
    }
}

impl fmt::Display for MeshRepair {
    /// `vertices welded: 2 (they lie at one place): vertex 5 into 1, vertex 6 into 2`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}): {}", self.what(), self.why(), self.place())
    }
}

/// Collects repairs, kind by kind in the order of their first places.
#[derive(Clone, Debug, Default)]
pub(super) struct Log(Vec<MeshRepair>);

impl Log {
    /// Notes a repair.
    pub fn note(&mut self, kind: RepairKind, place: Place) {
        match self.0.iter_mut().find(|r| r.kind == kind) {
            Some(repair) => repair.places.push(place),
            None => self.0.push(MeshRepair { kind, places: vec![place] }),
        }
    }

    /// Forgets the places of one kind that `keep` turns down.
    pub fn retain(&mut self, kind: RepairKind, keep: impl Fn(&Place) -> bool) {
        self.0.iter_mut().filter(|r| r.kind == kind).for_each(|r| r.places.retain(&keep));
        self.0.retain(|r| !r.places.is_empty());
    }

    /// All that was noted.
    pub fn into_repairs(self) -> Vec<MeshRepair> {
        self.0
    }
}
