//! Serial ports found by the USB device they belong to, whatever name the system gives them this time.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What such a device name begins with: `usb-VENDOR:PRODUCT` or `usb-VENDOR:PRODUCT/SERIAL`.
pub(super) const PREFIX: &str = "usb-";
/// Folders between a port and its USB device: the interface, and a port of its own with some drivers.
const LEVELS: usize = 4;

/// Names a USB device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct UsbDevice {
    vendor: u16,
    product: u16,
    serial: Option<String>,
}

/// Where the system shows its devices.
#[derive(Debug, Clone)]
pub(super) struct Places {
    pub(super) sys: PathBuf,
    pub(super) dev: PathBuf,
}

impl Default for Places {
    fn default() -> Self {
        Self { sys: "/sys".into(), dev: "/dev".into() }
    }
}

impl UsbDevice {
    /// Reads `usb-VENDOR:PRODUCT[/SERIAL]`, the numbers in four hexadecimal digits as `lsusb` prints them.
    pub(super) fn parse(name: &str) -> Option<Self> {
        let (ids, serial) = match name.strip_prefix(PREFIX)?.split_once('/') {
            Some((ids, serial)) if !serial.is_empty() && !serial.contains(':') => {
                (ids, Some(serial.to_owned()))
            }
            Some(_) => return None,
            None => (name.strip_prefix(PREFIX)?, None),
        };
        let (vendor, product) = ids.split_once(':')?;
        Some(Self { vendor: hex(vendor)?, product: hex(product)?, serial })
    }

    /// The device's port; of several, that of its first interface, where flight controllers speak MAVLink.
    pub(super) fn port(&self, places: &Places) -> io::Result<PathBuf> {
        let mut ports = Vec::new();
        for entry in fs::read_dir(places.sys.join("class/tty"))?.flatten() {
            // Ports of no device, such as consoles, have no such link.
            let Ok(device) = fs::canonicalize(entry.path().join("device")) else { continue };
            if device.ancestors().take(LEVELS).any(|folder| self.is_at(folder)) {
                ports.push((device, entry.file_name()));
            }
        }
        let first = ports.into_iter().min();
        first.map(|(_, name)| places.dev.join(name)).ok_or_else(|| {
            io::Error::new(io::ErrorKind::NotFound, format!("no serial port belongs to {self}"))
        })
    }

    fn is_at(&self, folder: &Path) -> bool {
        let read = |name: &str| fs::read_to_string(folder.join(name)).ok().map(|text| text.trim().to_owned());
        read("idVendor").as_deref().and_then(hex) == Some(self.vendor)
            && read("idProduct").as_deref().and_then(hex) == Some(self.product)
            && (self.serial.is_none() || self.serial == read("serial"))
    }
}

impl fmt::Display for UsbDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "USB device {:04x}:{:04x}", self.vendor, self.product)?;
        match &self.serial {
            Some(serial) => write!(f, " with serial number {serial}"),
            None => Ok(()),
        }
    }
}

fn hex(digits: &str) -> Option<u16> {
    if digits.len() == 4 { u16::from_str_radix(digits, 16).ok() } else { None }
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    /// A made-up /sys, removed at the end.
    struct Machine(Places);

    impl Machine {
        fn new(name: &str) -> Self {
            let root = std::env::temp_dir().join(format!("helmlink-usb-{name}-{}", std::process::id()));
            fs::create_dir_all(root.join("sys/class/tty/console")).unwrap();
            Self(Places { sys: root.join("sys"), dev: root.join("dev") })
        }

        /// Plugs a device into a socket; each port is (interface, folder below it, name).
        fn plug(&self, socket: &str, ids: (&str, &str, &str), ports: &[(&str, &str, &str)]) {
            let device = self.0.sys.join("devices").join(socket);
            for (interface, below, name) in ports {
                let place = device.join(interface).join(below);
                fs::create_dir_all(&place).unwrap();
                let class = self.0.sys.join("class/tty").join(name);
                fs::create_dir_all(&class).unwrap();
                symlink(&place, class.join("device")).unwrap();
            }
            for (file, text) in [("idVendor", ids.0), ("idProduct", ids.1), ("serial", ids.2)] {
                fs::write(device.join(file), format!("{text}\n")).unwrap();
            }
        }

        fn unplug(&self, name: &str) {
            fs::remove_dir_all(self.0.sys.join("class/tty").join(name)).unwrap();
        }

        fn find(&self, name: &str) -> Option<String> {
            let port = UsbDevice::parse(name).unwrap().port(&self.0).ok()?;
            Some(port.strip_prefix(&self.0.dev).unwrap().display().to_string())
        }
    }

    impl Drop for Machine {
        fn drop(&mut self) {
            fs::remove_dir_all(self.0.sys.parent().unwrap()).ok();
        }
    }

    #[test]
    fn names_are_read() {
        let device = |serial: Option<&str>| UsbDevice {
            vendor: 0x26AC,
            product: 0x11,
            serial: serial.map(str::to_owned),
        };
        assert_eq!(UsbDevice::parse("usb-26ac:0011"), Some(device(None)));
        assert_eq!(UsbDevice::parse("usb-26AC:0011/3B00"), Some(device(Some("3B00"))));
        for wrong in ["usb-26ac", "usb-26ac:11", "usb-26ac:0011/", "usb-:", "26ac:0011", "usb-zzzz:0011"] {
            assert_eq!(UsbDevice::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_device_is_found_under_whatever_name_it_comes_back() {
        let machine = Machine::new("rename");
        assert_eq!(machine.find("usb-1209:5740"), None);
        machine.plug("1-1", ("1209", "5740", "A1"), &[("1-1:1.0", "", "ttyACM0")]);
        assert_eq!(machine.find("usb-1209:5740").as_deref(), Some("ttyACM0"));
        machine.unplug("ttyACM0");
        assert_eq!(machine.find("usb-1209:5740"), None);
        machine.plug("1-2", ("1209", "5740", "A1"), &[("1-2:1.0", "", "ttyACM3")]);
        assert_eq!(machine.find("usb-1209:5740").as_deref(), Some("ttyACM3"));
    }

    #[test]
    fn of_two_interfaces_the_first_and_of_two_devices_the_one_with_the_serial_number() {
        let machine = Machine::new("several");
        machine.plug("1-1", ("2dae", "1016", "B"), &[("1-1:1.2", "", "ttyACM0"), ("1-1:1.0", "", "ttyACM1")]);
        machine.plug("1-4", ("2dae", "1016", "A"), &[("1-4:1.0", "", "ttyACM2")]);
        machine.plug("1-5", ("0403", "6001", "F"), &[("1-5:1.0", "ttyUSB0", "ttyUSB0")]);
        assert_eq!(machine.find("usb-2dae:1016").as_deref(), Some("ttyACM1"));
        assert_eq!(machine.find("usb-2dae:1016/A").as_deref(), Some("ttyACM2"));
        assert_eq!(machine.find("usb-0403:6001").as_deref(), Some("ttyUSB0"));
        assert_eq!(machine.find("usb-0403:6001/G"), None);
    }
}
