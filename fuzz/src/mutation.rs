//! Mutations of an input that are the same on every machine.

/// Words that a mutation may write.
pub type Vocabulary = &'static [&'static str];

/// Longest input that a mutation makes.
const MAX_LEN: usize = 8192;

/// A stream of mutated inputs.
pub struct Mutator {
    state: u64,
}

impl Mutator {
    /// The stream of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// One of `corpus` with one to eight edits: bytes flipped, taken out, doubled, words and
    /// pieces of other inputs written in.
    ///
    /// # Panics
    /// If `corpus` or `words` is empty.
    pub fn next_input(&mut self, corpus: &[Vec<u8>], words: Vocabulary) -> Vec<u8> {
        let mut input = corpus[self.below(corpus.len())].clone();
        for _ in 0..=self.below(8) {
            self.edit(&mut input, corpus, words);
        }
        input.truncate(MAX_LEN);
        input
    }

    fn edit(&mut self, input: &mut Vec<u8>, corpus: &[Vec<u8>], words: Vocabulary) {
        let (from, to) = self.range(input.len());
        match self.below(7) {
            0 => {
                if let Some(byte) = input.get_mut(from) {
                    *byte ^= 1 << self.below(8);
                }
            }
            1 => drop(input.drain(from..to)),
            2 => {
                let copy = input[from..to].to_vec();
                let at = self.below(input.len() + 1);
                input.splice(at..at, copy);
            }
            3 => {
                let word = words[self.below(words.len())];
                input.splice(from..from, word.bytes());
            }
            4 => {
                let word = words[self.below(words.len())];
                input.splice(from..to, word.bytes());
            }
            5 => self.replace_number(input, words),
            _ => {
                let other = &corpus[self.below(corpus.len())];
                let (other_from, other_to) = self.range(other.len());
                input.splice(from..to, other[other_from..other_to].iter().copied());
            }
        }
    }

    /// Writes a word, or another digit, over one run of digits.
    fn replace_number(&mut self, input: &mut Vec<u8>, words: Vocabulary) {
        let starts: Vec<usize> = (0..input.len())
            .filter(|&i| input[i].is_ascii_digit() && (i == 0 || !input[i - 1].is_ascii_digit()))
            .collect();
        if starts.is_empty() {
            return;
        }
        let from = starts[self.below(starts.len())];
        let len = input[from..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count();
        let text = match self.below(3) {
            0 => words[self.below(words.len())].to_owned(),
            1 => self.below(10).to_string(),
            _ => self.below(1 << 20).to_string(),
        };
        input.splice(from..from + len, text.bytes());
    }

    /// A range of at most 32 bytes, often short.
    fn range(&mut self, len: usize) -> (usize, usize) {
        let from = self.below(len + 1);
        let longest = 1 << self.below(6);
        (from, (from + self.below(longest + 1)).min(len))
    }

    fn below(&mut self, bound: usize) -> usize {
        // The remainder is below a usize.
        usize::try_from(self.next_u64() % bound as u64).unwrap_or(0)
    }

    /// splitmix64.
    fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_makes_the_same_inputs() {
        let corpus = [b"schema = 1".to_vec(), Vec::new()];
        let stream = |seed| {
            let mut mutator = Mutator::new(seed);
            (0..200)
                .map(|_| mutator.next_input(&corpus, &["nan"]))
                .collect::<Vec<_>>()
        };
        assert_eq!(stream(1), stream(1), "a stream repeats");
        assert_ne!(stream(1), stream(2), "seeds differ");
    }
}
