//! Meshes at several polygon levels, baked and traced.

use shisen::bake::{Baked, lone_mesh};
use shisen::simplify::{Ladder, PolygonLevels, Topology};
use shisen_tests::meshes::meshes;
use std::time::Instant;

#[test]
fn quick() {
    let levels = PolygonLevels::new(500..=u32::MAX, 16).unwrap();
    for (name, mesh) in meshes() {
        println!("{name}: {:?}", Topology::of(&mesh));
        let start = Instant::now();
        let ladder = Ladder::new(&mesh, &levels).unwrap();
        let faces: Vec<u32> = ladder.rungs().iter().map(|r| r.len() as u32).collect();
        println!(
            "{:?} {faces:?} {} deviation {}",
            start.elapsed(),
            ladder.versions().triangles.len(),
            levels.largest_deviation(&faces)
        );
        let scene = lone_mesh(mesh);
        let start = Instant::now();
        let baked = Baked::<8>::with_levels(&scene, &levels).unwrap();
        println!("fast {} {:?}", baked.as_bytes().len(), start.elapsed());
        let start = Instant::now();
        let baked = Baked::<4>::with_levels(&scene, &levels).unwrap();
        println!("compact {} {:?}", baked.as_bytes().len(), start.elapsed());
        let start = Instant::now();
        Baked::<8>::new(&scene).unwrap();
        println!("alone {:?}", start.elapsed());
    }
}
