//! `shisen tracker doctor`: how well a tracker does, and what to set.

use super::TrackerName;
use super::drops::{by_reason, in_words};
use super::follow::{EndArguments, follow};
use crate::cli::arguments::span;
use crate::cli::prelude::*;
use crate::live::quantiles::quantile_of;
use crate::tracker::{Feed, Intake, Role, Senses, Spec, TrackerEvent, TrackerKind, dropped_since};
use shisen_tracker::clock::{ClockEstimator, ClockEvent, StampSource};
use shisen_tracker::decoder::{Counts, Event};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::collections::BTreeMap;

/// Listens to a tracker, and says what is wrong and what to set
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// The tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// How long to listen
    #[arg(long, value_name = "S", default_value = "10", value_parser = span)]
    seconds: Duration,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// How well a tracker does.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Samples of the head that the SPEC names, or of all sensors.
    samples: u64,
    /// Samples of each sensor.
    sensors: BTreeMap<u8, u64>,
    /// Samples a second, of the sensor with most.
    rate_hz: f64,
    /// Time from one sample of it to the next, milliseconds: median, 99 % and longest.
    interval_ms: [f64; 3],
    /// Where times come from: device, arrival, or mixed.
    times: &'static str,
    /// Time from the measurement to the arrival, as far as it is known, milliseconds: median and
    /// 99 %.
    delay_ms: [f64; 2],
    /// How the least delay is known: measured by an exchange with the device, given, or unknown.
    least_delay: &'static str,
    /// How much faster the device's clock runs, parts per million; null in less than four seconds
    /// and without a clock.
    drift_ppm: Option<f64>,
    /// Jumps, wrong times and standstills of the device's clock.
    clock_events: u64,
    /// Samples lost, by the device's count.
    lost: u64,
    /// Drops of bytes by reason.
    dropped_by: BTreeMap<&'static str, u32>,
    /// Share of samples with a tracked head, and with a tracked gaze, 0 to 1.
    tracked_head: f64,
    /// Share of samples with a tracked gaze, 0 to 1.
    tracked_gaze: f64,
    /// Share of samples that are the same as the one before, 0 to 1.
    repeated: f64,
    /// What is wrong, each with what to do.
    findings: Vec<String>,
}

const UNKNOWN: &str = "unknown";

/// What was heard so far.
struct Heard {
    sensors: BTreeMap<u8, u64>,
    /// The newest sample of each sensor.
    newest: BTreeMap<u8, Sample>,
    intervals: BTreeMap<u8, Vec<f64>>,
    delays: Vec<f64>,
    sources: BTreeMap<&'static str, u64>,
    clock_events: u64,
    is_measured: bool,
    head: u64,
    gaze: u64,
    repeated: u64,
    farthest: f32,
    drift: Option<i64>,
    /// Milliseconds since the newest sample.
    silent: f64,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let spec = arguments.spec.alone()?;
    let mut feed = Feed::open(spec)?;
    let clock = ClockEstimator::new(spec.clock()).or_fail()?;
    let mut intake = Intake::new(Role::All, clock, spec, None);
    let mut heard = Heard {
        sensors: BTreeMap::new(),
        newest: BTreeMap::new(),
        intervals: BTreeMap::new(),
        delays: Vec::new(),
        sources: BTreeMap::new(),
        clock_events: 0,
        is_measured: false,
        head: 0,
        gaze: 0,
        repeated: 0,
        farthest: 0.0,
        drift: None,
        silent: 0.0,
    };
    let seconds = arguments.seconds.as_secs_f64();
    say(&format!("listening for {seconds} s"));
    let end = EndArguments {
        frames: None,
        seconds: Some(arguments.seconds),
    };
    let followed = follow(&mut feed, &end, None, &mut |_, said| {
        if let Some((at, offset)) = said.offset {
            intake.set_offset(at, offset);
            heard.is_measured = true;
        }
        for event in &said.events {
            if let Event::Sample(sample) = event {
                heard.take(sample, spec, &mut intake);
            }
        }
        Ok(true)
    });
    heard.drift = intake.rate();
    let report = heard.report(&feed, spec);
    // Without any sample there is only why.
    if report.samples > 0 || !report.findings.is_empty() {
        print(&report, arguments.json)?;
    }
    followed
}

impl Heard {
    fn take(&mut self, sample: &Sample, spec: &Spec, intake: &mut Intake) {
        *self.sensors.entry(sample.sensor).or_default() += 1;
        if spec.head.is_some_and(|head| head != sample.sensor) {
            return;
        }
        let clock_events = &mut self.clock_events;
        let stamp = intake.stamp(sample, &mut |event| {
            let is_good = matches!(event, TrackerEvent::Clock(ClockEvent::Thawed { .. }, _));
            *clock_events += u64::from(!is_good);
        });
        let source = match stamp.source {
            StampSource::Arrival => "arrival",
            _ => "device",
        };
        *self.sources.entry(source).or_default() += 1;
        self.delays
            .push(milliseconds(sample.arrival.since(stamp.time)));
        let before = self.newest.insert(sample.sensor, *sample);
        if let Some(before) = before {
            let interval = milliseconds(sample.arrival.since(before.arrival));
            self.intervals
                .entry(sample.sensor)
                .or_default()
                .push(interval);
            let same = Sample {
                arrival: before.arrival,
                device_time: before.device_time,
                sequence: before.sequence,
                ..*sample
            };
            self.repeated += u64::from(same == before);
        }
        let (head, eyes) = (
            &sample.head,
            [&sample.left, &sample.right, &sample.combined],
        );
        let place = head.position.filter(|one| one.tracked);
        let is_turned = head.orientation.is_some_and(|one| one.tracked);
        self.head += u64::from(place.is_some() || is_turned);
        self.farthest = self
            .farthest
            .max(place.map_or(0.0, |one| one.value.length()));
        let looks = eyes
            .iter()
            .any(|eye| eye.direction.is_some_and(|one| one.tracked));
        self.gaze += u64::from(looks || sample.gaze_point.is_some_and(|one| one.tracked));
    }

    fn report(mut self, feed: &Feed, spec: &Spec) -> Report {
        let counts = feed.counts();
        let own = |sensor: &u8| spec.head.is_none_or(|head| head == *sensor);
        let all = self.sensors.iter().filter(|(sensor, _)| own(sensor));
        let samples: u64 = all.clone().map(|(_, count)| count).sum();
        let most = all.max_by_key(|(_, count)| **count);
        let main = most.map_or(0, |(sensor, _)| *sensor);
        let mut intervals = self.intervals.remove(&main).unwrap_or_default();
        let newest = self.newest.get(&main).filter(|_| feed.is_live());
        self.silent = newest.map_or(0.0, |newest| milliseconds(feed.now().since(newest.arrival)));
        // The last one is not over yet.
        intervals.push(self.silent);
        let quantile = |part| quantile_of(intervals.clone(), part);
        let spanned: f64 = intervals.iter().sum();
        let share = |count: u64| count as f64 / (samples as f64).max(1.0);
        let mut report = Report {
            samples,
            sensors: self.sensors.clone(),
            rate_hz: 1_000.0 * (intervals.len() - 1) as f64 / spanned.max(1.0e-3),
            interval_ms: [0.5, 0.99, 1.0].map(quantile),
            times: match self.sources.len() {
                1 => self.sources.keys().next().copied().unwrap_or("arrival"),
                _ => "mixed",
            },
            delay_ms: [0.5, 0.99].map(|part| quantile_of(self.delays.clone(), part)),
            least_delay: match spec.times.delay() {
                Some(_) => "given",
                None if self.is_measured => "measured",
                None => UNKNOWN,
            },
            drift_ppm: self.drift.map(|rate| -rate as f64 / 1_000.0),
            clock_events: self.clock_events,
            lost: counts.lost,
            dropped_by: by_reason(&counts),
            tracked_head: share(self.head),
            tracked_gaze: share(self.gaze),
            repeated: share(self.repeated),
            findings: Vec::new(),
        };
        report.findings = if samples == 0 {
            without_samples(&report, &counts, spec)
        } else {
            findings(&report, &self, feed.senses(spec), spec)
        };
        report
    }
}

fn milliseconds(span: Micros) -> f64 {
    span.0 as f64 / 1_000.0
}

/// Returns why there is no sample of what comes.
fn without_samples(report: &Report, counts: &Counts, spec: &Spec) -> Vec<String> {
    let why = dropped_since(&Counts::new(), counts);
    let mut all: Vec<String> = why.into_iter().collect();
    if let (Some(head), false) = (spec.head, report.sensors.is_empty()) {
        let there: Vec<String> = report.sensors.keys().map(u8::to_string).collect();
        all.push(format!(
            "sensor {head} sends nothing: take one of those that do, {}",
            there.join(", ")
        ));
    }
    all
}

/// Returns what is wrong, each with what to do.
fn findings(report: &Report, heard: &Heard, senses: Senses, spec: &Spec) -> Vec<String> {
    let mut all = Vec::new();
    let [median, tail, longest] = report.interval_ms;
    let percent = |share: f64| 100.0 * share;
    if heard.silent > 1_000.0 {
        let seconds = heard.silent / 1_000.0;
        all.push(format!(
            "nothing came in the last {seconds:.1} s: see that the device runs"
        ));
    }
    if report.sensors.len() > 1 && spec.head.is_none() {
        let sensors: Vec<String> = report.sensors.keys().map(u8::to_string).collect();
        all.push(format!(
            "the sensors {} send: the first that comes counts as the head; name it with head=N",
            sensors.join(", ")
        ));
    }
    if report.rate_hz < 55.0 {
        all.push(format!(
            "{:.0} samples a second are fewer than a display shows: set the device to 60 or more",
            report.rate_hz
        ));
    }
    if tail > 3.0 * median && tail > 10.0 {
        let why = match spec.kind {
            TrackerKind::Serial(_) => {
                "a USB adapter holds bytes back: set its latency timer to 1 ms"
            }
            TrackerKind::Net(_) => {
                "a sender that gathers samples, or Wi-Fi: let it send each at once, over a cable"
            }
            _ => "the device or its driver gathers samples: let it send each at once",
        };
        all.push(format!(
            "samples come unevenly, {median:.1} ms apart at the median and {tail:.1} ms at 99 % \
             ({why})"
        ));
    }
    if longest > 250.0 {
        all.push(format!(
            "for {longest:.0} ms no sample came: longer than a gaze is held; see that nothing \
             interrupts the line"
        ));
    }
    let lost = report.lost as f64 / (report.lost + report.samples).max(1) as f64;
    if lost > 1.0e-3 {
        all.push(format!(
            "{:.1} % of the samples were lost on the way: take a lower rate, a faster line or a cable",
            percent(lost)
        ));
    }
    if !report.dropped_by.is_empty() {
        let reasons = in_words(&report.dropped_by);
        all.push(format!(
            "bytes were dropped{reasons}: see that protocol, speed and settings are the device's"
        ));
    }
    if report.clock_events > 0 {
        all.push(format!(
            "the device's clock jumped, stood still or was wrong {} times: switch its time \
             synchronisation off, or restart it",
            report.clock_events
        ));
    }
    if let Some(drift) = report.drift_ppm.filter(|drift| drift.abs() > 200.0) {
        all.push(format!(
            "the device's clock runs {drift:.0} ppm fast: it is followed, but a good one stays within \
             100"
        ));
    }
    if senses.head && report.tracked_head < 0.95 {
        all.push(format!(
            "the head is tracked in {:.0} % of the samples: see that its markers are in view",
            percent(report.tracked_head)
        ));
    }
    if senses.eyes && report.tracked_gaze < 0.7 {
        all.push(format!(
            "a gaze is in {:.0} % of the samples: calibrate the eye tracker, and see that it finds \
             both eyes",
            percent(report.tracked_gaze)
        ));
    }
    if heard.farthest > 30.0 {
        all.push(format!(
            "the head is {:.0} m from the origin: the unit may be another than metres",
            heard.farthest
        ));
    }
    if report.repeated > 0.2 {
        all.push(format!(
            "{:.0} % of the samples repeat the one before: the device sends faster than it measures",
            percent(report.repeated)
        ));
    }
    all
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [median, tail, longest] = self.interval_ms;
        let (samples, rate) = (self.samples, self.rate_hz);
        writeln!(
            f,
            "{samples} samples, {rate:.1} a second: {median:.2} ms apart at the median, {tail:.2} ms \
             at 99 %, {longest:.2} ms at most"
        )?;
        let [delay, late] = self.delay_ms;
        writeln!(
            f,
            "times by {}; from measurement to arrival {delay:.2} ms at the median, {late:.2} ms at \
             99 % (least delay {}{})",
            self.times,
            self.least_delay,
            if self.least_delay == UNKNOWN {
                ": give delay=S, in seconds, if its maker or a photodiode says"
            } else {
                ""
            }
        )?;
        if let Some(drift) = self.drift_ppm {
            writeln!(f, "the device's clock runs {drift:.0} ppm fast")?;
        }
        let (head, gaze) = (100.0 * self.tracked_head, 100.0 * self.tracked_gaze);
        let (lost, reasons) = (self.lost, in_words(&self.dropped_by));
        write!(
            f,
            "head in {head:.0} % of them, gaze in {gaze:.0} %; lost {lost}, dropped {}{reasons}",
            self.dropped_by.values().sum::<u32>()
        )?;
        if self.findings.is_empty() {
            return f.write_str("\nnothing is wrong");
        }
        self.findings
            .iter()
            .try_for_each(|finding| write!(f, "\n- {finding}"))
    }
}
