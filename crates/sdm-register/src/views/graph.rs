//! Which views hang together.

/// The components of a graph, each in increasing order, the one with the smallest index first.
pub(crate) fn components(count: usize, edges: impl Iterator<Item = [usize; 2]>) -> Vec<Vec<usize>> {
    let mut root: Vec<usize> = (0..count).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while root[i] != i {
            root[i] = root[root[i]];
            i = root[i];
        }
        i
    }
    for [i, j] in edges {
        let (a, b) = (find(&mut root, i), find(&mut root, j));
        root[a.max(b)] = a.min(b);
    }
    let mut out: Vec<Vec<usize>> = Vec::new();
    let mut place = vec![usize::MAX; count];
    for i in 0..count {
        let top = find(&mut root, i);
        if place[top] == usize::MAX {
            place[top] = out.len();
            out.push(Vec::new());
        }
        out[place[top]].push(i);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::components;

    #[test]
    fn finds_what_hangs_together() {
        let edges = [[4, 1], [2, 4], [5, 3]];
        assert_eq!(components(6, edges.into_iter()), [vec![0], vec![1, 2, 4], vec![3, 5]]);
        assert!(components(0, [].into_iter()).is_empty());
    }
}
