//! The cost of each effect, and the error of a frame without it.

use super::frames::{CLOSE_UP, CloseUp};
use super::gaze::{NOT_MISSED, UNSEEN};
use super::metrics::MEASURES;
use super::{Bench, Cause, Comparison, PictureDifference, Point, Section, Sight, measure};
use glam::{DVec3, Vec3};
use shisen::bake::Baked;
use shisen::cave::{Cave, Eye, Viewer, Wall};
use shisen::picture::Picture;
use shisen::render::effects::Effects;
use shisen::render::{self, Filling, Observer, Options};
use shisen::scene::Scene;
use shisen::scene::file::{BuiltInMesh, MeshSource};
use shisen::scene::mesh::TriangleMesh;
use shisen_core::scene::EffectSet;
use std::convert::Infallible;

const SCENE: &str = include_str!("effects.toml");

/// The place of the glass ball of flint, metres.
const LOOKED_AT: Vec3 = Vec3::new(0.15, -0.75, -2.3);

const SAMPLES: u16 = 4;

// Longer than 80 lines: half of it is the report.
pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let size = bench.effort.pick(96, 384);
    let baked: Baked = Baked::new(&scene(bench)?)?;
    let cave = room(size)?;
    let eye = [Observer::new(
        Eye::Centre,
        Viewer::default().eye(Eye::Centre),
    )];
    let mut options = bench.options();
    options.settings.samples = SAMPLES;
    let with = |effects: Effects| Options { effects, ..options };
    let asked_for = baked.scene().effects();
    let mut ways: Vec<(Option<EffectSet>, Effects)> = vec![(None, Effects::AUTO)];
    for &(effect, _) in EffectSet::NAMED
        .iter()
        .filter(|one| asked_for.contains(one.0))
    {
        ways.push((Some(effect), Effects::AUTO.less(effect)));
    }
    ways.push((Some(asked_for), Effects::AUTO.less(EffectSet::ALL)));
    let measured = bench.in_turns(&ways, (0.0, 1.0), |one| {
        let quiet = |_, _| {};
        let frame = render::cave(baked.scene().into(), &cave, &eye, &with(one.1), &quiet)?;
        Ok((frame.seconds, frame))
    })?;
    let account = render::account(baked.scene().into(), &cave, &eye, &options)?;
    let truth = measured[0].first.pictures[0].picture.clone();
    let view = render::view(&cave.walls[0], &eye[0])?;
    let sight = Sight::new(&view, LOOKED_AT);
    let near = CloseUp::new(LOOKED_AT, &eye, bench.effort.pick(120, CLOSE_UP))?;
    let near_frame =
        |effects: Effects| near.frame(&baked, &eye, &with(effects), Filling::Background);
    let near_truth = near_frame(Effects::AUTO)?;
    let mut points = Vec::new();
    let mut pictures = vec![("All effects".to_owned(), truth.clone())];
    for ((effect, effects), time) in ways.iter().zip(measured) {
        let found = &time.first.pictures[0].picture;
        let name = match effect {
            None => "all".to_owned(),
            Some(effect) if *effect == asked_for => "none".to_owned(),
            Some(effect) => format!("without {effect}"),
        };
        let near = near.error(&near_frame(*effects)?, &near_truth);
        let error = PictureDifference::new(&[(&sight, found, &truth)]).with_middle_of(&near);
        let mut errors = error.errors();
        // The entry of the effect alone in the ledger of the whole frame.
        let one = effect.filter(|&effect| effect != asked_for);
        let entry = one.map(|effect| account.ledger.entry(effect));
        errors.push(entry.map(|entry| 100.0 * entry.pixels as f64 / account.pixels as f64));
        errors.push(entry.map(|entry| entry.rays as f64));
        if effect.is_some() {
            let caption = format!("{}{}", name[..1].to_uppercase(), &name[1..]);
            pictures.push((caption, found.clone()));
        }
        let without = effect.map_or("nothing".to_owned(), |one| one.to_string());
        let settings = [("without", without.into()), ("samples", SAMPLES.into())];
        let point = Point::new("effects", name, settings);
        points.push(point.measured(errors, &time, Some(time.first.statistics.steps)));
    }
    let about = format!(
        "A scene with all effects, on one wall of {size}² pixels, {SAMPLES} rays a pixel, for one \
         eye that looks at the ball of flint (with a screen of its own within 5°, as in the first \
         section): with all effects, without each of them, and without all. The truth is the frame \
         with all. Each setting has its pixels and rays of the whole frame's ledger."
    );
    let mut measures = MEASURES.to_vec();
    measures.push(measure("ledger_pixels_percent", "its pixels, %"));
    measures.push(measure("ledger_rays", "its rays"));
    let comparison = Comparison::new(
        ("effects", "What can be left out"),
        "Without an effect the picture changes where the scene asks for it, and its rays and its \
         shading are saved.",
        measures,
        UNSEEN,
        points,
    )
    .with_other_limit(NOT_MISSED)
    .logarithmic();
    let mut section = Section::new("effects", "Effects", about, vec![comparison]);
    section.pictures = pictures;
    Ok(section)
}

/// Returns one wall in front; `size` is in pixels a side.
fn room(size: u32) -> Result<Cave, Cause> {
    let corner = |x: f64, y: f64| DVec3::new(x, y, -1.5);
    let corners = [corner(-1.5, -1.5), corner(1.5, -1.5), corner(-1.5, 1.5)];
    let [left, right, above] = corners;
    let wall = Wall::new("front", left, right, above, [size; 2])?;
    Ok(Cave::new(vec![wall])?)
}

/// Returns the scene with the bench's mesh for its animals, and a picture to hang up.
fn scene(bench: &Bench<'_>) -> Result<Scene, Cause> {
    let folder = tempfile::tempdir()?;
    swatches()?.write_png(&folder.path().join("picture.png"), &[])?;
    let mesh = |source: &MeshSource| -> Result<TriangleMesh, Infallible> {
        Ok(match source {
            MeshSource::BuiltIn(BuiltInMesh::Square) => TriangleMesh::square(),
            MeshSource::BuiltIn(BuiltInMesh::Quadruped) | MeshSource::File(_) => bench.mesh.clone(),
        })
    };
    Ok(Scene::from_toml(
        SCENE,
        "effects.toml",
        folder.path(),
        mesh,
    )?)
}

/// Squares of all hues, darker downwards.
fn swatches() -> Result<Picture, Cause> {
    let mut picture = Picture::new(64, 64)?;
    for y in 0..64 {
        for x in 0..64 {
            let hue = (x / 8) as f32 / 8.0;
            let value = 1.0 - (y / 16) as f32 / 5.0;
            let channel = |shift: f32| {
                let place = (hue + shift).fract() * 6.0;
                value * ((place - 3.0).abs() - 1.0).clamp(0.0, 1.0)
            };
            picture.set_pixel(
                x,
                y,
                [channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0), 1.0],
            );
        }
    }
    Ok(picture)
}
