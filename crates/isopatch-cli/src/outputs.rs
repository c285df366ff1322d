//! The files that a command writes: checked before the work, written all or none after it.

use crate::failure::Failure;
use crate::interrupt::{Interruptible, Writing};
use clap::ValueEnum;
use isopatch::io::atomic::Outputs;
use isopatch::io::native::{NativeModel, write_native};
use isopatch::io::{Format, WriteError, gltf, obj, ply, step, stl, vtk};
use isopatch::tessellate::{TessellateOptions, Tessellation, tessellate};
use std::collections::HashSet;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file to write.
#[derive(Clone, Debug)]
pub struct OutputFile {
    pub path: PathBuf,
    pub format: Format,
}

/// What the cells of a .vtu file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum VtkCells {
    /// The patches exactly, by their control points
    Bezier,
    /// The patches exactly, by points on them; faster to draw
    Lagrange,
}

impl From<VtkCells> for vtk::Cells {
    fn from(cells: VtkCells) -> Self {
        match cells {
            VtkCells::Bezier => Self::Bezier,
            VtkCells::Lagrange => Self::Lagrange,
        }
    }
}

/// How files are written.
#[derive(Clone, Copy, Debug, Default)]
pub struct Style {
    pub resolution: Option<usize>,
    pub cells: Option<VtkCells>,
}

/// A file that was written.
pub struct Written {
    pub path: PathBuf,
    pub bytes: u64,
}

/// Can every file be written? Makes and removes a temporary file beside each.
pub fn check(files: &[OutputFile], report: Option<&Path>) -> Result<(), Failure> {
    let paths: Vec<&Path> = files.iter().map(|file| file.path.as_path()).chain(report).collect();
    let mut seen = HashSet::new();
    for path in &paths {
        if !seen.insert(resolved(path)) {
            return Err(Failure::OutputTwice(path.to_path_buf()));
        }
    }
    let _writing = Writing::begin();
    let mut trial = Outputs::new();
    for path in paths {
        trial.write(path, |_| Ok(()))?;
    }
    Ok(())
}

/// The path without detours, so that `a.step` and `./a.step` are seen to be one file.
fn resolved(path: &Path) -> PathBuf {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// Writes all files under temporary names.
pub fn write(
    model: &NativeModel,
    files: &[OutputFile],
    style: &Style,
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    let default = TessellateOptions::default();
    let options = TessellateOptions { resolution: style.resolution.unwrap_or(default.resolution) };
    let tessellated = files.iter().any(|file| file.format.is_tessellated());
    let mesh = if tessellated { Some(tessellate(&model.spline, &options)?) } else { None };
    for file in files {
        outputs.write(&file.path, |out| {
            let mut out = Interruptible(out);
            match &mesh {
                Some(mesh) if file.format.is_tessellated() => write_mesh(model, mesh, file.format, &mut out),
                _ => write_patches(model, file, style, &mut out),
            }
        })?;
    }
    Ok(())
}

fn write_patches(
    model: &NativeModel,
    file: &OutputFile,
    style: &Style,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    match file.format {
        Format::Step => {
            let name = file.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let unit = model.provenance.unit;
            step::write_step(&model.spline, &step::StepOptions { unit, name, ..Default::default() }, out)
        }
        Format::Vtk => {
            let cells = style.cells.map_or_else(Default::default, vtk::Cells::from);
            vtk::write_vtk(&model.spline, &vtk::VtkOptions { cells }, out)
        }
        _ => write_native(&model.spline, &model.provenance, out),
    }
}

fn write_mesh(
    model: &NativeModel,
    mesh: &Tessellation,
    format: Format,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    match format {
        Format::Glb => gltf::write_glb(mesh, &gltf::GlbOptions { unit: model.provenance.unit }, out),
        Format::Ply => ply::write_ply(mesh, out),
        Format::Stl => stl::write_stl(mesh, out),
        _ => obj::write_obj(mesh, out),
    }
}

/// Puts all files under their names, unless Ctrl-C was pressed.
pub fn commit(outputs: Outputs, writing: &Writing, paths: &[&Path]) -> Result<Vec<Written>, Failure> {
    if writing.interrupted() {
        return Err(Failure::Interrupted);
    }
    outputs.commit()?;
    let size = |path: &Path| std::fs::metadata(path).map_or(0, |data| data.len());
    Ok(paths.iter().map(|path| Written { path: path.to_path_buf(), bytes: size(path) }).collect())
}
