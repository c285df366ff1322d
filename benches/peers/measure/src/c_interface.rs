//! The functions for peers in C, C++ and Python.

use crate::surface::{Surface, Work};

/// Number of a surface in the functions below: its place in [`Surface::ALL`].
fn numbered(surface: u32) -> Surface {
    Surface::ALL[surface as usize % Surface::ALL.len()]
}

/// f at a point.
#[unsafe(no_mangle)]
pub extern "C" fn peer_value(surface: u32, x: f64, y: f64, z: f64) -> f64 {
    numbered(surface).value([x, y, z])
}

struct Grid<'a> {
    origin: [f64; 3],
    step: f64,
    size: [usize; 3],
    values: &'a mut [f32],
}

impl Work<f64> for Grid<'_> {
    type Output = ();
    fn run(self, f: impl Fn([f64; 3]) -> f64) {
        let [nx, ny, _] = self.size;
        // Through i32, which every vector unit converts.
        let at = |axis: usize, i: usize| self.origin[axis] + self.step * f64::from(i as i32);
        for (row, values) in self.values.chunks_exact_mut(nx).enumerate() {
            let [y, z] = [at(1, row % ny), at(2, row / ny)];
            for (i, value) in values.iter_mut().enumerate() {
                *value = f([at(0, i), y, z]) as f32;
            }
        }
    }
}

/// f on a grid, x fastest: computed in double precision and stored in single precision, which keeps the place of the zeros.
///
/// # Safety
/// `origin` has three numbers, `size` too, and `values` has room for their product.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_grid(
    surface: u32,
    origin: *const f64,
    step: f64,
    size: *const usize,
    values: *mut f32,
) {
    // SAFETY: the caller's promise.
    let (origin, size) = unsafe { (*origin.cast::<[f64; 3]>(), *size.cast::<[usize; 3]>()) };
    // SAFETY: the caller's promise.
    let values = unsafe { std::slice::from_raw_parts_mut(values, size.iter().product()) };
    numbered(surface).with(Grid { origin, step, size, values });
}
