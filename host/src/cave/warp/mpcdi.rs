//! MPCDI 1.0, VESA's interchange of projector calibrations: an archive of
//! `mpcdi.xml`, a PFM of points and a PNG of weights.
//!
//! The profile is `a3`, advanced 3D: each value of the PFM is where a part of
//! the projector's picture meets the dome, (x, y, z) in metres, NaN where it
//! does not, and what reads it renders for the viewer's eye by itself. Values are
//! for the middles of cells, as many across and down as the grid has: with the
//! projector's resolution one a pixel. The weights (`alphaMap`) are white on the
//! dome and black elsewhere: edges are not blended.
//!
//! Points are in the room's axes, +X to the right, +Y up, −Z to the front, from
//! the room's origin, where the head is unless somebody moves it
//! (`idealEyePoint`); `coordinateFrame` has the axes, and the projector's
//! position. `frustum` is how the projector is turned, and its field: degrees,
//! yaw to the right, then pitch upwards, then roll clockwise as it looks.
//!
//! The same warp gives the same file: the date is 1980's first, as archives
//! without a clock have it.

use super::Warp;
use glam::DVec3;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::io::{self, Cursor, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// As archives have it that know no time.
const DATE: &str = "1980-01-01 00:00:00";

/// What the archive's description is called.
const DESCRIPTION: &str = "mpcdi.xml";

/// Writes the archive.
///
/// # Errors
/// What writing reports.
pub fn write(warp: &Warp<'_>, to: impl Write + Seek) -> io::Result<()> {
    let name = warp.projector.name();
    let (points, weights) = (format!("{name}.pfm"), format!("{name}-alpha.png"));
    let mut archive = ZipWriter::new(to);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let xml = description(warp, &points, &weights)?;
    archive.start_file(DESCRIPTION, options)?;
    archive.write_all(&xml)?;
    archive.start_file(points, options)?;
    write_points(warp, &mut archive)?;
    archive.start_file(weights, options)?;
    archive.write_all(&alpha(warp)?)?;
    archive.finish()?.flush()
}

/// A portable float map: rows from the lowest up, the least byte first.
fn write_points(warp: &Warp<'_>, to: &mut impl Write) -> io::Result<()> {
    let [columns, rows] = warp.grid();
    write!(to, "PF\n{columns} {rows}\n-1.000000\n")?;
    let mut line = Vec::with_capacity(12 * columns as usize);
    for row in (0..rows).rev() {
        line.clear();
        for column in 0..columns {
            let point = warp
                .node(column, row)
                .map_or(DVec3::NAN, |node| node.point)
                .as_vec3();
            for coordinate in point.to_array() {
                line.extend(coordinate.to_le_bytes());
            }
        }
        to.write_all(&line)?;
    }
    Ok(())
}

/// White where the dome is met, in a PNG of 8-bit grey.
fn alpha(warp: &Warp<'_>) -> io::Result<Vec<u8>> {
    let [columns, rows] = warp.grid();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    for row in 0..rows {
        let white = |column| {
            if warp.node(column, row).is_some() {
                u8::MAX
            } else {
                0
            }
        };
        let line: Vec<u8> = (0..columns).map(white).collect();
        stream.write_all(&line)?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok(file)
}

type Xml = Writer<Cursor<Vec<u8>>>;

/// `mpcdi.xml`.
fn description(warp: &Warp<'_>, points: &str, weights: &str) -> io::Result<Vec<u8>> {
    let projector = warp.projector;
    let [columns, rows] = projector.resolution().map(|side| side.to_string());
    let mut xml = Writer::new_with_indent(Cursor::new(Vec::new()), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("MPCDI")
        .with_attribute(("profile", "a3"))
        .with_attribute(("level", "1"))
        .with_attribute(("date", DATE))
        .with_attribute(("version", "1.0"))
        .write_inner_content(|xml| {
            xml.create_element("display").write_inner_content(|xml| {
                xml.create_element("buffer")
                    .with_attribute(("id", warp.dome.name()))
                    .with_attribute(("Xresolution", columns.as_str()))
                    .with_attribute(("Yresolution", rows.as_str()))
                    .write_inner_content(|xml| {
                        xml.create_element("region")
                            .with_attribute(("id", projector.name()))
                            .with_attribute(("Xresolution", columns.as_str()))
                            .with_attribute(("Yresolution", rows.as_str()))
                            .with_attribute(("x", "0"))
                            .with_attribute(("y", "0"))
                            .with_attribute(("xsize", "1"))
                            .with_attribute(("ysize", "1"))
                            .write_inner_content(|xml| region(warp, xml))?;
                        Ok(())
                    })?;
                Ok(())
            })?;
            xml.create_element("files").write_inner_content(|xml| {
                xml.create_element("fileset")
                    .with_attribute(("region", projector.name()))
                    .write_inner_content(|xml| files(xml, points, weights))?;
                Ok(())
            })?;
            Ok(())
        })?;
    Ok(xml.into_inner().into_inner())
}

/// How the projector is turned, and where it is.
fn region(warp: &Warp<'_>, xml: &mut Xml) -> io::Result<()> {
    let projector = warp.projector;
    let [yaw, pitch, roll] = projector.angles().map(f64::to_degrees);
    let [left, right, down, up] = projector.edges().map(|t| libm::atan(t).to_degrees());
    values(
        xml,
        "frustum",
        &[
            ("yaw", yaw),
            ("pitch", pitch),
            ("roll", roll),
            ("rightAngle", right),
            ("leftAngle", left),
            ("upAngle", up),
            ("downAngle", down),
        ],
    )?;
    let position = projector.position();
    values(
        xml,
        "coordinateFrame",
        &[
            ("posx", position.x),
            ("posy", position.y),
            ("posz", position.z),
            // Yaw is about what points down, pitch to the right, roll ahead.
            ("yawx", 0.0),
            ("yawy", -1.0),
            ("yawz", 0.0),
            ("pitchx", 1.0),
            ("pitchy", 0.0),
            ("pitchz", 0.0),
            ("rollx", 0.0),
            ("rolly", 0.0),
            ("rollz", -1.0),
        ],
    )
}

fn values(xml: &mut Xml, element: &str, values: &[(&str, f64)]) -> io::Result<()> {
    xml.create_element(element).write_inner_content(|xml| {
        for (name, value) in values {
            text(xml, name, &format!("{value:.9}"))?;
        }
        Ok(())
    })?;
    Ok(())
}

fn files(xml: &mut Xml, points: &str, weights: &str) -> io::Result<()> {
    xml.create_element("geometryWarpFile")
        .write_inner_content(|xml| {
            text(xml, "path", points)?;
            text(xml, "interpolation", "linear")?;
            text(xml, "geometricUnit", "m")?;
            text(xml, "originOf3DData", "idealEyePoint")
        })?;
    xml.create_element("alphaMap").write_inner_content(|xml| {
        text(xml, "path", weights)?;
        text(xml, "componentDepth", "1")?;
        text(xml, "bitDepth", "8")?;
        text(xml, "gammaEmbedded", "1.0")
    })?;
    Ok(())
}

fn text(xml: &mut Xml, element: &str, text: &str) -> io::Result<()> {
    xml.create_element(element)
        .write_text_content(BytesText::new(text))?;
    Ok(())
}
