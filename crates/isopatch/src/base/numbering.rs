//! Keys numbered in the order in which they come up, by several threads.

use super::octree::{FIBONACCI, KeyMap};
use crate::parallel::Evenly;
use rayon::prelude::*;
use std::hash::BuildHasherDefault;

/// Keys for which a thread is worth its while.
const TASK: usize = 4_096;

/// Numbers from 0 on for different keys. What number a key has does not depend on how many threads there are.
#[derive(Debug, Default)]
pub(super) struct Numbering {
    /// The number of each key, in the map of [`part_of`] its key.
    parts: Vec<KeyMap<u32>>,
    /// The key of each number.
    pub keys: Vec<u64>,
}

/// Which of some maps knows about a key; from other bits than those by which a map spreads its keys.
fn part_of(key: u64, parts: usize) -> usize {
    (key.wrapping_mul(FIBONACCI) >> 40 & 0xffff) as usize % parts
}

impl Numbering {
    /// Numbers keys in the order in which they first come up; gives the number of each, too.
    pub fn of(keys: &[u64]) -> (Self, Vec<u32>) {
        let parts = (keys.len() / TASK).clamp(1, rayon::current_num_threads());
        let firsts: Vec<(KeyMap<u32>, Vec<u32>)> =
            (0..parts).into_par_iter().evenly().map(|part| first_places(keys, part, parts)).collect();
        let (mut parts, firsts): (Vec<_>, Vec<_>) = firsts.into_iter().unzip();
        let mut of_part: Vec<_> = firsts.iter().map(|firsts| firsts.iter()).collect();
        let (mut different, mut numbers) = (Vec::new(), Vec::with_capacity(keys.len()));
        for (i, key) in (0..).zip(keys) {
            let first = of_part[part_of(*key, parts.len())].next().copied().filter(|first| *first < i);
            let number = first.map_or(different.len() as u32, |first: u32| numbers[first as usize]);
            if first.is_none() {
                different.push(*key);
            }
            numbers.push(number);
        }
        let number_of = |first: &mut u32| *first = numbers[*first as usize];
        parts.par_iter_mut().evenly().for_each(|part| part.values_mut().for_each(number_of));
        (Self { parts, keys: different }, numbers)
    }

    /// The number of a key.
    pub fn get(&self, key: u64) -> Option<u32> {
        self.parts.get(part_of(key, self.parts.len().max(1)))?.get(&key).copied()
    }

    /// Gives a key the next number, if it has none.
    pub fn add(&mut self, key: u64) {
        let part = part_of(key, self.parts.len().max(1));
        if let Some(part) = self.parts.get_mut(part) {
            part.entry(key).or_insert_with(|| {
                self.keys.push(key);
                self.keys.len() as u32 - 1
            });
        }
    }
}

/// The keys of a part with the places where they first come up; and such a place for each key of the part in the list.
fn first_places(keys: &[u64], part: usize, parts: usize) -> (KeyMap<u32>, Vec<u32>) {
    // Most keys come up several times.
    let mut places =
        KeyMap::with_capacity_and_hasher(keys.len() / (4 * parts), BuildHasherDefault::default());
    let mut firsts = Vec::with_capacity(keys.len() / parts);
    let of_part = (0..).zip(keys).filter(|(_, key)| part_of(**key, parts) == part);
    firsts.extend(of_part.map(|(i, key)| *places.entry(*key).or_insert(i)));
    (places, firsts)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails by a panic is a test that fails")]
mod tests {
    use super::*;

    fn numbered(keys: &[u64], threads: usize) -> (Numbering, Vec<u32>) {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| Numbering::of(keys))
    }

    #[test]
    fn numbers_follow_the_order_of_keys_whatever_the_number_of_threads() {
        // Each key some three times, in no order.
        let keys: Vec<u64> = (0..60_000u64).map(|i| ((i * i * 7_919 + i) % 20_011) << 21).collect();
        let mut different = Vec::new();
        let mut expected = KeyMap::default();
        for key in &keys {
            expected.entry(*key).or_insert_with(|| {
                different.push(*key);
                different.len() as u32 - 1
            });
        }
        for threads in [1, 2, 3, 8] {
            let (mut numbering, numbers) = numbered(&keys, threads);
            assert_eq!(numbering.keys, different, "{threads}");
            assert!(keys.iter().zip(&numbers).all(|(key, number)| expected[key] == *number));
            assert!(keys.iter().all(|key| numbering.get(*key) == Some(expected[key])));
            assert_eq!(numbering.get(1), None);
            numbering.add(keys[5]);
            numbering.add(1);
            assert_eq!(numbering.get(1), Some(different.len() as u32));
            assert_eq!(numbering.keys.len(), different.len() + 1);
        }
    }

    #[test]
    fn of_no_keys_there_is_an_empty_numbering() {
        let (mut numbering, numbers) = Numbering::of(&[]);
        assert!(numbers.is_empty() && numbering.get(0).is_none());
        numbering.add(7);
        assert_eq!((numbering.get(7), numbering.keys), (Some(0), vec![7]));
    }
}
