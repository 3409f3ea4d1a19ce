//! MPCDI 1.0, VESA's interchange of projector calibrations: an archive of `mpcdi.xml`, a PFM of
//! points and a PNG of weights.
//!
//! The profile is `a3`, advanced 3D: each value of the PFM is where the middle of a cell of the
//! projector's picture meets the dome, (x, y, z) in metres, or NaN. The weights (`alphaMap`) are
//! white on the dome and black elsewhere: edges are not blended.
//!
//! Points are in the room's axes, +X to the right, +Y up, −Z to the front, from the room's origin
//! (`idealEyePoint`); `coordinateFrame` has the axes and the projector's position. `frustum` is
//! how the projector is turned, and its field: degrees, yaw to the right, then pitch upwards, then
//! roll clockwise as it looks. The date is 1980's first: the same warp gives the same file.

use super::Warp;
use glam::DVec3;
use std::io::{self, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

const DATE: &str = "1980-01-01 00:00:00";

const DESCRIPTION: &str = "mpcdi.xml";

/// Writes the archive.
///
/// # Errors
/// What writing reports.
pub fn write(warp: &Warp<'_>, to: impl Write + Seek) -> io::Result<()> {
    let name = &warp.projector.name;
    let (points, weights) = (format!("{name}.pfm"), format!("{name}-alpha.png"));
    let mut archive = ZipWriter::new(to);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let xml = description(warp, &points, &weights);
    archive.start_file(DESCRIPTION, options)?;
    archive.write_all(xml.as_bytes())?;
    archive.start_file(points, options)?;
    write_points(warp, &mut archive)?;
    archive.start_file(weights, options)?;
    archive.write_all(&alpha(warp)?)?;
    archive.finish()?.flush()
}

/// Returns a portable float map: rows from the lowest up, the least byte first.
fn write_points(warp: &Warp<'_>, to: &mut impl Write) -> io::Result<()> {
    let [columns, rows] = warp.grid;
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
    let [columns, rows] = warp.grid;
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    for row in 0..rows {
        let white = |column| u8::MAX * u8::from(warp.node(column, row).is_some());
        let line: Vec<u8> = (0..columns).map(white).collect();
        stream.write_all(&line)?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok(file)
}

/// Returns the text of `mpcdi.xml`, without a line feed at its end.
fn description(warp: &Warp<'_>, points: &str, weights: &str) -> String {
    let projector = warp.projector;
    let [columns, rows] = projector.resolution;
    let [dome, name, points, weights] =
        [&warp.dome.name, &projector.name, points, weights].map(escape);
    let [yaw, pitch, roll] = projector.angles().map(f64::to_degrees);
    let [left, right, down, up] = projector.edges.map(|t| libm::atan(t).to_degrees());
    let DVec3 { x, y, z } = projector.position;
    let frustum = values(&[
        ("yaw", yaw),
        ("pitch", pitch),
        ("roll", roll),
        ("rightAngle", right),
        ("leftAngle", left),
        ("upAngle", up),
        ("downAngle", down),
    ]);
    let frame = values(&[
        ("posx", x),
        ("posy", y),
        ("posz", z),
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
    ]);
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<MPCDI profile="a3" level="1" date="{DATE}" version="1.0">
  <display>
    <buffer id="{dome}" Xresolution="{columns}" Yresolution="{rows}">
      <region id="{name}" Xresolution="{columns}" Yresolution="{rows}" x="0" y="0" xsize="1" ysize="1">
        <frustum>
{frustum}        </frustum>
        <coordinateFrame>
{frame}        </coordinateFrame>
      </region>
    </buffer>
  </display>
  <files>
    <fileset region="{name}">
      <geometryWarpFile>
        <path>{points}</path>
        <interpolation>linear</interpolation>
        <geometricUnit>m</geometricUnit>
        <originOf3DData>idealEyePoint</originOf3DData>
      </geometryWarpFile>
      <alphaMap>
        <path>{weights}</path>
        <componentDepth>1</componentDepth>
        <bitDepth>8</bitDepth>
        <gammaEmbedded>1.0</gammaEmbedded>
      </alphaMap>
    </fileset>
  </files>
</MPCDI>"#
    )
}

/// Returns a text as XML has it in attributes and elements.
fn escape(text: &str) -> String {
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;");
    escaped.replace('>', "&gt;").replace('"', "&quot;")
}

fn values(values: &[(&str, f64)]) -> String {
    let element = |(name, value): &(&str, f64)| format!("          <{name}>{value:.9}</{name}>\n");
    values.iter().map(element).collect()
}
