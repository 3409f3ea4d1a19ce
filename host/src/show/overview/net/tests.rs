use super::*;

fn wall(name: &str, lower_left: [f64; 3], lower_right: [f64; 3], upper_left: [f64; 3]) -> Wall {
    Wall {
        name: name.to_owned(),
        lower_left: lower_left.into(),
        lower_right: lower_right.into(),
        upper_left: upper_left.into(),
        pixels: [0, 0],
    }
}

/// The named walls of the cube from −1 to 1, as seen from inside.
fn cube(names: &[&str]) -> Vec<Wall> {
    let walls = [
        wall("front", [-1., -1., -1.], [1., -1., -1.], [-1., 1., -1.]),
        wall("left", [-1., -1., 1.], [-1., -1., -1.], [-1., 1., 1.]),
        wall("right", [1., -1., -1.], [1., -1., 1.], [1., 1., -1.]),
        wall("back", [1., -1., 1.], [-1., -1., 1.], [1., 1., 1.]),
        wall("floor", [-1., -1., 1.], [1., -1., 1.], [-1., -1., -1.]),
        wall("ceiling", [-1., 1., -1.], [1., 1., -1.], [-1., 1., 1.]),
    ];
    let named = |name: &&str| walls.iter().find(|wall| wall.name == *name).cloned();
    names.iter().filter_map(named).collect()
}

/// Every pixel another colour, for each wall.
fn pattern(wall: usize, width: u32, height: u32) -> Picture {
    let mut picture = Picture::new(width, height).unwrap();
    for y in 0..height {
        for x in 0..width {
            let value = [x, y, wall as u32].map(|channel| channel as f32 / 7.0);
            picture.set_pixel(x, y, [value[0], value[1], value[2], 0.5]);
        }
    }
    picture
}

/// The colour of a point of the room.
fn colour_of(point: DVec3) -> [f32; 4] {
    let [x, y, z] = (0.5 + 0.3 * point).to_array().map(|value| value as f32);
    [x, y, z, 1.0]
}

/// A picture of `colour_of` on the wall.
fn painted(wall: &Wall, width: u32, height: u32) -> Picture {
    let mut picture = Picture::new(width, height).unwrap();
    for y in 0..height {
        for x in 0..width {
            let along = (f64::from(x) + 0.5) / f64::from(width);
            let up = 1.0 - (f64::from(y) + 0.5) / f64::from(height);
            let point = wall.lower_left
                + along * (wall.lower_right - wall.lower_left)
                + up * (wall.upper_left - wall.lower_left);
            picture.set_pixel(x, y, colour_of(point));
        }
    }
    picture
}

fn unfolded(walls: &[Wall], pictures: &[Picture]) -> Picture {
    let pairs: Vec<_> = walls.iter().zip(pictures).collect();
    unfold(&pairs).unwrap()
}

/// The net's cells of `side` pixels that are walls, as `#`.
fn cells(net: &Picture, side: u32) -> Vec<String> {
    let margin = MARGIN as u32;
    (0..(net.height - 2 * margin) / side)
        .map(|row| {
            (0..(net.width - 2 * margin) / side)
                .map(|column| {
                    let x = margin + column * side + side / 2;
                    let y = margin + row * side + side * 7 / 8;
                    let is_wall = net.pixel(x, y) != Some(BACKGROUND);
                    if is_wall { '#' } else { '.' }
                })
                .collect()
        })
        .collect()
}

/// Checks that `picture`, turned to the right by `quarters`, is in the net at
/// the cell, bit for bit but for the label at its upper left.
fn assert_copied(net: &Picture, picture: &Picture, cell: [u32; 2], quarters: u32) {
    let side = picture.width;
    let margin = MARGIN as u32;
    for y in 0..side {
        for x in 0..side {
            if x < side - 1 && y < 14 {
                continue;
            }
            let (from_x, from_y) = match quarters {
                0 => (x, y),
                1 => (y, side - 1 - x),
                2 => (side - 1 - x, side - 1 - y),
                _ => (side - 1 - y, x),
            };
            let found = net.pixel(margin + cell[0] * side + x, margin + cell[1] * side + y);
            let expected = picture.pixel(from_x, from_y);
            assert_eq!(found, expected, "{cell:?} {x} {y}");
        }
    }
}

#[test]
fn three_walls_make_an_l_copied_bit_for_bit() {
    // "front" is upright wherever it stands in the list.
    let walls = cube(&["floor", "right", "front"]);
    let pictures: Vec<_> = (0..3).map(|index| pattern(index, 64, 64)).collect();
    let net = unfolded(&walls, &pictures);
    assert_eq!([net.width, net.height], [128 + 32, 128 + 32]);
    assert_eq!(cells(&net, 64), ["##", "#."]);
    assert_copied(&net, &pictures[2], [0, 0], 0);
    assert_copied(&net, &pictures[1], [1, 0], 0);
    assert_copied(&net, &pictures[0], [0, 1], 0);
}

#[test]
fn cube_makes_a_cross() {
    let walls = cube(&["front", "left", "right", "back", "floor", "ceiling"]);
    let pictures: Vec<_> = (0..6).map(|index| pattern(index, 64, 64)).collect();
    let net = unfolded(&walls, &pictures);
    assert_eq!(cells(&net, 64), ["..#.", "####", "..#."]);
    // Around the viewer: back, left, front, right.
    assert_copied(&net, &pictures[3], [0, 1], 0);
    assert_copied(&net, &pictures[1], [1, 1], 0);
    assert_copied(&net, &pictures[0], [2, 1], 0);
    assert_copied(&net, &pictures[2], [3, 1], 0);
    assert_copied(&net, &pictures[5], [2, 0], 0);
    assert_copied(&net, &pictures[4], [2, 2], 0);
}

#[test]
fn walls_are_turned_by_quarters_to_continue_the_picture() {
    // Without the front wall the floor hangs on the side walls, a quarter
    // turned: below the right wall, the room's front is to its left.
    let walls = cube(&["right", "floor"]);
    let pictures: Vec<_> = (0..2).map(|index| pattern(index, 64, 64)).collect();
    let net = unfolded(&walls, &pictures);
    assert_eq!(cells(&net, 64), ["#", "#"]);
    assert_copied(&net, &pictures[0], [0, 0], 0);
    assert_copied(&net, &pictures[1], [0, 1], 3);

    let walls = cube(&["left", "floor"]);
    let net = unfolded(&walls, &pictures);
    assert_copied(&net, &pictures[1], [0, 1], 1);

    let walls = cube(&["back", "floor"]);
    let net = unfolded(&walls, &pictures);
    assert_copied(&net, &pictures[1], [0, 1], 2);
}

#[test]
fn colours_go_on_across_every_seam() {
    let names = ["front", "left", "right", "back", "floor", "ceiling"];
    for first in names {
        let mut order = names.to_vec();
        order.sort_by_key(|name| *name != first);
        let mut walls = cube(&order);
        // No wall is "front", so that the first lies upright.
        for wall in &mut walls {
            wall.name.clear();
        }
        let pictures: Vec<_> = walls.iter().map(|wall| painted(wall, 64, 64)).collect();
        let net = unfolded(&walls, &pictures);
        let count = cells(&net, 64).concat().matches('#').count();
        assert_eq!(count, 6, "{first}");
        // Colours of neighbouring pixels differ by a pixel's step on a wall
        // and across a shared edge; walls that only touch may differ more.
        let step = 0.3 * 2.0 / 64.0 * 1.01;
        let mut jumps = 0;
        for y in 0..net.height {
            for x in 1..net.width {
                let [a, b] = [net.pixel(x - 1, y).unwrap(), net.pixel(x, y).unwrap()];
                if [a, b]
                    .iter()
                    .any(|pixel| *pixel == BACKGROUND || *pixel == BORDER)
                {
                    continue;
                }
                let apart = (0..3).any(|channel| (a[channel] - b[channel]).abs() > step);
                jumps += u32::from(apart);
            }
        }
        assert_eq!(jumps, 0, "{first}");
    }
}

#[test]
fn other_resolutions_are_resampled_to_the_first_walls() {
    let walls = cube(&["front", "right", "floor", "left"]);
    let sizes = [(64, 64), (200, 160), (32, 48), (96, 64)];
    let pictures: Vec<_> = walls
        .iter()
        .zip(sizes)
        .map(|(wall, (width, height))| painted(wall, width, height))
        .collect();
    let net = unfolded(&walls, &pictures);
    assert_eq!([net.width, net.height], [192 + 32, 128 + 32]);
    assert_eq!(cells(&net, 64), ["###", ".#."]);
    // Linear colours are interpolated exactly, but within half a pixel of the
    // coarsest picture's edges.
    let margin = MARGIN as u32;
    for (x, y, point) in [
        (128 + 40, 40, DVec3::new(1.0, -0.265_625, 0.265_625)),
        (64 + 40, 64 + 40, DVec3::new(0.265_625, -1.0, 0.265_625)),
        (40, 40, DVec3::new(-1.0, -0.265_625, -0.265_625)),
    ] {
        let found = net.pixel(margin + x, margin + y).unwrap();
        for (found, expected) in found.iter().zip(colour_of(point)) {
            assert!(
                (found - expected).abs() < 1e-6,
                "{x} {y}: {found} {expected}"
            );
        }
    }
}

#[test]
fn a_wall_that_touches_a_part_of_the_front_hangs_there_upright() {
    let mut walls = cube(&["front", "floor"]);
    // Half as high as the front wall, from its middle up, with a whole edge on no other.
    walls.push(wall("right", [1., 0., -1.], [1., 0., 1.], [1., 1., -1.]));
    let pictures = [pattern(0, 8, 8), pattern(1, 8, 8), pattern(2, 8, 4)];
    let net = unfolded(&walls, &pictures);
    assert_eq!(cells(&net, 4), ["####", "##..", "##..", "##.."]);
    for (x, y) in [(0, 0), (7, 3)] {
        let there = net.pixel(MARGIN as u32 + 8 + x, MARGIN as u32 + y);
        assert_eq!(there, pictures[2].pixel(x, y), "{x}, {y}");
    }
}

#[test]
fn walls_without_a_shared_edge_lie_apart() {
    let mut walls = cube(&["front", "floor"]);
    let floor = &mut walls[1];
    floor.lower_left.y -= 0.5;
    floor.lower_right.y -= 0.5;
    floor.upper_left.y -= 0.5;
    let pictures: Vec<_> = (0..2).map(|index| pattern(index, 64, 64)).collect();
    let net = unfolded(&walls, &pictures);
    assert_eq!([net.width, net.height], [2 * 64 + 3 * 16, 64 + 32]);
    assert_eq!(net.pixel(16 + 63, 40), pictures[0].pixel(63, 24));
    assert_eq!(net.pixel(16 + 64, 40), Some(BORDER));
    assert_eq!(net.pixel(16 + 66, 40), Some(BACKGROUND));
    assert_eq!(net.pixel(16 + 64 + 16, 40), pictures[1].pixel(0, 24));
}

#[test]
fn walls_whose_place_is_taken_lie_apart() {
    // Two walls on the front wall's right edge: only one can lie there.
    let mut walls = cube(&["front", "right", "right"]);
    walls[2].lower_right = DVec3::new(2.0, -1.0, 0.0);
    let pictures: Vec<_> = (0..3).map(|index| pattern(index, 64, 64)).collect();
    let net = unfolded(&walls, &pictures);
    assert_eq!(net.height, 64 + 32);
    assert!(net.width > 3 * 64 + 3 * 16 - 20, "{}", net.width);
    assert_copied(&net, &pictures[1], [1, 0], 0);
}

#[test]
fn oblique_walls_are_turned_by_their_angle() {
    // A parallelogram that rises along its lower edge.
    let front = wall("front", [0., 0., 0.], [1., 0., 0.], [0., 1., 0.]);
    let skewed = wall("side", [1., 0., 0.], [1., 0.5, 1.], [1., 1., 0.]);
    let walls = [front, skewed];
    let pictures = walls.each_ref().map(|wall| painted(wall, 64, 64));
    let net = unfolded(&walls, &pictures);
    // The side runs up along the skew: as high as the front and half of it.
    assert_eq!([net.width, net.height], [128 + 32, 96 + 32]);
    for x in 60..70 {
        let found = net.pixel(16 + x, 16 + 32 + 40).unwrap();
        let [red, green, blue, _] = colour_of(DVec3::new(
            ((f64::from(x) + 0.5) / 64.0).min(1.0),
            1.0 - 40.5 / 64.0,
            ((f64::from(x) + 0.5) / 64.0 - 1.0).max(0.0),
        ));
        for (found, expected) in found.iter().zip([red, green, blue]) {
            assert!((found - expected).abs() < 0.005, "{x}: {found} {expected}");
        }
    }
}

#[test]
fn tilted_walls_keep_their_shape() {
    // A screen over the front wall, leaning towards the viewer by 45°.
    let front = wall("front", [-1., 0., 0.], [1., 0., 0.], [-1., 2., 0.]);
    let leaning = wall("leaning", [-1., 2., 0.], [1., 2., 0.], [-1., 3., 1.]);
    let walls = [front, leaning];
    let pictures = walls.each_ref().map(|wall| painted(wall, 50, 50));
    let net = unfolded(&walls, &pictures);
    let height = (2.0_f64.sqrt() / 2.0 * 50.0).ceil() as u32;
    assert_eq!([net.width, net.height], [50 + 32, 50 + height + 32]);
}

#[test]
fn what_cannot_be_unfolded_is_refused() {
    assert!(matches!(unfold::<&Wall>(&[]), Err(NetError::NoWalls)));
    let walls = cube(&["front", "left"]);
    let picture = pattern(0, 4, 4);
    let empty = Picture::new(0, 4).unwrap();
    let error = unfold(&[(&walls[0], &picture), (&walls[1], &empty)]).unwrap_err();
    assert!(error.to_string().contains("\"left\""), "{error}");
    assert!(unfold(&[(&walls[0], &empty)]).is_err());

    let mut flat = walls[0].clone();
    flat.lower_right = flat.lower_left;
    assert!(matches!(
        unfold(&[(&flat, &picture)]),
        Err(NetError::Wall(_))
    ));

    let far = wall("far", [0.; 3], [1e9, 0., 0.], [0., 1e9, 0.]);
    let error = unfold(&[(&walls[0], &picture), (&far, &picture)]).unwrap_err();
    assert!(matches!(error, NetError::Picture(_)), "{error}");
}

#[test]
fn a_dome_lies_beside_the_walls_round_and_to_scale() {
    let room = r#"
        [[dome]]
        name = "dome"
        radius = 1.0
        centre = [0, 0, 0]
    "#;
    let cave = crate::cave::Cave::from_toml(room, "", [100; 2]).unwrap();
    let dome = Screen::Dome(&cave.domes[0]);
    let white = Picture::from_pixels(100, 100, vec![[1.0; 4]; 10_000]).unwrap();
    // Alone it is copied, but for what is outside the rim and its border.
    let net = unfold(&[(dome, &white)]).unwrap();
    let side = 100 + 2 * MARGIN as u32;
    assert_eq!((net.width, net.height), (side, side));
    // The name is written over the upper half.
    let found = net.pixels[(net.width * net.height / 2) as usize..]
        .iter()
        .filter(|pixel| **pixel == [1.0; 4])
        .count();
    let expected = (5_000..10_000)
        .map(|i| DVec2::new(f64::from(i % 100), f64::from(i / 100)) - 49.5)
        .filter(|at| at.length() <= 50.0)
        .count();
    assert_eq!(found, expected);
    assert_eq!(net.pixel(side - 18, side - 18), Some(BACKGROUND));

    let walls = cube(&["front"]);
    let wall = Picture::from_pixels(100, 100, vec![[0.5; 4]; 10_000]).unwrap();
    let net = unfold(&[(Screen::Wall(&walls[0]), &wall), (dome, &white)]).unwrap();
    // 2 m of wall are 100 pixels, so π m of dome are 157.
    let columns = |colour| {
        let is = |x: u32| (0..net.height).any(|y| net.pixel(x, y) == Some(colour));
        (0..net.width).filter(|&x| is(x)).collect::<Vec<_>>()
    };
    let (wall, dome) = (columns([0.5; 4]), columns([1.0; 4]));
    assert_eq!(wall.len(), 100);
    assert!(dome.len().abs_diff(157) < 3, "{}", dome.len());
    assert!(wall[99] < dome[0]);
}
