//! Values of options, checked as they are read: each function takes the text and returns the value or what is wrong.

use crate::arguments::FreeValues;
use crate::outputs::OutputFile;
use isopatch::field::Constants;
use isopatch::geom::{Aabb, Point3};
use isopatch::io::{Format, UnknownFormat};
use isopatch::render::MAX_SIZE;
use std::path::PathBuf;

/// Most intervals along an edge of a patch: one patch is then 262,144 triangles.
const MAX_RESOLUTION: usize = 512;

/// A formula or a name. A formula may start with a minus sign, but what looks like an option is not taken for one.
pub fn input(text: &str) -> Result<String, String> {
    let is_word = |word: &str| word.chars().all(|c| c.is_alphanumeric() || "-_=".contains(c));
    let option = match text.strip_prefix("--") {
        Some(word) => is_word(word),
        None => match text.strip_prefix('-').map(|word| word.chars().collect::<Vec<_>>()).as_deref() {
            Some([letter]) => letter.is_alphabetic() && !"xyz".contains(*letter),
            _ => false,
        },
    };
    if option { Err("there is no such option".into()) } else { Ok(text.to_owned()) }
}

/// A number that is neither infinite nor NaN.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err("the number is not finite".into()),
        Err(_) => Err("this is not a number".into()),
    }
}

/// A finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    if number > 0.0 { Ok(number) } else { Err("the number is not positive".into()) }
}

/// No distance can be smaller than the rounding of coordinates.
const LEAST_TOLERANCE: f64 = 1e-15;

/// A distance relative to the diagonal.
pub fn tolerance(text: &str) -> Result<f64, String> {
    match positive(text)? {
        t if t < LEAST_TOLERANCE => Err("coordinates have 16 digits: the smallest tolerance is 1e-15".into()),
        t => Ok(t),
    }
}

/// A whole number above 0.
pub fn count(text: &str) -> Result<usize, String> {
    let number: i128 = text.trim().parse().map_err(|_| "this is not a whole number")?;
    if number <= 0 {
        return Err("the number is not positive".into());
    }
    // Elements are numbered in 32 bits.
    u32::try_from(number).map(|n| n as usize).map_err(|_| "the number is too large".into())
}

/// Most faces of a base mesh: a surface of so many takes some gigabytes.
const MAX_FACES: usize = 1_000_000;

/// Number of faces.
pub fn faces(text: &str) -> Result<usize, String> {
    at_most(count(text)?, MAX_FACES, "number of faces")
}

/// More threads than any machine has processors for only take memory.
const MAX_THREADS: usize = 256;

/// Number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    at_most(count(text)?, MAX_THREADS, "number of threads")
}

fn at_most(number: usize, limit: usize, what: &str) -> Result<usize, String> {
    if number <= limit { Ok(number) } else { Err(format!("the largest {what} is {limit}")) }
}

/// Intervals along an edge.
pub fn resolution(text: &str) -> Result<usize, String> {
    at_most(count(text)?, MAX_RESOLUTION, "resolution")
}

/// An angle in degrees, from 0 to 180.
pub fn angle(text: &str) -> Result<f64, String> {
    let degrees = finite(text)?;
    if (0.0..=180.0).contains(&degrees) { Ok(degrees) } else { Err("an angle is from 0 to 180".into()) }
}

/// A number, or else the name of a file.
pub fn free(text: &str) -> Result<FreeValues, String> {
    match text.trim().parse::<f64>() {
        Ok(_) => finite(text).map(FreeValues::All),
        Err(_) => Ok(FreeValues::File(text.into())),
    }
}

/// "xmin,xmax,ymin,ymax,zmin,zmax".
pub fn bounds(text: &str) -> Result<Aabb, String> {
    let numbers = text
        .split(',')
        .map(|number| finite(number).map_err(|problem| format!("\"{number}\": {problem}")))
        .collect::<Result<Vec<_>, _>>()?;
    let &[x0, x1, y0, y1, z0, z1] = numbers.as_slice() else {
        return Err(format!(
            "a box has six numbers, xmin,xmax,ymin,ymax,zmin,zmax; here are {}",
            numbers.len()
        ));
    };
    for (axis, min, max) in [("x", x0, x1), ("y", y0, y1), ("z", z0, z1)] {
        if min > max {
            return Err(format!("the box is reversed in {axis}: {min} is above {max}"));
        }
        if min == max {
            return Err(format!("the box is flat in {axis}: from {min} to {max}"));
        }
    }
    Ok(Aabb::new(Point3::new(x0, y0, z0), Point3::new(x1, y1, z1)))
}

/// "NAME=VALUE".
pub fn assignment(text: &str) -> Result<String, isopatch::field::ConstantError> {
    Constants::new().assign(text).map(|()| text.to_owned())
}

/// A file name with a known ending.
pub fn output(text: &str) -> Result<OutputFile, UnknownFormat> {
    let path = PathBuf::from(text);
    Ok(OutputFile { format: Format::of(&path)?, path })
}

/// The name of a picture.
pub fn picture(text: &str) -> Result<OutputFile, String> {
    match output(text) {
        Ok(file) if file.format == Format::Png => Ok(file),
        _ => Err("a picture has the ending .png".into()),
    }
}

/// "WxH".
pub fn size(text: &str) -> Result<[usize; 2], String> {
    let (width, height) = text.split_once(['x', 'X']).ok_or("a size is WxH, such as 1200x900")?;
    let side = |text| at_most(count(text)?, MAX_SIZE, "width or height");
    Ok([side(width)?, side(height)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_may_start_with_a_minus_sign_and_options_are_no_formulas() {
        for formula in ["-x^2-y^2-z^2+1", "-z", "-(x+y)", "- x", "x", "-2x"] {
            assert_eq!(input(formula).as_deref(), Ok(formula));
        }
        for option in ["--speed", "-q", "--"] {
            assert!(input(option).is_err(), "{option}");
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        assert_eq!(positive("1e-4"), Ok(1e-4));
        for text in ["0", "-1", "nan", "inf", "1e999", "", "1e"] {
            assert!(positive(text).is_err(), "{text}");
        }
        assert_eq!(count("600"), Ok(600));
        for text in ["0", "-600", "6.5", "1e3", "99999999999999999999", "4294967296"] {
            assert!(count(text).is_err(), "{text}");
        }
        assert_eq!(angle("30"), Ok(30.0));
        assert!(angle("181").is_err() && angle("-1").is_err());
        assert_eq!(free("-2.5"), Ok(FreeValues::All(-2.5)));
        assert_eq!(free("b.txt"), Ok(FreeValues::File("b.txt".into())));
        assert!(free("nan").is_err());
        assert_eq!(resolution("512"), Ok(512));
        assert!(resolution("513").is_err());
    }

    #[test]
    fn sizes_are_two_numbers() {
        assert_eq!(size("1200x900"), Ok([1200, 900]));
        for text in ["1200", "0x10", "10x", "x", "-5x5", "20000x10", "1200x900x3"] {
            assert!(size(text).is_err(), "{text}");
        }
        assert!(picture("a.png").is_ok() && picture("a.stl").is_err());
    }

    #[test]
    fn boxes_are_six_numbers_in_order() {
        let expected = Aabb::new(Point3::new(-1.0, -2.0, 0.5), Point3::new(1.0, 2.0, 30.0));
        assert_eq!(bounds("-1,1, -2,2, 0.5,3e1"), Ok(expected));
        let problem = |text| bounds(text).unwrap_err();
        assert_eq!(problem("1,-1,0,1,0,1"), "the box is reversed in x: 1 is above -1");
        assert_eq!(problem("0,1,2,2,0,1"), "the box is flat in y: from 2 to 2");
        assert!(problem("0,1,0,1,0").ends_with("here are 5"));
        assert_eq!(problem("0,1,0,1,0,one"), "\"one\": this is not a number");
        assert_eq!(problem("0,1,0,1,0,nan"), "\"nan\": the number is not finite");
    }
}
