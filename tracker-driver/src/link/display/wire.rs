//! The bodies of reports and orders, field by field.

use super::super::body::Body;
use super::super::frame::{Content, LinkMessage};
use super::{
    CAPTURE, FRAME, FRAME_DONE, FrameDone, FrameStart, MOST_PIXELS, Order, PIXELS, PixelRun, READY,
    RENDERING, Ready, Rendering, Report, SCREEN, SCREENS, SLICE, Slice, Subject, TRACKER,
    TrackerState,
};
use crate::decoder::DropReason;
use crate::time::Micros;
use glam::Vec3;
use heapless::Vec;
use shisen_core::frame::{FlatScreen, Pixel};

/// A part of a body.
pub(super) trait Field: Sized {
    /// Appends its bytes.
    fn write(&self, content: &mut Content);

    /// Takes it off the front of a body.
    fn read(body: &mut Body<'_>) -> Result<Self, DropReason>;
}

macro_rules! integers {
    ($($integer:ty)*) => {$(
        impl Field for $integer {
            fn write(&self, content: &mut Content) {
                content.push(&self.to_le_bytes());
            }

            fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
                body.take().map(Self::from_le_bytes)
            }
        }
    )*};
}

/// Structs whose fields follow one another in this order.
macro_rules! structs {
    ($($name:ident: $($field:ident)*;)*) => {$(
        impl Field for $name {
            fn write(&self, content: &mut Content) {
                $(self.$field.write(content);)*
            }

            fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
                Ok(Self { $($field: Field::read(body)?,)* })
            }
        }
    )*};
}

integers! { u8 u16 u32 u64 }

structs! {
    Ready: scene_bytes effects linked fault flash_bytes static_bytes picture_bytes;
    FrameStart: number orders pictures state subject budget eyes forward up widen;
    PixelRun: picture column row pixels;
    Slice: frame instructions steps ended_tile time;
    FrameDone: number cut_short whole given_up steps primary rays instructions preparation latency
        age sent;
    TrackerState: records dropped overrun instructions stack_bytes;
    Rendering: budget slice depth wavelengths lod eye_distance display_delay restart_angle;
}

impl Field for bool {
    fn write(&self, content: &mut Content) {
        u8::from(*self).write(content);
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        match u8::read(body)? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(DropReason::Field),
        }
    }
}

/// A finite number.
impl Field for f32 {
    fn write(&self, content: &mut Content) {
        content.push(&self.to_le_bytes());
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        body.number()
    }
}

impl Field for Vec3 {
    fn write(&self, content: &mut Content) {
        for number in self.to_array() {
            number.write(content);
        }
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        body.vector()
    }
}

impl<T: Field> Field for [T; 2] {
    fn write(&self, content: &mut Content) {
        for part in self {
            part.write(content);
        }
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        Ok([T::read(body)?, T::read(body)?])
    }
}

impl Field for Micros {
    fn write(&self, content: &mut Content) {
        self.0.write(content);
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        u64::read(body).map(Self)
    }
}

/// The state of a gaze; 255 for none.
impl Field for Option<u8> {
    fn write(&self, content: &mut Content) {
        self.unwrap_or(u8::MAX).write(content);
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        Ok(Some(u8::read(body)?).filter(|&state| state != u8::MAX))
    }
}

impl Field for Subject {
    fn write(&self, content: &mut Content) {
        let size = match *self {
            Self::Screens => 0_u16,
            Self::Capture { size } => size,
        };
        size.write(content);
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        Ok(match u16::read(body)? {
            0 => Self::Screens,
            size => Self::Capture { size },
        })
    }
}

/// Its channels keep their bits, be they numbers or not.
impl Field for Pixel {
    fn write(&self, content: &mut Content) {
        for channel in [self.red, self.green, self.blue, self.alpha] {
            channel.write(content);
        }
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        let mut channel = || body.take().map(f32::from_le_bytes);
        Ok(Self {
            red: channel()?,
            green: channel()?,
            blue: channel()?,
            alpha: channel()?,
        })
    }
}

/// The rest of a body.
impl Field for Vec<Pixel, MOST_PIXELS> {
    fn write(&self, content: &mut Content) {
        for pixel in self {
            pixel.write(content);
        }
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        let mut pixels = Self::new();
        while body.end().is_err() {
            let pixel = Pixel::read(body)?;
            pixels.push(pixel).map_err(|_| DropReason::Length)?;
        }
        Ok(pixels)
    }
}

impl Field for FlatScreen {
    fn write(&self, content: &mut Content) {
        self.size.map(|pixels| pixels as u16).write(content);
        [self.first_pixel, self.column_step].write(content);
        self.row_step.write(content);
    }

    fn read(body: &mut Body<'_>) -> Result<Self, DropReason> {
        Ok(Self {
            size: <[u16; 2]>::read(body)?.map(u32::from),
            first_pixel: Field::read(body)?,
            column_step: Field::read(body)?,
            row_step: Field::read(body)?,
        })
    }
}

impl LinkMessage for Report {
    fn read(kind: u8, body: &[u8]) -> Result<Self, DropReason> {
        let body = &mut Body(body);
        let report = match kind {
            READY => Self::Ready(Field::read(body)?),
            FRAME => Self::Frame(Field::read(body)?),
            PIXELS => Self::Pixels(Field::read(body)?),
            SLICE => Self::Slice(Field::read(body)?),
            FRAME_DONE => Self::FrameDone(Field::read(body)?),
            TRACKER => Self::Tracker(Field::read(body)?),
            _ => return Err(DropReason::Unknown),
        };
        body.end()?;
        Ok(report)
    }
}

impl LinkMessage for Order {
    fn read(kind: u8, body: &[u8]) -> Result<Self, DropReason> {
        let body = &mut Body(body);
        let order = match kind {
            SCREENS => Self::Screens {
                count: Field::read(body)?,
            },
            SCREEN => Self::Screen {
                index: Field::read(body)?,
                screen: Field::read(body)?,
            },
            RENDERING => Self::Rendering(Field::read(body)?),
            CAPTURE => Self::Capture {
                size: Field::read(body)?,
                place: Field::read(body)?,
            },
            _ => return Err(DropReason::Unknown),
        };
        body.end()?;
        Ok(order)
    }
}
