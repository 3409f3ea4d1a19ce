//! Scenes, rooms and pictures as small as a test needs them.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::AnyScene;
use shisen::bake::simplify::PolygonLevels;
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::render::{self, Frame, Observer, Options};
use shisen::scene::camera::CameraPath;
use shisen::scene::motion::Motion;
use shisen::scene::{Background, Object, Scene, Shape};
use shisen_core::frame::{
    Budget, LevelOfDetail, Outcome, Pixel, Renderer, Tile, TileJob, View, Workspace,
};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_core::{Runs, Simd};

/// Returns a scene without objects and lights, in light of 1 from everywhere, on black.
pub fn empty() -> Scene {
    Scene {
        name: "test".into(),
        meshes: Vec::new(),
        materials: Vec::new(),
        objects: Vec::new(),
        lights: Vec::new(),
        background: Background::uniform([0.0; 3]),
        ambient: [1.0; 3],
        environment: None,
        camera: CameraPath::default(),
        motion: Motion::default(),
    }
}

/// Returns a faceted object of the scene's material of this number.
pub fn object(shape: Shape, material: usize, world_from_object: DAffine3) -> Object {
    Object {
        shape,
        material: Some(material),
        world_from_object,
        casts_shadow: true,
        smooth: false,
    }
}

/// Returns a sphere of the scene's material of this number.
pub fn sphere(radius: f32, material: usize, centre: impl Into<DVec3>) -> Object {
    let place = DAffine3::from_translation(centre.into());
    object(Shape::Sphere { radius }, material, place)
}

/// Returns front, right and floor, with `side` pixels a side.
pub fn three_walls(side: u32) -> Cave {
    Cave::built_in(BuiltInCave::ThreeWall, [side; 2]).expect("a room")
}

/// Returns both eyes of one in the middle of a room.
pub fn both_eyes() -> [Observer; 2] {
    Eye::STEREO.map(|eye| Observer::new(eye, Viewer::default().eye(eye)))
}

/// Returns the paper's levels of detail along a line of sight from a place.
pub fn lod(place: Vec3, forward: Vec3, up: Vec3) -> LevelOfDetail {
    let sight = LineOfSight::new(place, forward, up).expect("a line of sight");
    LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER))
}

/// Returns all faces to the fewest, in `rungs` steps.
pub fn levels(rungs: u32) -> PolygonLevels {
    PolygonLevels::new(PolygonLevels::FEWEST_FACES..=u32::MAX, rungs).expect("levels")
}

/// Renders what observers see in a room.
pub fn frame(scene: AnyScene<'_>, room: &Cave, eyes: &[Observer], options: &Options) -> Frame {
    render::cave(scene, room, eyes, options, &|_, _| {}).expect("a frame")
}

/// Returns a tile of a view.
pub const fn tile([x, y, width, height]: [u32; 4]) -> Tile {
    Tile {
        x,
        y,
        width,
        height,
    }
}

/// Renders a view, which must be finished.
pub fn pixels<const W: usize>(renderer: &Renderer<'_, W>, view: &View) -> Vec<Pixel>
where
    Simd: Runs<W>,
{
    pixels_with(renderer, view, &mut Workspace::new())
}

/// Returns the same, with a workspace.
pub fn pixels_with<const W: usize>(
    renderer: &Renderer<'_, W>,
    view: &View,
    workspace: &mut Workspace,
) -> Vec<Pixel>
where
    Simd: Runs<W>,
{
    let (width, height) = (view.columns(), view.rows());
    let mut pixels = vec![Pixel::default(); (width * height) as usize];
    let mut job = TileJob::new(tile([0, 0, width, height]));
    let mut budget = Budget::UNLIMITED;
    let outcome = job.render(renderer, view, &mut pixels, &mut budget, workspace);
    assert_eq!(outcome, Ok(Outcome::Finished));
    pixels
}

/// Returns the bits of pixels.
pub fn bits(pixels: &[Pixel]) -> Vec<[u32; 4]> {
    let bits = |p: &Pixel| [p.red, p.green, p.blue, p.alpha].map(f32::to_bits);
    pixels.iter().map(bits).collect()
}
