//! How many faces a surface needs at least.

/// Growth of the count while nothing works.
const GROWTH: f64 = 1.3;
/// Halvings of the interval in which the least count was found.
const BISECTIONS: usize = 3;

/// The least even count above `asked` and up to `most` that was seen to work: found by growing steps and bisection.
///
/// Counts neither work nor fail monotonically, so this is no proven minimum.
pub(super) fn least_that_works(asked: usize, most: usize, works: impl Fn(usize) -> bool) -> Option<usize> {
    let even = |n: usize| n + n % 2;
    let mut too_few = asked;
    let mut least = loop {
        let count = even((too_few as f64 * GROWTH) as usize + 2);
        if count > most {
            return None;
        }
        if works(count) {
            break count;
        }
        too_few = count;
    };
    for _ in 0..BISECTIONS {
        let middle = even((too_few + least) / 2);
        if middle >= least || middle <= too_few {
            break;
        }
        if works(middle) {
            least = middle;
        } else {
            too_few = middle;
        }
    }
    Some(least)
}

#[cfg(test)]
mod tests {
    use super::least_that_works;

    #[test]
    fn the_least_count_is_closed_in_on() {
        for (asked, needed) in [(4, 60), (20, 22), (100, 5_000)] {
            let least = least_that_works(asked, 100_000, |n| n >= needed).unwrap();
            assert!(
                least >= needed && least as f64 <= 1.1 * needed as f64 + 2.0,
                "{asked}, {needed}: {least}"
            );
        }
        assert_eq!(least_that_works(4, 100, |_| false), None);
    }
}
