//! Whole frames: the same bits on every path through the tracer.
//!
//! There are two instruction sets: AVX2 where the processor has it, and portable code, which
//! compilers make SSE2 on x86-64. No program can choose one number at a time:
//! `tests/capi/run` builds the portable code without vectors, for x86-64 and for a Cortex-M7, and
//! compares the pixels, as `tests/firmware/run` does for a controller's frames.

use super::{Case, Effort, Errors};
use shisen::bake::{AnyScene, Baked};
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::render::{self, Frame, Observer, Options};
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, paper_scene, spheres};
use shisen::scene::quadruped::quadruped;
use shisen_core::Simd;
use shisen_core::frame::{Mode, Settings};

pub(super) const CASES: &[Case] = cases! {
    [WAYS, ONE, SUM]:
    "frame-on-every-path-mirrors", 0.0,
        |effort| every_way(&paper_scene(PaperScene::A, quadruped()).ok()?, effort),
        "scene A by AVX2 and by portable code (on x86-64 the compiler's SSE2), ray by ray and in \
         tiles of rays, trees 8 and 4 wide, on 1 to 16 threads";
    "frame-on-every-path-glass", 0.0, |effort| every_way(&spheres(), effort),
        "the same of balls of quartz, with dispersion";
};

const WAYS: &str = "ways of which a pixel differs in a bit";
const ONE: &str = "the frame ray by ray, portable, on one thread: its hash";
const SUM: &str = "not a frame of its own, but what threads usually share: the reference frame \
                   reduced to a quarter of its size, the 16 pixels of each summed up in f32 by \
                   threads that took shares of its rows; its ways are the numbers of threads alone";

/// Numbers of threads, some above the number of processors.
const THREADS: [usize; 6] = [1, 2, 3, 4, 7, 16];

fn every_way(scene: &Scene, effort: Effort) -> Option<Errors> {
    let fast = Baked::<8>::new(scene).ok()?;
    let compact = Baked::<4>::new(scene).ok()?;
    // Pixels a side of each of three walls.
    let side = effort.pick(24, 96);
    let reference = frame(fast.scene().into(), side, 1, Mode::Single, Simd::PORTABLE)?;
    let mut errors = Errors::new(0.0, 0.0);
    for threads in THREADS {
        for mode in [Mode::Single, Mode::Tile] {
            for simd in [Simd::PORTABLE, Simd::detect()] {
                for found in [
                    frame(fast.scene().into(), side, threads, mode, simd),
                    frame(compact.scene().into(), side, threads, mode, simd),
                ] {
                    let same = found.is_some_and(|found| found.hash() == reference.hash());
                    errors.ours += f64::from(u8::from(!same));
                }
            }
        }
        let same = reduced(&reference, threads) == reduced(&reference, 1);
        errors.naive += f64::from(u8::from(!same));
    }
    Some(errors)
}

fn frame(scene: AnyScene<'_>, side: u32, threads: usize, mode: Mode, simd: Simd) -> Option<Frame> {
    let room = Cave::built_in(BuiltInCave::ThreeWall, [side; 2]).ok()?;
    let eye = Observer::new(Eye::Centre, Viewer::default().eye(Eye::Centre));
    let options = Options {
        threads,
        simd,
        settings: Settings {
            mode,
            samples: 2,
            ..Settings::default()
        },
        ..Options::default()
    };
    render::cave(scene, &room, &[eye], &options, &|_, _| {}).ok()
}

/// Returns the bits of a frame at a quarter of its size, every pixel the mean of 16: threads take
/// rows in turn, and their sums for a pixel are added at the end.
fn reduced(frame: &Frame, threads: usize) -> Vec<u32> {
    let mut bits = Vec::new();
    for picture in frame.pictures.iter().map(|one| &one.picture) {
        let [width, height] = [picture.width, picture.height].map(|side| side as usize);
        let columns = width / 4;
        let mut found = vec![[0f32; 3]; threads * columns * (height / 4)];
        let (shares, rows) = (columns * (height / 4), picture.pixels.chunks_exact(width));
        for (y, row) in rows.enumerate().take(height / 4 * 4) {
            for (x, pixel) in row.iter().enumerate().take(columns * 4) {
                let sum = &mut found[y % threads * shares + y / 4 * columns + x / 4];
                *sum = [0, 1, 2].map(|channel| sum[channel] + pixel[channel]);
            }
        }
        for at in 0..shares {
            for channel in 0..3 {
                let sum: f32 = (0..threads)
                    .map(|thread| found[thread * shares + at][channel])
                    .sum();
                bits.push((sum / 16.0).to_bits());
            }
        }
    }
    bits
}
