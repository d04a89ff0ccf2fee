//! The supply is cut at every operation: the old record or the new one is there.

mod fake;

use fake::{Cut, Fake, Torn};
use proptest::prelude::*;
use record_store::{Area, Store, StoreError};

/// Most bytes of a record of these tests.
const MOST: usize = 40;
/// Three slots in an area.
const AREA: usize = 3 * (MOST + 16);

type Under<const UNIT: usize> = Store<Fake<UNIT, AREA>, MOST>;

fn latest<const UNIT: usize>(store: &mut Under<UNIT>) -> Option<Vec<u8>> {
    let mut room = [0; MOST];
    store.read(0, &mut room).unwrap().map(<[u8]>::to_vec)
}

fn record(number: usize) -> Vec<u8> {
    (0..=number * 7 % MOST)
        .map(|at| (number * 31 + at) as u8)
        .collect()
}

/// Saves records and is cut once; then the others. Returns the operations of it all.
fn scenario<const UNIT: usize>(cut: Option<(usize, Torn)>, seed: u64, saves: usize) -> usize {
    let mut store = Under::<UNIT>::new(Fake::new(seed));
    if let Some((operations, torn)) = cut {
        store.flash().cut_after(operations, torn);
    }
    let mut old = None;
    for number in 0..saves {
        let new = record(number);
        let stored = store.append(&new);
        if store.flash().is_off() {
            assert_eq!(stored, Err(StoreError::Flash(Cut)));
            store.flash().restart();
            let now = latest(&mut store);
            let context = format!("unit {UNIT}, cut {cut:?}, seed {seed}, save {number}");
            assert!(
                now == old || now.as_ref() == Some(&new),
                "{context}: {now:?}"
            );
            // And again after a new start.
            assert_eq!(latest(&mut store), now, "{context}");
            store.append(&new).unwrap();
        } else {
            stored.unwrap();
        }
        assert_eq!(
            latest(&mut store).as_ref(),
            Some(&new),
            "cut {cut:?}, seed {seed}"
        );
        old = Some(new);
    }
    store.flash().operations
}

fn cut_everywhere<const UNIT: usize>() {
    const SAVES: usize = 11;
    let operations = scenario::<UNIT>(None, 0, SAVES);
    assert!(operations > 50, "{operations}");
    for at in 0..operations {
        scenario::<UNIT>(Some((at, Torn::Nothing)), 1, SAVES);
        for seed in 0..20 {
            scenario::<UNIT>(Some((at, Torn::Part)), seed, SAVES);
        }
    }
}

#[test]
fn words_cut_at_every_operation_leave_the_old_or_the_new_record() {
    cut_everywhere::<4>();
}

#[test]
fn double_words_cut_at_every_operation_leave_the_old_or_the_new_record() {
    cut_everywhere::<8>();
}

/// Many cuts one after the other, also within the save that follows a cut.
fn cut_again_and_again<const UNIT: usize>(steps: &[(u8, Option<(usize, bool)>)], seed: u64) {
    let mut store = Under::<UNIT>::new(Fake::new(seed));
    let mut possible: Vec<Option<Vec<u8>>> = vec![None];
    for (number, (length, cut)) in steps.iter().enumerate() {
        if let Some((operations, is_torn)) = *cut {
            let torn = if is_torn { Torn::Part } else { Torn::Nothing };
            store.flash().cut_after(operations, torn);
        }
        let new = vec![number as u8; usize::from(*length)];
        let stored = store.append(&new);
        if store.flash().is_off() {
            store.flash().restart();
            let now = latest(&mut store);
            let is_new = now.as_ref() == Some(&new);
            assert!(is_new || possible.contains(&now), "{now:?} of {possible:?}");
            possible = vec![now];
        } else {
            stored.unwrap();
            store.flash().restart();
            assert_eq!(latest(&mut store).as_ref(), Some(&new));
            possible = vec![Some(new)];
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn any_cuts_leave_the_old_or_the_new_record(
        steps in prop::collection::vec((0..=MOST as u8, prop::option::of((0..20_usize, any::<bool>()))), 1..40),
        seed in any::<u64>(),
    ) {
        cut_again_and_again::<4>(&steps, seed);
        cut_again_and_again::<8>(&steps, seed);
    }
}

#[test]
fn a_bit_that_changes_by_itself_brings_the_record_before_back() {
    for byte in 0..MOST + 16 {
        let mut store = Under::<4>::new(Fake::new(3));
        store.append(&[1; MOST]).unwrap();
        store.append(&[2; MOST]).unwrap();
        // The second slot; the last four bytes of a head mean nothing.
        if (12..16).contains(&byte) {
            continue;
        }
        store.flash().flip(Area::First, MOST + 16 + byte, 0x10);
        assert_eq!(latest(&mut store), Some(vec![1; MOST]), "byte {byte}");
    }
}

#[test]
fn older_records_are_there_in_order() {
    let mut store = Under::<8>::new(Fake::new(5));
    assert_eq!(Under::<8>::SLOTS, 3);
    for number in 0..20 {
        assert_eq!(store.sequence().unwrap(), number as u32);
        store.append(&[number; 5]).unwrap();
        for age in 0..=number.min(2) {
            let mut room = [0; 5];
            let read = store.read(age.into(), &mut room).unwrap();
            assert_eq!(read, Some(&[number - age; 5][..]), "{number} {age}");
        }
        assert_eq!(store.read(6, &mut [0; 5]), Ok(None));
        let mut all = Vec::new();
        store
            .for_each(|sequence, bytes| all.push((sequence, bytes[0])))
            .unwrap();
        all.sort_unstable();
        let kept = u8::try_from(all.len()).unwrap();
        let expected = (number + 1 - kept..=number).map(|number| (u32::from(number) + 1, number));
        assert!(
            kept > number.min(2) && all.iter().copied().eq(expected),
            "{all:?}"
        );
    }
}

#[test]
fn an_area_is_erased_once_for_all_its_slots() {
    let mut store = Under::<8>::new(Fake::new(6));
    for number in 0..30 {
        assert_eq!(store.is_full().unwrap(), number % 3 == 0);
        store.append(&[number; 5]).unwrap();
        assert_eq!(store.flash().erases, usize::from(number) / 3 + 1);
    }
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let mut store = Under::<8>::new(Fake::new(7));
    store.append(&[1; MOST]).unwrap();
    let operations = store.flash().operations;
    assert_eq!(
        store.append(&[2; MOST + 1]),
        Err(StoreError::TooLong {
            expected: MOST,
            actual: MOST + 1
        })
    );
    assert_eq!(store.flash().operations, operations);
    assert_eq!(
        store.read(0, &mut [0; MOST - 1]),
        Err(StoreError::Room {
            expected: MOST,
            actual: MOST - 1
        })
    );
    store.append(&[]).unwrap();
    assert_eq!(latest(&mut store), Some(vec![]));
}
