//! What of a level of detail is asked for, and how many rays it has.

use super::{GAZES, eyes, frame, level, levels, lod, mixed_scene, places, samples, views};
use shisen::bake::Baked;
use shisen::render::Frame;
use shisen_core::frame::LevelOfDetail;
use shisen_core::scene::Scene as CoreScene;

/// The paper's rays, with less or nothing taken off them.
fn assert_traced_in_full(what: &str, lod: LevelOfDetail, found: &Frame, expected: &Frame) {
    let size = [47, 43];
    let mut traced = 0;
    for (number, (view, _)) in views(size, &eyes(Some(lod))).iter().enumerate() {
        for at in places(view) {
            let of = |frame: &Frame| frame.pictures[number].picture.pixel(at.0, at.1);
            if level(&lod, view, at) > 0.0 {
                traced += 1;
                assert_eq!(of(found), of(expected), "{what}, picture {number}, {at:?}");
            }
        }
    }
    assert!(traced > 1000, "{what}: {traced}");
}

#[test]
fn what_is_not_asked_for_is_not_taken_off() {
    let (size, options) = ([47, 43], samples(1));
    let scene = mixed_scene(shisen::scene::quadruped::quadruped());
    let plain = Baked::<8>::new(&scene).expect("a scene");
    let ladder = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
    let (plain, ladder) = (plain.scene(), ladder.scene());
    let render = |scene: &CoreScene<'_, 8>, lod| frame(scene, size, &eyes(lod), &options);
    let full = render(&plain, None);
    for gaze in GAZES {
        let of = |bounces, faces| LevelOfDetail {
            bounces,
            faces,
            ..lod(gaze)
        };
        // Neither bounces nor faces: the field alone is cut.
        let cut = of(false, false);
        let found = render(&ladder, Some(cut));
        assert_traced_in_full("cut", cut, &found, &full);
        // Without a ladder, faces can be asked for in vain.
        let faces = of(false, true);
        let found = render(&plain, Some(faces));
        assert_traced_in_full("faces, no ladder", faces, &found, &full);
        // And bounces alone are the same with and without a ladder.
        let bounces = of(true, false);
        let found = render(&ladder, Some(bounces));
        assert_eq!(found.hash(), render(&plain, Some(bounces)).hash());
        // Each of the two does something.
        let hashes = [
            found.hash(),
            render(&ladder, Some(cut)).hash(),
            render(&ladder, Some(faces)).hash(),
            render(&ladder, Some(lod(gaze))).hash(),
        ];
        for (number, hash) in hashes.iter().enumerate() {
            assert!(!hashes[..number].contains(hash), "{gaze:?}: {hashes:?}");
        }
    }
}
