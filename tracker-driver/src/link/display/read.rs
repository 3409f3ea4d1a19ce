//! The bodies of reports and orders.

use super::super::body::Body;
use super::{
    CAPTURE, FRAME, FRAME_DONE, FrameDone, FrameStart, Order, PIXELS, PixelRun, READY, RENDERING,
    Ready, Rendering, Report, SCREEN, SCREENS, SLICE, Slice, Subject, TRACKER, TrackerState,
};
use crate::decoder::DropReason;
use crate::time::Micros;
use heapless::Vec;
use shisen_core::frame::{FlatScreen, Pixel};

impl Body<'_> {
    fn u8(&mut self) -> Result<u8, DropReason> {
        let [byte] = self.take()?;
        Ok(byte)
    }

    fn u16(&mut self) -> Result<u16, DropReason> {
        self.take().map(u16::from_le_bytes)
    }

    fn flag(&mut self) -> Result<bool, DropReason> {
        match self.u8()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(DropReason::Field),
        }
    }

    /// Whatever its bits are.
    fn channel(&mut self) -> Result<f32, DropReason> {
        self.take().map(f32::from_le_bytes)
    }
}

pub(super) fn read_report(kind: u8, body: &[u8]) -> Result<Report, DropReason> {
    let mut body = Body(body);
    let report = match kind {
        READY => Report::Ready(Ready {
            scene_bytes: body.u32()?,
            effects: body.u32()?,
            linked: body.u32()?,
            fault: body.u32()?,
            flash_bytes: body.u32()?,
            static_bytes: body.u32()?,
            picture_bytes: body.u32()?,
        }),
        FRAME => Report::Frame(FrameStart {
            number: body.u32()?,
            orders: body.u8()?,
            pictures: body.u8()?,
            state: Some(body.u8()?).filter(|&state| state != u8::MAX),
            subject: match body.u16()? {
                0 => Subject::Screens,
                size => Subject::Capture { size },
            },
            budget: body.u64()?,
            eyes: [body.vector()?, body.vector()?],
            forward: body.vector()?,
            up: body.vector()?,
            widen: body.number()?,
        }),
        PIXELS => Report::Pixels(read_pixels(&mut body)?),
        SLICE => Report::Slice(Slice {
            frame: body.u32()?,
            instructions: body.u32()?,
            steps: body.u32()?,
            ended_tile: body.flag()?,
            time: Micros(body.u64()?),
        }),
        FRAME_DONE => Report::FrameDone(FrameDone {
            number: body.u32()?,
            cut_short: body.flag()?,
            whole: body.u32()?,
            given_up: body.u32()?,
            steps: body.u64()?,
            primary: body.u64()?,
            rays: body.u64()?,
            instructions: body.u64()?,
            preparation: body.u32()?,
            latency: body.u32()?,
            age: body.u32()?,
            sent: body.u32()?,
        }),
        TRACKER => Report::Tracker(TrackerState {
            records: body.u32()?,
            dropped: body.u32()?,
            overrun: body.u32()?,
            instructions: body.u64()?,
            stack_bytes: body.u32()?,
        }),
        _ => return Err(DropReason::Unknown),
    };
    body.end()?;
    Ok(report)
}

fn read_pixels(body: &mut Body<'_>) -> Result<PixelRun, DropReason> {
    let mut run = PixelRun {
        picture: body.u8()?,
        column: body.u16()?,
        row: body.u16()?,
        pixels: Vec::new(),
    };
    while body.end().is_err() {
        let pixel = Pixel {
            red: body.channel()?,
            green: body.channel()?,
            blue: body.channel()?,
            alpha: body.channel()?,
        };
        run.pixels.push(pixel).map_err(|_| DropReason::Length)?;
    }
    Ok(run)
}

pub(super) fn read_order(kind: u8, body: &[u8]) -> Result<Order, DropReason> {
    let mut body = Body(body);
    let order = match kind {
        SCREENS => Order::Screens { count: body.u8()? },
        SCREEN => {
            let index = body.u8()?;
            let size = [body.u16()?, body.u16()?].map(u32::from);
            let screen = FlatScreen {
                first_pixel: body.vector()?,
                column_step: body.vector()?,
                row_step: body.vector()?,
                size,
            };
            Order::Screen { index, screen }
        }
        RENDERING => Order::Rendering(Rendering {
            budget: body.u64()?,
            slice: body.u32()?,
            depth: body.u8()?,
            wavelengths: body.u8()?,
            lod: body.flag()?,
            eye_distance: body.number()?,
            display_delay: body.u32()?,
            restart_angle: body.number()?,
        }),
        CAPTURE => Order::Capture {
            size: body.u16()?,
            place: body.vector()?,
        },
        _ => return Err(DropReason::Unknown),
    };
    body.end()?;
    Ok(order)
}
