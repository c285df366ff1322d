//! Ctrl-C ends the program at once, but never between the creation of a temporary file and its removal.

use crate::failure::{EXIT_INTERRUPTED, Failure};
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Are files being written?
static WRITING: Mutex<bool> = Mutex::new(false);
/// Has Ctrl-C been pressed while files were written?
static REQUESTED: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C ends the program with its exit status; see [`Writing`] for the exception.
pub fn install() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        // Held until the program ends, so that no file is begun any more.
        let writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
        if *writing {
            REQUESTED.store(true, Ordering::Relaxed);
        } else {
            let _ = writeln!(io::stderr(), "interrupted");
            std::process::exit(EXIT_INTERRUPTED.into());
        }
    })
    .map_err(Failure::Handler)
}

/// While this lives, Ctrl-C does not end the program but makes the next write of an [`Interruptible`] fail.
pub struct Writing(());

impl Writing {
    pub fn begin() -> Self {
        *WRITING.lock().unwrap_or_else(PoisonError::into_inner) = true;
        Self(())
    }

    /// Has Ctrl-C been pressed since the beginning?
    pub fn interrupted(&self) -> bool {
        REQUESTED.load(Ordering::Relaxed)
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        *WRITING.lock().unwrap_or_else(PoisonError::into_inner) = false;
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
