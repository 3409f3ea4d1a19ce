use super::super::walls::{cube, painted, wall};
use super::*;

fn colour(point: DVec3) -> [f32; 4] {
    let [x, y, z] = (0.5 + 0.3 * point).to_array().map(|value| value as f32);
    [x, y, z, 1.0]
}

fn unfolded(walls: &[Wall], side: u32) -> (Picture, Vec<Picture>) {
    let pictures: Vec<_> = walls
        .iter()
        .map(|wall| painted(wall, [side; 2], colour))
        .collect();
    let pairs: Vec<_> = walls.iter().zip(&pictures).collect();
    (unfold(&pairs).unwrap(), pictures)
}

fn cells(net: &Picture, side: u32) -> Vec<String> {
    let count = |pixels: u32| (pixels - 2 * MARGIN as u32) / side;
    let cell = |column: u32, row: u32| {
        let x = MARGIN as u32 + column * side + side / 2;
        let y = MARGIN as u32 + row * side + side * 7 / 8;
        let is_wall = net.pixel(x, y) != Some(BACKGROUND);
        if is_wall { '#' } else { '.' }
    };
    (0..count(net.height))
        .map(|row| {
            (0..count(net.width))
                .map(|column| cell(column, row))
                .collect()
        })
        .collect()
}

#[test]
fn other_resolutions_are_resampled_to_the_first_walls() {
    let walls = cube(["front", "right", "floor", "left"]);
    let sizes = [[64, 64], [200, 160], [32, 48], [96, 64]];
    let sized = walls.iter().zip(sizes);
    let painted = sized.map(|(wall, size)| painted(wall, size, colour));
    let pictures: Vec<_> = painted.collect();
    let pairs: Vec<_> = walls.iter().zip(&pictures).collect();
    let net = unfold(&pairs).unwrap();
    assert_eq!(cells(&net, 64), ["###", ".#."]);
    // Linear colours are interpolated exactly away from the coarsest picture's edges.
    let margin = MARGIN as u32;
    for (x, y, point) in [
        (128 + 40, 40, DVec3::new(1.0, -0.265_625, 0.265_625)),
        (64 + 40, 64 + 40, DVec3::new(0.265_625, -1.0, 0.265_625)),
        (40, 40, DVec3::new(-1.0, -0.265_625, -0.265_625)),
    ] {
        let found = net.pixel(margin + x, margin + y).unwrap();
        for (found, expected) in found.iter().zip(colour(point)) {
            assert!(
                (found - expected).abs() < 1e-6,
                "{x} {y}: {found} {expected}"
            );
        }
    }
}

#[test]
fn walls_that_do_not_fit_together_lie_apart_or_where_they_touch() {
    // A wall on the upper half of the front wall's edge hangs there.
    let hung = wall("right", [[1., 0., -1.], [1., 0., 1.], [1., 1., -1.]]);
    let (net, _) = unfolded(&[&cube(["front", "floor"])[..], &[hung]].concat(), 8);
    assert_eq!(cells(&net, 4), ["####", "##..", "##..", "##.."]);
    // A floor below the walls touches none.
    let mut walls = cube(["front", "floor"]);
    let floor = &mut walls[1];
    floor.name = "W".repeat(1_000);
    for corner in [
        &mut floor.lower_left,
        &mut floor.lower_right,
        &mut floor.upper_left,
    ] {
        corner.y -= 0.5;
    }
    let (net, pictures) = unfolded(&walls, 64);
    assert_eq!([net.width, net.height], [2 * 64 + 3 * 16, 64 + 32]);
    assert_eq!(net.pixel(16 + 64 + 16, 40), pictures[1].pixel(0, 24));
    assert_eq!(net.pixel(16 + 64, 40), Some(BORDER));
    assert_eq!(net.pixel(16 + 66, 40), Some(BACKGROUND));
    let mut margin = (0..net.height).map(|y| net.pixel(net.width - 8, y));
    assert!(margin.all(|pixel| pixel == Some(BACKGROUND)), "a long name");
    // Two walls on one edge: only one can lie there.
    let mut walls = cube(["front", "right", "right"]);
    walls[2].lower_right = DVec3::new(2.0, -1.0, 0.0);
    let (net, _) = unfolded(&walls, 64);
    assert!(net.height == 64 + 32 && net.width > 3 * 64 + 3 * 16 - 20);
}

#[test]
fn oblique_and_tilted_walls_keep_their_shape() {
    // A parallelogram that rises along its lower edge.
    let front = wall("front", [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
    let skewed = wall("side", [[1., 0., 0.], [1., 0.5, 1.], [1., 1., 0.]]);
    let (net, _) = unfolded(&[front, skewed], 64);
    // As high as the front and half of it.
    assert_eq!([net.width, net.height], [128 + 32, 96 + 32]);
    for x in 60..70 {
        let found = net.pixel(16 + x, 16 + 32 + 40).unwrap();
        let across = (f64::from(x) + 0.5) / 64.0;
        let (right, back) = (across.min(1.0), (across - 1.0).max(0.0));
        let expected = colour(DVec3::new(right, 1.0 - 40.5 / 64.0, back));
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 0.005, "{x}: {found} {expected}");
        }
    }
    // A screen over the front wall that leans towards the viewer by 45°.
    let front = wall("front", [[-1., 0., 0.], [1., 0., 0.], [-1., 2., 0.]]);
    let leaning = wall("leaning", [[-1., 2., 0.], [1., 2., 0.], [-1., 3., 1.]]);
    let (net, _) = unfolded(&[front, leaning], 50);
    let height = (2.0_f64.sqrt() / 2.0 * 50.0).ceil() as u32;
    assert_eq!([net.width, net.height], [50 + 32, 50 + height + 32]);
}

#[test]
fn what_cannot_be_unfolded_is_refused() {
    assert!(matches!(unfold::<&Wall>(&[]), Err(ShowError::NoWalls)));
    let walls = cube(["front", "left"]);
    let (picture, empty) = (
        painted(&walls[0], [4; 2], colour),
        Picture::new(0, 4).unwrap(),
    );
    let error = unfold(&[(&walls[0], &picture), (&walls[1], &empty)]).unwrap_err();
    assert!(error.to_string().contains("\"left\""), "{error}");
    let mut flat = walls[0].clone();
    flat.lower_right = flat.lower_left;
    let error = unfold(&[(&flat, &picture)]).unwrap_err();
    assert!(matches!(error, ShowError::Wall(_)), "{error}");
    let far = wall("far", [[0.; 3], [1e6, 0., 0.], [0., 1e6, 0.]]);
    let error = unfold(&[(&walls[0], &picture), (&far, &picture)]).unwrap_err();
    assert!(matches!(error, ShowError::Picture(_)), "{error}");
}
