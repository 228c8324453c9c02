//! In which order nodes are eliminated, and which of them are eliminated together.

use crate::FractureError;
use crate::mesh::to_u32;

/// Unknowns of a node. All have the same neighbors.
pub(super) const PER_NODE: usize = 3;

/// Two supernodes are one if of the entries of both together at most this part is none, for so many
/// columns of both: small ones cost more in calls than in zeros. The numbers are those of the library
/// `faer`, so that sums keep the order that they had with it.
const MERGES: [(usize, f64); 3] = [(16, 0.8), (48, 0.1), (usize::MAX, 0.05)];

/// Lists of nodes, one behind the other.
#[derive(Debug)]
pub(super) struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// For each node those of higher number that it has a pair with, in order and each once.
    pub(super) fn later(n_nodes: usize, pairs: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let mut starts = vec![0_u32; n_nodes + 1];
        for [a, b] in pairs.clone() {
            starts[a.min(b) as usize + 1] += 1;
        }
        for node in 0..n_nodes {
            starts[node + 1] += starts[node];
        }
        let mut ends = starts.clone();
        let mut items = vec![0; starts[n_nodes] as usize];
        for [a, b] in pairs {
            let end = &mut ends[a.min(b) as usize];
            items[*end as usize] = a.max(b);
            *end += 1;
        }
        let mut kept = 0;
        for node in 0..n_nodes {
            let (from, to) = (starts[node] as usize, starts[node + 1] as usize);
            items[from..to].sort_unstable();
            starts[node] = to_u32(kept);
            for at in from..to {
                if at == from || items[at] != items[at - 1] {
                    // Never beyond `at`: what is read is not yet overwritten but by itself.
                    let item = items[at];
                    items[kept] = item;
                    kept += 1;
                }
            }
        }
        starts[n_nodes] = to_u32(kept);
        items.truncate(kept);
        Self { starts, items }
    }

    pub(super) fn n(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn of(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.items[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// The same pairs of nodes with other numbers.
    pub(super) fn renumbered(&self, number: &[u32]) -> Self {
        let pairs = (0..to_u32(self.n())).flat_map(|node| {
            let other = move |&other: &u32| [number[node as usize], number[other as usize]];
            self.of(node).iter().map(other)
        });
        Self::later(self.n(), pairs)
    }

    /// Place of each node in an order that keeps the factor sparse: approximate minimum degree of
    /// the graph of nodes, a third of the work of that of unknowns \[Amestoy1996\].
    pub(super) fn elimination_places(&self) -> Result<Vec<u32>, FractureError> {
        let mut columns = vec![0];
        let mut rows = Vec::with_capacity(self.items.len() + self.n());
        for node in 0..to_u32(self.n()) {
            rows.push(node as usize);
            rows.extend(self.of(node).iter().map(|&other| other as usize));
            columns.push(rows.len());
        }
        let (_, place, _) = amd::order(self.n(), &columns, &rows, &amd::Control::default())
            .map_err(|status| FractureError::Solver {
                cause: format!("the order of elimination: {status:?}"),
            })?;
        Ok(place.into_iter().map(to_u32).collect())
    }
}

/// Nodes that are eliminated together.
#[derive(Debug)]
pub(super) struct Supernode {
    pub(super) first: u32,
    pub(super) n: usize,
    /// Those behind them that they are coupled with, in the matrix or by what is eliminated.
    pub(super) below: Vec<u32>,
}

/// Nodes in the order of elimination as supernodes: runs of nodes each of which is eliminated into
/// the next alone and has its neighbors \[Ng1993\], some of them merged.
pub(super) fn supernodes(later: &Lists) -> Vec<Supernode> {
    let n = later.n();
    const NONE: u32 = u32::MAX;
    // Of each node, the last of those whose first later neighbor it is; `next` leads to the others.
    let mut last_child = vec![NONE; n];
    let mut next = vec![NONE; n];
    // Of each node, which run it is in.
    let mut run_of = vec![0_u32; n];
    let mut runs: Vec<Supernode> = Vec::new();
    let mut seen_by = vec![NONE; n];
    for node in 0..to_u32(n) {
        let own = later.of(node);
        let child = last_child[node as usize];
        let goes_on = child != NONE
            && child + 1 == node
            && next[child as usize] == NONE
            && own
                .iter()
                .all(|&other| seen_by[other as usize] == run_of[child as usize]);
        if goes_on {
            if let Some(run) = runs.last_mut() {
                run.n += 1;
                run.below.remove(0);
            }
        } else {
            let run = to_u32(runs.len());
            let mut below = own.to_vec();
            for &other in own {
                seen_by[other as usize] = run;
            }
            let mut child = child;
            while child != NONE {
                let of_child = &runs[run_of[child as usize] as usize];
                for &other in of_child.below.iter().filter(|&&other| other > node) {
                    if std::mem::replace(&mut seen_by[other as usize], run) != run {
                        below.push(other);
                    }
                }
                child = next[child as usize];
            }
            below.sort_unstable();
            runs.push(Supernode {
                first: node,
                n: 1,
                below,
            });
        }
        run_of[node as usize] = to_u32(runs.len() - 1);
        let below = runs.last().and_then(|run| run.below.first());
        if let Some(&parent) = below {
            next[node as usize] = std::mem::replace(&mut last_child[parent as usize], node);
        }
    }
    merged(runs)
}

/// Takes runs together with the next one where that costs little.
fn merged(runs: Vec<Supernode>) -> Vec<Supernode> {
    let mut kept: Vec<(Supernode, usize)> = Vec::with_capacity(runs.len());
    for mut run in runs {
        let mut n_zeros = 0;
        if let Some((child, zeros)) = kept.last()
            && child.below.first() == Some(&run.first)
            && let Some(merged) = zeros_of_both(child, &run, *zeros)
        {
            run.first = child.first;
            run.n += child.n;
            n_zeros = merged;
            kept.pop();
        }
        kept.push((run, n_zeros));
    }
    kept.into_iter().map(|(run, _)| run).collect()
}

/// Entries that are none in both together, if those are few enough.
fn zeros_of_both(child: &Supernode, parent: &Supernode, zeros: usize) -> Option<usize> {
    let [n_child, n_parent] = [child, parent].map(|run| PER_NODE * run.n);
    let [below_child, below] = [child, parent].map(|run| PER_NODE * run.below.len());
    let new = (n_parent + below - below_child) * n_child;
    if new == 0 {
        return Some(zeros);
    }
    let n = n_child + n_parent;
    let n_entries = n * (n + 1) / 2 + below * n;
    let fits =
        |&(most, part): &(usize, f64)| n <= most && n_entries as f64 * part >= (zeros + new) as f64;
    MERGES.iter().any(fits).then_some(zeros + new)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Nodes behind each node that it is coupled with once those before it are eliminated.
    fn eliminated(later: &Lists) -> Vec<BTreeSet<u32>> {
        let n = to_u32(later.n());
        let mut behind: Vec<BTreeSet<u32>> = (0..n)
            .map(|node| later.of(node).iter().copied().collect())
            .collect();
        for node in 0..n {
            let all: Vec<u32> = behind[node as usize].iter().copied().collect();
            for (k, &a) in all.iter().enumerate() {
                behind[a as usize].extend(&all[k + 1..]);
            }
        }
        behind
    }

    fn graphs() -> impl Iterator<Item = Lists> {
        (0..400_u32).map(|k| {
            let n = 1 + k % 40;
            let pair = move |j: u32| [(31 * j * j + 17 * k + 5) % n, (37 * j + k * k) % n];
            let pairs = (0..k * 7 % 90).map(pair).filter(|[a, b]| a != b);
            Lists::later(n as usize, pairs)
        })
    }

    #[test]
    fn supernodes_hold_all_that_elimination_couples_and_few_zeros() {
        let (mut n_together, mut n_zeros, mut n_entries) = (0, 0, 0);
        for later in graphs() {
            let behind = eliminated(&later);
            let mut node = 0;
            for supernode in supernodes(&later) {
                assert_eq!(supernode.first, node, "one behind the other");
                let end = node + to_u32(supernode.n);
                let last: Vec<u32> = behind[end as usize - 1].iter().copied().collect();
                assert_eq!(supernode.below, last, "what is behind the last of it");
                let held: BTreeSet<u32> = (node..end).chain(supernode.below.clone()).collect();
                for own in node..end {
                    let wanted = &behind[own as usize];
                    assert!(wanted.is_subset(&held), "{own}: {wanted:?} in {held:?}");
                    n_zeros += held.range(own + 1..).count() - wanted.len();
                }
                n_together += supernode.n - 1;
                let n = supernode.n;
                n_entries += n * (n - 1) / 2 + n * supernode.below.len();
                node = end;
            }
            assert_eq!(node as usize, later.n());
        }
        assert!(
            n_together > 1500,
            "{n_together} of 8200 nodes are not alone"
        );
        assert!(5 * n_zeros < n_entries, "{n_zeros} of {n_entries}");
    }

    #[test]
    fn nodes_of_one_pattern_are_one_and_others_only_where_it_costs_little() {
        let nodes = |pairs: &[[u32; 2]], n: usize| {
            let of = supernodes(&Lists::later(n, pairs.iter().copied()));
            let of = of.into_iter().map(|one| (one.first, one.n, one.below));
            of.collect::<Vec<_>>()
        };
        // Two nodes without neighbors, and three that all know each other.
        let apart = [[2, 3], [2, 4], [3, 4]];
        let alone = |node: u32| (node, 1, Vec::new());
        assert_eq!(nodes(&apart, 5), [alone(0), alone(1), (2, 3, vec![])]);
        // A chain of 40: each has only the next behind it, and runs of five are merged, with most entries none.
        let chain: Vec<[u32; 2]> = (1..40).map(|k| [k - 1, k]).collect();
        let merged = nodes(&chain, 40);
        assert!((8..40).contains(&merged.len()), "{merged:?}");
        assert!(merged.iter().all(|(_, n, _)| *n <= 6), "{merged:?}");
    }

    #[test]
    fn an_order_numbers_every_node_once_and_fills_less() -> Result<(), FractureError> {
        // A grid, whose natural order fills its band.
        let side = 20;
        let at = |x: u32, y: u32| y * side + x;
        let grid = (0..side).flat_map(|y| {
            let beside = (1..side).map(move |x| [at(x - 1, y), at(x, y)]);
            beside.chain(
                (0..side)
                    .filter(move |_| y > 0)
                    .map(move |x| [at(x, y - 1), at(x, y)]),
            )
        });
        let later = Lists::later((side * side) as usize, grid);
        let places = later.elimination_places()?;
        let all: BTreeSet<u32> = places.iter().copied().collect();
        assert_eq!(all, (0..side * side).collect());
        let fill = |later: &Lists| eliminated(later).iter().map(BTreeSet::len).sum::<usize>();
        let (natural, ordered) = (fill(&later), fill(&later.renumbered(&places)));
        assert!(2 * ordered < natural, "{ordered}, {natural}");
        Ok(())
    }
}
