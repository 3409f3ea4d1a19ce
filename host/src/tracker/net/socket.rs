//! Sockets that are read for at most 2 ms.

use super::Server;
use crate::files::Fault;
use std::io::{self, ErrorKind, Read};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::time::{Duration, Instant};

/// The longest wait of a read.
pub(super) const WAIT: Duration = Duration::from_millis(2);

/// Most reads in that time. What a flood sends besides is left to the system, which keeps a
/// bounded part of it.
const MOST_READS: u32 = 16;

/// Bytes of the longest datagram.
pub(super) const LONGEST: usize = 65_536;

/// Runs `read` until nothing is left or 2 ms have passed; false from it ends that.
fn within_wait(mut read: impl FnMut() -> io::Result<bool>) -> io::Result<()> {
    let begun = Instant::now();
    for _ in 0..MOST_READS {
        match read() {
            Ok(true) => {}
            Ok(false) => return Ok(()),
            Err(error) => {
                return match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Ok(()),
                    _ => Err(error),
                };
            }
        }
        if begun.elapsed() >= WAIT {
            return Ok(());
        }
    }
    std::thread::sleep(WAIT.saturating_sub(begun.elapsed()));
    Ok(())
}

/// Hands over each datagram that comes within 2 ms, with its sender.
pub(super) fn datagrams(
    socket: &UdpSocket,
    buffer: &mut [u8],
    mut take: impl FnMut(&[u8], SocketAddr),
) -> io::Result<()> {
    within_wait(|| match socket.recv_from(buffer) {
        Ok((length, from)) => {
            take(&buffer[..length], from);
            Ok(true)
        }
        // One that was sent before met nobody.
        Err(error) if error.kind() == ErrorKind::ConnectionRefused => Ok(true),
        Err(error) => Err(error),
    })
}

/// Hands over the bytes that come within 2 ms.
///
/// # Errors
/// Why nothing more will come.
pub(super) fn bytes(
    stream: &mut TcpStream,
    buffer: &mut [u8],
    mut take: impl FnMut(&[u8]),
) -> Result<(), String> {
    let mut is_closed = false;
    let read = within_wait(|| {
        let length = stream.read(buffer)?;
        is_closed = length == 0;
        take(&buffer[..length]);
        Ok(!is_closed)
    });
    match read {
        Err(error) => Err(error.to_string()),
        Ok(()) if is_closed => Err("it closed the connection".to_owned()),
        Ok(()) => Ok(()),
    }
}

/// Opens a UDP socket at an address of this machine.
pub(super) fn bind(address: SocketAddr) -> Result<UdpSocket, Fault> {
    let opened = UdpSocket::bind(address).and_then(|socket| {
        socket.set_read_timeout(Some(WAIT))?;
        Ok(socket)
    });
    opened.map_err(|error| {
        let help = match error.kind() {
            ErrorKind::AddrInUse => "another program listens there: end it, or give another port",
            ErrorKind::AddrNotAvailable => {
                "give an address of this machine; 0.0.0.0 is all of them"
            }
            _ => "check the address and the port",
        };
        Fault::new(format!("cannot listen at UDP {address}: {error}"), help)
    })
}

/// Connects to a server.
pub(super) fn connect(server: &Server, patience: Duration) -> Result<TcpStream, Fault> {
    let mut reason = io::Error::from(ErrorKind::NotFound);
    for address in addresses(server)? {
        let connected = TcpStream::connect_timeout(&address, patience).and_then(|stream| {
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(WAIT))?;
            stream.set_write_timeout(Some(patience))?;
            Ok(stream)
        });
        match connected {
            Ok(stream) => return Ok(stream),
            Err(error) => reason = error,
        }
    }
    let help = "start it, check host and port, and see that no firewall is in the way";
    Err(Fault::new(format!("cannot reach {server}: {reason}"), help))
}

/// Returns the addresses of a server.
pub(super) fn addresses(server: &Server) -> Result<Vec<SocketAddr>, Fault> {
    let found = (server.host.as_str(), server.port).to_socket_addrs();
    let found: Vec<SocketAddr> = found.map(Iterator::collect).unwrap_or_default();
    if found.is_empty() {
        let message = format!("there is no host {:?}", server.host);
        return Err(Fault::new(message, "check its name, or give its address"));
    }
    Ok(found)
}
