//! A table of targets and when the viewer looks at them.
//!
//! ```csv
//! start_s,end_s,x,y,z
//! 1.0,3.0,-0.3,0.2,-1.0
//! 3.0,5.0, 0.3,0.2,-1.0
//! ```
//!
//! Times are seconds on the recording's clock (its `arrival_us`), or since the
//! tracker was opened; places are metres in the room.

use crate::files::Fault;
use glam::Vec3;
use shisen_tracker::mock::ScriptedTarget;
use shisen_tracker::time::Micros;
use std::path::Path;

const COLUMNS: [&str; 5] = ["start_s", "end_s", "x", "y", "z"];

/// The latest time, seconds: a day.
const LATEST: f64 = 86_400.0;
/// The farthest place along each axis, metres.
const FARTHEST: f32 = 1_000.0;

/// A target and the time in which the viewer looks at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TimedTarget {
    pub(crate) start: Micros,
    pub(crate) end: Micros,
    /// The place of the target: metres, in the room.
    pub(crate) place: Vec3,
}

/// Reads a table.
pub(crate) fn read_script(path: &Path) -> Result<Vec<TimedTarget>, Fault> {
    let (shown, columns) = (path.display(), COLUMNS.join(","));
    let text = crate::files::read_text(path).map_err(|reason| {
        Fault::new(
            format!("cannot read the targets in {shown}: {reason}"),
            format!("give the path of a table with the columns {columns}"),
        )
    })?;
    let mut table = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let same = table.headers().is_ok_and(|found| found.iter().eq(COLUMNS));
    if !same {
        return Err(Fault::new(
            format!("{shown}: line 1 is not the header of a table of targets"),
            format!("its first line is {columns}"),
        ));
    }
    let mut targets: Vec<TimedTarget> = Vec::new();
    for (number, record) in table.records().enumerate() {
        let wrong = |what: String| {
            Fault::new(
                format!("{shown}: line {}: {what}", number + 2),
                format!(
                    "start and end are seconds from 0 to {LATEST}, each target's after those of \
                     the one before; x, y and z are metres in the room, within ±{FARTHEST}"
                ),
            )
        };
        let record = record.map_err(|error| wrong(error.to_string()))?;
        let target = target(&record).map_err(wrong)?;
        let last = targets.last().map_or(Micros(0), |last| last.end);
        if target.start < last {
            return Err(wrong("start_s is below end_s of the line before".into()));
        }
        targets.push(target);
    }
    if targets.is_empty() {
        let help = format!("add lines of {columns}");
        return Err(Fault::new(format!("{shown} holds no target"), help));
    }
    Ok(targets)
}

fn target(record: &csv::StringRecord) -> Result<TimedTarget, String> {
    let mut cells = record.iter().zip(COLUMNS);
    let mut next = |limits: std::ops::RangeInclusive<f64>| {
        let (text, name) = cells.next().unwrap_or(("", "the line"));
        let number = text.parse().ok().filter(|number| limits.contains(number));
        number.ok_or_else(|| format!("{name} is {text:?}"))
    };
    let times = [next(0.0..=LATEST)?, next(0.0..=LATEST)?];
    let [start, end] = times.map(|seconds| Micros((seconds * 1.0e6).round() as u64));
    if end <= start {
        return Err("end_s is not above start_s".into());
    }
    let far = f64::from(FARTHEST);
    let [x, y, z] = [next(-far..=far)?, next(-far..=far)?, next(-far..=far)?];
    let place = Vec3::new(x as f32, y as f32, z as f32);
    Ok(TimedTarget { start, end, place })
}

/// Returns the targets of the mock's viewer, whose head is at the origin.
pub(super) fn scripted(targets: &[TimedTarget]) -> Vec<ScriptedTarget> {
    let scripted = |target: &TimedTarget| ScriptedTarget {
        at: target.start,
        direction: target.place,
    };
    targets.iter().map(scripted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_and_slips_say_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("targets.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_script(&path)
        };
        let head = "start_s,end_s,x,y,z\n";
        let good = read(&format!("{head}1,2.5, 0.1,0.2,-1\n2.5,4,0,0,-2\n")).unwrap();
        assert_eq!(good.len(), 2);
        assert_eq!(good[0].end, Micros(2_500_000));
        assert_eq!(good[0].place, Vec3::new(0.1, 0.2, -1.0));
        assert_eq!(scripted(&good)[1].at, Micros(2_500_000));
        for (text, expected) in [
            ("a,b\n".to_owned(), "line 1"),
            (head.to_owned(), "no target"),
            (format!("{head}1,2,0,0\n"), "line 2"),
            (format!("{head}2,1,0,0,-1\n"), "end_s is not above"),
            (format!("{head}-1,1,0,0,-1\n"), "start_s is \"-1\""),
            (format!("{head}0,1,0,nan,-1\n"), "y is \"nan\""),
            (format!("{head}0,2,0,0,-1\n1,3,0,0,-1\n"), "line 3: start_s"),
        ] {
            let said = read(&text).unwrap_err().to_string();
            assert!(said.contains(expected), "{text:?}: {said}");
        }
        let said = read_script(&folder.path().join("none")).unwrap_err();
        assert!(said.to_string().contains("none"), "{said}");
    }
}
