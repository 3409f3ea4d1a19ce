//! Detail that follows the gaze, against full tracing.

use super::frames::{Follow, Lod, RUNGS, Room, Way, pictures, scene, with_faces};
use super::metrics::{LEAST_PIXELS_PER_DEGREE, MEASURES};
use super::{Bench, Cause, Comparison, Effort, Figure, Limit, Point, Section, limit};
use shisen::bake::Baked;
use shisen::cli::output::counted;
use shisen::picture::Picture;
use shisen::render::{CaptureOptions, Filling, Frame};
use shisen::show::lod;
use shisen_core::gaze::{Acuity, Boundary, VisualField, VisualFieldLimits};

/// FLIP by acuity that counts as no error. A difference of 1 of CIELAB, just visible side by
/// side, has FLIP 0.057: this limit is reached where 1.7 % of the picture are that far off, or
/// 0.1 % are black for white. A convention, without a trial with people.
pub(super) const UNSEEN: Limit = limit(
    0.001,
    "unseen: as if 1.7 % of the picture were just visibly off, side by side",
);

/// FLIP by acuity that may be missing at the border of the field of view: ten times [`UNSEEN`].
/// A convention, too: visible beside the other picture, and seldom missed without it.
pub(super) const NOT_MISSED: Limit = limit(
    0.01,
    "not missed: as if 1 % of the picture, by the cortex that sees it, were black for \
              white",
);

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let size = bench.effort.pick(128, 256);
    let room = Room::new(bench, size)?;
    let scenes = scenes(bench)?;
    let about = format!(
        "The paper's scene A (mirrors all round) on three walls of {size}² pixels, at least {:.1} \
         pixels a degree, for two eyes that look at the animal above the middle of the front wall. \
         Errors are against full tracing of the same view: FLIP from 0 (equal) to 1, at {}; the \
         peak signal-to-noise ratio, which equal pictures do not have; structural similarity up to \
         1 (equal). They are taken over all pixels; in rings round the line of sight (the fovea to \
         1°, the parafovea to 5°, the periphery beyond: Rayner 1998); and by acuity, weighted by the \
         part of the visual cortex that sees a pixel: its solid angle times the square of \
         17.3 mm / (E + 0.75°), E being its eccentricity (Horton & Hoyt 1991). Fovea and parafovea \
         are taken from a screen of their own with {} pixels within 1° for each eye, which adds no \
         time and no steps. The settings say which rays are traced, how often they bounce, which \
         faces they see, and how fast acuity falls where it says how large detail is.",
        room.pixels_per_degree(),
        flip_at(room.pixels_per_degree()),
        room.near.pixels_in_the_fovea(),
    );
    let (methods, [full, paper]) = methods(bench, &room, &scenes)?;
    let depths = depths(bench, &room, &scenes)?;
    let samples = samples(bench, &room, &scenes)?;
    let title = "Detail that follows the gaze";
    let comparisons = vec![methods, depths, samples];
    let mut section = Section::new("gaze", title, about, comparisons);
    section.pictures = figures(&room, &full, &paper)?;
    Ok(section)
}

fn flip_at(pixels_per_degree: f32) -> String {
    if pixels_per_degree < LEAST_PIXELS_PER_DEGREE {
        format!(
            "{LEAST_PIXELS_PER_DEGREE} pixels a degree, the fewest that it has filters for: these \
             walls have fewer, and are compared as if seen from {:.1} times as far",
            LEAST_PIXELS_PER_DEGREE / pixels_per_degree
        )
    } else {
        format!("the {pixels_per_degree:.1} of the walls")
    }
}

/// Scene A with polygon levels: the fewest and the most faces of a mesh, the levels between them,
/// and the scene; first as `shisen cave` bakes it.
type Scenes = [(u32, u32, u32, Baked)];

fn scenes(bench: &Bench<'_>) -> Result<Vec<(u32, u32, u32, Baked)>, Cause> {
    let scene = scene(bench)?;
    let all = u32::MAX;
    let mut wanted = vec![(500, all, RUNGS), (2_000, all, RUNGS), (500, all, 4)];
    wanted.extend([(500, 2_000, 2)]);
    if bench.effort == Effort::Full {
        wanted.extend([(100, all, RUNGS), (250, all, RUNGS), (1_000, all, RUNGS)]);
        wanted.extend([(500, all, 2), (500, all, 8), (500, all, 40)]);
        wanted.extend([(500, 1_000, 2), (500, 4_000, 2)]);
    }
    let bake = |(min, max, rungs)| Ok((min, max, rungs, with_faces(&scene, min, max, rungs)?));
    wanted.into_iter().map(bake).collect()
}

struct Setting<'a> {
    series: &'static str,
    name: String,
    scene: &'a Baked,
    faces: Option<(u32, u32, u32)>,
    way: Way<'a>,
}

impl<'a> Setting<'a> {
    fn new(series: &'static str, name: impl Into<String>, scene: &'a Baked, way: Way<'a>) -> Self {
        Self {
            series,
            name: name.into(),
            scene,
            faces: None,
            way,
        }
    }

    fn point(&self) -> Point {
        let mut settings = self.way.settings();
        if let Some((min, max, rungs)) = self.faces {
            settings.push(("fewest_faces", min.into()));
            let most = (max != u32::MAX).then_some(max);
            settings.push(("most_faces", most.into()));
            settings.push(("polygon_levels", rungs.into()));
        }
        Point::new(self.series, self.name.clone(), settings)
    }
}

/// Renders several settings; returns their points, against the truth or else the first one, and
/// their frames.
fn points(
    bench: &Bench<'_>,
    room: &Room,
    settings: &[Setting<'_>],
    truth: Option<(&Baked, &Way<'_>)>,
    share: (f64, f64),
) -> Result<(Vec<Point>, Vec<Frame>), Cause> {
    let measured = bench.in_turns(settings, share, |one| {
        let frame = room.frame(one.scene, &one.way)?;
        Ok((frame.seconds, frame))
    })?;
    let (scene, way) = truth.unwrap_or((settings[0].scene, &settings[0].way));
    let near_truth = room.near_frame(scene, way)?;
    let truth = match truth {
        Some((scene, way)) => room.frame(scene, way)?,
        None => measured[0].first.clone(),
    };
    let mut points = Vec::new();
    let mut frames = Vec::new();
    for (one, time) in settings.iter().zip(measured) {
        let near = room.near_frame(one.scene, &one.way)?;
        let near = room.near.error(&near, &near_truth);
        let frame = &time.first;
        let error = room.error(pictures(frame), &truth).with_middle_of(&near);
        let steps = Some(frame.statistics.steps);
        points.push(one.point().measured(error.errors(), &time, steps));
        frames.push(time.first);
    }
    Ok((points, frames))
}

/// Compares all ways to follow the gaze; returns the frames in full and by the paper, too.
// Longer than 80 lines: the ways to follow a gaze are a table.
fn methods(
    bench: &Bench<'_>,
    room: &Room,
    scenes: &Scenes,
) -> Result<(Comparison, [Frame; 2]), Cause> {
    let usual = &scenes[0].3;
    let with = |lod: Lod| Way {
        lod: Some(Follow::Levels(lod)),
        ..Way::FULL
    };
    let field = |field: VisualField| {
        with(Lod {
            field,
            ..Lod::PAPER
        })
    };
    let new = |series, name: &str, way| Setting::new(series, name, usual, way);
    let ellipse = VisualField::PAPER.with_boundary(Boundary::Ellipse);
    let mut settings = vec![
        new("all in full", "full", Way::FULL),
        new("method", "paper", Way::PAPER),
        new("method", "paper-ellipse", field(ellipse)),
    ];
    for (name, bounces, faces) in [
        ("rays only", false, false),
        ("rays and bounces", true, false),
        ("rays and faces", false, true),
    ] {
        let lod = Lod {
            bounces,
            faces,
            ..Lod::PAPER
        };
        settings.push(new("method", name, with(lod)));
    }
    for degrees in bench
        .effort
        .pick(&[5u16, 15, 45][..], &[2, 5, 10, 15, 20, 25, 40, 50])
    {
        let name = format!("full to {degrees}°");
        settings.push(new("cut-offs", &name, field(central(*degrees)?)));
    }
    for degrees in bench.effort.pick(&[-20i8, 20][..], &[-20, -10, 10, 20, 30]) {
        let sign = if *degrees < 0 { "−" } else { "+" };
        let name = format!("border {sign}{}°", degrees.unsigned_abs());
        settings.push(new("cut-offs", &name, field(border(*degrees)?)));
    }
    for &(min, max, rungs, ref scene) in &scenes[1..] {
        let (series, name, way) = match max {
            u32::MAX if rungs == RUNGS => ("faces", format!("from {min} faces"), Way::PAPER),
            u32::MAX => ("faces", format!("{rungs} levels"), Way::PAPER),
            _ => ("fewer faces everywhere", format!("{max} faces"), Way::FULL),
        };
        settings.push(Setting {
            faces: Some((min, max, rungs)),
            ..Setting::new(series, name, scene, way)
        });
    }
    for &size in bench
        .effort
        .pick(&[64u32, 128][..], &[32, 64, 128, 256, 512])
    {
        let capture = CaptureOptions {
            size,
            ..CaptureOptions::default()
        };
        let way = Way {
            filling: Filling::Capture(capture),
            ..Way::PAPER
        };
        settings.push(new("filled by a capture", &format!("capture {size}²"), way));
    }
    let (points, mut frames) = points(bench, room, &settings, None, (0.0, 0.6))?;
    let about = "What follows the gaze (rays, bounces, faces), where full detail ends and tracing \
                 ends, how many faces meshes have at the border and everywhere, and how the rest is \
                 filled. The truth is everything in full, three bounces, one ray a pixel.";
    let title = ("methods", "What follows the gaze");
    let comparison = Comparison::new(title, about, MEASURES.to_vec(), NOT_MISSED, points)
        .with_other_limit(UNSEEN)
        .logarithmic();
    let paper = frames.swap_remove(1);
    let full = frames.swap_remove(0);
    Ok((comparison, [full, paper]))
}

fn foveated<'a>(bench: &Bench<'_>, usual: &'a Baked) -> Vec<Setting<'a>> {
    let point = |name: String, acuity: Acuity| {
        let way = Way {
            lod: Some(Follow::Acuity(acuity)),
            ..Way::FULL
        };
        Setting::new("size of detail", name, usual, way)
    };
    let mut settings = vec![point("foveated".to_owned(), Acuity::GUENTER)];
    let coarser = bench
        .effort
        .pick(&[2.0f32, 4.0][..], &[1.5, 2.0, 3.0, 4.0, 8.0]);
    settings.extend(coarser.iter().map(|&times| {
        let name = format!("foveated, {times} times as coarse");
        point(name, Acuity::GUENTER.steeper(times))
    }));
    settings
}

fn central(degrees: u16) -> Result<VisualField, Cause> {
    let paper = VisualField::PAPER;
    let limits = VisualFieldLimits {
        central: f32::from(degrees).to_radians(),
        ..paper.limits()
    };
    Ok(VisualField::new(limits, paper.boundary())?)
}

/// Returns the paper's field with its border farther out by this angle, as far as fields go.
fn border(degrees: i8) -> Result<VisualField, Cause> {
    let paper = VisualField::PAPER;
    let by = f32::from(degrees).to_radians();
    let limits = paper.limits();
    let upright = |limit: f32| (limit + by).min(std::f32::consts::FRAC_PI_2);
    let limits = VisualFieldLimits {
        central: limits.central,
        up: upright(limits.up),
        down: upright(limits.down),
        left: limits.left + by,
        right: limits.right + by,
    };
    Ok(VisualField::new(limits, paper.boundary())?)
}

fn depths(bench: &Bench<'_>, room: &Room, scenes: &Scenes) -> Result<Comparison, Cause> {
    let deepest = 8;
    let usual = &scenes[0].3;
    let way = |depth: u8, way: Way<'static>| Way { depth, ..way };
    let mut settings = Vec::new();
    for depth in 0..=5 {
        let (name, full) = (format!("depth {depth}"), way(depth, Way::FULL));
        settings.push(Setting::new("everywhere", name, usual, full));
    }
    for &depth in bench.effort.pick(&[1u8, 3, 5][..], &[0, 1, 2, 3, 4, 5]) {
        let name = format!("paper, depth {depth}");
        settings.push(Setting::new("paper", name, usual, way(depth, Way::PAPER)));
    }
    let about = format!(
        "Reflections after one another, in all pixels, and with the paper's levels, which leave \
         fewer of them farther out. The truth is full tracing with {deepest}."
    );
    let title = (("depths", "How often rays bounce"), about);
    let truth = way(deepest, Way::FULL);
    by_truth(bench, room, (usual, &truth), &settings, title, (0.6, 0.8))
}

fn samples(bench: &Bench<'_>, room: &Room, scenes: &Scenes) -> Result<Comparison, Cause> {
    let finest = bench.effort.pick(32, 64);
    let usual = &scenes[0].3;
    let way = |samples: u16, way: Way<'static>| Way { samples, ..way };
    let mut settings = Vec::new();
    for &samples in bench.effort.pick(&[1u16, 2, 4, 8][..], &[1, 2, 4, 8, 16]) {
        let rays = counted(samples.into(), "ray");
        let name = format!("paper, {rays}");
        let (full, paper) = (way(samples, Way::FULL), way(samples, Way::PAPER));
        settings.push(Setting::new("everywhere", rays, usual, full));
        settings.push(Setting::new("paper", name, usual, paper));
    }
    settings.extend(foveated(bench, usual));
    let about = format!(
        "Rays a pixel, in all pixels, and where the paper's levels leave any; and detail as large as \
         the eye sees it, which has four. The truth is full tracing with {finest}. What a viewer \
         makes of the same, as FovVideoVDP says, is in the measurements: detail as large as the eye \
         sees it."
    );
    let title = (("samples", "How many rays a pixel has"), about);
    let truth = way(finest, Way::FULL);
    by_truth(bench, room, (usual, &truth), &settings, title, (0.8, 1.0))
}

/// Compares settings with a truth that is not among them.
fn by_truth(
    bench: &Bench<'_>,
    room: &Room,
    truth: (&Baked, &Way<'_>),
    settings: &[Setting<'_>],
    (title, about): ((&'static str, &'static str), String),
    share: (f64, f64),
) -> Result<Comparison, Cause> {
    let (points, _) = points(bench, room, settings, Some(truth), share)?;
    let comparison = Comparison::new(title, about, MEASURES.to_vec(), UNSEEN, points);
    Ok(comparison.with_other_limit(NOT_MISSED))
}

fn figures(room: &Room, full: &Frame, paper: &Frame) -> Result<Vec<Figure>, Cause> {
    let copies = |frame: &Frame| pictures(frame).cloned().collect::<Vec<Picture>>();
    let (full, paper) = (copies(full), copies(paper));
    let pairs = paper.iter().zip(&full);
    let differences: Result<Vec<Picture>, _> = pairs.map(|(a, b)| lod::difference(a, b)).collect();
    let figures = [
        ("Everything in full, the left eye's walls unfolded", &full),
        (
            "By the paper's levels: the viewer looks at the upper animal of the front wall",
            &paper,
        ),
        (
            "What differs: black nothing, white a quarter of the range and more",
            &differences?,
        ),
    ];
    let figures = figures.into_iter();
    figures
        .map(|(caption, pictures)| Ok((caption.to_owned(), room.unfold(pictures)?)))
        .collect()
}
