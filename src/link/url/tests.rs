use proptest::prelude::*;

use super::*;

fn parse(text: &str) -> LinkUrl {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn message(text: &str) -> String {
    match text.parse::<LinkUrl>() {
        Ok(url) => panic!("{text} was read as {url}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn reads_every_form() {
    let cases = [
        ("udpin:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
        ("udpout:192.168.2.1:14550", "udpout:192.168.2.1:14550"),
        ("tcpin:127.0.0.1:0", "tcpin:127.0.0.1:0"),
        ("tcp:boat.local:5760", "tcpout:boat.local:5760"),
        ("tcpout://boat.local:5760", "tcpout:boat.local:5760"),
        ("TCP://127.0.0.1:5760", "tcpout:127.0.0.1:5760"),
        ("  udpin:[::]:14550\n", "udpin:[::]:14550"),
        ("udpout://[fe80::1%eth0]:14550", "udpout:[fe80::1%eth0]:14550"),
        ("serial:/dev/ttyACM0:57600", "serial:/dev/ttyACM0:57600"),
        ("serial:/dev/ttyACM0", "serial:/dev/ttyACM0:115200"),
        ("serial:///dev/ttyUSB0:921600", "serial:/dev/ttyUSB0:921600"),
        ("serial://///dev/ttyUSB0:921600", "serial:/dev/ttyUSB0:921600"),
        ("serial:COM3:57600", "serial:COM3:57600"),
        ("serial:usb-1209:5740", "serial:usb-1209:5740:115200"),
        ("serial:usb-1209:5740:57600", "serial:usb-1209:5740:57600"),
        ("serial:usb-26AC:0011/3B00:57600", "serial:usb-26AC:0011/3B00:57600"),
        (
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0",
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0:115200",
        ),
        (
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0:57600",
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0:57600",
        ),
    ];
    for (text, canonical) in cases {
        assert_eq!(parse(text).to_string(), canonical);
    }
}

#[test]
fn a_usb_device_is_named_by_vendor_and_product() {
    for wrong in ["serial:usb-1209", "serial:usb-1209:57:115200", "serial:usb-bus1:115200"] {
        assert!(message(wrong).contains("usb-VENDOR:PRODUCT"), "{wrong}: {}", message(wrong));
    }
}

#[test]
fn ipv6_hosts_lose_their_brackets() {
    let LinkUrl::TcpOut(to) = parse("tcp:[::1]:5760") else { panic!("not tcpout") };
    assert_eq!((to.host(), to.port()), ("::1", 5760));
}

#[test]
fn errors_name_the_cause_and_the_fix() {
    let cases = [
        ("", "the link URL is empty: write for example udpin:0.0.0.0:14550"),
        (" \t", "the link URL is empty: write for example udpin:0.0.0.0:14550"),
        ("boat", "`boat` has no scheme: write for example udpin:0.0.0.0:14550"),
        ("/dev/ttyACM0", "`/dev/ttyACM0` has no scheme: write for example serial:/dev/ttyACM0"),
        (
            "/dev/ttyACM0:57600",
            "`/dev/ttyACM0:57600` has no scheme: write for example serial:/dev/ttyACM0:57600",
        ),
        ("127.0.0.1:5760", "`127.0.0.1:5760` has no scheme: write for example tcpout:127.0.0.1:5760"),
        (
            "udp:127.0.0.1:14550",
            "`udp:` can mean two things: write udpin:127.0.0.1:14550 to listen there, or udpout:127.0.0.1:14550 to send there",
        ),
        (
            "udp:",
            "`udp:` can mean two things: write udpin:HOST:PORT to listen there, or udpout:HOST:PORT to send there",
        ),
        (
            "udpbcast:1.2.3.4:1",
            "`udpbcast` is not a transport: use udpin, udpout, tcpin, tcpout (or tcp) or serial",
        ),
        ("udpin:14550", "the host is missing in `udpin:14550`: write udpin:0.0.0.0:PORT"),
        ("tcp::5760", "the host is missing in `tcp::5760`: write tcpout:127.0.0.1:PORT"),
        (
            "tcpin:localhost",
            "the port is missing in `tcpin:localhost`: write tcpin:localhost:PORT, for example tcpin:localhost:14550",
        ),
        (
            "tcpin:[::1]:",
            "the port is missing in `tcpin:[::1]:`: write tcpin:[::1]:PORT, for example tcpin:[::1]:14550",
        ),
        ("udpin:0.0.0.0:65536", "`65536` is not a port: write a whole number from 0 to 65535"),
        ("udpout:1.2.3.4:0", "`0` is not a port: write a whole number from 1 to 65535"),
        ("udpin:0.0.0.0:+80", "`+80` is not a port: write a whole number from 0 to 65535"),
        (
            "udpin:::1:14550",
            "`::1` is neither a host name nor an IP address: put an IPv6 address in brackets, as in udpin:[::1]:14550",
        ),
        (
            "udpin:[::1:14550",
            "`[::1:14550` is neither a host name nor an IP address: close the bracket, as in [::1]:14550",
        ),
        (
            "udpin:[boat]:14550",
            "`[boat]:14550` is neither a host name nor an IP address: brackets hold an IPv6 address, as in [::1]:14550",
        ),
        (
            "udpout:10.0.0.256:14550",
            "`10.0.0.256` is neither a host name nor an IP address: an IPv4 address has four numbers from 0 to 255",
        ),
        (
            "tcp:my boat:1",
            "`my boat` is neither a host name nor an IP address: use letters, digits, dots and hyphens",
        ),
        ("serial:", "the device is missing in `serial:`: write for example serial:/dev/ttyACM0:115200"),
        (
            "serial::57600",
            "the device is missing in `serial::57600`: write for example serial:/dev/ttyACM0:115200",
        ),
        ("serial://dev/ttyACM0", "`dev/ttyACM0` lost its leading slash: write serial:/dev/ttyACM0"),
        (
            "serial:/dev/ttyACM0:fast",
            "`fast` is not a serial rate: write bits per second from 300 to 12000000, for example 57600",
        ),
        (
            "serial:/dev/ttyACM0:0",
            "`0` is not a serial rate: write bits per second from 300 to 12000000, for example 57600",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(message(text), expected);
    }
}

fn any_host() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<std::net::Ipv4Addr>().prop_map(|address| address.to_string()),
        any::<std::net::Ipv6Addr>().prop_map(|address| address.to_string()),
        "[a-z][a-z0-9_-]{0,12}(\\.[a-z][a-z0-9]{0,8}){0,3}",
    ]
}

fn any_url() -> impl Strategy<Value = LinkUrl> {
    let address = || (any_host(), 1..=u16::MAX).prop_map(|(host, port)| HostPort { host, port });
    prop_oneof![
        (any_host(), any::<u16>()).prop_map(|(host, port)| LinkUrl::UdpIn(HostPort { host, port })),
        (any_host(), any::<u16>()).prop_map(|(host, port)| LinkUrl::TcpIn(HostPort { host, port })),
        address().prop_map(LinkUrl::UdpOut),
        address().prop_map(LinkUrl::TcpOut),
        ("/dev/(serial/by-path/)?[a-zA-Z][a-zA-Z0-9:._-]{0,30}", MIN_BAUD..=MAX_BAUD)
            .prop_map(|(device, baud)| LinkUrl::Serial { device, baud }),
    ]
}

proptest! {
    #[test]
    fn text_round_trips(url in any_url()) {
        prop_assert_eq!(url.to_string().parse::<LinkUrl>(), Ok(url));
    }

    #[test]
    fn any_text_gives_a_url_or_a_one_line_message(text in "[^\\r\\n]{0,60}") {
        match text.parse::<LinkUrl>() {
            Ok(url) => prop_assert_eq!(url.to_string().parse::<LinkUrl>(), Ok(url)),
            Err(error) => prop_assert!(!error.to_string().contains('\n')),
        }
    }

    #[test]
    fn anything_after_a_scheme_round_trips_or_is_refused(
        scheme in "(udpin|udpout|tcpin|tcpout|tcp|serial)(://|:)",
        rest in "[\\[\\]a-z0-9:./%-]{0,30}",
    ) {
        if let Ok(url) = format!("{scheme}{rest}").parse::<LinkUrl>() {
            prop_assert_eq!(url.to_string().parse::<LinkUrl>(), Ok(url));
        }
    }
}
