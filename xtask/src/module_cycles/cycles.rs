//! The shortest ways around in the graph of needs.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

use super::need::Need;

/// For each need that is part of a cycle the shortest way around through it, each cycle once, short ones first.
pub(super) fn shortest_cycles(needs: &[Need]) -> Vec<Vec<Need>> {
    let mut by_file: BTreeMap<&Path, Vec<&Need>> = BTreeMap::new();
    for need in needs {
        by_file.entry(&need.from).or_default().push(need);
    }
    let cycles: BTreeSet<Vec<Need>> = needs
        .iter()
        .filter_map(|need| around(&by_file, need))
        .map(from_the_first_file)
        .collect();
    let mut cycles: Vec<Vec<Need>> = cycles.into_iter().collect();
    cycles.sort_by_key(Vec::len);
    cycles
}

/// The shortest way that begins with `first` and ends at its file.
fn around(by_file: &BTreeMap<&Path, Vec<&Need>>, first: &Need) -> Option<Vec<Need>> {
    let mut came_by: BTreeMap<&Path, &Need> = BTreeMap::from([(first.to.as_path(), first)]);
    let mut waiting = VecDeque::from([first.to.as_path()]);
    while let Some(file) = waiting.pop_front() {
        if file == first.from {
            return Some(way_back(&came_by, first));
        }
        for need in by_file.get(file).into_iter().flatten() {
            if !came_by.contains_key(need.to.as_path()) {
                came_by.insert(&need.to, need);
                waiting.push_back(&need.to);
            }
        }
    }
    None
}

fn way_back(came_by: &BTreeMap<&Path, &Need>, first: &Need) -> Vec<Need> {
    let mut way = Vec::new();
    let mut file = first.from.as_path();
    while let Some(need) = came_by.get(file) {
        way.push((*need).clone());
        file = &need.from;
        if *need == first {
            break;
        }
    }
    way.reverse();
    way
}

/// The same cycle, begun at the file that sorts first.
fn from_the_first_file(mut cycle: Vec<Need>) -> Vec<Need> {
    let first = (0..cycle.len()).min_by_key(|index| cycle[*index].from.clone());
    cycle.rotate_left(first.unwrap_or(0));
    cycle
}
