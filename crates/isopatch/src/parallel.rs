//! Loops whose turns are shared out evenly, among threads that are awake.

use rayon::iter::{IndexedParallelIterator, MaxLen, MinLen};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Parts of a loop for each thread. By itself rayon makes two, and a part that a thread has begun can't be shared any more: the
/// others may wait for it as long as a quarter of the loop takes.
const PARTS_PER_THREAD: usize = 8;

/// What loops with an index can do besides rayon's methods.
pub trait Evenly: IndexedParallelIterator {
    /// The loop in parts of `least` turns or more, several for each thread. So many turns should take some microseconds.
    fn evenly(self, least: usize) -> MaxLen<MinLen<Self>> {
        let most = self.len() / (PARTS_PER_THREAD * rayon::current_num_threads());
        self.with_min_len(least).with_max_len(most.max(least))
    }
}

impl<I: IndexedParallelIterator> Evenly for I {}

/// Looks for something to do, before a thread lets other programs have its turn.
const LOOKS: usize = 20;
/// Threads from which on they may sleep: then there is too little for each in any case.
const MANY: usize = 16;

/// Does something with the threads kept awake. A thread that sleeps is woken too late for the many short loops of a mesh of some
/// hundred faces; the price is that all threads are busy in between, too.
///
/// Nothing waits for this, so that it cannot block anything, and the work may do the same inside.
pub fn awake<R>(work: impl FnOnce() -> R) -> R {
    let watch = Watch(Arc::default());
    let threads = rayon::current_num_threads();
    if (2..MANY).contains(&threads) {
        (0..threads).for_each(|_| stay_awake(watch.0.clone()));
    }
    work()
}

/// Says that the work is over: when it is dropped, be it by a panic.
struct Watch(Arc<AtomicBool>);

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A job that finds other jobs, and soon comes back as a new one: a thread that waits for something sees in between whether
/// that is there.
fn stay_awake(is_over: Arc<AtomicBool>) {
    rayon::spawn(move || {
        let looks = (0..LOOKS).map(|_| rayon::yield_now());
        if looks.filter(|found| *found == Some(rayon::Yield::Executed)).count() == 0 {
            std::thread::yield_now();
        }
        if !is_over.load(Ordering::Relaxed) {
            stay_awake(is_over);
        }
    });
}
