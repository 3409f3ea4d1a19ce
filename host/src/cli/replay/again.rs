//! Renders the frames of a record again.

use super::report::{Against, Changed, Difference, Report, Unequal, Verified};
use super::what_if::WhatIf;
use super::{Arguments, Segment};
use crate::cli::play::{Change, Prepared, TimeArguments};
use crate::cli::prelude::*;
use crate::cli::run::files::Files;
use crate::live::{Cut, Engine, FrameBudget, Look, Observe, Quality, SessionError, Share};
use crate::picture::{Picture, colour_differences};
use crate::record::{RecordedFrame, Setup, WallHash, of_pictures, of_tiles};
use crate::render::{self, Observer};
use crate::scene::builtin::PaperScene;
use crate::show::stereo::Stereo;
use clap::Parser;
use shisen_core::Simd;
use shisen_core::gaze::Acuity;

/// An engine, and what puts the eyes of a look into a list.
type Seat<'a, 'e, 'o> = (&'a mut (dyn Engine + 'e), &'a mut Observe<'o>);

/// How frames are rendered a second time.
pub(super) enum Other {
    /// By another code path.
    Device(Simd),
    /// As they would have been.
    WhatIf(WhatIf),
}

/// The options of `shisen run` that name files which a replay reads.
const FILES: [&str; 2] = ["--scene", "--mesh"];

/// The arguments of `shisen run`, as a record has them.
#[derive(Debug, Parser)]
struct Recorded {
    #[command(flatten)]
    run: crate::cli::run::Arguments,
}

/// Renders sessions.
pub(super) struct Again<'r> {
    arguments: &'r Arguments,
    other: Option<Other>,
    report: &'r mut Report,
    /// Sums for the means of what would have been.
    steps: [f64; 2],
}

/// What two renderings of a frame have.
struct Pair<'p> {
    setup: &'p Setup,
    prepared: &'p Prepared,
    eyes: &'p [Observer],
    pictures: [&'p [Picture]; 2],
}

impl<'r> Again<'r> {
    pub(super) fn new(
        arguments: &'r Arguments,
        other: Option<Other>,
        report: &'r mut Report,
    ) -> Result<Self, Failure> {
        if let Some(out) = &arguments.out {
            make_writable(out)?;
            if other.is_some() {
                make_writable(&out.join("other"))?;
            }
        }
        if let Some(folder) = &arguments.describe {
            make_writable(folder)?;
        }
        report.verified = arguments.verify.then(Verified::default);
        match other {
            Some(Other::Device(_)) => report.against = Some(Against::default()),
            Some(Other::WhatIf(_)) => report.what_if = Some(Changed::default()),
            None => {}
        }
        Ok(Self {
            arguments,
            other,
            report,
            steps: [0.0; 2],
        })
    }

    /// Renders the frames of a session that are asked for.
    pub(super) fn play(&mut self, segment: &Segment) -> Result<(), Failure> {
        let wants = |frame: &&RecordedFrame| self.arguments.wants(frame.number);
        let mut wanted: Vec<&RecordedFrame> = segment.frames.iter().filter(wants).collect();
        let fills = segment.setup.fill == "previous";
        if let (true, Some(broken)) = (fills, segment.broken_at) {
            let count = wanted.len();
            wanted.retain(|frame| frame.number < broken);
            self.report.damaged.baseless_frames += count - wanted.len();
        }
        let (Some(first), Some(last)) = (wanted.first(), wanted.last()) else {
            return Ok(());
        };
        if fills && self.arguments.describe.is_some() {
            return Err(misuse!(
                "these frames build on those before them, and a description is of one frame: record \
                 with --fill background"
            ));
        }
        let begin = match segment.frames.first() {
            Some(begin) if fills => begin.number,
            _ => first.number,
        };
        let frames = segment.frames.iter();
        let frames: Vec<&RecordedFrame> = frames
            .filter(|frame| (begin..=last.number).contains(&frame.number))
            .collect();
        let mut prepared = self.prepare(&segment.setup)?;
        if let Some(device) = self.arguments.device {
            prepared.options.simd = device.simd()?;
        }
        let second = self.second(&segment.setup)?;
        prepared.engage(Share::ALL, |engine, observe| {
            Ok(match &second {
                None => self.frames(segment, &prepared, &frames, (engine, observe), None),
                Some(second) => second
                    .engage(Share::ALL, |other, sees| {
                        let other = Some((other, sees));
                        Ok(self.frames(segment, &prepared, &frames, (engine, observe), other))
                    })
                    .and_then(|played| played),
            })
        })?
    }

    /// Returns what renders the frames a second time.
    fn second(&self, setup: &Setup) -> Result<Option<Prepared>, Failure> {
        let Some(other) = &self.other else {
            return Ok(None);
        };
        let mut second = self.prepare(setup)?;
        match other {
            Other::Device(simd) => second.options.simd = *simd,
            Other::WhatIf(WhatIf::Lod(choice)) => {
                let mut arguments = second.arguments.clone();
                let without;
                (arguments.lod, without) = arguments.lod.with(*choice);
                if !without.is_empty() {
                    let (without, lod) = (without.join(", "), arguments.lod.name());
                    say(&format!(
                        "--lod {lod} is rendered without {without} of the record"
                    ));
                }
                second = arguments.prepare(&TimeArguments::of(FrameBudget::Off))?;
                if let Some(threads) = self.arguments.threads {
                    second.options.threads = threads.get();
                }
            }
            Other::WhatIf(WhatIf::Gaze(_)) => second.arguments.lod.check_gaze()?,
            Other::WhatIf(WhatIf::Budget(_)) => {}
        }
        Ok(Some(second))
    }

    /// Returns the scene and the room of a session, as they were.
    fn prepare(&self, setup: &Setup) -> Result<Prepared, Failure> {
        let arguments = self.recorded(setup)?;
        let mut live = arguments.run.of_session(setup)?;
        for change in &setup.changes {
            live = live.changed(match change.strip_prefix("scene ") {
                Some(name) => Change::Scene(name.parse::<PaperScene>().or_fail()?),
                None => Change::Detail,
            });
        }
        if let Some(threads) = self.arguments.threads {
            live.tracing.set_threads(threads);
        }
        let mut prepared = live
            .prepare(&TimeArguments::of(FrameBudget::Off))
            .inspect_err(|_| {
                say(&format!(
                    "the record is of scene {}, {}; its files are looked for {}beside the record and \
                     here, and --scene FILE says where the scene is now",
                    setup.scene,
                    setup.scene_hash,
                    in_folder(setup)
                ));
            })?;
        prepared.options.tile = setup.tile;
        let found = hexadecimal(prepared.scene_hash());
        if found != setup.scene_hash {
            return Err(Fault::new(
                format!(
                    "the record is of scene {}, {}; what is here is {found}",
                    setup.scene, setup.scene_hash
                ),
                format!(
                    "give the scene as it was with --scene FILE{}, and take the version that \
                     recorded it ({})",
                    if setup.folder.is_empty() {
                        ""
                    } else {
                        ": it has changed since"
                    },
                    setup.program
                ),
            )
            .into());
        }
        Ok(prepared)
    }

    /// Reads the arguments of a session. Its files are looked for where it was recorded, then beside
    /// the record, then here.
    fn recorded(&self, setup: &Setup) -> Result<Recorded, Failure> {
        let words = setup.arguments.iter();
        let mut words: Vec<String> = words
            .flat_map(|word| match word.split_once('=') {
                Some((option, file)) if FILES.contains(&option) => vec![option, file],
                _ => vec![word.as_str()],
            })
            .map(str::to_owned)
            .collect();
        for at in 1..words.len() {
            let (word, option) = (Path::new(&words[at]), words[at - 1].as_str());
            let beside = self.arguments.file.parent();
            let folders = [Some(Path::new(&setup.folder)), beside];
            let mut files = folders
                .into_iter()
                .flatten()
                .map(|folder| folder.join(word));
            let found = files.find(|file| file.is_file());
            if let (true, Some(file)) = (FILES.contains(&option), found) {
                words[at] = file.display().to_string();
            }
        }
        if let Some(scene) = &self.arguments.scene {
            let scene = scene.display().to_string();
            let at = words.iter().position(|word| word == "--scene");
            match at.and_then(|at| words.get_mut(at + 1)) {
                Some(word) => *word = scene,
                None => words.extend(["--scene".to_owned(), scene]),
            }
        }
        Recorded::try_parse_from(&words).map_err(|error| {
            let first = error.to_string();
            let first = first.lines().next().unwrap_or_default().to_owned();
            let message = format!("the record's arguments cannot be read: {first}");
            let help = format!(
                "take version {} of the program, which recorded it",
                setup.program
            );
            Fault::new(message, help).into()
        })
    }

    fn frames(
        &mut self,
        segment: &Segment,
        prepared: &Prepared,
        frames: &[&RecordedFrame],
        (engine, observe): Seat<'_, '_, '_>,
        mut other: Option<Seat<'_, '_, '_>>,
    ) -> Result<(), Failure> {
        let setup = &segment.setup;
        let fills = setup.fill == "previous";
        let (mut eyes, mut other_eyes) = (Vec::new(), Vec::new());
        let (mut pictures, mut others) = (Vec::new(), Vec::new());
        let (mut tiles, mut walls) = (Vec::new(), Vec::new());
        for &frame in frames {
            let wanted = self.arguments.wants(frame.number);
            let begun = Instant::now();
            let steps = self.render(
                (setup, frame),
                &frame.look,
                ((&mut *engine, &mut *observe), &mut eyes),
                Some(&frame.cuts),
            )?;
            let shows = self.arguments.out.is_some() || other.is_some();
            if fills || wanted && shows {
                engine.pictures(&mut pictures, fills)?;
            }
            if wanted && self.report.verified.is_some() {
                if fills {
                    of_pictures(setup, &pictures, &mut walls);
                } else {
                    engine.tile_hashes(&mut tiles);
                    of_tiles(setup, &tiles, &mut walls);
                }
                self.verify(setup, frame, &walls, begun.elapsed());
            }
            if let Some((engine, observe)) = &mut other
                && (wanted || fills)
            {
                let (look, cuts) = match &self.other {
                    Some(Other::WhatIf(change)) => (change.look(&frame.look), None),
                    _ => (frame.look, Some(frame.cuts.as_slice())),
                };
                let parts = ((&mut **engine, &mut **observe), &mut other_eyes);
                let other_steps = self.render((setup, frame), &look, parts, cuts)?;
                engine.pictures(&mut others, fills)?;
                if wanted {
                    self.steps[0] += steps as f64;
                    self.steps[1] += other_steps as f64;
                    let (number, eyes) = (frame.number, &other_eyes);
                    self.write(prepared, number, &others, eyes, Some("other"))?;
                }
            }
            if !wanted {
                continue;
            }
            if let Some(folder) = &self.arguments.describe {
                let described = engine.describe(&eyes, &frame.cuts)?;
                describe(folder, frame, &described, prepared)?;
            }
            self.write(prepared, frame.number, &pictures, &eyes, None)?;
            if other.is_some() {
                let pair = Pair {
                    setup,
                    prepared,
                    eyes: &eyes,
                    pictures: [&pictures, &others],
                };
                self.compare(frame, &pair);
            }
        }
        Ok(())
    }

    /// Renders a frame; without cuts as `--what-if` has it. Returns its steps.
    fn render(
        &self,
        (setup, frame): (&Setup, &RecordedFrame),
        look: &Look,
        ((engine, observe), eyes): (Seat<'_, '_, '_>, &mut Vec<Observer>),
        cuts: Option<&[Cut]>,
    ) -> Result<u64, Failure> {
        let render = || -> Result<u64, SessionError> {
            observe(look, eyes);
            engine.set_time(frame.time)?;
            engine.set_place(&frame.place);
            // A frame that names none is not read.
            let quality = setup.rungs.get(frame.decision.rung);
            let quality = quality.unwrap_or(&Quality::FULL);
            let rendered = match (cuts, &self.other) {
                (Some(cuts), _) => engine.render_cut(eyes, quality, cuts)?,
                (None, Some(Other::WhatIf(WhatIf::Budget(Some(steps))))) => {
                    // A budget is dealt by what the frame before took.
                    engine.render(eyes, quality, None)?;
                    engine.render(eyes, quality, Some(*steps))?
                }
                (None, Some(Other::WhatIf(WhatIf::Budget(None)))) => {
                    engine.render(eyes, setup.rungs.first().unwrap_or(quality), None)?
                }
                (None, _) => engine.render(eyes, quality, None)?,
            };
            Ok(rendered.steps)
        };
        Ok({ render }()?)
    }

    fn verify(&mut self, setup: &Setup, frame: &RecordedFrame, walls: &[WallHash], took: Duration) {
        let Some(verified) = &mut self.report.verified else {
            return;
        };
        verified.frames += 1;
        verified.seconds += took.as_secs_f64();
        verified.equal += u64::from(frame.walls == walls);
        for ((is, was), picture) in walls.iter().zip(&frame.walls).zip(&setup.pictures) {
            if is == was {
                continue;
            }
            let mut rows = is.rows.iter().zip(&was.rows);
            let row = rows.position(|(is, was)| is != was);
            verified.differ(Difference {
                frame: frame.number,
                wall: picture.name.clone(),
                eye: picture.eye.clone(),
                row: row.map(|row| row as u32 * setup.tile),
            });
        }
    }

    fn write(
        &self,
        prepared: &Prepared,
        number: u64,
        pictures: &[Picture],
        eyes: &[Observer],
        folder: Option<&str>,
    ) -> Result<(), Failure> {
        let Some(out) = &self.arguments.out else {
            return Ok(());
        };
        let files = Files {
            folder: out.join(folder.unwrap_or_default()),
            stereo: if eyes.len() > 1 {
                Stereo::Sequential
            } else {
                Stereo::Mono
            },
            cave: prepared.cave.clone(),
            share: Share::ALL,
        };
        files.write(number, pictures, eyes)
    }

    /// Compares two renderings of a frame.
    fn compare(&mut self, frame: &RecordedFrame, pair: &Pair<'_>) {
        let [ones, others] = pair.pictures;
        if let Some(against) = &mut self.report.against {
            against.frames += 1;
            let unequal = pair.setup.pictures.iter().zip(ones.iter().zip(others));
            let unequal = unequal.filter_map(|(picture, (one, other))| {
                let pixels = one.core_pixels().iter().zip(other.core_pixels());
                let bits = |pixel: &shisen_core::frame::Pixel| {
                    [pixel.red, pixel.green, pixel.blue, pixel.alpha].map(f32::to_bits)
                };
                let at = { pixels }.position(|(one, other)| bits(one) != bits(other))?;
                let [x, y] = [at as u32 % one.width, at as u32 / one.width];
                Some(Unequal {
                    frame: frame.number,
                    wall: picture.name.clone(),
                    eye: picture.eye.clone(),
                    pixel: [x, y],
                    one: one.pixel(x, y)?,
                    other: other.pixel(x, y)?,
                })
            });
            let first = { unequal }.next();
            against.equal += u64::from(first.is_none());
            against.first = against.first.take().or(first);
        }
        if let Some(changed) = &mut self.report.what_if {
            let [mut sum, mut seen, mut weights, mut count] = [0.0; 4];
            let eyes = pair.prepared.cave.pictured().flat_map(|pictured| {
                let eyes = pair.eyes.iter();
                eyes.map(move |eye| render::view(pictured, eye))
            });
            for (view, (one, other)) in eyes.zip(ones.iter().zip(others)) {
                let Ok(view) = view else {
                    continue;
                };
                let width = one.width.max(1);
                for (at, apart) in (0..).zip(colour_differences(one, other)) {
                    let (x, y) = (at % width, at / width);
                    let towards = view.direction(x as f32, y as f32);
                    let angle = towards.map_or(0.0, |to| to.angle_between(frame.look.forward));
                    let finest = Acuity::GUENTER.fovea() / Acuity::GUENTER.least_angle(angle);
                    let weight = f64::from(finest);
                    let apart = f64::from(apart);
                    sum += apart;
                    count += 1.0;
                    seen += weight * apart;
                    weights += weight;
                    changed.largest = changed.largest.max(apart);
                }
            }
            let before = changed.frames as f64;
            changed.frames += 1;
            changed.cut_frames += u64::from(!frame.cuts.is_empty());
            let mean = |old: f64, new: f64| (old * before + new) / (before + 1.0);
            changed.mean_difference = mean(changed.mean_difference, sum / f64::max(count, 1.0));
            changed.seen_difference = mean(changed.seen_difference, seen / f64::max(weights, 1e-9));
            changed.steps = self.steps[1] / self.steps[0].max(1.0);
        }
    }
}

/// Returns where a session was recorded, for a list of folders.
fn in_folder(setup: &Setup) -> String {
    if setup.folder.is_empty() {
        String::new()
    } else {
        format!("in {}, ", setup.folder)
    }
}

/// Writes the description of a frame, the hashes of its pictures, and the scene.
fn describe(
    folder: &Path,
    frame: &RecordedFrame,
    described: &[u8],
    prepared: &Prepared,
) -> Result<(), Fault> {
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(Fault::write(&path))
    };
    let hashes = frame.walls.iter().enumerate();
    let mut hashes: Vec<String> = hashes
        .map(|(picture, wall)| format!("{picture} {}", hexadecimal(wall.hash)))
        .collect();
    hashes.push(String::new());
    write(&format!("{:06}.frame", frame.number), described)?;
    write(
        &format!("{:06}.hashes", frame.number),
        hashes.join("\n").as_bytes(),
    )?;
    write("scene.shisen", prepared.scene_bytes())
}
