//! The report as one page that needs nothing else: HTML, with charts as SVG and
//! pictures as PNG in it, and no script.

mod notes;

use super::records::plain;
use super::{Comparison, Point, Report, Section};
use crate::selftest::Row;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use notes::Room;
use shisen::cli::output::counted;
use shisen::picture::chart::{Axis, Chart, Line, Names, Note, is_drawable};
use std::fmt::Write as _;
use std::io;
use std::ops::Range;

/// Columns and rows of a chart; two stand side by side.
const CHART: [u32; 2] = [580, 400];

/// Returns the page.
///
/// # Errors
/// A chart that cannot be drawn, a picture that cannot be encoded.
pub(crate) fn html(report: &Report) -> io::Result<String> {
    let (mut choices, mut sections) = (String::new(), String::new());
    for section in &report.sections {
        // Writing to a string does not fail.
        let _ = writeln!(
            choices,
            "<tr><th scope=\"row\"><a href=\"#{}\">{}</a></th><td>{}</td></tr>",
            section.id,
            escaped(section.title),
            escaped(&section.choice),
        );
        write_section(&mut sections, section)?;
    }
    let build = &report.build;
    Ok(format!(
        include_str!("page.html"),
        style = include_str!("page.css"),
        run = ["The full run", "The short run"][usize::from(report.quick)],
        version = escaped(report.version),
        threads = counted(report.threads as u64, "thread"),
        simd = escaped(&report.simd),
        mesh = escaped(&report.mesh),
        time = time(report.seconds),
        profile = escaped(&build.profile),
        commit = escaped(build.commit.unwrap_or("not told")),
        features = escaped(&build.cpu_features.join(", ")),
        warning = if build.optimised { "" } else { UNOPTIMISED },
        choices = choices,
        sections = sections,
    ))
}

const UNOPTIMISED: &str = "<p><strong>This build is not optimised.</strong> Errors and steps are \
    those of any build, but its times are not: nothing is chosen by them.</p>\n";

fn write_section(page: &mut String, section: &Section) -> io::Result<()> {
    let _ = writeln!(
        page,
        "<section id=\"{}\">\n<h2>{}</h2>\n<p>{}</p>",
        section.id,
        escaped(section.title),
        escaped(&section.about),
    );
    for (number, comparison) in section.comparisons.iter().enumerate() {
        write_comparison(page, comparison)?;
        // The pictures belong to the first comparison.
        if number == 0 {
            write_pictures(page, section)?;
        }
    }
    if !section.hard_cases.is_empty() {
        write_hard_cases(page, &section.choice, &section.hard_cases);
    }
    page.push_str("</section>\n");
    Ok(())
}

fn write_comparison(page: &mut String, comparison: &Comparison) -> io::Result<()> {
    let _ = writeln!(
        page,
        "<h3>{}</h3>\n<p>{}</p>\n<p class=\"choice\">{}</p>",
        escaped(comparison.title),
        escaped(&comparison.about),
        escaped(&comparison.choice),
    );
    page.push_str("<div class=\"charts\">\n");
    for chart in charts_of(comparison).iter().chain(&comparison.charts) {
        let picture = chart.svg(CHART)?;
        let _ = writeln!(page, "<figure>{}</figure>", picture.trim());
    }
    page.push_str("</div>\n");
    write_points(page, comparison);
    Ok(())
}

const NUMBER: &str = " class=\"number\"";

/// Returns a cell of a table, `th` or `td`.
fn cell(tag: &str, attribute: &str, text: &str) -> String {
    format!("<{tag}{attribute}>{}</{tag}>", escaped(text))
}

/// Writes a table of cells; a row has its class.
fn write_table(page: &mut String, class: &str, head: &[String], rows: &[(&str, Vec<String>)]) {
    let _ = writeln!(
        page,
        "<div class=\"wide\"><table{class}>\n<thead><tr>{}</tr></thead>\n<tbody>",
        head.concat()
    );
    for (class, cells) in rows {
        let _ = writeln!(page, "<tr{class}>{}</tr>", cells.concat());
    }
    page.push_str("</tbody>\n</table></div>");
}

fn write_points(page: &mut String, comparison: &Comparison) {
    let points = &comparison.points;
    let has_steps = points.iter().any(|point| point.steps.is_some());
    let has_series = points.iter().any(|point| point.series != points[0].series);
    let mut head = vec![cell("th", "", "")];
    head.extend(has_series.then(|| cell("th", "", "Series")));
    head.push(cell("th", "", "Setting"));
    head.push(cell("th", NUMBER, "Time, ms"));
    head.extend(has_steps.then(|| cell("th", NUMBER, "Steps")));
    let measures = comparison.measures.iter();
    head.extend(measures.map(|measure| cell("th", NUMBER, measure.label)));
    let row = |point: &Point| {
        let number = |text: String| cell("td", NUMBER, &text);
        let settings = point.settings.iter();
        let settings = settings.map(|(key, value)| format!("{key} {}", plain(value)));
        let settings = escaped(&settings.collect::<Vec<_>>().join(", "));
        let marks = [(point.best_by_time, "●"), (point.best_by_steps, "○")];
        let marks = marks.map(|(is_best, mark)| if is_best { mark } else { "" });
        let mut row = vec![cell("td", " class=\"best\"", &marks.concat())];
        row.extend(has_series.then(|| cell("td", "", point.series)));
        row.push(cell("td", &format!(" title=\"{settings}\""), &point.name));
        row.push(number(short(1e3 * point.seconds)));
        row.extend(has_steps.then(|| number(point.steps.map_or("–".to_owned(), grouped))));
        let errors = point.errors.iter();
        row.extend(errors.map(|error| number(error.map_or("–".to_owned(), short))));
        let classes = ["", " class=\"front\""];
        (classes[usize::from(point.best_by_time)], row)
    };
    page.push_str("<details open=\"\"><summary>Numbers</summary>\n");
    write_table(page, "", &head, &points.iter().map(row).collect::<Vec<_>>());
    page.push_str("</details>\n");
}

fn write_hard_cases(page: &mut String, choice: &str, cases: &[Row]) {
    let head = [
        ("", "Case"),
        ("", "What is hard"),
        (NUMBER, "Built in"),
        (NUMBER, "Bound"),
        (NUMBER, "Textbook"),
        ("", "Error"),
        ("", "Against"),
    ];
    let head = head.map(|(attribute, text)| cell("th", attribute, text));
    let row = |row: &Row| {
        let number = |error: f64, note: &str| {
            let wrong = || "wrong".to_owned();
            let text = Some(error)
                .filter(|error| error.is_finite())
                .map_or_else(wrong, short);
            cell("td", NUMBER, &(text + note))
        };
        let case = row.case;
        let naive = format!(" title=\"{}\"", escaped(case.naive));
        let cells = vec![
            cell("td", "", case.name),
            cell("td", "", case.hard),
            number(row.error, ""),
            number(case.bound, ""),
            number(
                row.naive_error,
                ["", " (control)"][usize::from(row.control)],
            ),
            cell("td", "", case.error),
            cell("td", &naive, case.reference),
        ];
        ([" class=\"failed\"", ""][usize::from(row.passed)], cells)
    };
    let _ = writeln!(page, "<p class=\"choice\">{}</p>", escaped(choice));
    let rows: Vec<_> = cases.iter().map(row).collect();
    write_table(page, " class=\"cases\"", &head, &rows);
    page.push('\n');
}

fn write_pictures(page: &mut String, section: &Section) -> io::Result<()> {
    if section.pictures.is_empty() {
        return Ok(());
    }
    page.push_str("<div class=\"pictures\">\n");
    for (caption, picture) in &section.pictures {
        let _ = writeln!(
            page,
            "<figure><img alt=\"{0}\" width=\"{1}\" height=\"{2}\" \
             src=\"data:image/png;base64,{3}\"/><figcaption>{0}</figcaption></figure>",
            escaped(caption),
            picture.width,
            picture.height,
            STANDARD.encode(picture.png_bytes()?),
        );
    }
    page.push_str("</div>\n");
    Ok(())
}

/// Error against time, and against steps where these are counted.
fn charts_of(comparison: &Comparison) -> Vec<Chart> {
    let by_time = |point: &Point| (Some(1e3 * point.seconds), point.best_by_time);
    let by_steps = |point: &Point| {
        let steps = point.steps.map(|steps| 1e-6 * steps as f64);
        (steps, point.best_by_steps)
    };
    let by_time = chart(comparison, ("seconds", "time, ms"), &by_time);
    let by_steps = chart(comparison, ("steps", "steps, millions"), &by_steps);
    [by_time, by_steps].into_iter().flatten().collect()
}

/// The most points that are all named.
const FEW: usize = 6;

/// Returns the points in the colours of their series, and their front; `None` where no point has a
/// cost.
// Longer than 80 lines: it sets each part of one drawing in turn.
fn chart(
    comparison: &Comparison,
    (name, label): (&'static str, &'static str),
    cost: &dyn Fn(&Point) -> (Option<f64>, bool),
) -> Option<Chart> {
    let measure = comparison.measures.first()?;
    let placed: Vec<(&Point, f64, f64, bool)> = comparison
        .points
        .iter()
        .filter_map(|point| {
            let (x, best) = cost(point);
            let error = point.error();
            Some((point, x.filter(|x| *x > 0.0)?, error, best)).filter(|_| error.is_finite())
        })
        .collect();
    let costs: Vec<f64> = placed.iter().map(|one| one.1).collect();
    let errors: Vec<f64> = placed.iter().map(|one| one.2).collect();
    let decades = spans_decades(&costs);
    let logarithmic = comparison.logarithmic && spans_decades(&errors);
    let (x, y) = (axis(&costs, decades)?, axis(&errors, logarithmic)?);
    // An error of 0 has no logarithm: it stands on the lower edge.
    let height = |error: f64| error.max(y.start);
    let mut front: Vec<(f64, f64)> = placed
        .iter()
        .filter(|one| one.3)
        .map(|one| (one.1, height(one.2)))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Between two points the front is a stair.
    let stairs = front
        .windows(2)
        .flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)])
        .chain(front.last().copied())
        .map(|(x, y)| (x, Some(y)));
    let mut lines = Vec::new();
    if front.len() > 1 {
        lines.push(Line {
            faint: true,
            ..Line::new("Pareto front", 6, stairs)
        });
    }
    let mut series: Vec<&str> = Vec::new();
    for (point, ..) in &placed {
        if !series.contains(&point.series) {
            series.push(point.series);
        }
    }
    for (colour, series) in series.into_iter().enumerate() {
        let own = placed.iter().filter(|one| one.0.series == series);
        let own = own.map(|one| (one.1, Some(height(one.2))));
        lines.push(Line {
            dots: true,
            ..Line::new(series, colour, own)
        });
    }
    let place = |cost: f64, error: f64| {
        let along = part(&x, cost, decades);
        (along, part(&y, height(error), logarithmic))
    };
    let places: Vec<(f64, f64)> = placed.iter().map(|one| place(one.1, one.2)).collect();
    // Names of the front first, and of the others where there are few.
    let few = placed.len() <= FEW;
    let named = |best: bool| {
        let all = placed.iter().zip(&places);
        all.filter(move |(one, _)| one.3 == best && (best || few))
    };
    let mut room = Room::new(&places);
    let notes = named(true)
        .chain(named(false))
        .filter_map(|((point, cost, error, _), place)| {
            Some(Note {
                side: room.take(*place, &point.name)?,
                at: (*cost, height(*error)),
                text: point.name.clone(),
            })
        })
        .collect();
    Some(Chart {
        title: format!(
            "{}: error and {}",
            comparison.title,
            name.replace("seconds", "time")
        ),
        x: Axis {
            logarithmic: decades,
            ..Axis::linear(name, label, x)
        },
        y: Axis {
            logarithmic,
            ..Axis::linear(measure.id, measure.label, y)
        },
        lines,
        names: Names::Below,
        notes,
    })
}

fn part(range: &Range<f64>, value: f64, logarithmic: bool) -> f64 {
    if logarithmic {
        libm::log(value / range.start) / libm::log(range.end / range.start)
    } else {
        (value - range.start) / (range.end - range.start)
    }
}

/// Returns whether numbers above 0 are far enough apart for ticks at powers of ten.
fn spans_decades(numbers: &[f64]) -> bool {
    let [least, most] = ends(numbers.iter().copied().filter(|number| *number > 0.0));
    most > 10.0 * least
}

fn ends(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers.fold(
        [f64::INFINITY, f64::NEG_INFINITY],
        |[least, most], number| [least.min(number), most.max(number)],
    )
}

/// Returns the range of numbers with room around them; `None` where none can be shown.
fn axis(numbers: &[f64], logarithmic: bool) -> Option<Range<f64>> {
    let shown = numbers.iter().copied();
    let [least, most] = ends(shown.filter(|number| !logarithmic || *number > 0.0));
    if !(least <= most) {
        return None;
    }
    let range = if logarithmic {
        let room = libm::pow((most / least).max(1.5), 0.12);
        least / room..most * room
    } else {
        let room = (most - least.min(0.0)).max(1e-9);
        least.min(0.0) - 0.04 * room..most + 0.12 * room
    };
    is_drawable(&range, logarithmic).then_some(range)
}

/// Returns three digits, and more before the point.
pub(super) fn short(number: f64) -> String {
    let size = number.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{number:.1e}");
    }
    let digits = (2 - libm::floor(libm::log10(size)) as i32).clamp(0, 6) as usize;
    format!("{number:.digits$}")
}

/// [`short`] without zeros at its end.
pub(super) fn brief(number: f64) -> String {
    let text = short(number);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

pub(super) fn time(seconds: f64) -> String {
    match seconds {
        60.0.. => format!(
            "{:.0} min {:02.0} s",
            libm::floor(seconds / 60.0),
            seconds % 60.0
        ),
        1.0.. => format!("{} s", short(seconds)),
        1e-3.. => format!("{} ms", short(1e3 * seconds)),
        _ => format!("{} µs", short(1e6 * seconds)),
    }
}

/// Returns a whole number in groups of three digits with thin spaces.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

/// Escapes a text and an attribute's value.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests;
