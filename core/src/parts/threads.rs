//! Parts in the threads of one process: messages are arrays that are handed over.

use super::{Communicator, order::Order, serve};
use std::{
    collections::BTreeMap,
    sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel},
    thread::{self, JoinHandle},
};

/// Most messages that may be on their way from one part to another. A part that is ahead waits.
const ON_THE_WAY: usize = 4;

/// The carrier of one part.
struct Between {
    part: usize,
    parts: usize,
    to: BTreeMap<usize, SyncSender<Vec<f64>>>,
    from: BTreeMap<usize, Receiver<Vec<f64>>>,
    orders: Orders,
}

/// The end of the channels of orders that a part has.
enum Orders {
    /// Part 0 sends orders, and joins the other threads at its end.
    Given(Vec<Sender<Vec<u64>>>, Vec<JoinHandle<()>>),
    Taken(Receiver<Vec<u64>>),
}

/// Starts the threads of all parts but part 0. Returns the carrier of part 0; the threads end when
/// it is dropped.
pub(super) fn start(parts: usize) -> Box<dyn Communicator> {
    let (mut to, mut from): (Vec<_>, Vec<_>) = (0..parts).map(|_| (BTreeMap::new(), BTreeMap::new())).unzip();
    // Part 0 exchanges messages with all parts, the others with their neighbours. Across the ends
    // of a ring, one of the two is part 0.
    let talk = |a: usize, b: usize| a != b && (a == 0 || b == 0 || a.abs_diff(b) == 1);
    for (a, b) in (0..parts).flat_map(|a| (0..parts).map(move |b| (a, b))).filter(|(a, b)| talk(*a, *b)) {
        let (sender, receiver) = sync_channel(ON_THE_WAY);
        to[a].insert(b, sender);
        from[b].insert(a, receiver);
    }
    let (mut given, mut threads, mut first) = (Vec::new(), Vec::new(), None);
    for (part, (to, from)) in to.into_iter().zip(from).enumerate() {
        if part == 0 {
            first = Some((to, from));
            continue;
        }
        let (sender, orders) = channel();
        given.push(sender);
        let mut between = Between { part, parts, to, from, orders: Orders::Taken(orders) };
        threads.push(thread::spawn(move || serve(&mut between)));
    }
    let (to, from) = first.unwrap_or_default();
    Box::new(Between { part: 0, parts, to, from, orders: Orders::Given(given, threads) })
}

const ENDED: &str = "the other part has not ended";

impl Communicator for Between {
    fn part(&self) -> usize {
        self.part
    }

    fn parts(&self) -> usize {
        self.parts
    }

    fn broadcast(&mut self, words: &mut Vec<u64>) {
        match &self.orders {
            // A failed send is ignored: part 0 panics later, where it expects numbers of that
            // thread.
            Orders::Given(given, _) => given.iter().for_each(|one| one.send(words.clone()).unwrap_or(())),
            Orders::Taken(taken) => *words = taken.recv().expect(ENDED),
        }
    }

    fn send(&mut self, to: usize, numbers: &[f64]) {
        self.to[&to].send(numbers.to_vec()).expect(ENDED);
    }

    fn receive(&mut self, from: usize, numbers: &mut [f64]) {
        numbers.copy_from_slice(&self.from[&from].recv().expect(ENDED));
    }

    fn pass(&mut self, to: Option<(usize, &[f64])>, from: Option<(usize, &mut [f64])>) {
        // The channel has room for one message more than a part can be ahead: this does not wait.
        if let Some((to, numbers)) = to {
            self.send(to, numbers);
        }
        if let Some((from, numbers)) = from {
            self.receive(from, numbers);
        }
    }
}

impl Drop for Between {
    fn drop(&mut self) {
        self.end();
    }
}

impl Between {
    /// As part 0, orders the other threads to end, and waits until they have.
    fn end(&mut self) {
        if let Orders::Given(given, threads) = &mut self.orders {
            given.drain(..).for_each(|one| one.send(Order::End.words()).unwrap_or(()));
            // Closes the channels, so that no thread waits for this part.
            (self.to, self.from) = (BTreeMap::new(), BTreeMap::new());
            // A thread that panicked has printed its message.
            threads.drain(..).for_each(|thread| drop(thread.join()));
        }
    }
}
