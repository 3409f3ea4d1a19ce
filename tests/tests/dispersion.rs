//! Wavelengths in pictures: a prism puts them where Snell's law says, they sum to
//! white, and they change nothing without dispersive glass.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::cave::{Eye, Viewer};
use shisen::render::spectrum::{CIE_1931, Dispersion};
use shisen::render::{Frame, Observer, Options};
use shisen::scene::builtin::{PaperScene, PrismBench, paper_scene, spheres};
use shisen::scene::material::Material;
use shisen::scene::{Background, Object, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, MAX_DEPTH, Pixel, Renderer, Settings, Spectrum, View, Workspace};
use shisen_core::shape::Ray;
use shisen_core::spectrum::{
    Matching, Medium, SpectralSample, SpectralTable, Wavelengths, line, rgb_from_xyz, xyz_from_rgb,
};
use shisen_tests::meshes::icosphere;
use shisen_tests::scenes::{self, empty, pixels, pixels_with, sphere, three_walls};

/// Columns of the front wall, whose middle row shows the spectrum.
const COLUMNS: u32 = 1024;

fn renderer<'a>(
    baked: &'a Baked<8>,
    depth: u8,
    samples: u16,
    spectrum: Spectrum<'a>,
) -> Renderer<'a, 8> {
    let settings = Settings {
        depth,
        samples,
        ..Settings::default()
    };
    let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
    renderer.with_spectrum(spectrum).expect("known media")
}

/// Returns the column of the wall, with its first edge at 0, that is seen at an
/// angle from −Z towards −X.
fn column(angle: f64) -> f64 {
    (0.5 - 0.5 * angle.tan()) * f64::from(COLUMNS)
}

/// Returns the centre of the spot around the brightest column in light of one wavelength.
fn spot(bench: PrismBench, nm: f32) -> f64 {
    let step = 3.0 / COLUMNS as f32;
    let first = Vec3::new(-1.5 + 0.5 * step, 0.0, -1.5);
    let (right, down) = (Vec3::X * step, Vec3::NEG_Y * step);
    let wall = View::new(Vec3::ZERO, first, right, down, [COLUMNS, 1]).expect("a view");
    let baked = Baked::<8>::new(&bench.scene()).expect("a scene");
    let row = pixels(&renderer(&baked, 3, 48, Spectrum::Single(nm)), &wall);
    let brightest = (0..row.len())
        .max_by(|&a, &b| row[a].red.total_cmp(&row[b].red))
        .expect("columns");
    let around = brightest.saturating_sub(12)..(brightest + 13).min(row.len());
    let (mut sum, mut moment) = (0.0, 0.0);
    for column in around {
        sum += f64::from(row[column].red);
        moment += f64::from(row[column].red) * (column as f64 + 0.5);
    }
    assert!(sum > 0.0, "nothing is seen");
    moment / sum
}

/// Returns the refracted direction by Snell's law, in 64 bits.
fn refract(direction: DVec3, normal: DVec3, eta: f64) -> DVec3 {
    let cosine = -direction.dot(normal);
    let root = (1.0 - eta * eta * (1.0 - cosine * cosine)).sqrt();
    eta * direction + (eta * cosine - root) * normal
}

/// Returns how far to the left of the slit's middle a ray from the eye at an angle
/// passes: metres.
fn misses_by(bench: PrismBench, angle: f64, index: f64) -> f64 {
    let inradius = PrismBench::SIDE / 12f64.sqrt();
    let [near, far] = bench.faces().map(PrismBench::towards);
    let meets = |from: DVec3, direction: DVec3, normal: DVec3| {
        let plane = bench.centre() + inradius * normal;
        from + direction * ((plane - from).dot(normal) / direction.dot(normal))
    };
    let direction = PrismBench::towards(angle);
    let enters = meets(DVec3::ZERO, direction, near);
    let inside = refract(direction, near, 1.0 / index);
    let leaves = meets(enters, inside, far);
    let beyond = refract(inside, -far, index);
    let towards = PrismBench::towards(bench.deviation());
    let left = DVec3::Y.cross(towards);
    let reach = (bench.slit() - leaves).dot(towards) / beyond.dot(towards);
    (leaves + beyond * reach - bench.slit()).dot(left)
}

/// Returns the angle at which the eye sees the slit's middle at an index of refraction.
fn seen_at(bench: PrismBench, index: f64) -> f64 {
    let (mut low, mut high) = (-0.2, 0.08);
    let sign = misses_by(bench, low, index).signum();
    assert!(sign != misses_by(bench, high, index).signum());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if misses_by(bench, middle, index).signum() == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn a_spectrum_lies_where_snell_says() {
    let bench = PrismBench::new(line::D);
    let mut before = 0.0;
    for nm in [700.0, line::C, 620.0, line::D, 550.0, line::F, 450.0, 400.0] {
        let index = Medium::SF11.index(nm).into();
        let expected = column(seen_at(bench, index));
        let found = spot(bench, nm);
        assert!(
            (found - expected).abs() < 1.0,
            "{nm} nm: {found}, not {expected}"
        );
        // The apex is to the right: light that is bent more appears nearer to it.
        assert!(found > before, "{nm} nm: {found} after {before}");
        before = found;
    }
}

/// Returns a clear ball before the eye in a white room.
fn ball(medium: Medium) -> Scene {
    let clear = Material {
        diffuse: [0.0; 3],
        transmission: [1.0; 3],
        medium: Some(medium),
        ..Material::default()
    };
    let ball = Object {
        casts_shadow: false,
        smooth: true,
        ..sphere(1.0, 0, [0.0, 0.0, -3.0])
    };
    Scene {
        materials: vec![clear],
        objects: vec![ball],
        background: Background::uniform([1.0; 3]),
        ambient: [0.0; 3],
        ..empty()
    }
}

/// Returns a view of the ball and its surroundings.
fn before_the_ball(side: u32) -> View {
    let step = 0.9 / side as f32;
    let first = Vec3::new(-0.45 + 0.5 * step, 0.45 - 0.5 * step, -1.0);
    let (right, down) = (Vec3::X * step, Vec3::NEG_Y * step);
    View::new(Vec3::ZERO, first, right, down, [side; 2]).expect("a view")
}

#[test]
fn clear_glass_in_a_white_room_is_white() {
    let one = ball(Medium::QUARTZ_O);
    // Behind the ball are a flat one and a block with edges, inside which light is
    // reflected many times.
    let mut several = ball(Medium::SF11);
    let behind = |shape, z| Object {
        shape,
        world_from_object: DAffine3::from_translation(DVec3::new(0.3, -0.2, z)),
        ..several.objects[0].clone()
    };
    let flat = Shape::Spheroid {
        equatorial_radius: 0.9,
        polar_radius: 0.3,
    };
    let more = [behind(flat, -5.0), behind(Shape::Mesh(0), -1.6)];
    several.objects.extend(more);
    several.meshes.push(icosphere(0));
    let view = before_the_ball(12);
    let mut workspace = Workspace::new();
    let mut storage = vec![SpectralSample::default(); SpectralTable::MOST_SAMPLES];
    let scenes = [
        (&one, MAX_DEPTH),
        (&several, 1),
        (&several, 3),
        (&several, 8),
    ];
    for ((scene, depth), samples) in scenes.into_iter().flat_map(|one| [(one, 1), (one, 15)]) {
        let baked = Baked::<8>::new(scene).expect("a scene");
        for (count, each) in [1, 7, 64]
            .into_iter()
            .flat_map(|n| [1, 3, u8::MAX].map(|e| (n, e)))
        {
            let wavelengths = Wavelengths::new(count, Wavelengths::RANGE).expect("a range");
            let table = SpectralTable::new(wavelengths, 32, Matching::Wyman, &mut storage);
            let table = table.expect("a table");
            let renderer = renderer(&baked, depth, samples, Spectrum::Comb { table, each });
            // A single ray, into the ball or past its rim, must not affect the next picture.
            for x in [0.2, 0.5] {
                let ray = Ray::new(Vec3::ZERO, Vec3::new(x, 0.0, -1.0)).expect("a ray");
                let budget = &mut { Budget::UNLIMITED };
                renderer.tracer().radiance(&ray, budget, &mut workspace);
            }
            for pixel in pixels_with(&renderer, &view, &mut workspace) {
                let off = (Vec3::new(pixel.red, pixel.green, pixel.blue) - 1.0).abs();
                let off = off.max_element().max((pixel.alpha - 1.0).abs());
                assert!(off < 1e-4, "{count}, {each}, {samples}, {depth}: {off}");
            }
        }
    }
}

fn frame(scene: &Scene, dispersion: Dispersion) -> Frame {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let eye = Observer::new(Eye::Centre, Viewer::default().eye(Eye::Centre));
    let mut options = Options {
        dispersion,
        ..Options::default()
    };
    options.settings.samples = 3;
    scenes::frame(baked.scene().into(), &three_walls(40), &[eye], &options)
}

#[test]
fn nothing_changes_where_no_glass_asks_for_it() {
    let mut glass = paper_scene(PaperScene::A, icosphere(2)).expect("a scene");
    glass.materials[0] = Material {
        transmission: [0.9; 3],
        ..Material::default()
    };
    let wavelengths = Wavelengths::new(7, Wavelengths::RANGE).expect("a range");
    let ways = [
        Dispersion::Comb(wavelengths, 1),
        Dispersion::Comb(wavelengths, 3),
        Dispersion::Comb(wavelengths, u8::MAX),
        Dispersion::Images(wavelengths, Matching::Endo),
        Dispersion::Single(450.0),
    ];
    let expected = frame(&glass, Dispersion::Off);
    for way in ways {
        let found = frame(&glass, way);
        assert_eq!(found.hash(), expected.hash(), "{way:?}");
        assert_eq!(found.statistics, expected.statistics, "{way:?}");
    }
    // The same holds for glass with one index for all wavelengths.
    let mut constant = spheres();
    let ordinary = Medium::form2([390.0, 800.0], 1.25, &[[0.5, 0.0]]).expect("a medium");
    for material in &mut constant.materials {
        material.medium = material.medium.map(|_| ordinary);
    }
    let expected = frame(&constant, Dispersion::Off);
    for way in ways {
        assert_eq!(frame(&constant, way).hash(), expected.hash(), "{way:?}");
    }
    // Dispersive glass does change the picture.
    let scene = spheres();
    let combed = frame(&scene, Dispersion::default()).hash();
    assert_ne!(combed, frame(&scene, Dispersion::Off).hash());
}

#[test]
fn a_split_is_the_sum_of_many_pictures() {
    let baked = Baked::<8>::new(&spheres()).expect("a scene");
    let view = before_the_ball(24);
    let (count, samples) = (401, 8);
    let matching = Matching::Table(*CIE_1931);
    // The standard's colours under equal energy, white by each of XYZ.
    let wavelengths: Vec<f32> = (0..count)
        .map(|k| 400.0 + 300.0 * (k as f32 + 0.5) / count as f32)
        .collect();
    let total: DVec3 = wavelengths
        .iter()
        .map(|&nm| matching.values(nm).as_dvec3())
        .sum();
    let white = xyz_from_rgb(Vec3::ONE).as_dvec3();
    let picture = |spectrum| {
        let pixels = pixels(&renderer(&baked, 3, samples, spectrum), &view);
        let light = |p: Pixel| DVec3::new(p.red.into(), p.green.into(), p.blue.into());
        pixels.into_iter().map(light)
    };
    let mut sum = vec![DVec3::ZERO; 576];
    for &nm in &wavelengths {
        let share = matching.values(nm).as_dvec3() / total;
        let weight = rgb_from_xyz((share * white).as_vec3()).as_dvec3();
        for (sum, one) in sum.iter_mut().zip(picture(Spectrum::Single(nm))) {
            *sum += weight * one;
        }
    }
    let mut storage = Vec::new();
    let wavelengths = Wavelengths::new(8, Wavelengths::RANGE).expect("a range");
    let split = picture(Dispersion::Reference(wavelengths).spectrum(&mut storage));
    let off = sum
        .iter()
        .zip(split)
        .map(|(sum, one)| (one - *sum).abs().max_element());
    let (worst, mean) = off.fold((0f64, 0.0), |(worst, mean), off| {
        (worst.max(off), mean + off / 576.0)
    });
    assert!(mean < 2e-3 && worst < 0.1, "{mean} {worst}");
}
