//! Header, units and the product structure that readers look for.

use super::StepOptions;
use crate::io::Unit;
use crate::io::text::push_real;
use std::io::{self, Write};

/// AP242 edition 1, "managed model-based 3D engineering".
const SCHEMA: &str = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }";
/// Files with the same content have the same bytes, so the time of writing is not recorded.
const TIME_STAMP: &str = "2000-01-01T00:00:00";

/// Everything before the first entity.
pub fn write_header(out: &mut impl Write, options: &StepOptions) -> io::Result<()> {
    let name = quoted(&options.name);
    let generator = concat!("isopatch ", env!("CARGO_PKG_VERSION"));
    write!(
        out,
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n\
         FILE_NAME({name},'{TIME_STAMP}',(''),(''),'{generator}','{generator}','');\n\
         FILE_SCHEMA(('{SCHEMA}'));\nENDSEC;\nDATA;\n"
    )
}

/// Gives entities consecutive numbers.
pub struct Entities<'a, W> {
    pub out: &'a mut W,
    pub next: u64,
}

impl<W: Write> Entities<'_, W> {
    /// Writes one entity and returns its number.
    pub fn add(&mut self, entity: &str) -> io::Result<u64> {
        writeln!(self.out, "#{}={entity};", self.next)?;
        self.next += 1;
        Ok(self.next - 1)
    }

    fn length_unit(&mut self, unit: Unit) -> io::Result<u64> {
        let si = |prefix| format!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))");
        match unit {
            Unit::Mm => self.add(&si(".MILLI.")),
            Unit::Cm => self.add(&si(".CENTI.")),
            Unit::M => self.add(&si("$")),
            Unit::In => {
                let millimetre = self.add(&si(".MILLI."))?;
                let exponents = self.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")?;
                let inch =
                    self.add(&format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#{millimetre})"))?;
                self.add(&format!(
                    "(CONVERSION_BASED_UNIT('INCH',#{inch})LENGTH_UNIT()NAMED_UNIT(#{exponents}))"
                ))
            }
        }
    }

    /// The context of all geometry: three dimensions, units and the uncertainty of lengths.
    pub fn context(&mut self, options: &StepOptions) -> io::Result<u64> {
        let length = self.length_unit(options.unit)?;
        let angle = self.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")?;
        let solid = self.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")?;
        let mut value = Vec::new();
        push_real(&mut value, options.uncertainty * Unit::Mm.metres() / options.unit.metres());
        let value = String::from_utf8_lossy(&value).into_owned();
        let uncertainty = self.add(&format!(
            "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({value}),#{length},'distance_accuracy_value','')"
        ))?;
        self.add(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{uncertainty}))\
             GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle},#{solid}))REPRESENTATION_CONTEXT('','3D'))"
        ))
    }

    /// The coordinate system at the origin.
    pub fn placement(&mut self) -> io::Result<u64> {
        let origin = self.add("CARTESIAN_POINT('',(0.,0.,0.))")?;
        let z = self.add("DIRECTION('',(0.,0.,1.))")?;
        let x = self.add("DIRECTION('',(1.,0.,0.))")?;
        self.add(&format!("AXIS2_PLACEMENT_3D('',#{origin},#{z},#{x})"))
    }

    /// One product whose shape is given by the representations.
    pub fn product(&mut self, options: &StepOptions, representations: &[u64]) -> io::Result<()> {
        let name = quoted(&options.name);
        let application = self.add("APPLICATION_CONTEXT('managed model based 3d engineering')")?;
        self.add(&format!(
            "APPLICATION_PROTOCOL_DEFINITION('international standard',\
             'ap242_managed_model_based_3d_engineering',2014,#{application})"
        ))?;
        let context = self.add(&format!("PRODUCT_CONTEXT('',#{application},'mechanical')"))?;
        let product = self.add(&format!("PRODUCT({name},{name},'',(#{context}))"))?;
        self.add(&format!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}))"))?;
        let formation = self.add(&format!("PRODUCT_DEFINITION_FORMATION('','',#{product})"))?;
        let design =
            self.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')"))?;
        let definition = self.add(&format!("PRODUCT_DEFINITION('design','',#{formation},#{design})"))?;
        let shape = self.add(&format!("PRODUCT_DEFINITION_SHAPE('','',#{definition})"))?;
        for representation in representations {
            self.add(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})"))?;
        }
        Ok(())
    }
}

/// A string of ISO 10303-21: quotes and backslashes doubled, other than printable ASCII as \X2\ UTF-16 \X0\.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("'");
    for c in text.chars() {
        match c {
            '\'' => quoted.push_str("''"),
            '\\' => quoted.push_str("\\\\"),
            ' '..='~' => quoted.push(c),
            _ => {
                let units: String = c.encode_utf16(&mut [0; 2]).iter().map(|u| format!("{u:04X}")).collect();
                quoted.push_str(&format!("\\X2\\{units}\\X0\\"));
            }
        }
    }
    quoted + "'"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_quoted() {
        assert_eq!(quoted("x^2-y'\\é\n"), r"'x^2-y''\\\X2\00E9\X0\\X2\000A\X0\'");
    }
}
