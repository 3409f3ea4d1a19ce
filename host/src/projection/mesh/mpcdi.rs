//! Reads MPCDI 1.0 and 2.0, profiles 2d and a3: as an archive, as a folder, or as its XML beside its
//! files. Unknown elements are ignored; attributes may be in upper or lower case.

use super::{Grey, Mesh, Shares, Unreadable, pfm};
use crate::files;
use roxmltree::{Document, Node, ParsingOptions};
use std::io::{Cursor, Read as _};
use std::path::{Component, Path};
use zip::ZipArchive;

/// Most MiB of a file of an archive, unpacked.
const MOST_MIB: u64 = super::MOST_MIB;

const DESCRIPTION: &str = "mpcdi.xml";

/// What the files of a description are read by.
type ReadFile<'r> = dyn FnMut(&str) -> Result<Vec<u8>, Unreadable> + 'r;

/// Reads the projector `name` of an archive.
pub(super) fn of_archive(bytes: &[u8], name: &str) -> Result<Mesh, Unreadable> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|reason| {
        let help = "it starts like an archive: copy or export it again";
        (format!("its archive cannot be read: {reason}"), help)
    })?;
    let mut read = |path: &str| {
        let unread = |reason: String| (format!("its file {path}: {reason}"), files::UNREAD);
        let file = archive
            .by_name(path)
            .map_err(|reason| unread(reason.to_string()))?;
        let mut bytes = Vec::new();
        let most = MOST_MIB << 20;
        let mut file = file.take(most + 1);
        file.read_to_end(&mut bytes)
            .map_err(|reason| unread(reason.to_string()))?;
        if bytes.len() as u64 > most {
            return Err(unread(format!("it has more than {MOST_MIB} MiB, unpacked")));
        }
        Ok(bytes)
    };
    let description = read(DESCRIPTION)?;
    of_description(&description, name, &mut read)
}

/// Reads the projector `name` of a folder with one XML file.
pub(super) fn of_folder(folder: &Path, name: &str) -> Result<Mesh, Unreadable> {
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .map_err(|reason| (reason.to_string(), files::UNREAD))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension()
                .is_some_and(|end| end.eq_ignore_ascii_case("xml"))
        })
        .collect();
    let (Some(path), None) = (found.pop(), found.pop()) else {
        let message = "it is not a folder with one XML file of MPCDI".to_owned();
        return Err((message, "name the XML file"));
    };
    let bytes = files::read_within(&path, MOST_MIB);
    let bytes = bytes.map_err(|reason| (reason.to_string(), files::UNREAD))?;
    of_xml(&bytes, folder, name)
}

/// Reads the projector `name` of a description whose files are in `folder`.
pub(super) fn of_xml(bytes: &[u8], folder: &Path, name: &str) -> Result<Mesh, Unreadable> {
    let mut read = |path: &str| {
        let found = files::read_within(&folder.join(path), MOST_MIB);
        found.map_err(|reason| (format!("its file {path}: {reason}"), files::UNREAD))
    };
    of_description(bytes, name, &mut read)
}

fn of_description(bytes: &[u8], name: &str, read: &mut ReadFile<'_>) -> Result<Mesh, Unreadable> {
    const HELP: &str = "MPCDI is XML with a root MPCDI, a display with regions, and files with a \
                        fileset for each region";
    let fault = |message: String| (message, HELP);
    let text = std::str::from_utf8(bytes).map_err(|_| fault("its XML is not UTF-8".to_owned()))?;
    let options = ParsingOptions {
        nodes_limit: 1 << 16,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options)
        .map_err(|reason| fault(format!("its XML is wrong: {reason}")))?;
    let root = document.root_element();
    let profile = attribute(root, "profile")
        .unwrap_or_default()
        .to_lowercase();
    if !["2d", "a3"].contains(&profile.as_str()) {
        let help = "export profile a3 (points in the room) or 2d (places in the picture)";
        return Err((format!("its profile is \"{profile}\""), help));
    }
    let all = |kind: &'static str| {
        let nodes = document.descendants();
        nodes.filter(move |node| node.tag_name().name().eq_ignore_ascii_case(kind))
    };
    let regions: Vec<Node<'_, '_>> = all("region").collect();
    let is_named = |node: &&Node<'_, '_>| attribute(**node, "id") == Some(name);
    let region = match regions.as_slice() {
        [only] => Some(only),
        several => several.iter().find(is_named),
    };
    let Some(region) = region else {
        let names = regions.iter().filter_map(|node| attribute(*node, "id"));
        let names = names.collect::<Vec<_>>().join(", ");
        let help = "name the projector as one of its regions";
        return Err((format!("it has no region \"{name}\", but: {names}"), help));
    };
    let id = attribute(*region, "id").unwrap_or_default();
    let files = all("fileset").find(|files| attribute(*files, "region") == Some(id));
    let files = files.ok_or_else(|| fault(format!("it has no fileset for the region \"{id}\"")))?;
    let warp = child(files, "geometryWarpFile");
    let warp = warp.ok_or_else(|| fault(format!("the region \"{id}\" has no geometryWarpFile")))?;
    let edge = |name, or: f64| attribute(*region, name).map_or(Ok(or), str::parse);
    let edges = [
        edge("x", 0.0),
        edge("y", 0.0),
        edge("xsize", 1.0),
        edge("ysize", 1.0),
    ];
    let [Ok(x), Ok(y), Ok(width), Ok(height)] = edges else {
        return Err(fault(format!(
            "the region \"{id}\" has edges that are not numbers"
        )));
    };
    let points = pfm::Points::read(&read(path_of(warp)?)?)?;
    let mut mesh = points.mesh(profile == "2d", unit(warp)?, Some([x, y, width, height]))?;
    let beta = child(files, "betaMap");
    if let Some(alpha) = child(files, "alphaMap") {
        let gamma = gamma_of(alpha)?.unwrap_or(1.0);
        let alpha = grey(alpha, gamma, read)?;
        // A beta map without a gamma has that of alpha.
        let beta = beta.map(|beta| grey(beta, gamma_of(beta)?.unwrap_or(gamma), read));
        let beta = beta.transpose()?;
        // White alone blends nothing.
        if beta.is_some() || alpha.values.iter().any(|share| *share != 1.0) {
            mesh.shares = Shares::Maps(alpha, beta);
        }
    } else if beta.is_some() {
        return Err(fault(format!(
            "the region \"{id}\" has a betaMap and no alphaMap"
        )));
    }
    Ok(mesh)
}

fn attribute<'d>(node: Node<'d, 'd>, name: &str) -> Option<&'d str> {
    let mut attributes = node.attributes();
    let found = attributes.find(|one| one.name().eq_ignore_ascii_case(name));
    found.map(|one| one.value().trim())
}

fn child<'d>(node: Node<'d, 'd>, name: &str) -> Option<Node<'d, 'd>> {
    let mut nodes = node.children();
    nodes.find(|node| node.tag_name().name().eq_ignore_ascii_case(name))
}

fn text<'d>(node: Node<'d, 'd>, name: &str) -> Option<&'d str> {
    child(node, name)?.text().map(str::trim)
}

/// Returns a path that stays where the description is.
fn path_of<'d>(node: Node<'d, 'd>) -> Result<&'d str, Unreadable> {
    let path = text(node, "path").unwrap_or_default();
    let mut parts = Path::new(path).components();
    if !path.is_empty()
        && !path.contains(['\\', ':'])
        && parts.all(|part| matches!(part, Component::Normal(_)))
    {
        return Ok(path);
    }
    let help = "its files are named relative to it, in its own folder";
    Err((
        format!("its path \"{}\" leads out of it", path.escape_debug()),
        help,
    ))
}

/// Returns the metres of a warp's unit.
fn unit(warp: Node<'_, '_>) -> Result<f64, Unreadable> {
    Ok(match text(warp, "geometricUnit").unwrap_or("m") {
        "mm" => 1.0e-3,
        "cm" => 0.01,
        "dm" => 0.1,
        "m" | "unkown" | "unknown" => 1.0,
        "in" => 0.0254,
        "ft" => 0.3048,
        "yd" => 0.9144,
        other => {
            let help = "its geometricUnit is mm, cm, dm, m, in, ft or yd";
            return Err((format!("there is no unit \"{other}\""), help));
        }
    })
}

/// Returns the gamma that a map says it has.
fn gamma_of(map: Node<'_, '_>) -> Result<Option<f64>, Unreadable> {
    let said = text(map, "gammaEmbedded").and_then(|gamma| gamma.parse().ok());
    if let Some(gamma) = said.filter(|gamma| !(0.1..=10.0).contains(gamma)) {
        let help = "its gammaEmbedded is a number such as 2.2";
        return Err((format!("the gamma of {} is {gamma}", path_of(map)?), help));
    }
    Ok(said)
}

/// Reads a PNG of 8 or 16 bits as light.
fn grey(map: Node<'_, '_>, gamma: f64, read: &mut ReadFile<'_>) -> Result<Grey, Unreadable> {
    let path = path_of(map)?;
    let bytes = read(path)?;
    let unread = |reason: png::DecodingError| {
        let help = "it is a PNG of 8 or 16 bits, grey or RGB";
        (format!("its file {path}: {reason}"), help)
    };
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(unread)?;
    let (width, height) = (reader.info().width, reader.info().height);
    if width.max(height) as usize > Mesh::MOST_NODES {
        let help = "give a map with the region's resolution";
        return Err((
            format!("its file {path} has {width} × {height} pixels"),
            help,
        ));
    }
    let most = (MOST_MIB << 20) as usize;
    let bytes = reader.output_buffer_size().filter(|bytes| *bytes <= most);
    let Some(bytes) = bytes else {
        let help = "give a map with the region's resolution";
        return Err((
            format!("its file {path} has more than {MOST_MIB} MiB, unpacked"),
            help,
        ));
    };
    let mut pixels = vec![0; bytes];
    let image = reader.next_frame(&mut pixels).map_err(unread)?;
    let bytes = match image.bit_depth {
        png::BitDepth::Sixteen => 2,
        _ => 1,
    };
    let channels = image.color_type.samples();
    let colours = if channels < 3 { 1 } else { 3 };
    let most = if bytes == 2 { 65535.0 } else { 255.0 };
    let mut values = Vec::with_capacity(image.width as usize * image.height as usize);
    for pixel in pixels[..image.buffer_size()].chunks_exact(bytes * channels) {
        let code = |channel: usize| {
            let code = &pixel[channel * bytes..(channel + 1) * bytes];
            code.iter()
                .fold(0.0, |sum, byte| 256.0 * sum + f64::from(*byte))
        };
        let first = code(0);
        if (1..colours).any(|channel| (code(channel) - first).abs() > 0.02 * most) {
            let help = "export one map for all channels";
            return Err((
                format!("its file {path} differs from channel to channel"),
                help,
            ));
        }
        values.push(libm::pow(first / most, gamma) as f32);
    }
    Ok(Grey {
        size: [image.width as usize, image.height as usize],
        values,
    })
}
