//! How far the cores are apart on which two threads run: a process that answers every line with the time that a cache line takes
//! from one to the other and back. On a machine that others use, too, it may change from one minute to the next.

use std::io::{self, BufRead, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

const ROUNDS: usize = 20_000;

fn wait_for(turn: &AtomicUsize, number: usize) {
    while turn.load(Ordering::Acquire) != number {
        std::hint::spin_loop();
    }
}

/// Two threads that have a number by turns.
fn nanoseconds() -> f64 {
    let turn = AtomicUsize::new(0);
    let mut start = Instant::now();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for round in 0..ROUNDS {
                wait_for(&turn, 2 * round + 1);
                turn.store(2 * round + 2, Ordering::Release);
            }
        });
        // The first round is over when the other thread runs.
        for round in 0..ROUNDS {
            turn.store(2 * round + 1, Ordering::Release);
            wait_for(&turn, 2 * round + 2);
            if round == 0 {
                start = Instant::now();
            }
        }
    });
    1e9 * start.elapsed().as_secs_f64() / (ROUNDS - 1) as f64
}

fn main() -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "ready")?;
    for line in io::stdin().lock().lines() {
        line?;
        writeln!(out, "nanoseconds={}", nanoseconds())?;
        out.flush()?;
    }
    Ok(())
}
