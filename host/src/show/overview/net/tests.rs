use super::super::walls::cube;
use super::*;

fn painted(wall: &Wall, side: u32) -> Picture {
    let mut picture = Picture::new(side, side).unwrap();
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let [along, down] = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(side));
        let point = wall.lower_left
            + along * (wall.lower_right - wall.lower_left)
            + (1.0 - down) * (wall.upper_left - wall.lower_left);
        let [r, g, b] = (0.5 + 0.3 * point).as_vec3().to_array();
        picture.set_pixel(x, y, [r, g, b, 1.0]);
    }
    picture
}

fn wall(name: &str, corners: [[f64; 3]; 3]) -> Wall {
    let [lower_left, lower_right, upper_left] = corners.map(DVec3::from);
    Wall::new(name, lower_left, lower_right, upper_left, [1; 2]).unwrap()
}

fn unfolded(walls: &[Wall], side: u32) -> (Picture, Vec<Picture>) {
    let pictures: Vec<_> = walls.iter().map(|wall| painted(wall, side)).collect();
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
fn what_cannot_be_unfolded_is_refused() {
    assert!(matches!(unfold::<&Wall>(&[]), Err(ShowError::NoWalls)));
    let walls = cube(["front", "left"]);
    let (picture, empty) = (painted(&walls[0], 4), Picture::new(0, 4).unwrap());
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
