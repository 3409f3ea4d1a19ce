//! Links all of the driver that a display controller can need, and nothing else.
//!
//! It links only without a path to a panic: the panic handler calls a function that
//! does not exist. `tests/firmware/run` looks for doubles and an allocator.
#![no_std]
#![no_main]

use core::convert::Infallible;
use core::hint::black_box;
use cortex_m_rt::entry;
use embedded_hal::i2c::{self, I2c, Operation};
use embedded_io::{ErrorType, Read, ReadReady};
use shisen_firmware as _;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::command::{Session, Watch};
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::estimate::{Calibration, EstimatorConfig, GazeEstimator, Model, Target};
use shisen_tracker::eye::{adhawk, asl, iscan};
use shisen_tracker::head::polhemus::{Family, Format, ItemList};
use shisen_tracker::head::{fastrak, flock, hatire, liberty, osvr_hdk};
use shisen_tracker::hid::eye_tracker::{Axes, EyeTracker, Mode};
use shisen_tracker::i2c::{I2cHid, Interrupt};
use shisen_tracker::link;
use shisen_tracker::time::Micros;
use shisen_tracker::uart;

/// Returns bytes whose values the compiler cannot know.
#[inline(never)]
fn received() -> (&'static [u8], Micros) {
    black_box((&[], Micros(0)))
}

/// A serial port and a bus whose results the compiler cannot know.
struct Board;

impl ErrorType for Board {
    type Error = Infallible;
}

impl ReadReady for Board {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(black_box(false))
    }
}

impl Read for Board {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        Ok(black_box(buffer).len())
    }
}

impl i2c::ErrorType for Board {
    type Error = i2c::ErrorKind;
}

impl I2c for Board {
    #[inline(never)]
    fn transaction(
        &mut self,
        _: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), i2c::ErrorKind> {
        black_box(operations);
        black_box(Err(i2c::ErrorKind::Other))
    }
}

/// Uses a HID tracker on I²C, from power-on to its reports.
fn hid_over_i2c(buffer: &mut [u8], now: Micros) {
    let mut device = I2cHid::new(Board, 0x2c, black_box(1));
    let interrupt = black_box(Interrupt::Asserted);
    black_box(device.poll(now, interrupt, buffer).ok());
    black_box(device.input(buffer).ok());
    black_box(device.get_feature(black_box(1), black_box(9), buffer).ok());
    black_box(device.set_feature(black_box(1), received().0).ok());
    black_box(device.sleep().ok());
}

/// Keeps the compiler from optimising a result away.
fn ignore<T>(event: T) {
    black_box(event);
}

/// The clock and the estimator behind a decoder, the same for all devices.
struct Behind {
    clock: ClockEstimator,
    gaze: GazeEstimator,
    link: link::Encoder,
}

impl Behind {
    #[inline(never)]
    fn take(&mut self, event: &Event) {
        let sample = match event {
            Event::Sample(sample) => sample,
            Event::Message(message) => {
                return self.gaze.on_message(message, &mut ignore);
            }
            other => return ignore(other),
        };
        let stamp = self.clock.stamp(sample, &mut ignore);
        self.gaze.push(sample, stamp.time, &mut ignore);
        black_box(self.link.sample(sample));
    }

    #[inline(never)]
    fn show(&mut self, time: Micros) {
        black_box(self.gaze.estimate(time, &mut ignore));
    }
}

#[inline(never)]
fn from_uart(decoder: &mut dyn Decoder, now: Micros, behind: &mut Behind) {
    let mut sink = |event| behind.take(&event);
    black_box(uart::drain(&mut Board, decoder, now, black_box(64), &mut sink).ok());
}

#[inline(never)]
fn step(decoder: &mut dyn Decoder, session: &mut Session, watch: &mut Watch, behind: &mut Behind) {
    let (bytes, now) = received();
    from_uart(decoder, now, behind);
    session.on_bytes(bytes.len());
    watch.on_bytes(bytes.len(), now);
    decoder.feed(bytes, now, &mut |event| {
        session.on_event(&event);
        watch.on_event(&event, now);
        behind.take(&event);
    });
    black_box(session.poll(now));
    black_box(watch.trouble(now));
    behind.show(now);
}

fn run() -> Option<()> {
    let clock = ClockEstimator::new(black_box(ClockConfig::default())).ok()?;
    let targets: &[Target] = black_box(&[]);
    let mut config = black_box(EstimatorConfig::default());
    config.combined = Calibration::fit(black_box(Model::Affine), targets).ok();
    let mut behind = Behind {
        clock,
        gaze: GazeEstimator::new(config).ok()?,
        link: link::Encoder::new(),
    };
    let binary = black_box(Format::Binary);
    let items = ItemList::new(Family::Fastrak, binary, black_box(&[2, 11, 0])).ok()?;
    let fastrak = fastrak::Config::new(items);
    let items = ItemList::new(Family::Liberty, binary, black_box(&[2, 7, 8, 0])).ok()?;
    let liberty = liberty::Config::new(items);
    let flock = black_box(flock::Config::default());
    let hatire = black_box(hatire::Config::default());
    let mut tracker = EyeTracker::new(received().0, black_box(Axes::default())).ok()?;
    black_box(tracker.mode_request(black_box(Mode::ALL)));
    black_box(tracker.capabilities(received().0).ok());
    black_box(tracker.configuration(received().0).ok());
    black_box(tracker.status(received().0).ok());
    let scripts = [
        fastrak.start(black_box(false)),
        liberty.start(black_box(false)),
        flock.start(1, 1, black_box(false)),
        hatire::start(black_box(false)),
        iscan::start(),
        asl::start(),
        adhawk::start(black_box(3), 500.0),
        link::start(black_box(None)),
    ];
    let mut watch = Watch::new();
    hid_over_i2c(black_box(&mut [0; 64]), Micros(0));
    let decoders: [&mut dyn Decoder; 10] = [
        &mut fastrak::Fastrak::new(fastrak),
        &mut liberty::Liberty::new(liberty),
        &mut flock::Flock::new(flock),
        &mut hatire::Hatire::new(hatire),
        &mut iscan::Iscan::new(black_box(iscan::Config::default())),
        &mut asl::Asl::new(black_box(asl::Config::default())),
        &mut adhawk::AdHawk::new(),
        &mut link::Link::new(),
        &mut osvr_hdk::OsvrHdk::new(),
        &mut tracker,
    ];
    // The last two devices have no such commands: they get the first one's.
    let scripts = scripts.iter().cycle();
    for (decoder, script) in decoders.into_iter().zip(scripts) {
        let mut session = Session::new(script.clone());
        step(decoder, &mut session, &mut watch, &mut behind);
    }
    Some(())
}

#[entry]
fn main() -> ! {
    black_box(run());
    loop {
        cortex_m::asm::nop();
    }
}
