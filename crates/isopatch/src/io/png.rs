//! PNG images.

use super::WriteError;
use crate::render::Image;
use std::io::{self, Write};

/// Writes an image of three bytes a pixel, marked as sRGB.
pub fn write_png(image: &Image, out: &mut impl Write) -> Result<(), WriteError> {
    encode(image, out).map_err(|error| match error {
        png::EncodingError::IoError(error) => WriteError::Io(error),
        other => WriteError::Io(io::Error::other(other)),
    })
}

fn encode(image: &Image, out: &mut impl Write) -> Result<(), png::EncodingError> {
    // The largest picture has far fewer columns than 32 bits can count.
    let mut encoder = png::Encoder::new(out, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&image.rgb)?;
    writer.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_read_back() {
        let (width, height) = (5, 3);
        let rgb: Vec<u8> = (0..3 * width * height).map(|i| (17 * i % 256) as u8).collect();
        let image = Image { width, height, rgb };
        let mut bytes = Vec::new();
        write_png(&image, &mut bytes).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(&bytes)).read_info().unwrap();
        let mut found = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut found).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (5, 3, png::ColorType::Rgb));
        assert_eq!(found, image.rgb);
    }
}
