//! The threads of a run.

use crate::failure::Failure;

/// Starts so many threads, by default one a processor. The calling thread is one of them: it works where it would wait otherwise.
pub fn start(threads: Option<usize>) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or_default()).use_current_thread();
    pool.build_global().map_err(Failure::Threads)
}
