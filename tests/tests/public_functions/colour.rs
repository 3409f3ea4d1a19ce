//! Spectra and media.

use super::numbers::{Case, Numbers, finite, finite_or_error};
use glam::Vec3;
use shisen_core::spectrum::{
    Matching, MatchingTable, Medium, SpectralSample, SpectralTable, Wavelengths, rgb_from_xyz,
    xyz_from_rgb,
};

pub(super) const CASES: &[(&str, Case)] = &[
    ("core spectrum::matching::rgb_from_xyz", |n| {
        converts(n, rgb_from_xyz);
    }),
    ("core spectrum::matching::xyz_from_rgb", |n| {
        converts(n, xyz_from_rgb);
    }),
    ("core spectrum::matching::Matching::values", |n| {
        let nm = n.next(550.0);
        // Of the functions that are built in, whatever is asked.
        finite(&Matching::Wyman.values(nm));
        finite(&Matching::Endo.values(nm));
        let xyz = [n.vec3([0.1, 0.2, 0.3]), n.vec3([0.4, 0.5, 0.6])].map(|xyz| xyz.to_array());
        let table = MatchingTable {
            first_nm: n.next(500.0),
            step_nm: n.next(100.0),
            xyz: &xyz,
        };
        let values = Matching::Table(table).values(nm);
        if xyz.iter().flatten().all(|value| value.abs() <= 1.0e30) {
            finite(&values);
        }
    }),
    ("core spectrum::medium::Medium::form1", |n| {
        form(n, Medium::form1);
    }),
    ("core spectrum::medium::Medium::form2", |n| {
        form(n, Medium::form2);
    }),
    ("core spectrum::medium::Medium::index", |n| {
        let nm = n.next(550.0);
        for (name, medium) in Medium::NAMED {
            let index = medium.index(nm);
            assert!(index >= 1.0, "{name}: {index}");
        }
    }),
    ("core spectrum::medium::Medium::index_in", |n| {
        let nm = n.next(550.0);
        for (_, medium) in Medium::NAMED {
            finite_or_error(medium.index_in(nm));
        }
    }),
    ("core spectrum::medium::Medium::index_clamped", |n| {
        let nm = n.next(550.0);
        for (name, medium) in Medium::NAMED {
            let index = medium.index_clamped(nm);
            assert!(
                (1.0..=Medium::MOST_INDEX).contains(&index),
                "{name}: {index}"
            );
        }
    }),
    ("core spectrum::table::SpectralTable::samples", |n| {
        for count in [1, 7, 64] {
            let range = [n.next(400.0), n.next(700.0)];
            if let Ok(wavelengths) = Wavelengths::new(count, range) {
                assert!(SpectralTable::samples(wavelengths, 32) >= 32 * count as usize);
            }
        }
    }),
    ("core spectrum::table::SpectralTable::new", |n| {
        let range = [n.next(400.0), n.next(700.0)];
        let xyz = [n.vec3([0.1, 0.2, 0.3]), n.vec3([0.4, 0.5, 0.6])].map(|xyz| xyz.to_array());
        let own = MatchingTable {
            first_nm: n.next(400.0),
            step_nm: n.next(300.0),
            xyz: &xyz,
        };
        let Ok(wavelengths) = Wavelengths::new(5, range) else {
            return;
        };
        let mut storage = [SpectralSample::default(); 64];
        for matching in [Matching::Wyman, Matching::Endo, Matching::Table(own)] {
            let table = SpectralTable::new(wavelengths, 4, matching, &mut storage);
            let Some(table) = finite_or_error(table) else {
                continue;
            };
            for phase in [0, 3, 4, u32::MAX] {
                finite(&(table.offset(phase), table.phase(phase), table.broad(phase)));
                finite(&table.sample(phase, 4));
            }
        }
    }),
    ("core spectrum::wavelengths::Wavelengths::new", |n| {
        let range = [n.next(400.0), n.next(700.0)];
        for count in [0, 1, 64, 65, u32::MAX] {
            finite_or_error(Wavelengths::new(count, range));
        }
    }),
    ("core spectrum::wavelengths::Wavelengths::clamped_to", |n| {
        let wavelengths = Wavelengths::new(8, Wavelengths::RANGE).expect("a range");
        finite_or_error(wavelengths.clamped_to([n.next(420.0), n.next(600.0)]));
    }),
    ("core spectrum::wavelengths::Wavelengths::at", |n| {
        let offset = n.next(0.5);
        let wavelengths = Wavelengths::new(8, Wavelengths::RANGE).expect("a range");
        let [low, high] = wavelengths.range();
        for k in [0, 7, 8, usize::MAX] {
            let nm = wavelengths.at(k, offset);
            assert!((low..=high).contains(&nm), "{nm} nm");
        }
    }),
];

fn converts(n: &mut Numbers, convert: fn(Vec3) -> Vec3) {
    let converted = convert(n.vec3([0.1, 0.2, 0.3]));
    if n.within(1.0e30) {
        finite(&converted);
    }
}

type Form = fn([f32; 2], f32, &[[f32; 2]]) -> Result<Medium, shisen_core::spectrum::MediumError>;

/// A medium is known all over its range.
fn form(n: &mut Numbers, form: Form) {
    let range = [n.next(400.0), n.next(700.0)];
    let a = n.next(0.1);
    let terms = [[n.next(1.1), n.next(0.01)], [n.next(0.2), n.next(0.02)]];
    if let Some(medium) = finite_or_error(form(range, a, &terms)) {
        for step in 0..=16 {
            let part = step as f32 / 16.0;
            let nm = (range[0] + (range[1] - range[0]) * part).min(range[1]);
            let index = medium.index_in(nm).expect("a wavelength of its range");
            assert!((1.0..=Medium::MOST_INDEX).contains(&index), "{index}");
        }
        finite(&medium.abbe());
    }
}
