//! Raw frames as a thread of its own reads them, while others wait or are damaged.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Buffers of frames: one is read, one is damaged and written, and the others wait.
const N_BUFFERS: usize = 4;

/// A frame that was read.
pub(super) struct Frame {
    pub(super) idx: u64,
    pub(super) bytes: Vec<u8>,
    /// When its last byte came.
    pub(super) whole_at: Instant,
}

/// How the input ended.
#[derive(Debug)]
pub(super) enum InputEnd {
    /// After some bytes of a frame; 0 between two.
    Ended { n_came: usize },
    /// The system refused.
    Failed(std::io::Error),
}

/// What comes next.
pub(super) enum Next {
    Frame(Frame),
    End(InputEnd),
    /// Nothing in this time.
    Nothing,
}

/// Frames that wait, and the thread that reads them.
pub(super) struct WaitingFrames {
    shared: Arc<Shared>,
    late_after: Option<Duration>,
}

struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    waiting: VecDeque<Frame>,
    end: Option<InputEnd>,
    /// Buffers that hold no frame.
    spare: Vec<Vec<u8>>,
    n_read: u64,
}

impl WaitingFrames {
    /// Reads frames of so many bytes. Where frames are late after some time, those that have waited longer are left out for
    /// newer ones, so that whoever sends never waits longer than that; else the sender waits. The thread ends with the input,
    /// or with the process.
    pub(super) fn read_from(
        mut input: impl Read + Send + 'static,
        n_bytes: usize,
        late_after: Option<Duration>,
    ) -> Self {
        let shared = Arc::new(Shared {
            state: Mutex::new(State {
                spare: (0..N_BUFFERS).map(|_| vec![0; n_bytes]).collect(),
                ..State::default()
            }),
            changed: Condvar::new(),
        });
        let reader = Arc::clone(&shared);
        std::thread::spawn(move || {
            loop {
                let mut bytes = reader.buffer(late_after);
                let end = read_one(&mut input, &mut bytes).err();
                if !reader.take_in(bytes, end) {
                    return;
                }
            }
        });
        Self { shared, late_after }
    }

    /// The next frame, or the newest where older ones are late; waits for it no longer than so.
    pub(super) fn next(&self, most: Duration) -> Next {
        let until = Instant::now() + most;
        let mut state = self.shared.lock();
        loop {
            while let Some(frame) = state.waiting.pop_front() {
                let is_late = (self.late_after).is_some_and(|late| frame.whole_at.elapsed() > late);
                // The newest is shown, however late it is.
                if !is_late || state.waiting.is_empty() {
                    return Next::Frame(frame);
                }
                state.spare.push(frame.bytes);
                self.shared.changed.notify_all();
            }
            if let Some(end) = state.end.take() {
                return Next::End(end);
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Next::Nothing;
            }
            state = self.shared.wait(state, Some(left));
        }
    }

    /// Takes the memory of a frame back.
    pub(super) fn give_back(&self, bytes: Vec<u8>) {
        self.shared.lock().spare.push(bytes);
        self.shared.changed.notify_all();
    }
}

impl Shared {
    /// No thread panics while it holds the lock.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'s>(
        &self,
        state: MutexGuard<'s, State>,
        most: Option<Duration>,
    ) -> MutexGuard<'s, State> {
        match most {
            Some(most) => {
                let waited = self.changed.wait_timeout(state, most);
                waited.unwrap_or_else(PoisonError::into_inner).0
            }
            None => {
                let waited = self.changed.wait(state);
                waited.unwrap_or_else(PoisonError::into_inner)
            }
        }
    }

    /// A buffer to read into: a spare one, or that of the frame that has waited longest, once that is late.
    fn buffer(&self, late_after: Option<Duration>) -> Vec<u8> {
        let mut state = self.lock();
        loop {
            if let Some(buffer) = state.spare.pop() {
                return buffer;
            }
            let oldest = state.waiting.front().map(|frame| frame.whole_at.elapsed());
            let left = late_after.zip(oldest);
            let left = left.map(|(late, waited)| late.saturating_sub(waited));
            if left.is_some_and(|left| left.is_zero())
                && let Some(frame) = state.waiting.pop_front()
            {
                return frame.bytes;
            }
            state = self.wait(state, left);
        }
    }

    /// Takes in a frame, or the end; whether more may come.
    fn take_in(&self, bytes: Vec<u8>, end: Option<InputEnd>) -> bool {
        let mut state = self.lock();
        let is_frame = end.is_none();
        if is_frame {
            let idx = state.n_read;
            state.n_read += 1;
            state.waiting.push_back(Frame {
                idx,
                bytes,
                whole_at: Instant::now(),
            });
        }
        state.end = end;
        self.changed.notify_all();
        is_frame
    }
}

fn read_one(input: &mut impl Read, buffer: &mut [u8]) -> Result<(), InputEnd> {
    let mut n_came = 0;
    while n_came < buffer.len() {
        match input.read(&mut buffer[n_came..]) {
            Ok(0) => return Err(InputEnd::Ended { n_came }),
            Ok(n) => n_came += n,
            Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
            Err(cause) => return Err(InputEnd::Failed(cause)),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use super::*;

    /// Frames of one byte, their number, at once; tells when all of them were read.
    struct Numbers {
        next: u8,
        n: u8,
        all_read: Sender<()>,
    }

    impl Read for Numbers {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            if self.next == self.n {
                // Nobody may listen.
                let _ = self.all_read.send(());
                return Ok(0);
            }
            buffer[0] = self.next;
            self.next += 1;
            Ok(1)
        }
    }

    /// A hundred of them, and what tells when all were read.
    fn hundred(late_after: Option<Duration>) -> (WaitingFrames, Receiver<()>) {
        let (all_read, is_all_read) = channel();
        let numbers = Numbers {
            next: 0,
            n: 100,
            all_read,
        };
        let frames = WaitingFrames::read_from(numbers, 1, late_after);
        (frames, is_all_read)
    }

    fn next(frames: &WaitingFrames) -> Option<(u64, u8)> {
        match frames.next(Duration::from_secs(60)) {
            Next::Frame(frame) => {
                let number = (frame.idx, frame.bytes[0]);
                frames.give_back(frame.bytes);
                Some(number)
            }
            Next::End(InputEnd::Ended { n_came: 0 }) => None,
            Next::End(end) => panic!("{end:?}"),
            Next::Nothing => panic!("nothing comes"),
        }
    }

    #[test]
    fn whoever_sends_does_not_wait_for_a_slow_reader_where_late_frames_are_left_out() {
        let (frames, is_all_read) = hundred(Some(Duration::ZERO));
        let read = is_all_read.recv_timeout(Duration::from_secs(60));
        assert!(read.is_ok(), "the sender is held up");
        assert_eq!(next(&frames), Some((99, 99)), "the newest");
        assert_eq!(next(&frames), None);
    }

    #[test]
    fn every_frame_comes_in_its_turn_where_none_is_late() {
        let (frames, _) = hundred(None);
        for k in 0..100 {
            assert_eq!(next(&frames), Some((u64::from(k), k)));
        }
        assert_eq!(next(&frames), None);
    }
}
