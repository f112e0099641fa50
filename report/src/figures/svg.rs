//! A picture as an SVG file: one file without references to others.
//!
//! Texts stay texts, in the font of the PNG files if the viewer has it and in a sans-serif font of
//! the viewer otherwise; each is set to the width that was laid out for it. Images are embedded PNG
//! files.

use std::fmt::Write;

use base64::{Engine, engine::general_purpose::STANDARD};

use super::bitmap::encoded;
use super::canvas::{CAPITALS, Error, Label, Picture, Shape, text_width};
use super::palette::Rgb;
use crate::letters::runs;

/// The SVG file, with the caption as its description.
pub fn svg(picture: &Picture) -> Result<Vec<u8>, Error> {
    let (width, height) = picture.size;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         role=\"img\" xml:space=\"preserve\" font-family=\"DejaVu Sans, Verdana, sans-serif\" stroke-linejoin=\"round\">\n\
         <title>{}</title>\n<desc>{}</desc>\n<metadata>{}</metadata>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        escaped(&picture.title),
        escaped(&picture.caption),
        crate::output::PROGRAM
    );
    // Lines of one style that follow each other, such as dashes, are one element.
    for shapes in picture.shapes.chunk_by(|a, b| style(a).is_some() && style(a) == style(b)) {
        element(&mut out, shapes)?;
    }
    out += "</svg>\n";
    Ok(out.into_bytes())
}

/// Colour, width and dashes of a line.
fn style(shape: &Shape) -> Option<(Rgb, f64, &[f64])> {
    match shape {
        Shape::Line { colour, width, dash, .. } => Some((*colour, *width, dash)),
        _ => None,
    }
}

/// Appends a shape, or lines of one style.
fn element(out: &mut String, shapes: &[Shape]) -> Result<(), Error> {
    match &shapes[0] {
        Shape::Line { colour, width, dash, .. } => {
            let dash = dash.iter().map(|&length| number(length)).collect::<Vec<_>>().join(" ");
            let dash = if dash.is_empty() { dash } else { format!(" stroke-dasharray=\"{dash}\"") };
            let (colour, width) = (hex(*colour), number(*width));
            let at = |shape: &Shape| match shape {
                Shape::Line { points, .. } => format!("M{}", places(points)),
                _ => String::new(),
            };
            let moves: String = shapes.iter().map(at).collect();
            line(
                out,
                format_args!("<path d=\"{moves}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>"),
            );
        }
        Shape::Polygon { points, colour } => {
            line(out, format_args!("<polygon points=\"{}\" fill=\"{}\"/>", places(points), hex(*colour)));
        }
        Shape::Image { corner: (x, y), width, pixels } => {
            let size = (*width as u32, (pixels.len() / width) as u32);
            let bytes: Vec<u8> = pixels.iter().flat_map(|&(r, g, b)| [r, g, b]).collect();
            let data = STANDARD.encode(encoded(size, &bytes, None)?);
            let (wide, high) = size;
            line(
                out,
                format_args!(
                    "<image x=\"{x}\" y=\"{y}\" width=\"{wide}\" height=\"{high}\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{data}\"/>"
                ),
            );
        }
        Shape::Text(label) => text(out, label),
    }
    Ok(())
}

/// Appends a text: its runs, those that are lower or higher moved by a share of the size.
fn text(out: &mut String, label: &Label) {
    let &Label { ref text, at: (x, y), size, colour, anchor, upwards } = label;
    if text.trim().is_empty() {
        return;
    }
    let width = text_width(text, size);
    let (along, across) = (-anchor.0 * width, CAPITALS * (1.0 - anchor.1) * size);
    let turn = if upwards { " rotate(-90)" } else { "" };
    let mut inside = String::new();
    let mut drop = 0.0;
    for (level, run) in runs(text) {
        let (scale, below) = level.scale_and_drop();
        let (dy, run) = (size * (below - drop), escaped(&run));
        drop = below;
        if scale == 1.0 && dy == 0.0 {
            inside += &run;
        } else {
            let (dy, size) = (number(dy), number(size * scale));
            let _ = write!(inside, "<tspan dy=\"{dy}\" font-size=\"{size}\">{run}</tspan>");
        }
    }
    let (place, along, across) = (places(&[(x, y)]), number(along), number(across));
    let (size, width, colour) = (number(size), number(width), hex(colour));
    line(
        out,
        format_args!(
            "<text transform=\"translate({place}){turn}\" x=\"{along}\" y=\"{across}\" font-size=\"{size}\" fill=\"{colour}\" \
         textLength=\"{width}\" lengthAdjust=\"spacingAndGlyphs\">{inside}</text>"
        ),
    );
}

fn line(out: &mut String, element: std::fmt::Arguments<'_>) {
    let _ = writeln!(out, "{element}");
}

/// Points in the form of SVG's attribute `points`.
fn places(points: &[(f64, f64)]) -> String {
    points.iter().map(|&(x, y)| format!("{},{}", number(x), number(y))).collect::<Vec<_>>().join(" ")
}

/// A length to a hundredth of a pixel.
fn number(value: f64) -> String {
    let rounded = (100.0 * value).round() / 100.0;
    // Without the sign of a zero.
    (rounded + 0.0).to_string()
}

fn hex((r, g, b): Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A text in XML, which has no control characters. For a character that the font lacks a viewer
/// may have another font.
fn escaped(text: &str) -> String {
    let text = crate::output::harmless(text);
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
