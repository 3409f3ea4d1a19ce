//! Ladders of polygon levels: what every rung keeps to.

use proptest::prelude::*;
use shisen::bake::simplify::{Ladder, PolygonLevels, Topology};
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen_core::frame::FACE_TOLERANCE;
use shisen_tests::meshes::{faceted, gridded_cube, icosphere, meshes, torus};
use std::collections::HashSet;

fn levels(min: u32, max: u32, rungs: u32) -> PolygonLevels {
    PolygonLevels::new(min..=max, rungs).expect("levels that there can be")
}

/// Returns one rung as a mesh.
fn rung(ladder: &Ladder<'_>, number: usize) -> TriangleMesh {
    let mut mesh = ladder.versions().clone();
    let pick = |&triangle: &u32| mesh.triangles[triangle as usize];
    mesh.triangles = ladder.rungs()[number].iter().map(pick).collect();
    mesh.triangle_materials.clear();
    mesh
}

/// Checks what every ladder keeps to; returns the faces of its rungs.
fn check_any(mesh: &TriangleMesh, (min, max, rungs): (u32, u32, u32)) -> Vec<u32> {
    let asked = levels(min, max, rungs);
    let ladder = Ladder::new(mesh, &asked);
    let versions = ladder.versions();
    versions.validate().expect("a mesh");
    let faces: Vec<u32> = ladder.rungs().iter().map(|r| r.len() as u32).collect();
    let all = mesh.triangles.len() as u32;
    if all <= min {
        assert_eq!(faces, [all]);
        return faces;
    }
    assert_eq!(faces.len(), rungs as usize);
    assert!(faces.is_sorted_by(|a, b| a >= b), "{faces:?}");

    let closed = Topology::of(mesh).is_closed();
    let mut used = vec![false; versions.triangles.len()];
    for (number, triangles) in ladder.rungs().iter().enumerate() {
        assert!(triangles.is_sorted_by(|a, b| a < b), "rung {number}");
        for &triangle in triangles {
            used[triangle as usize] = true;
        }
        let topology = Topology::of(&rung(&ladder, number));
        let kept = topology.is_closed() || !closed;
        assert!(kept, "rung {number}: {topology:?}");
    }
    assert!(used.iter().all(|&used| used), "a version that no rung has");
    if max >= all {
        assert!(versions.triangles.starts_with(&mesh.triangles));
        assert_eq!(versions.positions, mesh.positions);
    }
    // Where it is stuck, it stays.
    let finest = f64::from(faces[0]);
    let ideal = |rung: usize| {
        let share = rung as f64 / f64::from(rungs - 1);
        finest - share * (finest - f64::from(min)).max(0.0)
    };
    let is_off = |rung: usize| f64::from(faces[rung]) > ideal(rung) + 2.0;
    if let Some(stuck) = (1..faces.len()).find(|&rung| is_off(rung)) {
        let rest = &ladder.rungs()[stuck..];
        assert!(rest.iter().all(|rung| *rung == rest[0]), "{faces:?}");
    }
    faces
}

/// Checks also that a mesh with room to simplify gets what was asked for.
fn check(mesh: &TriangleMesh, asked: (u32, u32, u32)) -> Vec<u32> {
    let faces = check_any(mesh, asked);
    let (min, max, rungs) = asked;
    let finest = max.min(mesh.triangles.len() as u32);
    for (number, &found) in faces.iter().enumerate() {
        let share = number as f64 / f64::from(rungs - 1);
        let ideal = f64::from(finest) - share * f64::from(finest - min);
        let off = (f64::from(found) - ideal).abs();
        assert!(off <= 2.0, "rung {number} should have {ideal}: {faces:?}");
    }
    let nearest = 0.5 / f64::from(rungs - 1);
    let most = nearest.max(FACE_TOLERANCE.into()) + 3.0 / f64::from(finest - min).max(1.0);
    let deviation = levels(min, max, rungs).largest_deviation(&faces);
    assert!((0.0..=most).contains(&deviation), "{deviation}: {faces:?}");
    faces
}

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn closed_meshes_stay_closed_on_every_rung() {
    for (name, mesh) in meshes() {
        for asked in [(500, u32::MAX, 16), (501, 3001, 7), (40, u32::MAX, 64)] {
            println!("{name} {asked:?}: {:?}", check(&mesh, asked));
        }
    }
    check(&icosphere(3), (4, 1280, 64));
    check(&torus(40, 20), (50, 1600, 20));
    check(&torus(40, 20), (1600, 5000, 20));
}

#[test]
fn seams_between_normals_do_not_crack() {
    for mesh in [
        torus(40, 20),
        gridded_cube(8),
        shisen::scene::quadruped::quadruped(),
    ] {
        let faces = mesh.triangles.len() as u32;
        let facets = faceted(&mesh);
        assert!(Topology::of(&facets).is_closed());
        check(&facets, (faces / 8, faces, 9));
    }
    // A cube's faces stay flat, so the normals must be those of its sides.
    let facets = faceted(&gridded_cube(6));
    let ladder = Ladder::new(&facets, &levels(60, 432, 8));
    let versions = ladder.versions();
    for triangle in &versions.triangles {
        let [a, b, c] = triangle.map(|v| glam::Vec3::from(versions.positions[v as usize]));
        let normal = (b - a).cross(c - a).normalize();
        for vertex in triangle {
            let own = glam::Vec3::from(versions.normals[*vertex as usize]);
            assert!(own.dot(normal) > 0.999, "{own} on a face along {normal}");
        }
    }
}

/// Every triangle's vertices are ones that triangles of the same material had.
fn check_materials(mesh: &TriangleMesh, asked: (u32, u32, u32)) {
    check(mesh, asked);
    let (min, max, rungs) = asked;
    let ladder = Ladder::new(mesh, &levels(min, max, rungs));
    let of = |mesh: &TriangleMesh| -> HashSet<(u32, [u32; 3])> {
        let materials = mesh.triangles.iter().zip(&mesh.triangle_materials);
        materials
            .flat_map(|(corners, &material)| {
                corners.map(|v| (material, mesh.positions[v as usize].map(f32::to_bits)))
            })
            .collect()
    };
    let (before, after) = (of(mesh), of(ladder.versions()));
    assert!(after.is_subset(&before));
    let coarsest = ladder.rungs().last().expect("a rung");
    let left: HashSet<u32> = coarsest
        .iter()
        .map(|&t| ladder.versions().triangle_materials[t as usize])
        .collect();
    let all: HashSet<u32> = mesh.triangle_materials.iter().copied().collect();
    assert_eq!(left, all, "materials of the coarsest rung");
}

#[test]
fn triangles_keep_their_materials() {
    let with_materials = |mut mesh: TriangleMesh, count: u32, of: &dyn Fn(usize) -> u32| {
        mesh.materials = vec![Material::default(); count as usize];
        mesh.triangle_materials = (0..mesh.triangles.len()).map(of).collect();
        mesh
    };
    // Above and below the middle.
    let halves = with_materials(torus(60, 20), 2, &|t| u32::from(t / 2 % 20 < 10));
    check_materials(&halves, (200, 2400, 12));
    // Its sides: three of them meet at each corner.
    let sides = with_materials(gridded_cube(8), 6, &|t| t as u32 / 128);
    check_materials(&sides, (50, 768, 9));
    let facets = faceted(&sides);
    let facets = with_materials(facets, 6, &|t| t as u32 / 128);
    check_materials(&facets, (50, 768, 9));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_mesh_has_a_ladder(
        around in 3..20u32,
        across in 3..12u32,
        left_out in proptest::collection::vec(any::<prop::sample::Index>(), 0..6),
        moved in proptest::collection::vec((any::<prop::sample::Index>(), -2.0f32..2.0), 0..40),
        merged in proptest::collection::vec(any::<[prop::sample::Index; 2]>(), 0..4),
        facets: bool,
        materials in 0..4u32,
        min in 1..400u32,
        more in 0..600u32,
        rungs in 2..20u32,
    ) {
        let mut mesh = torus(around, across);
        for index in left_out {
            mesh.triangles.swap_remove(index.index(mesh.triangles.len()));
        }
        let count = mesh.positions.len();
        for (index, by) in moved {
            mesh.positions[index.index(count)][1] += by;
        }
        for [from, to] in merged {
            mesh.positions[from.index(count)] = mesh.positions[to.index(count)];
        }
        if facets {
            let has_area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| glam::Vec3::from(mesh.positions[v as usize]));
                (b - a).cross(c - a).try_normalize().is_some()
            };
            mesh.triangles = mesh.triangles.iter().copied().filter(has_area).collect();
            mesh = faceted(&mesh);
        }
        if materials > 0 {
            mesh.materials = vec![Material::default(); materials as usize];
            mesh.triangle_materials =
                (0..mesh.triangles.len() as u32).map(|t| t / 7 % materials).collect();
        }
        check_any(&mesh, (min, min + more, rungs));
    }
}
