//! Ctrl-C ends the program at once, but never between the creation of a temporary file and its removal.

use crate::failure::{EXIT_INTERRUPTED, Failure};
use signal_hook::consts::SIGINT;
use signal_hook::flag;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

/// Are no files being written?
static IDLE: LazyLock<Arc<AtomicBool>> = LazyLock::new(|| Arc::new(AtomicBool::new(true)));
/// Has Ctrl-C been pressed while files were written?
static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// From here on Ctrl-C ends the program with its exit status; see [`Writing`] for the exception. There is no thread that waits for
/// it: with a second thread, a small run would take a tenth longer.
pub fn install() -> Result<(), Failure> {
    flag::register_conditional_shutdown(SIGINT, EXIT_INTERRUPTED.into(), Arc::clone(&IDLE))
        .and_then(|_| flag::register(SIGINT, Arc::clone(&REQUESTED)))
        .map_err(Failure::Handler)?;
    Ok(())
}

/// While this lives, Ctrl-C does not end the program but makes the next write of an [`Interruptible`] fail.
pub struct Writing(());

impl Writing {
    pub fn begin() -> Self {
        IDLE.store(false, Ordering::SeqCst);
        Self(())
    }

    /// Has Ctrl-C been pressed since the beginning?
    pub fn interrupted(&self) -> bool {
        REQUESTED.load(Ordering::Relaxed)
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        IDLE.store(true, Ordering::SeqCst);
    }
}

/// A writer that fails after Ctrl-C.
pub struct Interruptible<W>(pub W);

impl<W: Write> Write for Interruptible<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if REQUESTED.load(Ordering::Relaxed) {
            // Not `ErrorKind::Interrupted`, after which `write_all` tries again.
            return Err(io::Error::other("interrupted"));
        }
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
