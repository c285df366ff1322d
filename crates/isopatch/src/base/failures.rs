//! Collapses that failed: they would again, as long as nothing near changes.

/// When something changed around each vertex, and when each half edge could not be collapsed, by a clock that changes tick.
#[derive(Clone, Debug)]
pub(super) struct Failures {
    clock: u64,
    /// By vertex.
    changed: Vec<u64>,
    /// By slot and side; zero for one that was not tried.
    tried: Vec<[u64; 3]>,
}

impl Failures {
    pub fn new(vertices: usize, slots: usize) -> Self {
        Self { clock: 1, changed: vec![0; vertices], tried: vec![[0; 3]; slots] }
    }

    /// Something has changed in the faces at these vertices, some of which may be new.
    pub fn change(&mut self, vertices: impl IntoIterator<Item = u32>) {
        self.clock += 1;
        for v in vertices.into_iter().map(|v| v as usize) {
            if v >= self.changed.len() {
                self.changed.resize(v + 1, 0);
            }
            self.changed[v] = self.clock;
        }
    }

    /// Side `side` of the face in a slot can't be collapsed as things are.
    pub fn note(&mut self, slot: u32, side: usize) {
        let slot = slot as usize;
        if slot >= self.tried.len() {
            self.tried.resize(slot + 1, [0; 3]);
        }
        self.tried[slot][side] = self.clock;
    }

    /// Has it failed, and nothing changed since at these vertices, those of the faces at its ends?
    pub fn stands(&self, slot: u32, side: usize, region: impl IntoIterator<Item = u32>) -> bool {
        let tried = self.tried.get(slot as usize).map_or(0, |sides| sides[side]);
        tried > 0 && region.into_iter().all(|v| self.changed.get(v as usize).is_none_or(|at| *at <= tried))
    }
}
