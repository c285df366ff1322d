//! Numbers sorted into buckets.

/// The numbers from 0 on, each in the bucket that it was said to belong to, ascending in each bucket; in one array, and made in
/// linear time.
#[derive(Clone, Debug)]
pub(crate) struct Buckets {
    sorted: Vec<u32>,
    /// End of each bucket in `sorted`; it starts where the one before ends.
    end: Vec<u32>,
}

impl Buckets {
    /// Sorts the number `i` into bucket `bucket_of[i]`, and into none of the `count` buckets if there is no such one.
    pub fn new(bucket_of: &[u32], count: usize) -> Self {
        let mut end = vec![0u32; count];
        for bucket in bucket_of {
            if let Some(n) = end.get_mut(*bucket as usize) {
                *n += 1;
            }
        }
        let mut total = 0;
        for n in &mut end {
            total += std::mem::replace(n, total);
        }
        let mut sorted = vec![0; total as usize];
        for (i, bucket) in (0..).zip(bucket_of) {
            if let Some(place) = end.get_mut(*bucket as usize) {
                sorted[*place as usize] = i;
                *place += 1;
            }
        }
        Self { sorted, end }
    }

    /// The numbers in a bucket.
    pub fn get(&self, bucket: usize) -> &[u32] {
        let start = if bucket == 0 { 0 } else { self.end[bucket - 1] };
        &self.sorted[start as usize..self.end[bucket] as usize]
    }

    /// All numbers, bucket after bucket, and the end of each bucket among them.
    pub fn into_parts(self) -> (Vec<u32>, Vec<u32>) {
        (self.sorted, self.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_hold_their_numbers_in_ascending_order() {
        let bucket_of = [2, 0, u32::MAX, 2, 5, 0, 2];
        let buckets = Buckets::new(&bucket_of, 4);
        let expected: [&[u32]; 4] = [&[1, 5], &[], &[0, 3, 6], &[]];
        assert_eq!([0, 1, 2, 3].map(|b| buckets.get(b)), expected);
        assert_eq!(buckets.into_parts(), (vec![1, 5, 0, 3, 6], vec![2, 2, 5, 5]));
        assert_eq!(Buckets::new(&[], 0).into_parts(), (vec![], vec![]));
    }
}
