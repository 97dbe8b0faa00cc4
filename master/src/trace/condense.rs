//! Long runs of frames of one kind, told as their first, their number and their last.

/// Frames that are shown one by one even if they are of one kind.
const SHORT: usize = 4;

/// Frames as they are to be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group<T> {
    /// This one.
    One(T),
    /// So many of one kind that are left out.
    LeftOut(usize),
}

/// Leaves out the middle of each run of items for which `kind` gives the same kind. Items without a kind always stay.
pub fn condense<T: Copy, K: Eq>(items: &[T], kind: impl Fn(&T) -> Option<K>) -> Vec<Group<T>> {
    let runs = items.chunk_by(|a, b| kind(a).is_some() && kind(a) == kind(b));
    runs.flat_map(|run| match run {
        [first, middle @ .., last] if run.len() > SHORT => {
            vec![
                Group::One(*first),
                Group::LeftOut(middle.len()),
                Group::One(*last),
            ]
        }
        _ => run.iter().copied().map(Group::One).collect(),
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_long_runs_of_one_kind_are_cut() {
        let items = [1, 1, 2, 2, 2, 2, 2, 2, 3, 0, 0, 0, 0, 0, 0];
        let kind = |item: &i32| (*item != 0).then_some(*item);
        let mut expected = vec![
            Group::One(1),
            Group::One(1),
            Group::One(2),
            Group::LeftOut(4),
            Group::One(2),
        ];
        expected.extend([3, 0, 0, 0, 0, 0, 0].map(Group::One));
        assert_eq!(condense(&items, kind), expected);
    }
}
