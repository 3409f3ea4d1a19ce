//! `shisen replay`: the frames of a record again, checked, or as they would have been.

mod again;
pub(super) mod report;
mod what_if;

use crate::cli::prelude::*;
use crate::record::{Damage, Entry, Reader, RecordedFrame, Setup};
use again::{Again, Other};
use report::{Damaged, Decided, Report, Session};
use shisen_core::Simd;
use what_if::WhatIf;

/// Shows and checks the frames that run has recorded
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// File of `shisen run --record`
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The one frame N, counted from 0. With nothing else to do, what decided it is printed
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..),
          conflicts_with_all = ["from", "to"])]
    frame: Option<u64>,
    /// The first frame
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..))]
    from: Option<u64>,
    /// The last frame
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..))]
    to: Option<u64>,
    /// Render the frames again and compare their hashes with the record's
    #[arg(long)]
    verify: bool,
    /// Code path to render by [default: avx2 where the processor has it]
    #[arg(long, value_enum, value_name = "PATH")]
    device: Option<Device>,
    /// Render by this path, too, and show the first pixel that differs
    #[arg(long, value_enum, value_name = "PATH", conflicts_with = "what_if")]
    against: Option<Device>,
    /// Render frames as they would have been, too, and say how far they differ where the viewer
    /// looked: lod=off, paper, paper-ellipse or foveated, or gaze=RIGHT,UP in degrees, both whole, in
    /// the quality that the frames had; budget=off, in full quality; or budget=N, cut off after N steps
    #[arg(long, value_name = "CHANGE")]
    what_if: Option<WhatIf>,
    /// The scene, where it is not at the recorded path
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Threads to trace with [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = crate::cli::arguments::threads)]
    threads: Option<std::num::NonZeroUsize>,
    /// Folder for a picture of each frame's walls; made if it does not exist
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder for the scene, a description of each frame, which the core alone can render on a
    /// microcontroller, and the hashes of its pictures; made if it does not exist. It takes a record
    /// of `run --layout compact`
    #[arg(long, value_name = "DIR")]
    describe: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A code path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Device {
    /// Without vectors
    Portable,
    /// Vectors of eight numbers
    Avx2,
}

impl Device {
    fn simd(self) -> Result<Simd, Failure> {
        let simd = match self {
            Self::Portable => Simd::PORTABLE,
            Self::Avx2 => Simd::detect(),
        };
        if self == Self::Avx2 && simd.name() == Simd::PORTABLE.name() {
            return Err(misuse!(
                "this processor has no AVX2: --device portable gives the same pixels"
            ));
        }
        Ok(simd)
    }
}

/// A session of a record.
struct Segment {
    setup: Setup,
    frames: Vec<RecordedFrame>,
    /// The first frame that was damaged.
    broken_at: Option<u64>,
}

impl Arguments {
    /// Returns whether a frame is among those that are asked for.
    fn wants(&self, number: u64) -> bool {
        let range = self.from.unwrap_or(0)..=self.to.unwrap_or(u64::MAX);
        self.frame.is_none_or(|frame| frame == number) && range.contains(&number)
    }

    /// Returns whether frames are rendered.
    fn renders(&self) -> bool {
        let shows = self.out.is_some()
            || self.describe.is_some()
            || self.against.is_some()
            || self.what_if.is_some();
        self.verify || shows
    }

    fn other(&self) -> Result<Option<Other>, Failure> {
        Ok(match (self.against, &self.what_if) {
            (Some(device), _) => {
                let own = self.device.map_or(Ok(Simd::detect()), Device::simd)?;
                let other = device.simd()?;
                if own.name() == other.name() {
                    return Err(misuse!(
                        "--against {0} and --device {0} are one path: nothing is compared",
                        own.name()
                    ));
                }
                Some(Other::Device(other))
            }
            (None, Some(change)) => Some(Other::WhatIf(*change)),
            (None, None) => None,
        })
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let bytes = std::fs::read(&arguments.file).map_err(|reason| {
        let message = format!("{}: {reason}", arguments.file.display());
        Fault::new(message, "give a file that `shisen run --record FILE` wrote")
    })?;
    let (segments, damaged) = read(&arguments.file, &bytes)?;
    let mut report = Report::new(&arguments.file, damaged);
    for segment in &segments {
        report
            .sessions
            .push(Session::of(&segment.setup, &segment.frames));
    }
    let all = || segments.iter().flat_map(|segment| &segment.frames);
    let wanted = all().filter(|frame| arguments.wants(frame.number)).count();
    let chooses = arguments
        .frame
        .or(arguments.from)
        .or(arguments.to)
        .is_some();
    let is_told_how =
        arguments.device.is_some() || arguments.scene.is_some() || arguments.threads.is_some();
    if !arguments.renders() && is_told_how {
        return Err(misuse!(
            "say what to do with the frames: --verify, --out, --against, --what-if or --describe"
        ));
    }
    if wanted == 0 && !report.damaged.is_altered() && (arguments.renders() || chooses) {
        let last = all().last().map_or(0, |frame| frame.number);
        return Err(match all().next() {
            Some(_) => misuse!("the record has frames 0 to {last}, and none of those"),
            None => misuse!("the record has no frames: record again with `shisen run --record`"),
        });
    }
    let has_wanted = |segment: &&Segment| segment.frames.iter().any(|f| arguments.wants(f.number));
    if arguments.describe.is_some() && segments.iter().filter(has_wanted).count() > 1 {
        return Err(misuse!(
            "these frames are of several sessions, and a folder has one scene: choose those of one \
             with --from and --to"
        ));
    }
    if !arguments.renders() && chooses {
        let wanted = all().filter(|frame| arguments.wants(frame.number));
        report.frames.extend(wanted.map(Decided::of));
    }
    if arguments.renders() {
        let other = arguments.other()?;
        let mut again = Again::new(arguments, other, &mut report)?;
        for segment in &segments {
            again.play(segment)?;
        }
    }
    print(&report, arguments.json)?;
    for folder in [&arguments.out, &arguments.describe].into_iter().flatten() {
        say(&format!("the frames are in {}", folder.display()));
    }
    match report.fault() {
        None => Ok(()),
        Some(what) => {
            let help = "record it again, or compare the versions of program and scene";
            Err(Fault::new(what, help).into())
        }
    }
}

/// Reads a record as far as it can be read.
fn read(path: &Path, bytes: &[u8]) -> Result<(Vec<Segment>, Damaged), Failure> {
    let mut reader = Reader::new(path, bytes)?;
    let (mut segments, mut damaged) = (Vec::<Segment>::new(), Damaged::default());
    while let Some(entry) = reader.entry() {
        match entry {
            Ok(Entry::Session(setup)) => segments.push(Segment {
                setup: *setup,
                frames: Vec::new(),
                broken_at: None,
            }),
            Ok(Entry::Frame(frame)) => {
                if let Some(segment) = segments.last_mut() {
                    segment.frames.push(*frame);
                }
            }
            Ok(Entry::Raw(..) | Entry::End) => {}
            Err(Damage::CutOff) => damaged.is_cut_off = true,
            Err(Damage::Frame(frame)) => {
                damaged.frames.push(frame);
                if let Some(segment) = segments.last_mut() {
                    segment.broken_at.get_or_insert(frame);
                }
            }
            Err(Damage::Other(frame)) => damaged.before.push(frame),
        }
    }
    damaged.rest_is_lost = reader.is_lost();
    Ok((segments, damaged))
}
