//! Header, units and the product structure that readers look for.

use super::StepOptions;
use crate::io::Unit;
use crate::io::text::push_real;
use std::io::{self, Write};

/// AP242 edition 1, "managed model-based 3D engineering".
const SCHEMA: &str = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }";
/// The start of the year 2000, in seconds since 1970 began.
pub const YEAR_2000: u64 = 946_684_800;

/// Everything before the first entity.
pub fn write_header(out: &mut impl Write, options: &StepOptions) -> io::Result<()> {
    let name = quoted(&options.name);
    let time = time_stamp(options.time);
    let generator = concat!("isopatch ", env!("CARGO_PKG_VERSION"));
    write!(
        out,
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n\
         FILE_NAME({name},'{time}',(''),(''),'{generator}','{generator}','');\n\
         FILE_SCHEMA(('{SCHEMA}'));\nENDSEC;\nDATA;\n"
    )
}

/// A time in seconds since 1970 began, as ISO 8601 has it.
fn time_stamp(seconds: u64) -> String {
    const DAY: u64 = 86_400;
    // Years of the Gregorian calendar that begin in March, so that the leap day is the last; 400 of them are one period.
    const PERIOD: u64 = 146_097;
    const FROM_MARCH_OF_YEAR_0: u64 = 719_468;
    let days = seconds / DAY + FROM_MARCH_OF_YEAR_0;
    let day = days % PERIOD;
    let year = (day - day / 1_460 + day / 36_524 - day / (PERIOD - 1)) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // Five months from March on have 153 days, and so have the next five.
    let from_march = (5 * day + 2) / 153;
    let day = day - (153 * from_march + 2) / 5 + 1;
    let month = (from_march + 2) % 12 + 1;
    let year = 400 * (days / PERIOD) + year + u64::from(month <= 2);
    let (hour, minute, second) = (seconds % DAY / 3_600, seconds / 60 % 60, seconds % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}")
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

    #[test]
    fn times_are_days_of_the_calendar() {
        for (seconds, stamp) in [
            (0, "1970-01-01T00:00:00"),
            (YEAR_2000, "2000-01-01T00:00:00"),
            (951_782_400, "2000-02-29T00:00:00"),
            (951_868_800, "2000-03-01T00:00:00"),
            (1_735_689_599, "2024-12-31T23:59:59"),
            (4_107_542_400, "2100-03-01T00:00:00"),
        ] {
            assert_eq!(time_stamp(seconds), stamp);
        }
    }
}
