//! Virtual HID devices: `/dev/uhid`, as in the kernel's `linux/uhid.h`.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

/// `struct uhid_event`: a type and the largest of its contents.
const EVENT_BYTES: usize = 4 + 4372;

const DESTROY: u32 = 1;
const STOP: u32 = 3;
const OPEN: u32 = 4;
const GET_REPORT: u32 = 9;
const GET_REPORT_REPLY: u32 = 10;
const CREATE2: u32 = 11;
const INPUT2: u32 = 12;
const SET_REPORT: u32 = 13;
const SET_REPORT_REPLY: u32 = 14;

/// What hidapi takes for a USB device.
const BUS_USB: u16 = 3;
const EIO: u16 = 5;

/// What a device is, before it is plugged in.
pub struct Description<'a> {
    pub name: &'a str,
    pub serial: &'a str,
    pub id: (u16, u16),
    pub descriptor: &'a [u8],
    /// Feature reports that can be read, by their ids: 0 of a device that has none. The
    /// bytes are what the device's driver hands over: with the id in front where there
    /// are ids, and where not, with a 0 in front as USB's does, or without.
    pub features: Vec<(u8, Vec<u8>)>,
    /// Whether feature reports can be set.
    pub settable: bool,
}

/// What the host did to a device.
#[derive(Default, Clone)]
pub struct Seen {
    pub opened: u32,
    /// Feature reports that were set, each with its id, or 0, in front.
    pub set: Vec<Vec<u8>>,
}

/// A device that is plugged in until it is dropped.
pub struct Device {
    file: File,
    seen: Arc<Mutex<Seen>>,
    kernel: Option<JoinHandle<()>>,
}

impl Device {
    pub fn new(description: &Description<'_>) -> io::Result<Self> {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .open("/dev/uhid")?;
        let mut create = vec![0; 4 + 128 + 64 + 64];
        put(&mut create, 0, &CREATE2.to_le_bytes());
        put(&mut create, 4, description.name.as_bytes());
        put(&mut create, 4 + 128 + 64, description.serial.as_bytes());
        create.extend((description.descriptor.len() as u16).to_le_bytes());
        create.extend(BUS_USB.to_le_bytes());
        let (vendor, product) = description.id;
        for word in [u32::from(vendor), u32::from(product), 1, 0] {
            create.extend(word.to_le_bytes());
        }
        create.extend(description.descriptor);
        file.write_all(&create)?;
        let seen = Arc::new(Mutex::new(Seen::default()));
        let kernel = {
            let (file, seen) = (file.try_clone()?, seen.clone());
            let (features, settable) = (description.features.clone(), description.settable);
            thread::spawn(move || answer(file, &features, settable, &seen))
        };
        Ok(Self {
            file,
            seen,
            kernel: Some(kernel),
        })
    }

    pub fn send(&mut self, report: &[u8]) -> io::Result<()> {
        let mut event = INPUT2.to_le_bytes().to_vec();
        event.extend((report.len() as u16).to_le_bytes());
        event.extend(report);
        self.file.write_all(&event)
    }

    pub fn seen(&self) -> Seen {
        self.seen.lock().expect("no thread panics").clone()
    }
}

impl Drop for Device {
    /// Unplugs it.
    fn drop(&mut self) {
        let destroyed = self.file.write_all(&DESTROY.to_le_bytes());
        if let (Ok(()), Some(kernel)) = (destroyed, self.kernel.take()) {
            kernel.join().expect("no thread panics");
        }
    }
}

fn put(to: &mut [u8], at: usize, bytes: &[u8]) {
    to[at..at + bytes.len()].copy_from_slice(bytes);
}

/// Answers the kernel until the device is gone.
fn answer(mut file: File, features: &[(u8, Vec<u8>)], settable: bool, seen: &Mutex<Seen>) {
    let mut event = [0; EVENT_BYTES];
    while file.read(&mut event).is_ok_and(|length| length >= 4) {
        let word = |at: usize| u32::from_le_bytes(event[at..at + 4].try_into().expect("4 bytes"));
        let id = word(4).to_le_bytes();
        let mut seen = seen.lock().expect("no thread panics");
        let reply = match word(0) {
            STOP => return,
            OPEN => {
                seen.opened += 1;
                continue;
            }
            GET_REPORT => {
                let found = features.iter().find(|(id, _)| *id == event[8]);
                let error = if found.is_some() { 0 } else { EIO };
                let report = found.map_or(&[][..], |(_, report)| report);
                let mut reply = [&GET_REPORT_REPLY.to_le_bytes()[..], &id].concat();
                reply.extend(error.to_le_bytes());
                reply.extend((report.len() as u16).to_le_bytes());
                reply.extend(report);
                reply
            }
            SET_REPORT => {
                let length = usize::from(u16::from_le_bytes([event[10], event[11]]));
                seen.set.push(event[12..12 + length].to_vec());
                let error = if settable { 0 } else { EIO };
                let error = error.to_le_bytes();
                [&SET_REPORT_REPLY.to_le_bytes()[..], &id, &error].concat()
            }
            _ => continue,
        };
        drop(seen);
        if file.write_all(&reply).is_err() {
            return;
        }
    }
}
