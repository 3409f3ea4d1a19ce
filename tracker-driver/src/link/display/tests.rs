use super::*;
use std::vec::Vec;

fn frame(kind: u8, body: &[u8]) -> Frame {
    let mut content = Encoder::new().begin(kind);
    content.push(body);
    content.finish()
}

/// Returns what a frame says, in the frame of who says it again, byte by byte; `None` where it is
/// counted as dropped.
fn said_again(kind: u8, frame: &Frame) -> Option<Frame> {
    let (mut reports, mut orders) = (Reports::new(), Orders::new());
    let mut again = Vec::new();
    for byte in frame {
        if kind < SCREENS {
            let mut sink = |report| again.push(Encoder::new().report(&report));
            reports.feed(&[*byte], &mut sink);
        } else {
            let mut sink = |order| again.push(Encoder::new().order(&order));
            orders.feed(&[*byte], &mut sink);
        }
    }
    let dropped = reports.dropped() + orders.dropped();
    assert_eq!(again.len() + dropped as usize, 1);
    again.pop()
}

/// Bodies by the table, and where they have a byte that is 0 or 1.
#[test]
fn every_message_comes_through_with_its_bits() {
    for (kind, length, switch) in [
        (READY, 28, None),
        (FRAME, 69, None),
        (PIXELS, 5 + 16 * 8, None),
        (SLICE, 21, Some(12)),
        (FRAME_DONE, 61, Some(4)),
        (TRACKER, 24, None),
        (SCREENS, 1, None),
        (SCREEN, 41, None),
        (RENDERING, 27, Some(14)),
        (CAPTURE, 14, None),
    ] {
        let mut body: Vec<u8> = (1..=length).collect();
        if let Some(at) = switch {
            body[at] = 2;
            assert_eq!(said_again(kind, &frame(kind, &body)), None, "{kind}");
            body[at] = 1;
        }
        let whole = frame(kind, &body);
        assert_eq!(said_again(kind, &whole).as_ref(), Some(&whole), "{kind}");
        assert_eq!(said_again(kind, &frame(kind, &body[1..])), None, "{kind}");
        body.push(0);
        assert_eq!(said_again(kind, &frame(kind, &body)), None, "{kind}");
    }
    // Pixels need not be numbers; more than eight are no message, nor is another kind.
    let pixels = frame(PIXELS, &[0xFF; 5 + 16 * 3]);
    assert_eq!(said_again(PIXELS, &pixels).as_ref(), Some(&pixels));
    assert_eq!(said_again(PIXELS, &frame(PIXELS, &[0; 5 + 16 * 9])), None);
    assert_eq!(said_again(READY, &frame(CAPTURE, &[0; 14])), None);
}

#[test]
fn numbers_are_where_the_table_has_them() {
    let mut body: Vec<u8> = (1..=69).collect();
    (body[6], body[7], body[8]) = (255, 0, 0);
    body[65..].copy_from_slice(&0.25_f32.to_le_bytes());
    Reports::new().feed(&frame(FRAME, &body), &mut |report| {
        let Report::Frame(start) = report else {
            panic!("{report:?}");
        };
        assert_eq!(
            (start.number, start.orders, start.pictures),
            (0x0403_0201, 5, 6)
        );
        assert_eq!((start.state, start.subject), (None, Subject::Screens));
        assert_eq!(start.budget, 0x1110_0F0E_0D0C_0B0A);
        assert_eq!(start.eyes[0].x.to_bits(), 0x1514_1312);
        assert_eq!(start.widen, 0.25);
    });
}
