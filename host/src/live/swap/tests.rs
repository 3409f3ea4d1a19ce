//! Machines as threads.

use super::*;
use std::time::Instant;

const WAIT: Duration = Duration::from_secs(20);

fn look(number: f32) -> Look {
    Look {
        head: HeadPose {
            position: Vec3::new(number, 1.6, -0.1),
            ..HeadPose::IDENTITY
        },
        position: Vec3::new(number, 1.7, -0.2),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        widen: 0.25,
    }
}

fn order(frame: u64) -> Order {
    Order {
        frame,
        look: look(frame as f32 * 0.1),
        rung: frame as usize % 5,
        steps: frame.is_multiple_of(2).then_some(1_000 + frame),
        whole_fovea: frame.is_multiple_of(3),
        purpose: [Purpose::Plain, Purpose::Shown, Purpose::Compared][frame as usize % 3],
    }
}

/// Has each machine of a cluster do something.
fn with_machines<R: Send>(
    ranks: usize,
    wait: Duration,
    act: impl Fn(Cluster<Channels>) -> R + Sync,
) -> Vec<R> {
    std::thread::scope(|scope| {
        let machines: Vec<_> = Channels::new(ranks)
            .into_iter()
            .map(|wire| {
                let act = &act;
                scope.spawn(move || act(Cluster::new(wire, wait).unwrap()))
            })
            .collect();
        let ended = machines.into_iter().map(|machine| machine.join().unwrap());
        ended.collect()
    })
}

#[test]
fn all_hear_what_is_ordered_and_one_hears_what_it_took() {
    const FRAMES: u64 = 30;
    let heard = with_machines(3, WAIT, |mut lock| {
        let rank = lock.share().rank();
        let mut frames = Vec::new();
        let mut next = 0;
        loop {
            let order = if rank == 0 {
                if next == FRAMES {
                    lock.end().unwrap();
                    break;
                }
                let order = order(next);
                lock.order(&order).unwrap();
                order
            } else {
                match lock.obey().unwrap() {
                    Some(order) => order,
                    None => break,
                }
            };
            assert_eq!(order, super::tests::order(next), "rank {rank}");
            next += 1;
            let own = Done {
                frame: order.frame,
                steps: 10 + rank as u64,
                need: 20,
                tracing: Duration::from_millis(5 - rank as u64),
                tiles: 4,
                unfinished: rank,
                unfinished_fovea: rank == 2,
                hashes: vec![100 * order.frame + rank as u64],
            };
            let gathered = lock.gather(&own).unwrap();
            if rank == 0 {
                let all = &gathered.all;
                assert_eq!((all.steps, all.need, all.tiles), (33, 60, 12));
                assert_eq!((all.unfinished, all.unfinished_fovea), (3, true));
                assert_eq!(all.tracing, Duration::from_millis(5));
                let base = 100 * order.frame;
                assert_eq!(all.hashes, [base, base + 1, base + 2]);
                assert_eq!(gathered.slowest.steps, 10, "that of rank 0");
            }
            lock.swap(order.frame).unwrap();
            frames.push(order.frame);
        }
        let counts = |waits: Waits<'_>| [waits.waited, waits.spread].map(Histogram::len);
        assert_eq!(lock.waits().map(counts), (rank == 0).then_some([FRAMES; 2]));
        frames
    });
    for frames in heard {
        assert!(frames.into_iter().eq(0..FRAMES));
    }
}

/// Whoever orders may be the last itself: that it waits for nobody does not say that all
/// were ready at once.
#[test]
fn the_spread_is_from_the_first_to_the_last_of_all() {
    let later = Duration::from_millis(30);
    for late in 0..3 {
        let spreads = with_machines(3, WAIT, |mut lock| {
            let rank = lock.share().rank();
            if rank == 0 {
                lock.order(&order(1)).unwrap();
            } else {
                lock.obey().unwrap();
            }
            if rank == late {
                std::thread::sleep(later);
            }
            let own = Done {
                frame: 1,
                ..Done::default()
            };
            lock.gather(&own).unwrap();
            lock.waits().map(|waits| waits.spread.max())
        });
        let spread = Duration::from_micros(spreads[0].unwrap());
        // Others may be held up, too.
        assert!(spread > later / 2, "of rank {late}: {spread:?}");
    }
}

#[test]
fn one_that_is_late_is_named() {
    let wait = Duration::from_millis(300);
    let said = with_machines(3, wait, |mut lock| {
        match lock.share().rank() {
            0 => {
                lock.order(&order(1)).unwrap();
                let begun = Instant::now();
                let own = Done {
                    frame: 1,
                    ..Done::default()
                };
                let error = lock.gather(&own).unwrap_err();
                assert!(begun.elapsed() >= wait);
                Some(error.to_string())
            }
            1 => {
                let order = lock.obey().unwrap().unwrap();
                let own = Done {
                    frame: order.frame,
                    ..Done::default()
                };
                lock.gather(&own).unwrap();
                None
            }
            // It hears, and does nothing.
            _ => {
                lock.obey().unwrap();
                std::thread::sleep(2 * wait);
                None
            }
        }
    });
    let said: Vec<String> = said.into_iter().flatten().collect();
    assert_eq!(
        said,
        [
            "frame 1 is not there after 0.3 s on rank 2 (thread): see what has stopped there, and start all of them again"
        ]
    );
}

#[test]
fn silence_and_nonsense_are_told() {
    let wait = Duration::from_millis(20);
    let said = with_machines(2, wait, |mut lock| {
        (lock.share().rank() == 1).then(|| lock.obey().unwrap_err().to_string())
    });
    assert_eq!(
        said[1].as_deref(),
        Some(
            "rank 0 (thread) has said nothing for 0.2 s: see what has stopped there, and start all of them again"
        )
    );
    for nonsense in [&[9u8][..], &[], &[2, 1, 2, 3]] {
        let [mut leader, follower] = <[Channels; 2]>::try_from(Channels::new(2)).unwrap();
        leader.send(1, &[1, b'x']);
        leader.send(1, nonsense);
        let mut lock = Cluster::new(follower, wait).unwrap();
        let error = lock.obey().unwrap_err();
        let name = "rank 0 (x)".to_owned();
        assert_eq!(error, SwapError::Unknown { name }, "{nonsense:?}");
    }
}

#[test]
fn one_machine_waits_for_nobody() {
    let own = Done {
        frame: 3,
        steps: 7,
        hashes: vec![1],
        ..Done::default()
    };
    let gathered = Alone.gather(&own).unwrap();
    assert_eq!(gathered.all, own);
    assert_eq!(
        (gathered.slowest.steps, gathered.slowest.hashes.len()),
        (7, 0)
    );
    assert_eq!(Alone.obey(), Ok(None));
    assert!(Alone.waits().is_none() && Alone.share() == Share::ALL);
    let cluster = with_machines(1, WAIT, |mut lock| {
        lock.order(&order(0)).unwrap();
        let gathered = lock.gather(&own).unwrap();
        lock.swap(0).unwrap();
        lock.end().unwrap();
        gathered.all
    });
    assert_eq!(cluster[0], own);
}

#[test]
fn every_picture_is_somebodys() {
    for pictures in 1..=12 {
        for ranks in 1..=pictures {
            let mut counts = vec![0; ranks];
            let mut last = 0;
            for picture in 0..pictures {
                let shares = (0..ranks).filter_map(|rank| Share::new(rank, ranks));
                let owners: Vec<Share> = shares
                    .filter(|share| share.has(picture, pictures))
                    .collect();
                assert_eq!(owners.len(), 1, "{picture} of {pictures} on {ranks}");
                let rank = owners[0].rank();
                assert!(rank >= last, "those of a machine are beside one another");
                last = rank;
                counts[rank] += 1;
            }
            let most = counts.iter().max().unwrap();
            let least = counts.iter().min().unwrap();
            assert!(*least >= 1 && most - least <= 1, "{counts:?}");
        }
    }
    assert_eq!(Share::new(2, 2), None);
    assert_eq!(Share::new(0, 0), None);
    assert!(!Share::ALL.has(0, 0));
}
