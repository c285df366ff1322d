use std::path::Path;

/// A file format that can be written, chosen by the ending of the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// STEP, `.step` or `.stp`.
    Step,
    /// VTK unstructured grid, `.vtu`.
    Vtk,
    /// Binary glTF, `.glb`.
    Glb,
    /// Wavefront OBJ, `.obj`.
    Obj,
    /// Binary PLY, `.ply`.
    Ply,
    /// Binary STL, `.stl`.
    Stl,
    /// The native format, `.isopatch`.
    Native,
}

/// A file name whose ending names no format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: unknown ending {ending}; the endings are {}", Format::endings())]
pub struct UnknownFormat {
    file: String,
    ending: String,
}

impl Format {
    const ENDINGS: [(&'static str, Self); 8] = [
        ("step", Self::Step),
        ("stp", Self::Step),
        ("vtu", Self::Vtk),
        ("glb", Self::Glb),
        ("obj", Self::Obj),
        ("ply", Self::Ply),
        ("stl", Self::Stl),
        ("isopatch", Self::Native),
    ];

    /// The format of a file by the ending of its name, in upper or lower case.
    pub fn of(path: &Path) -> Result<Self, UnknownFormat> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let known = |(name, _): &&(&str, Self)| Some(*name) == ending.as_deref();
        Self::ENDINGS.iter().find(known).map(|(_, format)| *format).ok_or_else(|| UnknownFormat {
            file: path.display().to_string(),
            ending: ending.as_ref().map_or("(none)".to_owned(), |e| format!(".{e}")),
        })
    }

    /// Does the format hold flat triangles instead of the patches themselves?
    pub fn is_tessellated(self) -> bool {
        matches!(self, Self::Glb | Self::Obj | Self::Ply | Self::Stl)
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
        let known = ".step .stp .vtu .glb .obj .ply .stl .isopatch";
        assert_eq!(message, format!("x.dwg: unknown ending .dwg; the endings are {known}"));
        assert!(Format::of(Path::new("step")).unwrap_err().to_string().contains("(none)"));
    }
}
