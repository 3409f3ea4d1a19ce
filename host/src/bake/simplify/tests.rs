use super::*;
use std::f64::consts::TAU;

fn levels(min: u32, max: u32, rungs: u32) -> PolygonLevels {
    PolygonLevels::new(min..=max, rungs).unwrap()
}

/// Returns a closed torus of 2·`around`·`across` triangles, nowhere the same.
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

fn faces(ladder: &Ladder<'_>) -> Vec<u32> {
    ladder.rungs().iter().map(|r| r.len() as u32).collect()
}

#[test]
fn levels_that_there_cannot_be_are_refused() {
    for (faces, rungs, says) in [
        (RangeInclusive::new(6, 5), 16, "6..5 is not a range"),
        (0..=5, 16, "0..5 is not a range"),
        (1..=5, 1, "cannot be 1 polygon levels"),
        (1..=5, 65, "cannot be 65"),
    ] {
        let error = PolygonLevels::new(faces, rungs).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
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
fn a_mesh_without_an_area_is_one_rung() {
    let mut mesh = torus(10, 10);
    let faces = mesh.triangles.len();
    mesh.positions.fill([1.0, 2.0, 3.0]);
    let ladder = Ladder::new(&mesh, &levels(20, u32::MAX, 4));
    assert_eq!(self::faces(&ladder), [200]);
    // Beside such faces, only the others count.
    mesh.positions.extend(torus(10, 10).positions);
    let others = torus(10, 10).triangles.into_iter();
    mesh.triangles.extend(others.map(|t| t.map(|v| v + 100)));
    let ladder = Ladder::new(&mesh, &levels(20, u32::MAX, 4));
    let found = self::faces(&ladder);
    assert_eq!(found[0] as usize, 2 * faces);
    assert!(found[1] == 200 && found[3] == 20, "{found:?}");
}
