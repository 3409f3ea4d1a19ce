//! MPCDI 1.0 and 2.0, VESA's interchange of projector calibrations: an archive of `mpcdi.xml`, a
//! PFM of points and a PNG of weights.
//!
//! The profile is `a3`, advanced 3D: each value of the PFM is where the middle of a cell of the
//! projector's picture meets its screen, (x, y, z) in metres, or NaN. The weights (`alphaMap`) are
//! the projector's share of the light, black off the screen; where black levels are lifted, there is
//! a `betaMap`. Both are 8-bit grey of gamma 2.2, since readers fail on more bits: a pixel shows
//! L·α·(1 − β) + β, all linear.
//!
//! Points are in the room's axes, +X to the right, +Y up, −Z to the front, from the room's origin
//! (`idealEyePoint`). For projectors with a pose, `coordinateFrame` has the axes and the position,
//! and `frustum` how it is turned, and its field: degrees, yaw to the right, then pitch upwards, then
//! roll clockwise as it looks. The date is 1980's first: the same warp gives the same file.

use super::Warp;
use crate::projection::show::{Light, lights_of};
use crate::projection::{Lens, Transfer};
use glam::DVec3;
use std::io::{self, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

const DATE: &str = "1980-01-01 00:00:00";

const DESCRIPTION: &str = "mpcdi.xml";

/// The version of the format. They differ in the root's attributes and one's letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// 1.0, of 2013.
    One,
    /// 2.0, of 2015: geometry of level 2, colour of level 1.
    Two,
}

/// Gamma of the maps' codes.
const GAMMA: f64 = 2.2;

/// Writes the archive.
///
/// # Errors
/// What writing reports.
pub fn write(warp: &Warp<'_>, version: Version, to: impl Write + Seek) -> io::Result<()> {
    let name = &warp.projector().name;
    let lights = lights_of(warp.blend);
    let lights = &lights[warp.member];
    let [points, weights, lifts] =
        ["{}.pfm", "{}-alpha.png", "{}-beta.png"].map(|file| file.replace("{}", name));
    let is_lifted = lights.iter().flatten().any(|light| light.lift > 0.0);
    let mut archive = ZipWriter::new(to);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let lifts_file = is_lifted.then_some(lifts.as_str());
    let xml = description(warp, version, &points, &weights, lifts_file);
    archive.start_file(DESCRIPTION, options)?;
    archive.write_all(xml.as_bytes())?;
    archive.start_file(points, options)?;
    write_points(warp, &mut archive)?;
    archive.start_file(weights, options)?;
    let size = warp.projector().resolution;
    archive.write_all(&grey(size, lights, |light| {
        light.weight / (1.0 - light.lift)
    })?)?;
    if is_lifted {
        archive.start_file(lifts, options)?;
        archive.write_all(&grey(size, lights, |light| light.lift)?)?;
    }
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

/// Returns a PNG of 8-bit grey of a number of each pixel: of gamma [`GAMMA`], black off the screen.
fn grey(
    size: [u32; 2],
    lights: &[Option<Light>],
    number: impl Fn(&Light) -> f64,
) -> io::Result<Vec<u8>> {
    let gamma = Transfer::Gamma(GAMMA);
    let code = |light: &Option<Light>| {
        let light = light.as_ref().map_or(0.0, &number);
        (255.0 * gamma.code(light)).round_ties_even() as u8
    };
    let codes: Vec<u8> = lights.iter().map(code).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size[0], size[1]);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&codes)?;
    writer.finish()?;
    Ok(file)
}

/// Returns the text of `mpcdi.xml`, without a line feed at its end.
fn description(
    warp: &Warp<'_>,
    version: Version,
    points: &str,
    weights: &str,
    lifts: Option<&str>,
) -> String {
    let (level, number, across, down) = match version {
        Version::One => ("level=\"1\"", "1.0", "Xresolution", "Yresolution"),
        Version::Two => (
            "geometry=\"2\" color=\"1\"",
            "2.0",
            "xResolution",
            "yResolution",
        ),
    };
    let projector = warp.projector();
    let [columns, rows] = projector.resolution;
    let screen = warp.screen().name();
    let [screen, name, points] = [screen, &projector.name, points].map(escape);
    let pose = projector.lens().map_or_else(|_| String::new(), pose);
    let alpha = map_element("alphaMap", weights);
    let beta = lifts.map_or_else(String::new, |lifts| map_element("betaMap", lifts));
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<MPCDI profile="a3" {level} date="{DATE}" version="{number}">
  <display>
    <buffer id="{screen}" {across}="{columns}" {down}="{rows}">
      <region id="{name}" {across}="{columns}" {down}="{rows}" x="0" y="0" xsize="1" ysize="1">
{pose}      </region>
    </buffer>
  </display>
  <files>
    <fileset region="{name}">
      <geometryWarpFile>
        <path>{points}</path>
        <interpolation>linear</interpolation>
        <geometricUnit>m</geometricUnit>
        <originOf3DData>idealEyePoint</originOf3DData>
      </geometryWarpFile>{alpha}{beta}
    </fileset>
  </files>
</MPCDI>"#
    )
}

/// Returns the element of a PNG of 8-bit grey.
fn map_element(element: &str, path: &str) -> String {
    let path = escape(path);
    format!(
        "
      <{element}>
        <path>{path}</path>
        <componentDepth>1</componentDepth>
        <bitDepth>8</bitDepth>
        <gammaEmbedded>{GAMMA}</gammaEmbedded>
      </{element}>"
    )
}

/// Returns the elements of a projector's pose and field.
fn pose(lens: &Lens) -> String {
    let [yaw, pitch, roll] = lens.angles().map(f64::to_degrees);
    let [left, right, down, up] = lens.edges.map(|t| libm::atan(t).to_degrees());
    let DVec3 { x, y, z } = lens.position;
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
        "        <frustum>\n{frustum}        </frustum>\n        <coordinateFrame>\n{frame}        \
         </coordinateFrame>\n"
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
