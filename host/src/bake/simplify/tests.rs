use super::*;
use crate::scene::material::Material;
use std::f64::consts::TAU;

fn levels(min: u32, max: u32, rungs: u32) -> PolygonLevels {
    PolygonLevels::new(min..=max, rungs).unwrap()
}

/// A closed torus of 2·`around`·`across` triangles, nowhere the same.
fn torus(around: u32, across: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let turn = |k, n| f64::from(k) / f64::from(n) * TAU;
        let (u, v) = (turn(i, around), turn(j, across));
        let r = 3.0 + (1.0 + 0.2 * (3.0 * u).sin()) * v.cos();
        let place = [r * u.cos(), (1.0 + 0.1 * u.cos()) * v.sin(), -r * u.sin()];
        mesh.positions.push(place.map(|c| c as f32));
        let vertex = |i: u32, j: u32| i % around * across + j % across;
        let [a, b] = [vertex(i, j), vertex(i + 1, j)];
        let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// The mesh and its copy, moved so that their vertices `these` are at one
/// place.
fn joined(mesh: &TriangleMesh, these: [u32; 2]) -> TriangleMesh {
    let [here, there] = these.map(|v| mesh.positions[v as usize]);
    let count = mesh.positions.len() as u32;
    let mut both = mesh.clone();
    for place in &mesh.positions {
        // Exact where it matters: `there` becomes `here`.
        let moved = |axis| here[axis] + (place[axis] - there[axis]);
        both.positions.push(std::array::from_fn(moved));
    }
    let copy = mesh.triangles.iter().map(|t| t.map(|v| v + count));
    both.triangles.extend(copy);
    both
}

fn faces(ladder: &Ladder<'_>) -> Vec<u32> {
    ladder.rungs().iter().map(|r| r.len() as u32).collect()
}

/// Whether each rung has the faces that it should, to one collapse.
fn as_asked(found: &[u32], finest: u32, min: u32) -> bool {
    let last = (found.len() - 1) as f64;
    found.iter().enumerate().all(|(rung, &faces)| {
        let share = rung as f64 / last;
        let ideal = f64::from(finest) - share * f64::from(finest - min);
        (f64::from(faces) - ideal).abs() <= 2.0
    })
}

#[test]
fn levels_that_there_cannot_be_are_refused() {
    let new = PolygonLevels::new;
    assert!(new(1..=1, 2).is_ok() && new(500..=u32::MAX, 64).is_ok());
    for (min, max) in [(6, 5), (0, 5)] {
        let faces = RangeInclusive::new(min, max);
        assert_eq!(new(faces, 16), Err(LevelsError::Faces { min, max }));
    }
    for found in [0, 1, 65] {
        assert_eq!(new(1..=5, found), Err(LevelsError::Rungs { found }));
    }
}

#[test]
fn the_largest_deviation_is_half_a_step_or_what_a_rung_misses() {
    let levels = levels(100, 300, 5);
    let even = levels.largest_deviation(&[300, 250, 200, 150, 100]);
    assert!((even - 0.125).abs() < 1e-12, "{even}");
    // A rung that is 10 faces off, of 200.
    let off = levels.largest_deviation(&[300, 250, 210, 150, 100]);
    assert!((off - 0.175).abs() < 1e-12, "{off}");
    // Fewer faces than MAX: all that the mesh has.
    let all = self::levels(100, u32::MAX, 5);
    assert_eq!(all.largest_deviation(&[300, 250, 200, 150, 100]), even);
    assert_eq!(levels.largest_deviation(&[42]), 0.0);
    let one = self::levels(100, 100, 3);
    assert_eq!(one.largest_deviation(&[100, 100, 100]), 0.0);
}

#[test]
fn open_and_crowded_meshes_have_the_faces_asked_for() {
    let mut open = torus(40, 20);
    open.triangles.drain(700..703);
    // A wall inside, along the first ring, from each of its edges to a point.
    let mut crowded = torus(40, 20);
    let centre = crowded.positions.len() as u32;
    crowded.positions.push([3.0, 0.0, 0.0]);
    let wall = (0..20).map(|j| [j, (j + 1) % 20, centre]);
    crowded.triangles.extend(wall);
    let topology = Topology::of(&crowded);
    assert_eq!((topology.open_edges, topology.crowded_edges), (20, 20));
    for (mesh, min, rungs) in [(open, 100, 12), (crowded, 150, 6)] {
        let levels = levels(min, u32::MAX, rungs);
        let ladder = Ladder::new(&mesh, &levels).unwrap();
        let found = faces(&ladder);
        assert_eq!(found.len(), rungs as usize);
        assert!(
            as_asked(&found, mesh.triangles.len() as u32, min),
            "{found:?}"
        );
        let again = Ladder::new(&mesh, &levels).unwrap();
        assert_eq!(ladder.versions(), again.versions());
        assert_eq!(ladder.rungs(), again.rungs());
    }
}

#[test]
fn a_mesh_with_no_more_than_the_fewest_is_one_rung() {
    let mesh = torus(10, 10);
    for min in [200, 201, u32::MAX] {
        let levels = levels(min, u32::MAX, 16);
        assert!(!levels.apply_to(&mesh));
        let ladder = Ladder::new(&mesh, &levels).unwrap();
        assert_eq!(ladder.versions(), &mesh);
        assert_eq!(faces(&ladder), [200]);
    }
}

#[test]
fn a_mesh_without_an_area_is_one_rung() {
    let mut mesh = torus(10, 10);
    let faces = mesh.triangles.len();
    mesh.positions.fill([1.0, 2.0, 3.0]);
    let ladder = Ladder::new(&mesh, &levels(20, u32::MAX, 4)).unwrap();
    assert_eq!(self::faces(&ladder), [200]);
    // Beside such faces, only the others count.
    mesh.positions.extend(torus(10, 10).positions);
    let others = torus(10, 10).triangles.into_iter();
    mesh.triangles.extend(others.map(|t| t.map(|v| v + 100)));
    let ladder = Ladder::new(&mesh, &levels(20, u32::MAX, 4)).unwrap();
    let found = self::faces(&ladder);
    assert_eq!(found[0] as usize, 2 * faces);
    assert!(found[1] == 200 && found[3] == 20, "{found:?}");
}

#[test]
fn parts_that_touch_at_a_vertex_stay_closed() {
    // Twice the same place, once with a vertex for each part and once with
    // one for both.
    let apart = joined(&torus(20, 10), [0, 105]);
    let mut shared = apart.clone();
    let there = 200 + 105;
    for corner in shared.triangles.iter_mut().flatten() {
        if *corner == there {
            *corner = 0;
        }
    }
    for mesh in [apart, shared] {
        let expected = Topology {
            open_edges: 0,
            crowded_edges: 0,
            pinched_vertices: 1,
        };
        assert_eq!(Topology::of(&mesh), expected);
        let ladder = Ladder::new(&mesh, &levels(80, u32::MAX, 8)).unwrap();
        let found = faces(&ladder);
        assert!(as_asked(&found, 800, 80), "{found:?}");
        let rungs = ladder.rungs().iter();
        let mut meshes = rungs.map(|rung| ladder.versions().part(rung));
        assert!(meshes.all(|mesh| Topology::of(&mesh).is_closed()));
    }
}

#[test]
fn the_fewest_that_there_can_be_are_said_and_can_be_had() {
    let fewest = |mesh: &TriangleMesh, asked, rungs| {
        let ladder = Ladder::new(mesh, &levels(asked, u32::MAX, rungs));
        match ladder.map(|ladder| faces(&ladder)) {
            Err(LadderError::Unreachable {
                asked: said,
                reached,
            }) if said == asked => reached,
            other => panic!("{asked} faces: {other:?}"),
        }
    };
    // Where all faces have materials of their own, no edge can go.
    let mut mesh = torus(4, 3);
    mesh.materials = vec![Material::default(); 24];
    mesh.triangle_materials = (0..24).collect();
    assert_eq!(fewest(&mesh, 3, 2), 24);
    // Six patches, whose corners stay.
    let mut mesh = torus(30, 10);
    mesh.materials = vec![Material::default(); 6];
    mesh.triangle_materials = (0..600).map(|t| t / 200 * 2 + t / 2 % 10 / 5).collect();
    let reached = fewest(&mesh, 2, 4);
    assert!((12..100).contains(&reached), "{reached}");
    let ladder = Ladder::new(&mesh, &levels(reached, u32::MAX, 4)).unwrap();
    assert!(as_asked(&faces(&ladder), 600, reached));
}

#[test]
fn normals_are_those_of_the_full_mesh() {
    let mesh = torus(40, 20);
    let full = mesh.vertex_normals();
    let ladder = Ladder::new(&mesh, &levels(100, u32::MAX, 6)).unwrap();
    assert_eq!(ladder.versions().normals[..], full[..]);
    assert_eq!(ladder.versions().positions, mesh.positions);
    // Where even the finest rung is simplified, its vertices keep theirs.
    let ladder = Ladder::new(&mesh, &levels(100, 800, 6)).unwrap();
    let versions = ladder.versions();
    assert!(versions.positions.len() < mesh.positions.len());
    for (place, normal) in versions.positions.iter().zip(&versions.normals) {
        let original = mesh.positions.iter().position(|p| p == place).unwrap();
        assert_eq!(*normal, full[original]);
    }
}

#[test]
fn each_rung_is_handed_on_as_it_stays() {
    let shape = |mesh: &TriangleMesh, rung: &[u32]| -> Vec<[[f32; 3]; 3]> {
        let corners = rung
            .iter()
            .map(|&triangle| mesh.triangles[triangle as usize]);
        corners
            .map(|three| three.map(|one| mesh.positions[one as usize]))
            .collect()
    };
    // The second has too few faces for a ladder.
    for (mesh, levels) in [
        (torus(40, 20), levels(100, 1400, 8)),
        (torus(8, 4), levels(500, 1400, 3)),
    ] {
        let mut handed_on = Vec::new();
        let each = |versions: &TriangleMesh, rung: &[u32]| handed_on.push(shape(versions, rung));
        let ladder = Ladder::with_each(&mesh, &levels, each).unwrap();
        let rungs = ladder.rungs().iter();
        let stay: Vec<_> = rungs.map(|rung| shape(ladder.versions(), rung)).collect();
        assert_eq!(handed_on, stay);
    }
}
