use super::*;
use std::vec::Vec;

fn reports() -> [Report; 6] {
    let pixel = |red| Pixel {
        red,
        green: -0.0,
        blue: f32::from_bits(0x7fc0_1234),
        alpha: f32::MIN_POSITIVE / 2.0,
    };
    [
        Report::Ready(Ready {
            scene_bytes: 1,
            effects: 2,
            linked: 7,
            fault: 3,
            flash_bytes: 4,
            static_bytes: 5,
            picture_bytes: 6,
        }),
        Report::Frame(FrameStart {
            number: 7,
            orders: 255,
            pictures: 6,
            subject: Subject::Capture { size: 256 },
            state: None,
            budget: u64::MAX,
            eyes: [Vec3::X, Vec3::NEG_X],
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            widen: 0.25,
        }),
        Report::Pixels(PixelRun {
            picture: 5,
            column: 65_535,
            row: 258,
            pixels: [1.0, 2.0, 3.0].into_iter().map(pixel).collect(),
        }),
        Report::Slice(Slice {
            frame: 7,
            instructions: 1,
            steps: 2,
            ended_tile: true,
            time: Micros(1 << 33),
        }),
        Report::FrameDone(FrameDone {
            number: 7,
            cut_short: true,
            whole: 1,
            given_up: 2,
            steps: 3,
            primary: 4,
            rays: 5,
            instructions: 6,
            preparation: 8,
            latency: 9,
            age: 10,
            sent: 11,
        }),
        Report::Tracker(TrackerState {
            records: 1,
            dropped: 2,
            overrun: 3,
            instructions: 4,
            stack_bytes: 5,
        }),
    ]
}

fn orders() -> [Order; 4] {
    let screen = FlatScreen {
        first_pixel: Vec3::ONE,
        column_step: Vec3::X,
        row_step: Vec3::NEG_Y,
        size: [64, 65_535],
    };
    [
        Order::Screens { count: 3 },
        Order::Screen { index: 2, screen },
        Order::Rendering(Rendering {
            budget: 1 << 40,
            slice: 10_000,
            depth: 3,
            wavelengths: 7,
            lod: true,
            eye_distance: 0.064,
            display_delay: 20_000,
            restart_angle: 0.25,
        }),
        Order::Capture {
            size: 256,
            place: Vec3::NEG_Z,
        },
    ]
}

/// Whether two reports have equal bits, NaN or not.
fn same(a: &Report, b: &Report) -> bool {
    let mut encoders = [Encoder::new(), Encoder::new()];
    let [first, second] = &mut encoders;
    first.report(a) == second.report(b)
}

#[test]
fn every_message_comes_through_with_its_bits() {
    let mut encoder = Encoder::new();
    let (mut line, mut back) = (Vec::new(), Vec::new());
    for report in &reports() {
        line.extend_from_slice(&encoder.report(report));
    }
    for order in &orders() {
        back.extend_from_slice(&encoder.order(order));
    }
    let (mut seen, mut told) = (Vec::new(), Vec::new());
    let (mut decoder, mut listener) = (Reports::new(), Orders::new());
    for byte in line {
        decoder.feed(&[byte], &mut |report| seen.push(report));
    }
    listener.feed(&back, &mut |order| told.push(order));
    assert_eq!(seen.len(), reports().len());
    assert!(reports().iter().zip(&seen).all(|(a, b)| same(a, b)));
    assert_eq!(told, orders());
    assert_eq!((decoder.dropped(), listener.dropped()), (0, 0));
}

#[test]
fn bodies_of_other_lengths_are_no_messages() {
    let mut encoder = Encoder::new();
    for (kind, length) in [(SCREENS, 2), (SCREEN, 40), (RENDERING, 26), (CAPTURE, 15)] {
        let mut content = encoder.begin(kind);
        content.push(&[0; 64][..length]);
        let mut orders = Orders::new();
        orders.feed(&content.finish(), &mut |order| panic!("{order:?}"));
        assert_eq!(orders.dropped(), 1);
    }
    for (kind, length) in [(READY, 27), (FRAME, 71), (PIXELS, 20), (TRACKER, 25)] {
        let mut content = encoder.begin(kind);
        content.push(&[0; 80][..length]);
        let mut reports = Reports::new();
        reports.feed(&content.finish(), &mut |report| panic!("{report:?}"));
        assert_eq!(reports.dropped(), 1);
    }
    // More pixels than fit.
    let mut content = encoder.begin(PIXELS);
    content.push(&[0; 5 + 16 * 9]);
    let mut reports = Reports::new();
    reports.feed(&content.finish(), &mut |report| panic!("{report:?}"));
    assert_eq!(reports.dropped(), 1);
}
