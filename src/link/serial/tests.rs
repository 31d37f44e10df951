use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use tokio::time::Instant;

use crate::link::test_support::{bytes, down, gather, hub_at, quick, up, within};
use crate::link::usb::Places;
use crate::link::{LinkEvent, LinkSettings};

/// A device name that a pseudo-terminal can be plugged into, as udev would make and remove it.
struct Socket {
    name: PathBuf,
}

impl Socket {
    fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        Self::at(std::env::temp_dir().join(format!("helmlink-tty-{}-{number}", std::process::id())))
    }

    fn at(name: PathBuf) -> Self {
        _ = std::fs::remove_file(&name);
        Self { name }
    }

    fn url(&self, baud: u32) -> String {
        format!("serial:{}:{baud}", self.name.display())
    }

    fn plug(&self) -> Device {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        rustix::fs::fcntl_setfl(&master, rustix::fs::OFlags::NONBLOCK).unwrap();
        let terminal = ptsname(&master, Vec::new()).unwrap();
        std::os::unix::fs::symlink(terminal.to_str().unwrap(), &self.name).unwrap();
        Device { master }
    }

    fn unplug(&self, device: Device) {
        // The name goes first, so that it never leads to another's terminal with the same number.
        std::fs::remove_file(&self.name).unwrap();
        drop(device);
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        _ = std::fs::remove_file(&self.name);
    }
}

/// The far end of the line. It asks again and again whether it can go on, the other tasks in between.
struct Device {
    master: OwnedFd,
}

impl Device {
    async fn read(&self) -> Vec<u8> {
        let mut buffer = vec![0; 4096];
        let reading = until_ready(|| rustix::io::read(&self.master, &mut buffer));
        let count = within("bytes on the line", reading).await;
        buffer.truncate(count);
        buffer
    }

    async fn read_exactly(&self, count: usize) -> Vec<u8> {
        let mut gathered = Vec::new();
        while gathered.len() < count {
            gathered.extend(self.read().await);
        }
        gathered
    }

    async fn write(&self, data: &[u8]) {
        let writing = until_ready(|| rustix::io::write(&self.master, data));
        assert_eq!(within("room on the line", writing).await, data.len());
    }
}

async fn until_ready(mut attempt: impl FnMut() -> rustix::io::Result<usize>) -> usize {
    loop {
        match attempt() {
            Ok(count) => return count,
            Err(Errno::AGAIN) => tokio::task::yield_now().await,
            Err(error) => panic!("{error}"),
        }
    }
}

/// Every value of a byte, among them those that a terminal would act on.
fn every_byte() -> Vec<u8> {
    (0..=255).collect()
}

#[tokio::test]
async fn carries_every_byte_both_ways() {
    let socket = Socket::new();
    let device = socket.plug();
    let mut hub = hub_at(&socket.url(57_600), quick()).await;
    let (link, peer) = up(&mut hub).await;
    assert_eq!(peer, format!("{} at 57600 bit/s", socket.name.display()));
    hub.send(link, &every_byte());
    assert_eq!(device.read_exactly(256).await, every_byte());
    device.write(&every_byte()).await;
    assert_eq!(gather(&mut hub, link, 256).await, every_byte());
}

#[tokio::test]
async fn comes_back_under_a_new_number_after_each_unplugging() {
    let socket = Socket::new();
    let mut hub = hub_at(&socket.url(115_200), quick()).await;
    let mut seen = Vec::new();
    for _ in 0..3 {
        let device = socket.plug();
        let (link, _) = up(&mut hub).await;
        assert!(!seen.contains(&link));
        seen.push(link);
        device.write(b"hello").await;
        assert_eq!(gather(&mut hub, link, 5).await, b"hello");
        hub.send(link, b"hi");
        assert_eq!(device.read_exactly(2).await, b"hi");
        socket.unplug(device);
        assert_eq!(down(&mut hub).await.0, link);
        assert!(!hub.send(link, b"x"));
    }
}

#[tokio::test]
async fn a_usb_device_is_found_under_the_name_that_it_comes_back_with() {
    let root = std::env::temp_dir().join(format!("helmlink-usb-replug-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&root);
    let usb = Places { sys: root.join("sys"), dev: root.join("dev") };
    let (class, device) = (usb.sys.join("class/tty"), usb.sys.join("devices/1-1"));
    for folder in [&class, &usb.dev, &device.join("1-1:1.0")] {
        std::fs::create_dir_all(folder).unwrap();
    }
    std::fs::write(device.join("idVendor"), "1209\n").unwrap();
    std::fs::write(device.join("idProduct"), "5740\n").unwrap();
    let settings = LinkSettings { usb: usb.clone(), ..quick() };
    let mut hub = hub_at("serial:usb-1209:5740:115200", settings).await;
    for name in ["ttyACM0", "ttyACM1", "ttyACM0"] {
        let socket = Socket::at(usb.dev.join(name));
        let port = socket.plug();
        std::fs::create_dir(class.join(name)).unwrap();
        std::os::unix::fs::symlink(device.join("1-1:1.0"), class.join(name).join("device")).unwrap();
        let (link, peer) = up(&mut hub).await;
        assert!(peer.starts_with(socket.name.to_str().unwrap()), "{peer}");
        port.write(b"hello").await;
        assert_eq!(gather(&mut hub, link, 5).await, b"hello");
        std::fs::remove_dir_all(class.join(name)).unwrap();
        socket.unplug(port);
        assert_eq!(down(&mut hub).await.0, link);
    }
    std::fs::remove_dir_all(&root).unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_missing_device_is_waited_for_and_found_within_the_longest_wait() {
    let socket = Socket::new();
    let mut hub = hub_at(&socket.url(115_200), LinkSettings::default()).await;
    let hour = Duration::from_secs(3600);
    assert!(tokio::time::timeout(hour, hub.next_event()).await.is_err());
    let _device = socket.plug();
    let plugged = Instant::now();
    assert!(matches!(hub.next_event().await, LinkEvent::Up { .. }));
    assert!(plugged.elapsed() <= LinkSettings::default().retry_longest, "{:?}", plugged.elapsed());
}

#[tokio::test]
async fn a_slow_line_gets_the_newest_writes() {
    let socket = Socket::new();
    let device = socket.plug();
    let mut hub = hub_at(&socket.url(9600), quick()).await;
    let (link, _) = up(&mut hub).await;
    let write = |number: u32| [number.to_be_bytes(); 25].concat();
    for number in 0..1000 {
        hub.send(link, &write(number));
        tokio::task::yield_now().await;
    }
    let lost = hub.traffic(link).unwrap().lost_bytes as usize;
    // What waits in the hub is bounded by the least queue, the rest by the terminal's own buffer.
    assert!(lost > 50_000, "{lost}");
    let received = device.read_exactly(100_000 - lost).await;
    assert_eq!(received.len(), 100_000 - lost);
    assert_eq!(&received[received.len() - 100..], write(999));
}

#[tokio::test]
async fn a_device_that_takes_nothing_is_closed_and_opened_again() {
    let socket = Socket::new();
    let _device = socket.plug();
    let settings = LinkSettings { write_stall: Duration::from_millis(50), ..quick() };
    let mut hub = hub_at(&socket.url(115_200), settings).await;
    let (stuck, _) = up(&mut hub).await;
    let filling = within("the port to be closed", async {
        while hub.send(stuck, &[0; 1000]) {
            tokio::task::yield_now().await;
        }
    });
    filling.await;
    assert_eq!(down(&mut hub).await, (stuck, "took no bytes for 50ms".to_owned()));
    assert_ne!(up(&mut hub).await.0, stuck);
}

#[tokio::test]
async fn closing_writes_what_waits() {
    let socket = Socket::new();
    let device = socket.plug();
    let mut hub = hub_at(&socket.url(115_200), quick()).await;
    let (link, _) = up(&mut hub).await;
    device.write(b"a").await;
    bytes(&mut hub).await;
    for number in 0..10u8 {
        hub.send(link, &[number; 100]);
    }
    within("the hub to close", hub.close()).await;
    let received = device.read_exactly(1000).await;
    assert!(received.chunks(100).enumerate().all(|(index, chunk)| chunk == [index as u8; 100]));
}
