use super::*;
use crate::hid::eye_tracker::documented::DESCRIPTOR;
use hidreport::Report as _;
use proptest::prelude::*;
use std::vec::Vec as List;

/// An element: its report, its first bit and how many, its usage.
type Found = (ReportKind, u8, u32, u32, Option<Usage>);

/// Returns all elements.
fn elements(descriptor: &[u8]) -> Result<List<Found>, Problem> {
    let mut found = List::new();
    walk(descriptor, |e| {
        found.push((e.kind, e.report_id, e.bit_offset, e.bits, e.usage));
    })
    .map_err(|error| error.problem)?;
    Ok(found)
}

// All that it is compared with are optional.
#[allow(clippy::unnecessary_wraps)]
const fn usage(page: u16, id: u16) -> Option<Usage> {
    Some(Usage { page, id })
}

/// A boot mouse: three buttons, five bits of padding, x, y, wheel.
const MOUSE: [u8; 52] = [
    0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x01, 0xA1, 0x00, 0x05, 0x09, 0x19, 0x01, 0x29, 0x03,
    0x15, 0x00, 0x25, 0x01, 0x95, 0x03, 0x75, 0x01, 0x81, 0x02, 0x95, 0x01, 0x75, 0x05, 0x81, 0x01,
    0x05, 0x01, 0x09, 0x30, 0x09, 0x31, 0x09, 0x38, 0x15, 0x81, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x03,
    0x81, 0x06, 0xC0, 0xC0,
];

#[test]
fn descriptors_that_cannot_be_are_refused() {
    let problem = |bytes: &[u8]| walk(bytes, |_| ()).unwrap_err();
    // 65,535 times 4 GiB.
    let huge = problem(&[0x77, 0xFF, 0xFF, 0xFF, 0xFF, 0x96, 0xFF, 0xFF, 0x81, 0x02]);
    assert_eq!(huge.offset, 8);
    assert_eq!(huge.problem, Problem::ElementTooLarge { bits: u32::MAX });
    // 4 Gi values of 8 bits, and of 0.
    let many = problem(&[0x75, 0x08, 0x97, 0xFF, 0xFF, 0xFF, 0xFF, 0x81, 0x02]);
    let bits = 8 * u64::from(u32::MAX);
    assert_eq!(many.problem, Problem::ReportTooLarge { bits });
    let none = elements(&[0x75, 0x00, 0x97, 0xFF, 0xFF, 0xFF, 0xFF, 0x81, 0x02]);
    assert_eq!(none, Ok(List::new()));
    // Two times 20,000 bits.
    let twice = problem(&[0x75, 0x08, 0x96, 0xC4, 0x09, 0x81, 0x02, 0x81, 0x02]);
    assert_eq!(twice.problem, Problem::ReportTooLarge { bits: 40_000 });

    let of = |bytes: &[u8]| problem(bytes).problem;
    assert_eq!(of(&[0; 5_000]), Problem::TooLong { found: 5_000 });
    assert_eq!(of(&[0x27, 1, 2, 3]), Problem::Truncated);
    assert_eq!(of(&[0xFE, 9, 0, 1]), Problem::Truncated);
    assert_eq!(of(&[0xFE]), Problem::Truncated);
    assert_eq!(of(&[0x0C]), Problem::UnknownItem { prefix: 0x0C });
    assert_eq!(of(&[0xD0]), Problem::UnknownItem { prefix: 0xD0 });
    assert_eq!(of(&[0xC4]), Problem::UnknownItem { prefix: 0xC4 });
    assert_eq!(of(&[0xB8]), Problem::UnknownItem { prefix: 0xB8 });
    assert_eq!(of(&[0xA1, 0x01].repeat(17)), Problem::CollectionsTooDeep);
    assert_eq!(of(&[0xC0]), Problem::CollectionNotBegun);
    assert_eq!(
        of(&[0xA1, 1, 0xA1, 0]),
        Problem::CollectionNotEnded { open: 2 }
    );
    assert_eq!(of(&[0xA4; 9]), Problem::PushedTooMuch);
    assert_eq!(of(&[0xB4]), Problem::NothingPushed);
    assert_eq!(of(&[0x09, 0x01].repeat(65)), Problem::TooManyUsages);
    assert_eq!(of(&[0x29, 0x05]), Problem::UsageRange);
    assert_eq!(of(&[0x19, 0x05, 0x29, 0x04]), Problem::UsageRange);
    assert_eq!(of(&[0x19, 0x05, 0x81, 0x02]), Problem::UsageRange);
    assert_eq!(of(&[0x1B, 0, 0, 1, 0, 0x29, 0x04]), Problem::UsageRange);
    assert_eq!(of(&[0x85, 0x00]), Problem::ReportId { found: 0 });
    assert_eq!(of(&[0x86, 0x00, 0x01]), Problem::ReportId { found: 256 });
    let late = [0x75, 8, 0x95, 1, 0x81, 2, 0x85, 1, 0x81, 2];
    assert_eq!(of(&late), Problem::ReportIdMissing);
    let upside_down = [0x15, 5, 0x25, 4, 0x81, 2];
    let (minimum, maximum) = (5, 4);
    assert_eq!(of(&upside_down), Problem::LogicalRange { minimum, maximum });
    let mut ids = List::from([0x75, 8, 0x95, 1]);
    for id in 1..=33 {
        ids.extend([0x85, id, 0x81, 2]);
    }
    assert_eq!(of(&ids), Problem::TooManyReports);

    let text = std::format!("{huge}");
    assert_eq!(
        text,
        "HID report descriptor, byte 8: an element of 4294967295 bits, where 64 are the most"
    );
}

#[test]
fn usages_are_given_out_in_order() {
    for (descriptor, expected) in [
        // A state that is pushed and popped.
        (
            &[
                0x05, 0x12, 0x75, 8, 0x95, 1, 0xA4, 0x05, 0x01, 0x75, 16, 0x09, 0x30, 0x81, 2,
                0xB4, 0x09, 0x21, 0x81, 2,
            ][..],
            &[(0, 16, 1, 0x30), (16, 8, 0x12, 0x21)][..],
        ),
        // A range, one with a page of its own, the last one again and again; the page is set
        // after the usages.
        (
            &[
                0x19, 0x05, 0x29, 0x06, 0x0B, 0x30, 0x00, 0x01, 0x00, 0x09, 0x20, 0x05, 0x12, 0x75,
                4, 0x95, 5, 0x81, 2,
            ],
            &[
                (0, 4, 0x12, 5),
                (4, 4, 0x12, 6),
                (8, 4, 1, 0x30),
                (12, 4, 0x12, 0x20),
                (16, 4, 0x12, 0x20),
            ],
        ),
        // The first of alternatives.
        (
            &[
                0x05, 0x12, 0xA9, 1, 0x09, 0x21, 0x09, 0x22, 0xA9, 0, 0x09, 0x23, 0x75, 8, 0x95, 2,
                0x81, 2,
            ],
            &[(0, 8, 0x12, 0x21), (8, 8, 0x12, 0x23)],
        ),
    ] {
        let expected = expected
            .iter()
            .map(|&(offset, bits, page, id)| (ReportKind::Input, 0, offset, bits, usage(page, id)));
        assert!(expected.eq(elements(descriptor).unwrap()));
    }
}

#[test]
fn long_items_and_odd_exponents_are_read() {
    let exponent = |data: u8| {
        let mut found = None;
        walk(
            &[
                0xFE, 2, 0xF0, 0xC0, 0xC0, 0x55, data, 0x75, 8, 0x95, 1, 0x81, 2,
            ],
            |e| found = Some(e.unit_exponent),
        )
        .unwrap();
        found.unwrap()
    };
    assert_eq!(exponent(0x0C), -4);
    assert_eq!(exponent(0x08), -8);
    assert_eq!(exponent(0x07), 7);
    assert_eq!(exponent(0xFC), -4);
    assert_eq!(exponent(0x40), 7);
}

/// Returns the variable elements that are not constant, as `hidreport` has them.
fn theirs(descriptor: &[u8]) -> Option<List<Found>> {
    let parsed = hidreport::ReportDescriptor::try_from(descriptor).ok()?;
    let mut found = List::new();
    let mut add = |kind, id: u8, fields: &[hidreport::Field]| {
        for field in fields {
            if let hidreport::Field::Variable(field) = field {
                let usage = usage(field.usage.usage_page.into(), field.usage.usage_id.into());
                let id_bits = if id == 0 { 0 } else { 8 };
                let (start, bits) = (field.bits.start, field.bits.len());
                found.push((kind, id, (start - id_bits) as u32, bits as u32, usage));
            }
        }
    };
    let id = |id: &Option<hidreport::ReportId>| id.map_or(0, u8::from);
    for report in parsed.input_reports() {
        add(ReportKind::Input, id(report.report_id()), report.fields());
    }
    for report in parsed.output_reports() {
        add(ReportKind::Output, id(report.report_id()), report.fields());
    }
    for report in parsed.feature_reports() {
        add(ReportKind::Feature, id(report.report_id()), report.fields());
    }
    found.sort_by_key(|e| (e.0 as u8, e.1, e.2));
    Some(found)
}

fn ours(descriptor: &[u8]) -> List<Found> {
    let mut found = List::new();
    walk(descriptor, |e| {
        if e.flags & 3 == VARIABLE {
            found.push((e.kind, e.report_id, e.bit_offset, e.bits, e.usage));
        }
    })
    .unwrap();
    found.sort_by_key(|e| (e.0 as u8, e.1, e.2));
    found
}

#[test]
fn another_parser_agrees() {
    for descriptor in [&MOUSE[..], &DESCRIPTOR] {
        let theirs = theirs(descriptor).unwrap();
        assert!(theirs.len() >= 6);
        assert_eq!(ours(descriptor), theirs);
    }
}

/// Returns a main item with its usages, in a report, in a few collections.
fn main_item() -> impl Strategy<Value = List<u8>> {
    let flags = prop::sample::select(&[0x81_u8, 0x91, 0xB1][..]);
    let kind = prop::sample::select(&[0_u8, 1, 2, 3, 6][..]);
    (
        prop::collection::vec(1_u8..0x80, 1..4),
        any::<bool>(),
        1_u8..=32,
        1_u8..6,
        flags,
        kind,
        1_u8..4,
        0..3_usize,
    )
        .prop_map(|(usages, range, size, count, flags, kind, id, depth)| {
            let mut item = [0xA1, 0x00].repeat(depth);
            item.extend([0x85, id, 0x75, size, 0x95, count, 0x05, 0x12]);
            if range {
                item.extend([0x19, usages[0], 0x29, usages[0] + count]);
            } else {
                item.extend(usages.iter().flat_map(|&usage| [0x09, usage]));
            }
            item.extend([flags, kind]);
            item.extend([0xC0].repeat(depth));
            item
        })
}

proptest! {
    #[test]
    fn another_parser_agrees_on_any_descriptor(items in prop::collection::vec(main_item(), 1..8)) {
        let start = [0x05, 0x12, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x25, 0x7F];
        let descriptor = [&start[..], &items.concat(), &[0xC0]].concat();
        let theirs = theirs(&descriptor);
        prop_assert!(theirs.is_some());
        prop_assert_eq!(ours(&descriptor), theirs.unwrap());
    }

}
