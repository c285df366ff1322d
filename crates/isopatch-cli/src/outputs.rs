//! The files that a command writes: checked before the work, written all or none after it.

use crate::failure::Failure;
use crate::interrupt::{Interruptible, Writing};
use crate::making;
use crate::render::{self, PictureOptions};
use clap::ValueEnum;
use isopatch::base::Repair;
use isopatch::geom::{Aabb, Point3};
use isopatch::io::atomic::Outputs;
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::io::{
    Format, ThinParts, Unit, WriteError, gltf, gmsh, obj, off, ply, png, step, stl, threemf, vtk,
};
use isopatch::surface::{Domain, Surface};
use isopatch::tessellate::{
    APatchResolution, APatchTriangles, AdaptedResolution, TessellateOptions, Tessellation, resolution_for,
    tessellate, tessellate_a_patches, tessellate_hybrid,
};
use std::collections::{HashMap, HashSet};
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
    /// Flat triangles with normals
    Linear,
}

/// How files are written.
#[derive(Clone, Copy, Debug, Default)]
pub struct Style {
    pub fineness: Fineness,
    pub cells: Option<VtkCells>,
}

/// How fine flat triangles are.
#[derive(Clone, Copy, Debug, Default)]
pub enum Fineness {
    #[default]
    Standard,
    /// Intervals along an edge.
    Along(usize),
    /// Largest height of the surface over them, relative to the diagonal.
    Chord(f64),
}

impl Style {
    /// Of `resolution` and `chord`, one at most is given.
    pub fn new(resolution: Option<usize>, chord: Option<f64>, cells: Option<VtkCells>) -> Self {
        let fineness = match (resolution, chord) {
            (Some(along), _) => Fineness::Along(along),
            (None, Some(tolerance)) => Fineness::Chord(tolerance),
            (None, None) => Fineness::Standard,
        };
        Self { fineness, cells }
    }
}

/// A file that was written.
pub struct Written {
    pub path: PathBuf,
    pub bytes: u64,
}

/// Can every file be written? Makes and removes a temporary file beside each.
pub fn check(files: &[OutputFile], report: Option<&Path>) -> Result<(), Failure> {
    time_of_writing()?;
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

/// The environment's time for files that tell one, so that builds can be repeated bit for bit.
const TIME_VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// That time, in seconds since 1970 began, if the environment has one.
fn time_of_writing() -> Result<Option<u64>, Failure> {
    let Some(text) = std::env::var_os(TIME_VARIABLE) else { return Ok(None) };
    let text = text.to_string_lossy();
    // Years have four digits.
    const END: u64 = 253_402_300_800;
    match text.parse::<u64>() {
        Ok(seconds) if seconds < END => Ok(Some(seconds)),
        _ => Err(Failure::Unfit(format!(
            "{TIME_VARIABLE}={text}: a time is a whole number of seconds since 1970, before the year 10000"
        ))),
    }
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

/// Can A-patches be written to these files, with these cells?
pub fn check_a_patches(files: &[OutputFile], cells: Option<VtkCells>) -> Result<(), Failure> {
    if let Some(file) = files.iter().find(|file| file.format == Format::Step) {
        return Err(Failure::Unfit(format!("{}: a STEP file can't hold A-patches", file.path.display())));
    }
    match cells {
        Some(VtkCells::Bezier | VtkCells::Lagrange) => {
            Err(Failure::Unfit("--cells: A-patches are no polynomials; their .vtu has linear cells".into()))
        }
        Some(VtkCells::Linear) | None => Ok(()),
    }
}

/// Can rational patches be written with these cells?
pub fn check_rational(cells: Option<VtkCells>) -> Result<(), Failure> {
    match cells {
        Some(VtkCells::Lagrange) => {
            Err(Failure::Unfit("--cells: rational patches have Bézier or linear cells".into()))
        }
        _ => Ok(()),
    }
}

/// What there is to say about files that are meant for solids, if the surface is open.
pub fn open_shells(model: &NativeModel, files: &[OutputFile]) -> Option<Repair> {
    let is_for_solids =
        |file: &&OutputFile| matches!(file.format, Format::Step | Format::Stl | Format::Threemf);
    let names: Vec<String> =
        files.iter().filter(is_for_solids).map(|file| file.path.display().to_string()).collect();
    let is_open = has_boundary(model.as_surface());
    let why = match making::is_of_mesh(&model.provenance) {
        true => "the mesh has a boundary, and a closed one makes a solid",
        false => "the box cuts the surface, and a larger --box makes a solid if the surface is bounded",
    };
    (is_open && !names.is_empty()).then(|| Repair {
        what: "open shell instead of a solid".into(),
        place: names.join(", "),
        why: why.into(),
    })
}

/// Does a patch end where no other one goes on? Sheets that cross end in each other.
fn has_boundary(surface: &dyn Surface) -> bool {
    let seams = surface.seams();
    let mut ends_at: HashMap<u32, usize> = HashMap::new();
    for s in (0..seams.len()).filter(|s| seams[*s].second.is_none()) {
        *ends_at.entry(surface.curve(s)).or_default() += 1;
    }
    ends_at.values().any(|patches| *patches == 1)
}

/// Do the patches have control points, which files can hold?
pub fn has_nets(model: &NativeModel) -> bool {
    model.spline().is_some() || model.rational().is_some()
}

/// Does a file hold flat triangles?
fn is_flat(model: &NativeModel, file: &OutputFile, style: &Style) -> bool {
    match file.format {
        Format::Vtk => style.cells == Some(VtkCells::Linear) || !has_nets(model),
        Format::Gmsh => model.spline().is_none(),
        other => other.is_tessellated(),
    }
}

/// Most triangles of A-patches unless a resolution is asked for: as many take some hundred megabytes in a file.
const MOST_TRIANGLES: usize = 10_000_000;
/// Intervals along an edge of the mesh for one across the patch over it, which is narrow.
const ALONG_FOR_ONE_ACROSS: usize = 4;

/// The same if it follows from the height of the surface over them.
const MOST_FOR_CHORD: usize = 200_000_000;

/// Flat triangles of a surface with some resolution.
fn triangles(surface: &dyn Surface, APatchResolution { along, across }: APatchResolution) -> usize {
    let of_patch = |patch| match surface.domain(patch) {
        Domain::Triangle => along * along,
        Domain::Square => 2 * across * (along - 1),
        Domain::Polygon(corners) => usize::from(corners) * along * along,
    };
    surface.patches().map(of_patch).sum()
}

/// Triangles of a picture, about: one for each two or three pixels that show the surface. Normals are blended between their corners, so
/// that more would change nothing that is seen.
const MOST_FOR_PICTURE: usize = 200_000;
/// Most intervals along an edge of a patch in a picture, of which few patches are large.
const FINEST_FOR_PICTURE: usize = 64;

/// A surface as flat triangles that are small in a picture.
pub fn flattened_for_picture(model: &NativeModel, along: Option<usize>) -> Result<Tessellation, Failure> {
    let surface = model.as_surface();
    let with = |along: usize| APatchResolution { along, across: along.div_ceil(ALONG_FOR_ONE_ACROSS) };
    let finest = || (2..=FINEST_FOR_PICTURE).rev().find(|n| triangles(surface, with(*n)) <= MOST_FOR_PICTURE);
    let along = along.or_else(finest).unwrap_or(2);
    flattened(model, &Style { fineness: Fineness::Along(along), ..Style::default() })
}

/// The resolution that is asked for, or else the default.
fn resolution(model: &NativeModel, style: &Style) -> Result<APatchResolution, Failure> {
    let with = |along: usize| APatchResolution { along, across: along.div_ceil(ALONG_FOR_ONE_ACROSS) };
    let surface = model.as_surface();
    match style.fineness {
        Fineness::Along(along) => Ok(with(along)),
        Fineness::Standard if has_nets(model) => Ok(with(TessellateOptions::default().resolution)),
        Fineness::Standard => {
            let coarser = (1..=APatchResolution::default().along).rev().map(with);
            Ok(coarser.into_iter().find(|r| triangles(surface, *r) <= MOST_TRIANGLES).unwrap_or(with(1)))
        }
        Fineness::Chord(tolerance) => {
            let AdaptedResolution { resolution, error } =
                resolution_for(surface, model.provenance.diagonal, tolerance);
            let is_reached = error <= tolerance && triangles(surface, resolution) <= MOST_FOR_CHORD;
            if is_reached { Ok(resolution) } else { Err(Failure::Chord(tolerance)) }
        }
    }
}

/// Intervals along and across with which A-patches are written to files of flat triangles; none if there are none.
pub fn intervals(
    model: &NativeModel,
    files: &[OutputFile],
    style: &Style,
) -> Result<Option<[usize; 2]>, Failure> {
    if has_nets(model) || !files.iter().any(|file| is_flat(model, file, style)) {
        return Ok(None);
    }
    resolution(model, style).map(|r| Some([r.along, r.across]))
}

fn flattened(model: &NativeModel, style: &Style) -> Result<Tessellation, Failure> {
    let resolution = resolution(model, style)?;
    Ok(match &model.surface {
        NativeSurface::Spline(spline) => {
            tessellate(spline.as_ref(), &TessellateOptions { resolution: resolution.along })?
        }
        NativeSurface::APatches(surface) => tessellate_a_patches(surface, resolution)?,
        NativeSurface::Hybrid(surface) => tessellate_hybrid(surface, resolution)?.mesh,
        NativeSurface::Rational(surface) => {
            tessellate(surface.as_ref(), &TessellateOptions { resolution: resolution.along })?
        }
    })
}

/// The flat triangles that files hold.
enum Flat<'a> {
    /// There are no such files.
    Nothing,
    /// All of them.
    Mesh(Tessellation),
    /// Made when they are written, with the box around them.
    Parts(Box<APatchTriangles<'a>>, Aabb),
}

/// The triangles for all files that hold some. Those of a .glb alone are made part by part, if there is one normal a point.
fn flat<'a>(model: &'a NativeModel, files: &[OutputFile], style: &Style) -> Result<Flat<'a>, Failure> {
    let mut flat = files.iter().filter(|file| is_flat(model, file, style)).peekable();
    if flat.peek().is_none() {
        return Ok(Flat::Nothing);
    }
    if let NativeSurface::APatches(surface) = &model.surface
        && flat.all(|file| file.format == Format::Glb)
    {
        let triangles = APatchTriangles::new(surface, resolution(model, style)?)?;
        if triangles.is_smooth() {
            let bounds = triangles.bounds()?;
            return Ok(Flat::Parts(Box::new(triangles), bounds));
        }
    }
    flattened(model, style).map(Flat::Mesh)
}

/// Writes all files under temporary names.
pub fn write(
    model: &NativeModel,
    files: &[OutputFile],
    style: &Style,
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    let time = time_of_writing()?;
    let flat = flat(model, files, style)?;
    let is_picture = |file: &OutputFile| file.format == Format::Png;
    let picture = match files.iter().any(is_picture) {
        true => Some(render::of_model(model, &PictureOptions::default())?),
        false => None,
    };
    for file in files {
        outputs.write(&file.path, |out| {
            let mut out = Interruptible(out);
            let unit = model.provenance.unit;
            match (&flat, &picture) {
                (_, Some(image)) if is_picture(file) => png::write_png(image, &mut out),
                (Flat::Mesh(mesh), _) if is_flat(model, file, style) => {
                    write_mesh(unit, mesh, file.format, &mut out)
                }
                (Flat::Parts(triangles, bounds), _) if is_flat(model, file, style) => {
                    gltf::write_glb_of_a_patches(triangles, bounds, &gltf::GlbOptions { unit }, &mut out)
                }
                _ => write_patches(model, file, style, time, &mut out),
            }
        })?;
    }
    Ok(())
}

/// Flat triangles that are no patches, and what is thinner.
pub struct Conforming {
    pub mesh: Tessellation,
    pub thin: ThinParts,
    /// The singular set, for pictures.
    pub singular: Vec<Vec<Point3>>,
}

/// Writes flat triangles that are no patches under temporary names.
pub fn write_triangles(
    made: &Conforming,
    unit: Unit,
    files: &[OutputFile],
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    let is_picture = |file: &OutputFile| file.format == Format::Png;
    let picture = match files.iter().any(is_picture) {
        true => Some(render::of_singular(&made.mesh, &made.singular)?),
        false => None,
    };
    let (mesh, thin) = (&made.mesh, &made.thin);
    for file in files {
        outputs.write(&file.path, |out| {
            let mut out = Interruptible(out);
            match (file.format, &picture) {
                (Format::Png, Some(image)) => png::write_png(image, &mut out),
                (Format::Glb, _) => gltf::write_glb_with(mesh, thin, &gltf::GlbOptions { unit }, &mut out),
                (Format::Vtk, _) => vtk::write_vtk_mesh_with(mesh, thin, &mut out),
                (Format::Ply, _) => ply::write_ply_with(mesh, thin, &mut out),
                (Format::Obj, _) => obj::write_obj_with(mesh, thin, &mut out),
                (format, _) => write_mesh(unit, mesh, format, &mut out),
            }
        })?;
    }
    Ok(())
}

/// Can a file show isolated points and curves without sheets?
pub fn holds_thin_parts(format: Format) -> bool {
    matches!(format, Format::Glb | Format::Vtk | Format::Ply | Format::Obj | Format::Png)
}

/// Can flat triangles that are no patches be written to these files, with this style?
pub fn check_triangles(files: &[OutputFile], style: &Style) -> Result<(), Failure> {
    const WHAT: &str = "a surface with singularities is made of flat triangles";
    let holds_patches = |file: &&OutputFile| matches!(file.format, Format::Step | Format::Native);
    if let Some(file) = files.iter().find(holds_patches) {
        let path = file.path.display();
        return Err(Failure::Unfit(format!(
            "{path}: {WHAT}, for .glb .3mf .obj .off .ply .png .stl .vtu and .msh"
        )));
    }
    if !matches!(style.fineness, Fineness::Standard) {
        return Err(Failure::Unfit(format!(
            "--resolution and --chord are for patches; {WHAT}: see --tol and --faces"
        )));
    }
    match style.cells {
        Some(VtkCells::Bezier | VtkCells::Lagrange) => {
            Err(Failure::Unfit(format!("--cells: {WHAT}; their .vtu has linear cells")))
        }
        Some(VtkCells::Linear) | None => Ok(()),
    }
}

/// Writes all files and puts them under their names.
pub fn write_all(model: &NativeModel, files: &[OutputFile], style: &Style) -> Result<(), Failure> {
    let writing = Writing::begin();
    let mut outputs = Outputs::new();
    let result = write(model, files, style, &mut outputs);
    if writing.interrupted() {
        return Err(Failure::Interrupted);
    }
    result?;
    let paths: Vec<&Path> = files.iter().map(|file| file.path.as_path()).collect();
    commit(outputs, &writing, &paths)?;
    Ok(())
}

fn write_patches(
    model: &NativeModel,
    file: &OutputFile,
    style: &Style,
    time: Option<u64>,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    let surface = model.as_surface();
    match file.format {
        Format::Step => {
            let name = file.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let mut options = step::StepOptions { unit: model.provenance.unit, name, ..Default::default() };
            options.time = time.unwrap_or(options.time);
            step::write_step(surface, &options, out)
        }
        Format::Vtk => {
            let cells = match style.cells {
                Some(VtkCells::Lagrange) => vtk::Cells::Lagrange,
                _ => vtk::Cells::Bezier,
            };
            vtk::write_vtk(surface, &vtk::VtkOptions { cells }, out)
        }
        Format::Gmsh => gmsh::write_gmsh(surface, out),
        _ => model.write(out),
    }
}

fn write_mesh(
    unit: Unit,
    mesh: &Tessellation,
    format: Format,
    out: &mut impl Write,
) -> Result<(), WriteError> {
    match format {
        Format::Glb => gltf::write_glb(mesh, &gltf::GlbOptions { unit }, out),
        Format::Vtk => vtk::write_vtk_mesh(mesh, out),
        Format::Gmsh => gmsh::write_gmsh_mesh(mesh, out),
        Format::Threemf => threemf::write_3mf(mesh, &threemf::ThreemfOptions { unit }, out),
        Format::Off => off::write_off(mesh, out),
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
