use super::*;

/// Returns a wall of 16² pixels, 1 m a side, 1 m ahead.
fn view() -> View {
    let pixel = 1.0 / 16.0;
    let first = Vec3::new(-0.5 + 0.5 * pixel, 0.5 - 0.5 * pixel, -1.0);
    View::new(
        Vec3::ZERO,
        first,
        Vec3::X * pixel,
        Vec3::NEG_Y * pixel,
        [16, 16],
    )
    .unwrap()
}

/// Returns a grey of an 8-bit code.
fn grey(code: u8) -> Picture {
    let encoded = f32::from(code) / 255.0;
    let linear = match code {
        ..=10 => encoded / 12.92,
        _ => ((encoded + 0.055) / 1.055).powf(2.4),
    };
    Picture::from_pixels(16, 16, vec![[linear, linear, linear, 1.0]; 256]).unwrap()
}

#[test]
fn even_differences_are_the_same_however_they_are_weighted() {
    let sight = Sight::new(&view(), Vec3::NEG_Z);
    let error = PictureDifference::new(&[(&sight, &grey(120), &grey(100))]);
    for found in [
        error.all,
        error.weighted,
        error.rings[1].unwrap(),
        error.rings[2].unwrap(),
    ] {
        // 20 codes everywhere.
        assert!((found.psnr.unwrap() - 20.0 * (255.0f64 / 20.0).log10()).abs() < 1e-9);
        assert!((found.flip - error.all.flip).abs() < 1e-6, "{found:?}");
        let c1 = (0.01f64 * 255.0).powi(2);
        let ssim = (2.0 * 120.0 * 100.0 + c1) / (120.0f64.powi(2) + 100.0f64.powi(2) + c1);
        assert!((found.ssim - ssim).abs() < 1e-9, "{found:?}");
    }
}

#[test]
fn black_for_white_is_all_of_flip() {
    let sight = Sight::new(&view(), Vec3::NEG_Z);
    let error = PictureDifference::new(&[(&sight, &grey(0), &grey(255))]);
    // Equations 7 to 10 of the paper: HyAB of black and white is 100, that of the
    // farthest colours, green and blue, 203.4; there is no edge.
    let part = (100.0f64 / 203.4).powf(0.7);
    let exact = 0.95 + 0.05 * (part - 0.4) / 0.6;
    assert!(
        (error.all.flip - exact).abs() < 2e-3,
        "{} {exact}",
        error.all.flip
    );
    assert!(error.all.psnr.unwrap().abs() < 1e-9, "{error:?}");
}

#[test]
fn weights_are_of_the_solid_angle_and_the_cortex() {
    let view = view();
    let sight = Sight::new(&view, Vec3::NEG_Z);
    // Weights over magnification add up to the wall's solid angle.
    let mut solid = 0.0;
    for (index, weight) in sight.weights.iter().enumerate() {
        let (x, y) = ((index % 16) as f32, (index / 16) as f32);
        let degrees = f64::from(
            view.direction(x, y)
                .unwrap()
                .angle_between(Vec3::NEG_Z)
                .to_degrees(),
        );
        solid += weight * ((degrees + 0.75) / 17.3).powi(2);
    }
    assert!((solid - 4.0 * 0.2f64.asin()).abs() < 0.005, "{solid}");
    // A pixel in the middle, from edge to edge.
    let least = 1.0 / (1.0f64 / 16.0).atan().to_degrees();
    assert!((f64::from(sight.pixels_per_degree) / least - 1.0).abs() < 0.01);
}

#[test]
fn rings_are_where_the_viewer_looks() {
    assert_eq!(
        [0.0, 1.0, 1.1, 5.0, 5.1, 180.0].map(Ring::of),
        [
            Ring::Fovea,
            Ring::Fovea,
            Ring::Parafovea,
            Ring::Parafovea,
            Ring::Periphery,
            Ring::Periphery,
        ]
    );
    // A difference in one corner counts the more the nearer the gaze is.
    let mut found = grey(100);
    found.pixels[0] = [1.0; 4];
    let corner = view().direction(0.0, 0.0).unwrap();
    let weighted = [Vec3::NEG_Z, corner].map(|forward| {
        let sight = Sight::new(&view(), forward);
        PictureDifference::new(&[(&sight, &found, &grey(100))])
    });
    assert!(
        weighted[1].weighted.flip > 10.0 * weighted[0].weighted.flip,
        "{weighted:?}"
    );
    assert_eq!(weighted[0].all, weighted[1].all);
    assert!(weighted[1].rings[0].is_some() && weighted[0].rings[0].is_none());
}

/// The walls are equal, the close-up of 10° is not: what is weighted has a part of each.
#[test]
fn what_is_weighted_has_the_middle_of_the_close_up() {
    let (walls, half) = (view(), 5f32.to_radians().tan());
    let pixel = 2.0 * half / 16.0;
    let first = Vec3::new(-half + 0.5 * pixel, half - 0.5 * pixel, -1.0);
    let (right, down) = (Vec3::X * pixel, Vec3::NEG_Y * pixel);
    let close_up = View::new(Vec3::ZERO, first, right, down, [16, 16]).unwrap();
    let [walls, close_up] = [walls, close_up].map(|view| Sight::new(&view, Vec3::NEG_Z));
    let equal = PictureDifference::new(&[(&walls, &grey(90), &grey(90))]);
    let near = PictureDifference::new(&[(&close_up, &grey(120), &grey(100))]);
    let found = equal.clone().with_middle_of(&near);

    let weight = |sight: &Sight, is_near: bool| -> f64 {
        let pixels = sight.rings.iter().zip(&sight.weights);
        let those = pixels.filter(|one| (*one.0 != Ring::Periphery) == is_near);
        those.map(|one| *one.1).sum()
    };
    let (middle, beyond) = (weight(&close_up, true), weight(&walls, false));
    let part = middle / (middle + beyond);
    assert!(part > 0.1 && part < 0.9, "{part}");
    let (weighted, whole) = (found.weighted, near.all);
    assert!((weighted.flip - part * whole.flip).abs() < 1e-6 * whole.flip);
    assert!((weighted.ssim - (part * whole.ssim + 1.0 - part)).abs() < 1e-9);
    let psnr = 20.0 * (255.0f64 / 20.0).log10() - 10.0 * part.log10();
    assert!((weighted.psnr.unwrap() - psnr).abs() < 1e-9, "{weighted:?}");
    let [fovea, _, periphery] = found.rings.map(Option::unwrap);
    assert!(weighted.flip > periphery.flip && weighted.flip < fovea.flip);
    assert!(weighted.ssim < periphery.ssim && weighted.ssim > fovea.ssim);
    // All pixels of the walls, and their periphery, are as they were.
    assert_eq!((found.all, found.rings[2]), (equal.all, equal.rings[2]));
}
