//! What to do where the system does not let a device be opened.

use std::path::Path;

/// The file of udev rules, in the sources.
const RULES: &str = "tracker-driver/udev/70-shisen-trackers.rules";

/// Vendor and product of the HID devices that the file names.
const NAMED: [(u16, u16); 2] = [(0x1532, 0x0b00), (0x03eb, 0x2421)];

/// Says which rule or which group is missing for the device at a path.
pub(super) fn advice(path: &str) -> String {
    let name = Path::new(path).file_name().and_then(|name| name.to_str());
    let name = name.unwrap_or_default();
    if name.starts_with("hidraw") {
        let uevent = std::fs::read_to_string(format!("/sys/class/hidraw/{name}/device/uevent"));
        return hid_advice(uevent.ok().and_then(|uevent| parse(&uevent)));
    }
    if name.starts_with("ttyUSB") || name.starts_with("ttyACM") {
        return format!("a udev rule is missing: {INSTALL}; joining the group dialout does too");
    }
    format!(
        "{RULES} has no rule for such a port, only for ttyUSB and ttyACM: join the group that \
         owns it, which `ls -l {path}` shows (often dialout), and log in again"
    )
}

const INSTALL: &str = "copy tracker-driver/udev/70-shisen-trackers.rules to /etc/udev/rules.d, \
                       run `udevadm control --reload` and plug the device in again";

/// The advice for a HID device, by its vendor and product where the system says them.
fn hid_advice(identity: Option<(u16, u16)>) -> String {
    let Some((vendor, product)) = identity.filter(|id| !NAMED.contains(id)) else {
        return format!("a udev rule is missing: {INSTALL}");
    };
    format!(
        "a udev rule is missing: {INSTALL}; where it is no tracker of usage page 0x12, the file \
         needs one line more: KERNEL==\"hidraw*\", ATTRS{{idVendor}}==\"{vendor:04x}\", \
         ATTRS{{idProduct}}==\"{product:04x}\", TAG+=\"uaccess\""
    )
}

/// Reads vendor and product from a line such as `HID_ID=0003:00001532:00000B00`.
fn parse(uevent: &str) -> Option<(u16, u16)> {
    let id = uevent
        .lines()
        .find_map(|line| line.strip_prefix("HID_ID="))?;
    let mut parts = id.split(':').skip(1);
    let mut number = || u16::try_from(u32::from_str_radix(parts.next()?, 16).ok()?).ok();
    Some((number()?, number()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_names_the_rules_of_the_file() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let rules = std::fs::read_to_string(root.join(RULES)).unwrap();
        for (vendor, product) in NAMED {
            let vendor = format!("ATTRS{{idVendor}}==\"{vendor:04x}\"");
            let ids = format!("{vendor}, ATTRS{{idProduct}}==\"{product:04x}\"");
            assert!(rules.contains(&ids), "{ids}");
        }
        assert_eq!(rules.matches("idVendor").count(), NAMED.len());
        assert!(rules.contains("ttyUSB[0-9]*|ttyACM[0-9]*"));
        for (advice, has, lacks) in [
            (advice("/dev/ttyUSB0"), "rules to /etc/udev", "idVendor"),
            (advice("/dev/ttyUSB0"), "dialout", "ls -l"),
            (advice("/dev/ttyS0"), "ls -l /dev/ttyS0", "rule is missing"),
            (hid_advice(Some(NAMED[0])), "/etc/udev", "idVendor"),
            (hid_advice(Some((0x2104, 0x0313))), "\"2104\"", "dialout"),
            (hid_advice(Some((0x2104, 0x0313))), "\"0313\"", "dialout"),
        ] {
            assert!(advice.contains(has) && !advice.contains(lacks), "{advice}");
        }
        let uevent = "DRIVER=hid-generic\nHID_ID=0003:00001532:00000B00\nHID_NAME=x\n";
        assert_eq!(parse(uevent), Some((0x1532, 0x0b00)));
        assert_eq!(parse("HID_ID=0003:FFFFFFFF:0"), None);
        assert_eq!(parse("DRIVER=x"), None);
    }
}
