//! Public functions under integers at the borders of their types and of what is sensible:
//! none of them panics, and what they give keeps to what they are given.

use super::numbers::message;
use super::records::{Port, items};
use super::seeing::{BAKED, every_view, renderer, tracer};
use super::texts::{NOWHERE, WALLS};
use glam::Vec3;
use shisen::cave::{BuiltInCave, Cave};
use shisen::dashboard::{Canvas, Coordinates};
use shisen::live::{Channels, Share};
use shisen::lod::Coverage;
use shisen::picture::Picture;
use shisen::scene::camera::{CameraKey, CameraPath, DomeCamera};
use shisen::simplify::PolygonLevels;
use shisen::texture::Image;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, DomePose, DomeProjection, FrameJob, LevelOfDetail, Mode, Part, Pictures, Place,
    Surroundings, View, Workspace,
};
use shisen_core::gaze::{Detail, FaceRange, Gaze, LineOfSight, VisualField};
use shisen_core::scene::EffectSet;
use shisen_core::scene::format::Node;
use shisen_core::spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths};
use shisen_core::trace::{MeshTracer, TileRays, Tracer, TraversalStack};
use shisen_tests::rays::Random;
use shisen_tracker::command::{Action, Script, Session, Watch};
use shisen_tracker::eye::adhawk;
use shisen_tracker::head::polhemus::Family;
use shisen_tracker::head::{fastrak, flock, hatire};
use shisen_tracker::hid::{descriptor, eye_tracker};
use shisen_tracker::link;
use shisen_tracker::mock::{Device, Random as Random32};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::Parts;
use shisen_tracker::serial::Serial;
use shisen_tracker::time::{DeviceTime, Micros};
use shisen_tracker::uart;
use std::panic::catch_unwind;
use std::path::Path;

/// A use of one public function: three integers, of which it takes as many as it has
/// parameters, each as its type holds it.
pub(super) type Case = fn([u64; 3]);

pub(super) const CASES: &[(&str, Case)] = &[
    ("core frame::Renderer::detail", |[x, y, _]| {
        let renderer = renderer(Mode::Tile);
        for view in every_view() {
            let found = renderer.detail(&view, x as u32, y as u32);
            let inside = (x as u32) < view.columns() && (y as u32) < view.rows();
            assert!(found.is_none() || inside);
        }
    }),
    ("core frame::foveation::Renderer::stride", |[x, y, _]| {
        let renderer = renderer(Mode::Tile);
        for view in every_view() {
            assert_eq!(renderer.stride(&view, x as u32, y as u32), 1);
        }
    }),
    ("core frame::fill::Surroundings::views", |[side, ..]| {
        let views = Surroundings::views(DomePose::over_room(Vec3::Y), side as u32);
        if let Ok(views) = views {
            assert!(views.iter().all(|view| view.columns() == side as u32));
        }
    }),
    ("core frame::fill::Surroundings::new", |[side, ..]| {
        let pose = DomePose::over_room(Vec3::Y);
        assert!(side as u32 == 0 || Surroundings::new(pose, side as u32, [&[], &[]]).is_err());
    }),
    ("core frame::job::FrameJob::tiles_of", |[a, b, side]| {
        let sizes = [[a as u32, b as u32], [b as u32, a as u32], [8, 8]];
        assert!(FrameJob::tiles_of(sizes.into_iter(), side as u32) >= 1);
    }),
    ("core frame::job::FrameJob::new", |[side, ..]| {
        of_four(|parts| {
            let mut places = [Place::default(); 64];
            let made = FrameJob::new(parts, side as u32, Budget::UNLIMITED, &mut places);
            // 8×8 pixels in tiles of one have no room.
            assert_eq!(made.is_ok(), (2..=256).contains(&(side as u32)));
        });
    }),
    ("core frame::view::View::dome", |[size, ..]| {
        let projection = DomeProjection::Equidistant { field_of_view: 3.0 };
        let view = View::dome(projection, DomePose::over_room(Vec3::Y), size as u32);
        if let Ok(view) = view {
            assert_eq!([view.columns(), view.rows()], [size as u32; 2]);
        }
    }),
    ("core frame::job::Pictures::view", |[number, ..]| {
        of_four(|parts| {
            let found = Pictures::<8>::view(parts, number as usize);
            assert_eq!(found.is_some(), number < 4);
        });
    }),
    ("core frame::job::Pictures::renderer", |[number, ..]| {
        of_four(|parts| {
            let found = Pictures::<8>::renderer(parts, number as usize);
            assert_eq!(found.is_some(), number < 4);
        });
    }),
    ("core gaze::detail::Detail::bounces", |[most, ..]| {
        each_detail(|detail| assert!(detail.bounces(most as u8) <= most as u8));
    }),
    ("core gaze::detail::Detail::wavelengths", |[most, ..]| {
        each_detail(|detail| assert!(detail.wavelengths(most as u8) <= (most as u8).max(1)));
    }),
    ("core gaze::detail::FaceRange::new", |[min, max, _]| {
        if let Ok(range) = FaceRange::new(min as u32, max as u32) {
            each_detail(|detail| {
                let faces = detail.faces(range);
                assert!((range.min()..=range.max()).contains(&faces), "{faces}");
            });
        }
    }),
    ("core scene::effects::EffectSet::from_bits", |[bits, ..]| {
        let set = EffectSet::from_bits(bits as u32);
        assert_eq!(set.bits() & !(bits as u32), 0);
        assert_eq!(set.names().count() as u32, set.bits().count_ones());
    }),
    ("core scene::format::Node::is_empty_lane", |[lane, ..]| {
        let node = |low, high| Node::<8> {
            planes: [low, high, low, high, low, high].map(|plane| [plane; 8]),
            child: [0; 8],
            order: [0; 8],
        };
        let empty = node(f32::INFINITY, f32::NEG_INFINITY);
        assert_eq!(empty.is_empty_lane(lane as usize), lane < 8);
        assert!(!node(0.0, 1.0).is_empty_lane(lane as usize));
    }),
    ("core scene::format::Node::order", |[octant, ..]| {
        let node = Node::<8> {
            planes: [[0.0; 8]; 6],
            child: [0; 8],
            order: [7; 8],
        };
        assert_eq!(node.order(octant as usize), 7);
        let node = Node::<4> {
            planes: [[0.0; 4]; 6],
            child: [0; 4],
            order: [0x7_0007; 4],
        };
        assert_eq!(node.order(octant as usize) & 0xffff, 7);
    }),
    (
        "core spectrum::table::SpectralTable::samples",
        |[phases, ..]| {
            let samples = SpectralTable::samples(visible(), phases as u32);
            assert!(samples as u64 >= u64::from(phases as u32).min(usize::MAX as u64));
        },
    ),
    (
        "core spectrum::table::SpectralTable::new",
        |[phases, ..]| {
            let mut storage = [SpectralSample::default(); 64];
            let made = SpectralTable::new(visible(), phases as u32, Matching::Wyman, &mut storage);
            assert_eq!(made.is_ok(), [1, 2, 4, 8].contains(&(phases as u32)));
        },
    ),
    (
        "core spectrum::table::SpectralTable::offset",
        |[phase, ..]| {
            of_a_table(|table| assert!((0.0..1.0).contains(&table.offset(phase as u32))));
        },
    ),
    (
        "core spectrum::table::SpectralTable::phase",
        |[phase, ..]| {
            of_a_table(|table| assert_eq!(table.phase(phase as u32).len(), 5));
        },
    ),
    (
        "core spectrum::table::SpectralTable::broad",
        |[phase, ..]| {
            of_a_table(|table| assert_eq!(table.broad(phase as u32).len(), SpectralTable::BROAD));
        },
    ),
    (
        "core spectrum::table::SpectralTable::sample",
        |[phase, k, _]| {
            of_a_table(|table| {
                let sample = table.sample(phase as u32, k as usize);
                assert!(sample.nm == 0.0 || (400.0..=700.0).contains(&sample.nm));
            });
        },
    ),
    ("core spectrum::wavelengths::Wavelengths::at", |[k, ..]| {
        assert!((400.0..=700.0).contains(&visible().at(k as usize, 0.5)));
    }),
    ("core trace::budget::Budget::steps", |[steps, ..]| {
        let budget = Budget::steps(steps);
        assert_eq!((budget.left(), budget.is_spent()), (steps, steps == 0));
        assert!(!budget.is_exhausted());
    }),
    (
        "core trace::budget::Budget::with_overrun",
        |[steps, overrun, _]| {
            let budget = Budget::steps(steps).with_overrun(overrun);
            assert_eq!(budget.left(), steps);
            assert_eq!(budget.is_exhausted(), steps == 0 && overrun == 0);
            for view in every_view() {
                let (mut left, mut workspace) = (budget, Workspace::new());
                if let Some(ray) = view.ray(4.0, 4.0) {
                    tracer().radiance(&ray, &mut left, &mut workspace);
                }
                let spent = workspace.statistics.steps;
                assert!(spent <= steps.saturating_add(overrun), "{spent}");
            }
        },
    ),
    ("core trace::mesh::MeshTracer::new", |[mesh, ..]| {
        let scene = BAKED.scene();
        let made = MeshTracer::new(&scene, mesh as usize, Simd::detect());
        assert!(made.is_none() || mesh < 8);
    }),
    ("core trace::tile::TileRays::on_rung", |[rung, ..]| {
        let rays = rays().on_rung(rung as u8);
        let mut stack = TraversalStack::EMPTY.clone();
        let tracer = MeshTracer::new(&BAKED.scene(), 0, Simd::detect()).expect("a mesh");
        std::hint::black_box(tracer.nearest_of_tile(&rays, &mut stack));
    }),
    ("core trace::tile::TileRays::at", |[column, row, _]| {
        let found = rays().at(column as usize, row as usize);
        assert_eq!(found.is_some(), column < 8 && row < 8);
    }),
    ("core trace::tile::TileHits::at", |[column, row, _]| {
        let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
        let hits = tracer().nearest_of_tile(&rays(), &mut budget, &mut workspace);
        let inside = column < 8 && row < 8;
        assert!(hits.at(column as usize, row as usize).is_none() || inside);
    }),
    ("core trace::tracer::Tracer::new", |[depth, ..]| {
        sees(&Tracer::new(BAKED.scene(), Simd::detect(), depth as u8));
    }),
    ("core trace::tracer::Tracer::for_effects", |[depth, ..]| {
        const ALL: u32 = EffectSet::ALL.bits();
        let scene = BAKED.scene();
        sees(&Tracer::for_effects::<ALL>(
            scene,
            Simd::detect(),
            depth as u8,
        ));
    }),
    ("core trace::tracer::Tracer::at_rung", |[rung, ..]| {
        sees(&tracer().at_rung(rung as u8));
    }),
    ("tracker command::Script::speed", |[baud, ..]| {
        let mut script = Script::new();
        script.speed(baud as u32);
        let mut session = Session::new(script);
        assert_eq!(session.poll(Micros(0)), Action::Speed(baud as u32));
    }),
    ("tracker command::Session::on_bytes", |[count, often, _]| {
        let mut session = Session::new(hatire::start(false));
        for _ in 0..3 {
            session.on_bytes(count as usize);
            std::hint::black_box(session.poll(Micros(often)));
        }
    }),
    (
        "tracker command::watch::Watch::on_bytes",
        |[count, now, then]| {
            let mut watch = Watch::new();
            for now in [now, then, now] {
                watch.on_bytes(count as usize, Micros(now));
                std::hint::black_box(watch.trouble(Micros(then)));
            }
        },
    ),
    ("tracker eye::adhawk::result_name", |[result, ..]| {
        assert!(says(adhawk::result_name(result as u32)));
    }),
    (
        "tracker eye::adhawk::encode::encode_response",
        |[number, kind, result]| {
            let data = [0; 300];
            for data in [&data[..], &[]] {
                let packet = adhawk::encode_response(number as u16, kind as u8, result as u8, data);
                assert!(!packet.is_empty());
            }
        },
    ),
    ("tracker head::fastrak::change_speed", |[baud, ..]| {
        if let Some(script) = fastrak::change_speed(baud as u32) {
            assert!(script.is_complete() && script.says_anything());
        }
    }),
    ("tracker head::fastrak::fault_meaning", |[letter, ..]| {
        assert!(says(fastrak::fault_meaning(letter as u8)));
    }),
    (
        "tracker head::flock::command::Config::start",
        |[first, birds, reset]| {
            let config = flock::Config::default();
            let script = config.start(first as u8, birds as u8, reset & 1 == 1);
            assert!(script.is_complete() && script.says_anything());
        },
    ),
    (
        "tracker head::flock::command::error_meaning",
        |[code, ..]| {
            assert!(says(flock::error_meaning(code as u8)));
        },
    ),
    ("tracker head::hatire::error_meaning", |[code, ..]| {
        assert!(says(hatire::error_meaning(code as u16)));
    }),
    ("tracker head::fastrak::error_meaning", |[code, ..]| {
        assert!(says(fastrak::error_meaning(code as u32)));
    }),
    (
        "tracker head::polhemus::ItemList::command",
        |[station, ..]| {
            for family in [Family::Fastrak, Family::Liberty] {
                let command = items(family).command(station as u8);
                assert!(command.starts_with(format!("O{}", station as u8).as_bytes()));
                assert_eq!(command.last(), Some(&b'\r'));
            }
        },
    ),
    ("tracker hid::descriptor::Reports::find", |[id, ..]| {
        let reports = descriptor::walk(&eye_tracker::documented::DESCRIPTOR, |_| {});
        let reports = reports.expect("a descriptor");
        for kind in [
            descriptor::ReportKind::Input,
            descriptor::ReportKind::Feature,
        ] {
            let found = reports.find(kind, id as u8);
            assert!(found.is_none_or(|found| found.report_id == id as u8));
        }
    }),
    (
        "tracker hid::eye_tracker::feature::status_name",
        |[status, ..]| {
            assert!(says(eye_tracker::status_name(status as u32)));
        },
    ),
    ("tracker link::start", |[hertz, some, _]| {
        let script = link::start((some & 1 == 1).then_some(hertz as u16));
        assert!(script.is_complete() && script.says_anything());
    }),
    (
        "tracker mock::device::flock::Device::with_birds",
        |[first, birds, _]| {
            let protocol = Protocol::named("flock").expect("a Flock");
            std::hint::black_box(Device::new(&protocol).with_birds(first as u8, birds as u8));
        },
    ),
    (
        "tracker mock::random::Random::new",
        |[seed, sequence, _]| {
            let mut random = Random32::new(seed, sequence);
            assert!((0.0..1.0).contains(&random.uniform()));
        },
    ),
    ("tracker sample::parts::Parts::from_bits", |[bits, ..]| {
        let found = Parts::from_bits(bits as u16);
        assert!(found.is_none_or(|found| found.bits() == bits as u16));
    }),
    ("tracker serial::Serial::open", |[baud, ..]| {
        assert!(Serial::open(NOWHERE, baud as u32).is_err());
    }),
    ("tracker time::Micros::from_millis", |[milliseconds, ..]| {
        let micros = Micros::from_millis(milliseconds);
        assert_eq!(micros, Micros(milliseconds.saturating_mul(1_000)));
    }),
    ("tracker time::DeviceTime::unwrapped", |[time, ..]| {
        std::hint::black_box(DeviceTime::unwrapped(time));
    }),
    ("tracker time::DeviceTime::micros_u32", |[time, ..]| {
        std::hint::black_box(DeviceTime::micros_u32(time as u32));
    }),
    ("tracker time::DeviceTime::millis_u32", |[time, ..]| {
        std::hint::black_box(DeviceTime::millis_u32(time as u32));
    }),
    ("tracker uart::drain", |[now, most, _]| {
        let mut wire = hatire::Hatire::new(hatire::Config::default());
        let read = uart::drain(
            &mut Port::default(),
            &mut wire,
            Micros(now),
            most as usize,
            &mut |_| {},
        );
        assert_eq!(read, Ok(0));
    }),
    (
        "host dashboard::canvas::Canvas::new",
        |[width, height, _]| {
            let [width, height] = [width as u32, height as u32];
            if narrow(width, height) {
                let fits = [width, height].map(|pixels| pixels.min(Canvas::MOST));
                assert_eq!(Canvas::new(width, height).size(), fits);
            }
        },
    ),
    ("host dashboard::canvas::Canvas::pixel", |[x, y, _]| {
        let canvas = Canvas::new(8, 8);
        assert_eq!(
            canvas.pixel(x as u32, y as u32).is_some(),
            (x as u32).max(y as u32) < 8
        );
    }),
    ("host dashboard::canvas::Canvas::set", |[x, y, colour]| {
        let mut canvas = Canvas::new(8, 8);
        canvas.set(x as u32, y as u32, colour as u32);
        let found = canvas.pixel(x as u32, y as u32);
        assert!(found.is_none_or(|found| found == colour as u32));
    }),
    ("host dashboard::canvas::Canvas::write", |[x, y, colour]| {
        let end = Canvas::new(8, 8).write(x as u32, y as u32, "left", colour as u32);
        assert!(end >= x as u32);
    }),
    ("host dashboard::place_map::PlaceMap::place", |[x, y, _]| {
        let cave = room();
        let net = Coordinates::new(&cave)
            .expect("coordinates")
            .net()
            .expect("a net");
        let [width, height] = net.size();
        let inside = (x as u32) < width && (y as u32) < height;
        assert_eq!(net.place(x as u32, y as u32).is_some(), inside);
    }),
    (
        "host dashboard::place_map::PlaceMap::fitted",
        |[width, height, colour]| {
            let [width, height] = [width as u32, height as u32];
            if !narrow(width, height) {
                return;
            }
            let cave = room();
            let net = Coordinates::new(&cave)
                .expect("coordinates")
                .net()
                .expect("a net");
            let fitted = net.fitted(width, height, colour as u32);
            let most = Canvas::MOST;
            assert_eq!(fitted.size(), [width.min(most), height.min(most)]);
        },
    ),
    ("host live::swap::Share::new", |[rank, ranks, _]| {
        let share = Share::new(rank as usize, ranks as usize);
        assert_eq!(share.is_some(), rank < ranks);
    }),
    (
        "host live::swap::Share::has",
        |[picture, pictures, ranks]| {
            for rank in [0, ranks / 2, ranks.saturating_sub(1)] {
                if let Some(share) = Share::new(rank as usize, ranks as usize) {
                    let has = share.has(picture as usize, pictures as usize);
                    assert!(!has || picture < pictures);
                    assert!(has || ranks != 1 || picture >= pictures);
                }
            }
        },
    ),
    ("host live::swap::cluster::Channels::new", |[ranks, ..]| {
        let ends = Channels::new(ranks as usize);
        assert_eq!(ends.len() as u64, ranks.min(Channels::MOST as u64));
    }),
    ("host lod::Coverage::new", |[depth, ..]| {
        let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).expect("a line");
        let lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        for view in every_view() {
            let coverage = Coverage::new(&view, &lod, depth as u8);
            assert!(coverage.mean_bounces <= f64::from(depth as u8));
        }
    }),
    ("host cave::Cave::built_in", |[width, height, _]| {
        let sizes = [width as u32, height as u32];
        for of in [BuiltInCave::ThreeWall, BuiltInCave::Cube] {
            std::hint::black_box(Cave::built_in(of, sizes).is_ok());
        }
    }),
    ("host cave::file::Cave::from_toml", |[width, height, _]| {
        let sizes = [width as u32, height as u32];
        let read = Cave::from_toml(WALLS, "a.toml", sizes);
        assert!(read.is_ok() || width.max(height) > 8 || sizes.contains(&0));
    }),
    ("host cave::file::Cave::load", |[width, height, _]| {
        assert!(Cave::load(Path::new(NOWHERE), [width as u32, height as u32]).is_err());
    }),
    ("host texture::Image::new", |[width, height, _]| {
        let made = Image::new(width as u32, height as u32, &[[1, 2, 3]; 16]);
        assert_eq!(
            made.is_some(),
            (width as u32).checked_mul(height as u32) == Some(16)
        );
    }),
    (
        "host simplify::PolygonLevels::largest_deviation",
        |[finest, next, last]| {
            let levels = PolygonLevels::new(4..=u32::MAX, 8).expect("levels");
            let deviation = levels.largest_deviation(&[finest as u32, next as u32, last as u32]);
            assert!(deviation.is_finite() && deviation >= 0.0, "{deviation}");
        },
    ),
    ("tracker protocol::Protocol::change_speed", |[baud, ..]| {
        for name in ["fastrak", "flock", "hatire"] {
            let protocol = Protocol::named(name).expect("a protocol");
            let script = protocol.change_speed(baud as u32);
            assert!(script.is_none_or(|script| script.is_complete()));
        }
    }),
    ("host picture::Picture::new", |[width, height, _]| {
        let [width, height] = [width as u32, height as u32];
        let small = u64::from(width) * u64::from(height) < 1 << 22;
        // A large one may be had, and takes long.
        if small || width.max(height) == u32::MAX {
            assert_eq!(Picture::new(width, height).is_ok(), small);
        }
    }),
    ("host picture::Picture::rows_mut", |[rows, ..]| {
        let mut picture = Picture::new(3, 5).expect("a picture");
        let pixels: usize = picture.rows_mut(rows as u32).map(|rows| rows.len()).sum();
        assert_eq!(pixels, 15);
    }),
    ("host picture::Picture::pixel", |[x, y, _]| {
        let picture = Picture::new(3, 5).expect("a picture");
        let inside = (x as u32) < 3 && (y as u32) < 5;
        assert_eq!(picture.pixel(x as u32, y as u32).is_some(), inside);
    }),
    (
        "host scene::camera::CameraPath::camera",
        |[frame, key, _]| {
            let camera = DomeCamera::tilted(glam::DVec3::Y, 0.3);
            let keys = [0, key as u32].map(|frame| CameraKey { frame, camera });
            if let Ok(path) = CameraPath::new(keys.to_vec()) {
                assert!(
                    path.camera(frame as u32)
                        .is_some_and(|camera| camera.is_usable())
                );
            }
        },
    ),
    ("host simplify::PolygonLevels::new", |[min, max, rungs]| {
        if let Ok(levels) = PolygonLevels::new(min as u32..=max as u32, rungs as u32) {
            let deviation = levels.largest_deviation(&[max as u32, min as u32]);
            assert!(deviation.is_finite() && deviation >= 0.0, "{deviation}");
        }
    }),
];

/// Words, or none.
fn says(meaning: &str) -> bool {
    meaning.is_ascii() && meaning.len() < 200
}

/// Four pictures, one of every kind of view.
fn of_four(check: impl Fn(&[Part<'_, '_, 8>])) {
    let renderer = renderer(Mode::Tile);
    check(&every_view().map(|view| Part {
        view,
        renderer: &renderer,
    }));
}

/// Small enough to be filled at once.
fn narrow(width: u32, height: u32) -> bool {
    let most = u64::from(Canvas::MOST);
    u64::from(width).min(most) * u64::from(height).min(most) <= 1 << 20
}

fn room() -> Cave {
    Cave::built_in(BuiltInCave::ThreeWall, [3; 2]).expect("a room")
}

fn visible() -> Wavelengths {
    Wavelengths::new(5, [400.0, 700.0]).expect("wavelengths")
}

fn of_a_table(check: impl Fn(SpectralTable<'_>)) {
    let mut storage = [SpectralSample::default(); 64];
    for phases in [1, 8] {
        let table = SpectralTable::new(visible(), phases, Matching::Wyman, &mut storage);
        check(table.expect("room for a table"));
    }
}

fn each_detail(check: impl Fn(Detail)) {
    for level in [1.0e-6, 0.34, 0.99, 1.0] {
        check(Detail::of_level(level).expect("a level"));
    }
}

fn rays() -> TileRays {
    TileRays::new(Vec3::ZERO, |column, row| {
        Vec3::new(column as f32 - 3.5, row as f32 - 3.5, -8.0)
    })
}

/// Light along a ray.
fn sees(tracer: &Tracer<'_>) {
    let ray = every_view()[0].ray(3.0, 3.0).expect("a ray");
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    super::numbers::finite(&tracer.radiance(&ray, &mut budget, &mut workspace));
}

/// What breaks counts and indices: none, borders of what there may be of something, and of
/// types.
const HOSTILE: [u64; 36] = [
    0,
    1,
    2,
    3,
    4,
    5,
    7,
    8,
    9,
    15,
    16,
    17,
    31,
    32,
    33,
    63,
    64,
    65,
    127,
    128,
    255,
    256,
    257,
    32_767,
    32_768,
    65_535,
    65_536,
    i32::MAX as u64,
    1 << 31,
    u32::MAX as u64 - 1,
    u32::MAX as u64,
    1 << 32,
    i64::MAX as u64,
    1 << 63,
    u64::MAX - 1,
    u64::MAX,
];

/// Gives a case each hostile number in all places and in each alone, and mixtures.
pub(super) fn torment((name, case): &(&str, Case), mixtures: usize) -> Result<(), String> {
    let mut given: Vec<[u64; 3]> = Vec::new();
    for number in HOSTILE {
        given.extend([[number; 3], [number, 4, 4], [4, number, 4], [4, 4, number]]);
    }
    let mut random = Random::new(7);
    for _ in 0..mixtures {
        given.push([(); 3].map(|()| HOSTILE[random.below(HOSTILE.len())]));
    }
    for numbers in given {
        if let Err(panic) = catch_unwind(|| case(numbers)) {
            return Err(format!("{name}: {}\n    of {numbers:?}", message(&*panic)));
        }
    }
    Ok(())
}
