//! Wavelengths in pictures: where a prism puts them, what they sum to, and that
//! they change nothing where no glass asks for them.

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
    Matching, Medium, SpectralSample, SpectralTable, Wavelengths, line, xyz_from_rgb,
};
use shisen_core::trace::Tracer;
use shisen_tests::meshes::icosphere;
use shisen_tests::scenes::{self, empty, pixels_with, sphere, three_walls};

/// Columns of the front wall, whose middle rows show the spectrum.
const COLUMNS: u32 = 1024;
const ROWS: u32 = 3;

fn render(baked: &Baked<8>, view: &View, detail: (u8, u16), spectrum: Spectrum<'_>) -> Vec<Pixel> {
    render_with(&mut Workspace::new(), baked, view, detail, spectrum)
}

fn render_with(
    workspace: &mut Workspace,
    baked: &Baked<8>,
    view: &View,
    (depth, samples): (u8, u16),
    spectrum: Spectrum<'_>,
) -> Vec<Pixel> {
    let settings = Settings {
        depth,
        samples,
        ..Settings::default()
    };
    let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
    let renderer = renderer.with_spectrum(spectrum).expect("known media");
    pixels_with(&renderer, view, workspace)
}

/// What a method makes of so many wavelengths.
fn with_table<T>(count: u32, phases: u32, run: impl FnOnce(SpectralTable<'_>) -> T) -> T {
    let mut storage = vec![SpectralSample::default(); SpectralTable::MOST_SAMPLES];
    let wavelengths = Wavelengths::new(count, Wavelengths::RANGE).expect("a range");
    run(SpectralTable::new(wavelengths, phases, Matching::Wyman, &mut storage).expect("a table"))
}

/// One wavelength each.
const fn comb(table: SpectralTable<'_>) -> Spectrum<'_> {
    Spectrum::Comb { table, each: 1 }
}

/// All of them each.
const fn split(table: SpectralTable<'_>) -> Spectrum<'_> {
    Spectrum::Comb {
        table,
        each: u8::MAX,
    }
}

/// The middle rows of a CAVE's front wall.
fn wall() -> View {
    let step = 3.0 / COLUMNS as f32;
    let first = Vec3::new(-1.5 + 0.5 * step, 0.5 * (ROWS - 1) as f32 * step, -1.5);
    let (right, down) = (Vec3::X * step, Vec3::NEG_Y * step);
    View::new(Vec3::ZERO, first, right, down, [COLUMNS, ROWS]).expect("a view")
}

/// The column of the wall, its first edge at 0, that is seen at an angle from
/// −Z towards −X.
fn column(angle: f64) -> f64 {
    (0.5 - 0.5 * angle.tan()) * f64::from(COLUMNS)
}

/// The wall, summed over its rows.
fn columns(bench: PrismBench, samples: u16, spectrum: Spectrum<'_>) -> Vec<DVec3> {
    let baked = Baked::<8>::new(&bench.scene()).expect("a scene");
    let pixels = render(&baked, &wall(), (3, samples), spectrum);
    let sum = |column: usize| {
        let rows = pixels.iter().skip(column).step_by(COLUMNS as usize);
        rows.map(|p| DVec3::new(p.red.into(), p.green.into(), p.blue.into()))
            .sum()
    };
    (0..COLUMNS as usize).map(sum).collect()
}

/// The middle of what is around the brightest column.
fn spot(columns: &[f64]) -> f64 {
    let brightest = (0..columns.len())
        .max_by(|&a, &b| columns[a].total_cmp(&columns[b]))
        .expect("columns");
    let around = brightest.saturating_sub(12)..(brightest + 13).min(columns.len());
    let (mut sum, mut moment) = (0.0, 0.0);
    for column in around {
        sum += columns[column];
        moment += columns[column] * (column as f64 + 0.5);
    }
    assert!(sum > 0.0, "nothing is seen");
    moment / sum
}

fn spot_of(bench: PrismBench, nm: f32) -> f64 {
    let columns = columns(bench, 16, Spectrum::Single(nm));
    let red: Vec<f64> = columns.iter().map(|sum| sum.x).collect();
    spot(&red)
}

/// Snell's law in 64 bits, by the vectors.
fn refract(direction: DVec3, normal: DVec3, eta: f64) -> DVec3 {
    let cosine = -direction.dot(normal);
    let root = (1.0 - eta * eta * (1.0 - cosine * cosine)).sqrt();
    eta * direction + (eta * cosine - root) * normal
}

/// How far to the left of the slit's middle the ray passes that the eye sends at
/// an angle: metres.
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

/// The angle at which the eye sees the slit's middle in light of an index.
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
        let found = spot_of(bench, nm);
        assert!(
            (found - expected).abs() < 1.0,
            "{nm} nm: {found}, not {expected}"
        );
        // The apex is to the right: light that is bent more is seen nearer it.
        assert!(found > before, "{nm} nm: {found} after {before}");
        before = found;
    }
}

#[test]
fn a_spectrum_has_the_colours_of_the_rainbow_without_stripes() {
    let bench = PrismBench::new(line::D);
    let smooth = with_table(64, 32, |table| columns(bench, 16, split(table)));
    let [red, green, blue] = [0, 1, 2].map(|channel| {
        let (mut sum, mut moment) = (0.0, 0.0);
        for (column, light) in smooth.iter().enumerate() {
            sum += light[channel].max(0.0);
            moment += light[channel].max(0.0) * column as f64;
        }
        moment / sum
    });
    assert!(
        red + 5.0 < green && green + 5.0 < blue,
        "{red} {green} {blue}"
    );
    // Beyond blue there is violet, which is red besides.
    let end = smooth
        .iter()
        .rposition(|light| light.z > 0.02)
        .expect("a spectrum");
    let violet = smooth[end - 6];
    assert!(
        violet.z > violet.x && violet.x > violet.y.max(0.0),
        "{violet}"
    );
    // How far luminance is from that of very many wavelengths.
    let luminance = |light: &DVec3| f64::from(xyz_from_rgb(light.as_vec3()).y);
    let most = smooth.iter().map(luminance).fold(0.0, f64::max);
    let rough = |columns: &[DVec3]| {
        let pairs = columns.iter().zip(&smooth);
        let squares = pairs.map(|(a, b)| (luminance(a) - luminance(b)).powi(2));
        (squares.sum::<f64>() / 90.0).sqrt() / most
    };
    let turns = with_table(14, 32, |table| columns(bench, 56, comb(table)));
    let fixed = with_table(14, 1, |table| columns(bench, 56, comb(table)));
    let (turns, fixed) = (rough(&turns), rough(&fixed));
    assert!(
        turns < 0.05 && 2.0 * turns < fixed,
        "{turns}, fixed {fixed}"
    );
}

/// A clear ball before the eye.
fn ball(material: Material, background: Background) -> Scene {
    let ball = Object {
        casts_shadow: false,
        smooth: true,
        ..sphere(1.0, 0, [0.0, 0.0, -3.0])
    };
    Scene {
        materials: vec![material],
        objects: vec![ball],
        background,
        ambient: [0.0; 3],
        ..empty()
    }
}

fn clear(medium: Medium) -> Material {
    Material {
        diffuse: [0.0; 3],
        transmission: [1.0; 3],
        medium: Some(medium),
        ..Material::default()
    }
}

/// The ball and what is around it.
fn before_the_ball(side: u32) -> View {
    let step = 0.9 / side as f32;
    let first = Vec3::new(-0.45 + 0.5 * step, 0.45 - 0.5 * step, -1.0);
    let (right, down) = (Vec3::X * step, Vec3::NEG_Y * step);
    View::new(Vec3::ZERO, first, right, down, [side; 2]).expect("a view")
}

fn largest_difference(found: &[Pixel], expected: &[Pixel]) -> f32 {
    assert_eq!(found.len(), expected.len());
    let channels = |p: &Pixel| [p.red, p.green, p.blue, p.alpha];
    let pairs = found.iter().zip(expected);
    pairs
        .flat_map(|(a, b)| channels(a).into_iter().zip(channels(b)))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

#[test]
fn glass_without_dispersion_has_the_colours_of_rgb() {
    // The term is nothing beside 1 + A, but one that depends on the wavelength.
    let constant = Medium::form2([390.0, 800.0], 1.25, &[[1e-9, 0.01]]).expect("a medium");
    assert!(constant.is_dispersive() && constant.index(400.0) == constant.index(700.0));
    let sky = Background {
        zenith: [0.2, 0.5, 0.9],
        horizon: [0.9, 0.8, 0.6],
        nadir: [0.3, 0.1, 0.0],
        alpha: 1.0,
    };
    let baked = Baked::<8>::new(&ball(clear(constant), sky)).expect("a scene");
    let check = |view: &View, samples, way: &str, render_with: &dyn Fn() -> Vec<Pixel>| {
        let expected = render(&baked, view, (4, samples), Spectrum::Rgb);
        let off = largest_difference(&render_with(), &expected);
        assert!(off < 1e-5, "{way}, {samples} samples: {off}");
    };
    let view = before_the_ball(32);
    for (count, samples) in [2, 7, 14]
        .into_iter()
        .flat_map(|n| [(n, 1), (n, 5), (n, 28)])
    {
        with_table(count, 32, |table| {
            check(&view, samples, &format!("split into {count}"), &|| {
                render(&baked, &view, (4, samples), split(table))
            });
            // Rays of a comb have colours, and lie side by side in their pixel:
            // the mean is that of one place.
            for place in [[0.0, 0.0], [0.2, -0.1], [-0.1, 0.3]] {
                let view = around(place);
                check(&view, samples, &format!("a comb of {count}"), &|| {
                    render(&baked, &view, (4, samples), comb(table))
                });
            }
            check(&view, samples, &format!("pictures of {count}"), &|| {
                let mut sum = vec![Pixel::default(); 32 * 32];
                for &SpectralSample { nm, weight } in table.phase(0) {
                    let one = render(&baked, &view, (4, samples), Spectrum::Single(nm));
                    for (sum, one) in sum.iter_mut().zip(one) {
                        sum.red += weight.x * one.red;
                        sum.green += weight.y * one.green;
                        sum.blue += weight.z * one.blue;
                        sum.alpha += one.alpha / count as f32;
                    }
                }
                sum
            });
        });
    }
}

/// Pixels of one place on the ball or beside it.
fn around([x, y]: [f32; 2]) -> View {
    let (right, down) = (Vec3::X * 1e-7, Vec3::NEG_Y * 1e-7);
    View::new(Vec3::ZERO, Vec3::new(x, y, -1.0), right, down, [4; 2]).expect("a view")
}

#[test]
fn clear_glass_in_a_white_room_is_white() {
    let white = Background::uniform([1.0; 3]);
    let one = ball(clear(Medium::QUARTZ_O), white);
    // Behind it a flat one and a block with edges, in which light is reflected
    // again and again.
    let mut several = ball(clear(Medium::SF11), white);
    let behind = |shape, z| Object {
        shape,
        world_from_object: DAffine3::from_translation(DVec3::new(0.3, -0.2, z)),
        ..several.objects[0].clone()
    };
    let more = [
        behind(
            Shape::Spheroid {
                equatorial_radius: 0.9,
                polar_radius: 0.3,
            },
            -5.0,
        ),
        behind(Shape::Mesh(0), -1.6),
    ];
    several.objects.extend(more);
    several.meshes.push(icosphere(0));
    let view = before_the_ball(12);
    let white = Pixel {
        red: 1.0,
        green: 1.0,
        blue: 1.0,
        alpha: 1.0,
    };
    let expected = vec![white; 12 * 12];
    for (scene, depth) in [
        (&one, 3),
        (&one, MAX_DEPTH),
        (&several, 1),
        (&several, 3),
        (&several, 8),
    ] {
        let baked = Baked::<8>::new(scene).expect("a scene");
        for samples in [1, 15] {
            for count in [1, 7, 64] {
                with_table(count, 32, |table| {
                    let check = |spectrum, way: &str| {
                        let found = render(&baked, &view, (depth, samples), spectrum);
                        let off = largest_difference(&found, &expected);
                        assert!(off < 1e-4, "{way}, {count}, {samples}, {depth}: {off}");
                    };
                    check(split(table), "split");
                    check(comb(table), "comb");
                    check(Spectrum::Comb { table, each: 3 }, "comb of three");
                });
            }
        }
    }
}

#[test]
fn a_ray_alone_leaves_nothing_for_the_next_picture() {
    let white = Background::uniform([1.0; 3]);
    let baked = Baked::<8>::new(&ball(clear(Medium::SF11), white)).expect("a scene");
    let view = before_the_ball(16);
    with_table(7, 32, |table| {
        let expected = render(&baked, &view, (4, 2), comb(table));
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 4);
        let tracer = tracer.with_spectrum(comb(table)).expect("known media");
        let mut workspace = Workspace::new();
        // Into the ball, which is 2 m off, and past its rim.
        for x in [0.0, 0.2, 0.24, 0.5] {
            let ray = Ray::new(Vec3::ZERO, Vec3::new(x, 0.0, -1.0)).expect("a ray");
            tracer.radiance(&ray, &mut { Budget::UNLIMITED }, &mut workspace);
        }
        let found = render_with(&mut workspace, &baked, &view, (4, 2), comb(table));
        assert_eq!(found, expected);
    });
}

fn frame(scene: &Scene, dispersion: Dispersion) -> Frame {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let eye = Observer::new(Eye::Centre, Viewer::default().eye(Eye::Centre));
    let mut options = Options {
        dispersion,
        ..Options::default()
    };
    options.settings.samples = 3;
    scenes::frame(&baked, &three_walls(40), &[eye], &options)
}

#[test]
fn nothing_changes_where_no_glass_asks_for_it() {
    let mut glass = paper_scene(PaperScene::A, icosphere(2)).expect("a scene");
    glass.materials[0] = Material {
        transmission: [0.9; 3],
        ..Material::default()
    };
    let ways = [1, 7, 64].into_iter().flat_map(|count| {
        let wavelengths = Wavelengths::new(count, Wavelengths::RANGE).expect("a range");
        [
            Dispersion::Comb(wavelengths, 1),
            Dispersion::Comb(wavelengths, 3),
            Dispersion::Comb(wavelengths, u8::MAX),
            Dispersion::Images(wavelengths, Matching::Endo),
        ]
    });
    let ways: Vec<Dispersion> = ways.chain([Dispersion::Single(450.0)]).collect();
    for scene in [
        glass,
        paper_scene(PaperScene::B, icosphere(2)).expect("a scene"),
    ] {
        let expected = frame(&scene, Dispersion::Off);
        for &way in &ways {
            let found = frame(&scene, way);
            assert_eq!(found.hash(), expected.hash(), "{way:?}");
            assert_eq!(found.statistics, expected.statistics, "{way:?}");
        }
    }
    // Nor where its index is the same for all.
    let mut constant = spheres();
    let ordinary = Medium::form2([390.0, 800.0], 1.25, &[[0.5, 0.0]]).expect("a medium");
    for material in constant
        .materials
        .iter_mut()
        .filter(|one| one.medium.is_some())
    {
        material.medium = Some(ordinary);
    }
    let expected = frame(&constant, Dispersion::Off);
    for &way in &ways {
        assert_eq!(frame(&constant, way).hash(), expected.hash(), "{way:?}");
    }
    // Where glass does, it does.
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
    let mut sum = vec![DVec3::ZERO; 576];
    for &nm in &wavelengths {
        let share = matching.values(nm).as_dvec3() / total;
        let weight = shisen_core::spectrum::rgb_from_xyz((share * white).as_vec3()).as_dvec3();
        let picture = render(&baked, &view, (3, samples), Spectrum::Single(nm));
        for (sum, one) in sum.iter_mut().zip(picture) {
            *sum += weight * DVec3::new(one.red.into(), one.green.into(), one.blue.into());
        }
    }
    let mut storage = Vec::new();
    let wavelengths = Wavelengths::new(8, Wavelengths::RANGE).expect("a range");
    let spectrum = Dispersion::Reference(wavelengths).spectrum(&mut storage);
    let split = render(&baked, &view, (3, samples), spectrum);
    let off = sum.iter().zip(&split).map(|(sum, one)| {
        let one = DVec3::new(one.red.into(), one.green.into(), one.blue.into());
        (one - *sum).abs().max_element()
    });
    let (worst, mean) = off.fold((0f64, 0.0), |(worst, mean), off| {
        (worst.max(off), mean + off / 576.0)
    });
    assert!(mean < 2e-3 && worst < 0.1, "{mean} {worst}");
}
