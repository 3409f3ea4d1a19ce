//! `shisen show`: pictures full-screen on monitors.

use crate::cave::Eye;
use crate::cli::arguments::outputs::OutputsArguments;
use crate::cli::arguments::span;
use crate::cli::cave::pictures::STEREO_FILES;
use crate::cli::prelude::*;
use crate::cli::tracker::Interrupt;
use crate::files::explain;
use crate::live::Refresh;
use crate::outputs::{Outputs, OutputsReport};
use crate::picture::Picture;
use crate::projection::Projection;
use crate::scene::texture::Image;
use crate::show::stereo::Stereo;
use palette::Srgb;
use std::collections::BTreeMap;
use std::io;

/// Shows the pictures that cave has written full-screen on monitors
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Folder of the pictures: SCREEN-left.png and SCREEN-right.png, or SCREEN-centre.png
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    outputs: OutputsArguments,
    /// TOML file of the room that has the projectors of --outputs
    #[arg(long, value_name = "FILE")]
    walls: Option<PathBuf>,
    /// How monitors show two eyes, where their output does not say: mono (the left one alone),
    /// sequential (by turns), side-by-side, top-bottom or anaglyph
    #[arg(long, value_name = "FORMAT", default_value_t = Stereo::Mono)]
    stereo: Stereo,
    /// End after S seconds [default: at Ctrl-C]
    #[arg(long, value_name = "S", value_parser = span)]
    seconds: Option<Duration>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let found = pictures(&arguments.folder)?;
    let mut screens: Vec<&str> = found.keys().map(|(screen, _)| screen.as_str()).collect();
    screens.dedup();
    let of: Vec<(&str, Eye)> = (found.keys())
        .map(|(screen, eye)| (screen.as_str(), Eye::ALL[*eye]))
        .collect();
    let first = found.values().next();
    let size = first.map_or([1; 2], |picture| [picture.width, picture.height]);
    let room = arguments
        .walls
        .as_deref()
        .map(|path| Cave::load(path, size));
    let projections = match room.transpose()? {
        Some(room) => Projection::all(&room)?,
        None => Vec::new(),
    };
    for ((screen, _), picture) in &found {
        let mut all = projections.iter().filter(|one| one.screen() == screen);
        let size = [picture.width, picture.height];
        if let Some(one) = all.find(|one| one.picture_size() != size) {
            let [columns, rows] = one.picture_size();
            let message = format!(
                "the pictures of \"{screen}\" have {} × {} pixels, and the room's file says \
                 {columns} × {rows}",
                size[0], size[1]
            );
            let help = "render them anew with this --walls file, or leave pixels out of it";
            return Err(Fault::new(message, help).into());
        }
    }
    let opened = (arguments.outputs).open(&screens, &of, &projections, arguments.stereo)?;
    let mut outputs = opened.ok_or_else(|| {
        misuse!(
            "give --outputs, such as --outputs {}=HDMI-1",
            screens.join("=DP-1,")
        )
    })?;
    let pictures: Vec<Picture> = found.into_values().collect();
    outputs.prepare(&pictures);
    let report = hold(&mut outputs, arguments.seconds, |outputs| {
        if outputs.prepare_again() {
            outputs.prepare(&pictures);
        }
    });
    print(&report, arguments.json)
}

/// Shows what was prepared, and what `prepare` does for each further refresh, for some time or
/// until the program is interrupted.
pub(super) fn hold(
    outputs: &mut Outputs,
    seconds: Option<Duration>,
    prepare: impl Fn(&mut Outputs),
) -> OutputsReport {
    let interrupt = Interrupt::watched();
    let end = seconds.map(|span| Instant::now() + span);
    let mut next = Instant::now();
    loop {
        let shown = outputs.present(next);
        outputs.said().for_each(|text| warn(&text));
        next = match shown {
            Some(Refresh { at, period, .. }) => at + period,
            None => Instant::now() + Duration::from_secs_f64(1.0 / outputs.hz()),
        };
        let is_over = end.is_some_and(|end| Instant::now() >= end);
        if is_over || interrupt.came() || !outputs.is_open() {
            return outputs.report();
        }
        prepare(outputs);
    }
}

/// Returns the pictures of a folder by screen and number of the eye.
fn pictures(folder: &Path) -> Result<BTreeMap<(String, usize), Picture>, Failure> {
    let mut found = BTreeMap::new();
    let unread = |reason: io::Error| {
        let (what, advice) = explain(&reason);
        Fault::new(format!("{}: {what}", folder.display()), advice)
    };
    let mut left = Image::MOST_BYTES;
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        let stem = name.and_then(|name| name.strip_suffix(".png"));
        let Some((screen, eye)) = stem.and_then(|stem| stem.rsplit_once('-')) else {
            continue;
        };
        if STEREO_FILES.contains(&screen) {
            continue;
        }
        if let Some(eye) = Eye::ALL.iter().position(|one| one.name() == eye) {
            let picture = linear(&Image::load(&path, &mut left)?)?;
            found.insert((screen.to_owned(), eye), picture);
        }
    }
    if found.is_empty() {
        let message = format!("{} has no pictures of screens", folder.display());
        let help = "give a folder that shisen cave has written: it has front-left.png and others";
        return Err(Fault::new(message, help).into());
    }
    Ok(found)
}

/// Returns the picture of which an image has the codes.
fn linear(image: &Image) -> Result<Picture, Failure> {
    let linear: [f32; 256] =
        std::array::from_fn(|code| Srgb::new(code as u8, 0, 0).into_linear().red);
    let texels = image.texels().iter();
    let pixels = texels.map(|&[red, green, blue, _]| {
        let [red, green, blue] = [red, green, blue].map(|code| linear[usize::from(code)]);
        [red, green, blue, 1.0]
    });
    Picture::from_pixels(image.width(), image.height(), pixels.collect()).or_fail()
}
