//! Loops whose turns are shared out evenly, among threads that are awake.

use rayon::iter::{IndexedParallelIterator, MaxLen, MinLen};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Parts of a loop for each thread. By itself rayon makes two, and a part that a thread has begun can't be shared any more: the
/// others may wait for it as long as a quarter of the loop takes.
const PARTS_PER_THREAD: usize = 8;

/// What loops with an index can do besides rayon's methods.
pub trait Evenly: IndexedParallelIterator {
    /// The loop in several parts for each thread.
    fn evenly(self) -> MaxLen<MinLen<Self>> {
        self.evenly_by(1)
    }

    /// The same, but with `least` turns or more in a part, which should take some microseconds.
    fn evenly_by(self, least: usize) -> MaxLen<MinLen<Self>> {
        let most = self.len() / (PARTS_PER_THREAD * rayon::current_num_threads());
        self.with_min_len(least).with_max_len(most.max(least))
    }
}

impl<I: IndexedParallelIterator> Evenly for I {}

/// Looks for something to do, before a thread lets other programs have its turn; and pauses after a vain one, of some ten nanoseconds
/// each, in which a thread on the same core has it to itself.
const LOOKS: usize = 20;
const PAUSES: usize = 8;
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
        let is_vain = |_: &usize| {
            let is_vain = rayon::yield_now() != Some(rayon::Yield::Executed);
            if is_vain {
                (0..PAUSES).for_each(|_| std::hint::spin_loop());
            }
            is_vain
        };
        if (0..LOOKS).filter(is_vain).count() == LOOKS {
            std::thread::yield_now();
        }
        if !is_over.load(Ordering::Relaxed) {
            stay_awake(is_over);
        }
    });
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]
mod tests {
    use super::*;
    use rayon::prelude::*;

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn parts_are_many_but_not_too_small() {
        let parts = |turns: usize, least: usize, threads: usize| -> Vec<usize> {
            let parts = || (0..turns).into_par_iter().evenly_by(least).fold(|| 0, |n, _| n + 1).collect();
            pool(threads).install(parts)
        };
        for threads in [1, 2, 5] {
            let many = parts(100_000, 10, threads);
            assert!(many.len() >= PARTS_PER_THREAD * threads, "{threads} {}", many.len());
            assert_eq!(many.iter().sum::<usize>(), 100_000);
            assert!(parts(100, 20, threads).iter().all(|part| *part >= 20));
            assert_eq!(parts(0, 1, threads).iter().sum::<usize>(), 0);
        }
    }

    #[test]
    fn work_with_threads_awake_ends_with_its_result_inside_each_other_and_after_a_panic() {
        let sum = |n: u64| (0..n).into_par_iter().map(|i| i % 7).sum::<u64>();
        let nested = || -> u64 {
            let one = |i: u64| awake(|| sum(1_000 + i));
            awake(|| (0..40).into_par_iter().map(one).sum::<u64>())
        };
        let expected: u64 = (0..40).map(|i| (0..1_000 + i).map(|i| i % 7).sum::<u64>()).sum();
        for threads in [1, 2, 3, MANY] {
            let pool = pool(threads);
            assert_eq!(pool.install(nested), expected);
            let failed = || std::panic::catch_unwind(|| awake(|| -> u64 { panic!("as it is meant to") }));
            assert!(pool.install(failed).is_err());
            assert_eq!(pool.install(nested), expected);
        }
    }

    #[test]
    fn threads_are_left_alone_when_the_work_is_over() {
        let pool = pool(2);
        let watched = pool.install(|| {
            let watch = Watch(Arc::default());
            (0..2).for_each(|_| stay_awake(watch.0.clone()));
            Arc::downgrade(&watch.0)
        });
        // Jobs that come back hold on to it.
        while watched.strong_count() > 0 {
            std::thread::yield_now();
        }
    }
}
