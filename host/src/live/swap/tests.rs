//! Machines as threads.

use super::*;
use glam::DVec3;
use std::sync::mpsc::{Receiver, Sender, channel};

#[derive(Debug)]
struct Channels {
    rank: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Receiver<Vec<u8>>>,
}

impl Channels {
    fn new(ranks: usize) -> Vec<Self> {
        let (to, from) = (Vec::new, Vec::new);
        let ends = (0..ranks).map(|rank| (rank, to(), from()));
        let ends = ends.map(|(rank, to, from)| Self { rank, to, from });
        let mut ends: Vec<Self> = ends.collect();
        for (from, to) in (0..ranks).flat_map(|from| (0..ranks).map(move |to| (from, to))) {
            let (sender, receiver) = channel();
            ends[from].to.push(sender);
            ends[to].from.push(receiver);
        }
        ends
    }
}

impl Wire for Channels {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.to.len()
    }

    fn name(&self) -> String {
        "thread".to_owned()
    }

    fn send(&mut self, to: usize, message: &[u8]) {
        // A thread that has ended receives nothing.
        let _ = self.to[to].send(message.to_owned());
    }

    fn poll(&mut self, from: usize) -> Option<Vec<u8>> {
        self.from[from].try_recv().ok()
    }
}

const WAIT: Duration = Duration::from_secs(20);

fn order(frame: u64) -> Order {
    let x = frame as f32 * 0.1;
    Order {
        frame,
        look: Look {
            head: HeadPose {
                position: Vec3::new(x, 1.6, -0.1),
                ..HeadPose::IDENTITY
            },
            position: Vec3::new(x, 1.7, -0.2),
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            widen: 0.25,
        },
        place: RoomPlace {
            position: DVec3::new(f64::from(x), 0.25, -1.0e4),
            yaw: 0.5,
        },
        decision: Decision {
            steps: frame.is_multiple_of(2).then_some(1_000 + frame),
            whole_fovea: frame.is_multiple_of(3),
            rung: frame as usize % 5,
        },
        time: f64::from(frame as u32) / 60.0,
        purpose: [Purpose::Plain, Purpose::Shown, Purpose::Compared][frame as usize % 3],
    }
}

fn result(frame: u64) -> FrameResult {
    FrameResult {
        frame,
        ..FrameResult::default()
    }
}

fn with_machines<R: Send>(
    ranks: usize,
    wait: Duration,
    act: impl Fn(Cluster<Channels>) -> R + Sync,
) -> Vec<R> {
    let act = |wire| act(Cluster::new(wire, wait).unwrap());
    std::thread::scope(|scope| {
        let wires = Channels::new(ranks).into_iter();
        let machines: Vec<_> = wires.map(|wire| scope.spawn(|| act(wire))).collect();
        let ended = machines.into_iter().map(|machine| machine.join().unwrap());
        ended.collect()
    })
}

#[test]
fn all_receive_orders_and_the_leader_receives_results() {
    const FRAMES: u64 = 30;
    let frames = with_machines(3, WAIT, |mut lock| {
        let rank = lock.share().rank();
        let mut next = 0;
        loop {
            if rank == 0 && next == FRAMES {
                lock.end().unwrap();
                break;
            } else if rank == 0 {
                lock.order(&order(next)).unwrap();
            } else if let Some(found) = lock.obey().unwrap() {
                assert_eq!(found, order(next), "rank {rank}");
            } else {
                break;
            }
            let gathered = lock.gather(&FrameResult {
                frame: next,
                steps: 10 + rank as u64,
                need: 20,
                tracing: Duration::from_millis(5 - rank as u64),
                tiles: 4,
                unfinished: rank,
                unfinished_fovea: rank == 2,
                hashes: vec![100 * next + rank as u64],
            });
            if rank == 0 {
                let GatheredResults { all, slowest } = gathered.unwrap();
                assert_eq!((all.steps, all.need, all.tiles), (33, 60, 12));
                assert_eq!((all.unfinished, all.unfinished_fovea), (3, true));
                assert_eq!(all.tracing, Duration::from_millis(5));
                let base = 100 * next;
                assert_eq!(all.hashes, [base, base + 1, base + 2]);
                assert_eq!(slowest.steps, 10, "that of rank 0");
            }
            lock.swap(next).unwrap();
            next += 1;
        }
        let counts = |waits: &Waits| [&waits.waited, &waits.spread].map(Histogram::len);
        assert_eq!(lock.waits().map(counts), (rank == 0).then_some([FRAMES; 2]));
        next
    });
    assert_eq!(frames, [FRAMES; 3]);
}

#[test]
fn late_silent_and_unknown_machines_are_named() {
    let wait = Duration::from_millis(300);
    let errors = with_machines(3, wait, |mut lock| match lock.share().rank() {
        0 => {
            lock.order(&order(1)).unwrap();
            Some(lock.gather(&result(1)).unwrap_err())
        }
        1 => {
            lock.obey().unwrap();
            lock.gather(&result(1)).unwrap();
            None
        }
        _ => {
            lock.obey().unwrap();
            std::thread::sleep(2 * wait);
            None
        }
    });
    let error = errors[0].as_ref().unwrap().to_string();
    let late = "frame 1 is not there after 0.3 s on rank 2 (thread): see what has stopped there";
    assert!(error.starts_with(late), "{error}");
    let wait = Duration::from_millis(20);
    let errors = with_machines(2, wait, |mut lock| {
        (lock.share().rank() == 1).then(|| lock.obey().unwrap_err())
    });
    let error = errors[1].as_ref().unwrap().to_string();
    let silent = "rank 0 (thread) has said nothing for 0.2 s: see what has stopped there";
    assert!(error.starts_with(silent), "{error}");
    for nonsense in [&[9u8][..], &[], &[2, 1, 2, 3]] {
        let [mut leader, follower] = <[Channels; 2]>::try_from(Channels::new(2)).unwrap();
        leader.send(1, &[1, b'x']);
        leader.send(1, nonsense);
        let mut lock = Cluster::new(follower, wait).unwrap();
        let error = lock.obey().unwrap_err().to_string();
        let unknown = "rank 0 (x) sent a message of another version";
        assert!(error.starts_with(unknown), "{nonsense:?}: {error}");
    }
}

#[test]
fn shares_are_as_equal_as_can_be() {
    for (pictures, ranks) in (1..=12).flat_map(|all| (1..=all).map(move |ranks| (all, ranks))) {
        let shares = (0..ranks).filter_map(|rank| Share::new(rank, ranks));
        let count = |share: Share| {
            (0..pictures)
                .filter(|one| share.has(*one, pictures))
                .count()
        };
        let mut counts: Vec<usize> = shares.map(count).collect();
        counts.sort_unstable();
        assert_eq!(counts.iter().sum::<usize>(), pictures, "on {ranks}");
        assert!(counts[0] >= 1 && counts[ranks - 1] - counts[0] <= 1);
    }
    assert_eq!((Share::new(2, 2), Share::new(0, 0)), (None, None));
    assert!(!Share::ALL.has(0, 0));
}
