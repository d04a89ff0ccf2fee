//! Every combination of facts that one axis and a group of two can reach, against every promise of the master that facts can express.
//!
//! `cargo test -p can-motion --test every_fact -- --nocapture` prints how many there are. A broken promise is shown with the shortest
//! path to it.

mod changes;
mod drive;
mod ends;
mod exits;
mod faults;
mod group;
mod mistakes;
mod needs;
mod own_moves;
mod promises;
mod readings;
mod rules;
mod table;
mod walk;

use can_motion::facts::Brake;
use changes::every_promise;
use group::{POLICIES, Policy, group_of_two};
use rules::{BRAKES, RULES, Rules, every_combination, inputs};
use walk::Broken;

/// Every promise about one axis, on every step; the number of combinations.
fn one_axis(rules: &Rules) -> Result<Vec<usize>, Broken> {
    let check = |before, input, after| every_promise(rules, before, input, after);
    let counts = BRAKES.map(|brake| rules.walk_one(brake, check).map(|seen| seen.len()));
    counts.into_iter().collect()
}

/// What the exit keeps back, and what a command needs, in every combination that the types allow, whether it can be reached or not.
fn every_combination_is_guarded(rules: &Rules) -> Result<usize, Broken> {
    let all = every_combination();
    for facts in &all {
        let with_path = |promise| Broken {
            promise,
            path: format!("no input: it cannot be reached today, {facts:?}"),
        };
        exits::keeps_back(rules, facts).map_err(with_path)?;
        for input in inputs() {
            needs::is_fit_for(rules, facts, input).map_err(with_path)?;
        }
    }
    Ok(all.len())
}

fn kept<T>(result: Result<T, Broken>) -> T {
    match result {
        Ok(value) => value,
        Err(Broken { promise, path }) => panic!("{promise}\n   by {path}"),
    }
}

#[test]
fn one_axis_keeps_every_promise() {
    let counts = kept(one_axis(&RULES));
    println!(
        "one axis: {} combinations, with a brake {}: every promise kept",
        counts[0], counts[1]
    );
}

#[test]
fn exit_and_commands_are_guarded_whatever_the_facts_are() {
    let count = kept(every_combination_is_guarded(&RULES));
    println!("exit and commands: {count} combinations of values, every promise kept");
}

#[test]
fn nothing_is_a_dead_end() {
    let count = kept(ends::nothing_is_a_dead_end(&RULES));
    println!(
        "from {count} combinations: off, repaired, cleared, written to, and back to streaming"
    );
}

#[test]
fn what_the_master_believes_of_a_drive_is_true() {
    let counts = kept(drive::beliefs_are_true(&RULES));
    println!(
        "facts, drive and frames under way: {} combinations, with a brake {}",
        counts[0], counts[1]
    );
}

#[test]
fn a_group_of_two_keeps_every_promise() {
    for policy in POLICIES {
        let count = kept(group_of_two(&RULES, policy, [Brake::Absent; 2]));
        println!("group of two, {policy:?}: {count} combinations, every promise kept");
    }
}

#[test]
fn a_group_of_an_axis_with_a_brake_and_one_without_keeps_every_promise() {
    let brakes = [Brake::Unclear, Brake::Absent];
    let count = kept(group_of_two(&RULES, Policy::RampDown, brakes));
    println!("group of two, one with a brake: {count} combinations, every promise kept");
}

/// The first promise that these functions break, by everything above.
fn first_broken(rules: &Rules) -> Option<Broken> {
    let group = |policy| group_of_two(rules, policy, [Brake::Absent; 2]).err();
    one_axis(rules)
        .err()
        .or_else(|| every_combination_is_guarded(rules).err())
        .or_else(|| ends::nothing_is_a_dead_end(rules).err())
        .or_else(|| drive::beliefs_are_true(rules).err())
        .or_else(|| POLICIES.into_iter().find_map(group))
}

#[test]
fn every_seeded_mistake_is_found() {
    let mistakes = mistakes::all();
    let mut missed = Vec::new();
    for (number, mistake) in mistakes.iter().enumerate() {
        let name = mistake.name;
        match first_broken(&mistake.rules) {
            Some(Broken { promise, path }) => {
                println!("{}. {name}\n   breaks: {promise}\n   by {path}", number + 1);
            }
            None => missed.push(name),
        }
    }
    assert!(missed.is_empty(), "not found: {missed:#?}");
    println!("{} seeded mistakes, every one found", mistakes.len());
}
