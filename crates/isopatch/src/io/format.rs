use std::path::Path;

/// A file format that can be written, chosen by the ending of the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// STEP, `.step` or `.stp`.
    Step,
    /// VTK unstructured grid, `.vtu`.
    Vtk,
    /// Gmsh mesh, `.msh`.
    Gmsh,
    /// Binary glTF, `.glb`.
    Glb,
    /// 3MF, `.3mf`.
    Threemf,
    /// Wavefront OBJ, `.obj`.
    Obj,
    /// OFF, `.off`.
    Off,
    /// Binary PLY, `.ply`.
    Ply,
    /// Binary STL, `.stl`.
    Stl,
    /// A picture, `.png`.
    Png,
    /// The native format, `.isopatch`.
    Native,
}

/// A file name whose ending names no format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown ending {ending}; the endings are {}", Format::endings())]
pub struct UnknownFormat {
    ending: String,
}

impl Format {
    const ENDINGS: [(&'static str, Self); 12] = [
        ("step", Self::Step),
        ("stp", Self::Step),
        ("vtu", Self::Vtk),
        ("msh", Self::Gmsh),
        ("glb", Self::Glb),
        ("3mf", Self::Threemf),
        ("obj", Self::Obj),
        ("off", Self::Off),
        ("ply", Self::Ply),
        ("stl", Self::Stl),
        ("png", Self::Png),
        ("isopatch", Self::Native),
    ];

    /// The format of a file by the ending of its name, in upper or lower case.
    pub fn of(path: &Path) -> Result<Self, UnknownFormat> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let known = |(name, _): &&(&str, Self)| Some(*name) == ending.as_deref();
        Self::ENDINGS.iter().find(known).map(|(_, format)| *format).ok_or_else(|| UnknownFormat {
            ending: ending.as_ref().map_or("(none)".to_owned(), |e| format!(".{e}")),
        })
    }

    /// Does the format hold flat triangles instead of the patches themselves?
    pub fn is_tessellated(self) -> bool {
        matches!(self, Self::Glb | Self::Threemf | Self::Obj | Self::Off | Self::Ply | Self::Stl)
    }

    fn endings() -> String {
        Self::ENDINGS.map(|(ending, _)| format!(".{ending}")).join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_name_formats() {
        assert_eq!(Format::of(Path::new("a.b/c.STP")), Ok(Format::Step));
        assert_eq!(Format::of(Path::new("x.isopatch")), Ok(Format::Native));
        assert!(Format::Stl.is_tessellated() && !Format::Vtk.is_tessellated());
    }

    #[test]
    fn unknown_endings_are_named_with_the_known_ones() {
        let message = Format::of(Path::new("x.dwg")).unwrap_err().to_string();
        let known = ".step .stp .vtu .msh .glb .3mf .obj .off .ply .stl .png .isopatch";
        assert_eq!(message, format!("unknown ending .dwg; the endings are {known}"));
        assert!(Format::of(Path::new("step")).unwrap_err().to_string().contains("(none)"));
    }
}
