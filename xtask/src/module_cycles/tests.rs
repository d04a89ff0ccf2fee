use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use super::cycles::shortest_cycles;
use super::need::Need;
use super::resolve::needs;
use super::source::read_crate;

/// The cycles of a crate of these files, each as the files it goes through.
fn cycles(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    let files: BTreeMap<&Path, &str> = files
        .iter()
        .map(|(path, text)| (Path::new(*path), *text))
        .collect();
    let read = |path: &Path| match files.get(path) {
        Some(text) => Ok((*text).to_owned()),
        None => Err(io::ErrorKind::NotFound.into()),
    };
    let modules = read_crate(Path::new("lib.rs"), &read).unwrap();
    let cycles = shortest_cycles(&needs(&modules));
    let through = |cycle: Vec<Need>| {
        let files = cycle.iter().map(|need| need.from.display().to_string());
        files.collect()
    };
    cycles.into_iter().map(through).collect()
}

#[test]
fn siblings_that_import_each_other_are_a_cycle() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::B; pub struct A;"),
        ("b.rs", "use super::a::A; pub struct B;"),
    ];
    assert_eq!(cycles(&files), [["a.rs", "b.rs"]]);
}

#[test]
fn one_way_is_no_cycle() {
    let files = [
        ("lib.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
        ("a.rs", "use crate::B; pub struct A(B);"),
        ("b.rs", "pub struct B;"),
    ];
    assert!(cycles(&files).is_empty());
}

#[test]
fn a_name_that_the_root_passes_on_is_traced_to_its_file() {
    let files = [
        ("lib.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
        ("a.rs", "use crate::B; pub struct A(B);"),
        ("b.rs", "use crate::A; pub struct B(A);"),
    ];
    assert_eq!(cycles(&files), [["a.rs", "b.rs"]]);
}

#[test]
fn a_name_behind_a_star_or_another_name_is_traced() {
    let files = [
        (
            "lib.rs",
            "mod a; mod b; pub use a::*; pub use b::B as Other;",
        ),
        ("a.rs", "use crate::Other; pub struct A(Other);"),
        ("b.rs", "use crate::A; pub struct B(A);"),
    ];
    assert_eq!(cycles(&files), [["a.rs", "b.rs"]]);
}

#[test]
fn a_path_in_code_and_in_a_macro_counts() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "pub fn a() -> u8 { crate::b::B }"),
        (
            "b.rs",
            "pub const B: u8 = 1; fn b() { println!(\"{}\", super::a::a()); }",
        ),
    ];
    assert_eq!(cycles(&files), [["a.rs", "b.rs"]]);
}

#[test]
fn a_path_that_begins_with_an_imported_module_counts() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b; pub fn a() { b::inner::f(); }"),
        ("b/mod.rs", "pub mod inner;"),
        ("b/inner.rs", "pub fn f() { crate::a::a(); }"),
    ];
    assert_eq!(cycles(&files), [["a.rs", "b/inner.rs"]]);
}

#[test]
fn a_parent_that_passes_on_its_child_may_be_needed_by_it() {
    let files = [
        ("lib.rs", "mod a;"),
        (
            "a/mod.rs",
            "mod child; pub use child::Child; pub struct Parent;",
        ),
        ("a/child.rs", "use super::Parent; pub struct Child(Parent);"),
    ];
    assert!(cycles(&files).is_empty());
}

#[test]
fn a_parent_that_uses_what_it_passes_on_needs_it() {
    let files = [
        ("lib.rs", "mod a;"),
        (
            "a/mod.rs",
            "mod child; pub use child::Child; pub struct Parent(Child);",
        ),
        (
            "a/child.rs",
            "use super::Parent; pub struct Child(Option<Box<Parent>>);",
        ),
    ];
    assert_eq!(cycles(&files), [["a/child.rs", "a/mod.rs"]]);
}

#[test]
fn a_field_or_method_of_the_same_name_uses_nothing_that_is_passed_on() {
    let files = [
        ("lib.rs", "mod a;"),
        (
            "a/mod.rs",
            "mod child; pub use child::{on, off}; pub struct Parent { on: u8 } impl Parent { fn f(&self) -> u8 { self.on + self.off() } }",
        ),
        (
            "a/child.rs",
            "use super::Parent; pub fn on(_: Parent) {} pub fn off(_: Parent) {}",
        ),
    ];
    assert!(cycles(&files).is_empty());
}

#[test]
fn a_private_use_of_a_child_is_a_need() {
    let files = [
        ("lib.rs", "mod a;"),
        (
            "a.rs",
            "mod child; use child::Child; pub struct Parent(Child);",
        ),
        (
            "a/child.rs",
            "pub struct Child(Option<Box<super::Parent>>);",
        ),
    ];
    assert_eq!(cycles(&files), [["a/child.rs", "a.rs"]]);
}

#[test]
fn who_may_use_an_item_is_no_need() {
    let files = [
        ("lib.rs", "mod a;"),
        ("a.rs", "mod child; pub fn f() { child::f() }"),
        (
            "a/child.rs",
            "pub(in crate::a) fn f() {} pub(super) struct S { pub(in crate::a) x: u8 }",
        ),
    ];
    assert!(cycles(&files).is_empty());
}

#[test]
fn tests_do_not_count() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::B; pub struct A(B);"),
        (
            "b.rs",
            "pub struct B; #[cfg(test)] mod tests { use crate::a::A; } #[cfg(test)] use crate::a::A;",
        ),
    ];
    assert!(cycles(&files).is_empty());
}

#[test]
fn a_module_inside_a_file_is_part_of_that_file() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        (
            "a.rs",
            "mod inner { use super::Outer; use crate::b::B; } pub struct Outer;",
        ),
        ("b.rs", "use crate::a::Outer; pub struct B(Outer);"),
    ];
    assert_eq!(cycles(&files), [["a.rs", "b.rs"]]);
}

#[test]
fn a_module_with_a_path_is_read_from_there() {
    let files = [
        ("lib.rs", "#[path = \"elsewhere/x.rs\"] mod a; mod b;"),
        (
            "elsewhere/x.rs",
            "mod child; use crate::b::B; pub struct A(B);",
        ),
        ("elsewhere/child.rs", "pub struct C;"),
        ("b.rs", "use crate::a::A; pub struct B(A);"),
    ];
    assert_eq!(cycles(&files), [["b.rs", "elsewhere/x.rs"]]);
}

#[test]
fn names_of_other_crates_are_no_need() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        (
            "a.rs",
            "use std::fmt; use crate::b::B; pub struct A(B); impl fmt::Debug for A {}",
        ),
        (
            "b.rs",
            "use a_crate::a::A; pub struct B(A); fn f() { ::a::f(); }",
        ),
    ];
    assert!(cycles(&files).is_empty());
}

#[test]
fn every_longer_way_around_is_found_once() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::b::B; pub struct A;"),
        ("b.rs", "use crate::c::C; pub struct B;"),
        ("c.rs", "use crate::a::A; pub struct C;"),
    ];
    assert_eq!(cycles(&files), [["a.rs", "b.rs", "c.rs"]]);
}

#[test]
fn a_need_names_file_line_and_path() {
    let need = Need {
        from: "a.rs".into(),
        line: 7,
        path: "crate::b::B".into(),
        to: "b.rs".into(),
    };
    assert_eq!(need.to_string(), "a.rs:7: crate::b::B -> b.rs");
}

#[test]
fn a_file_that_is_missing_or_does_not_parse_is_named() {
    let read = |text: &'static str| {
        move |path: &Path| match path.to_str() {
            Some("lib.rs") => Ok(text.to_owned()),
            _ => Err(io::ErrorKind::NotFound.into()),
        }
    };
    let missing = read_crate(Path::new("lib.rs"), &read("mod gone;")).map(|_| ());
    assert!(
        missing
            .unwrap_err()
            .to_string()
            .starts_with("gone/mod.rs: ")
    );
    let broken = read_crate(Path::new("lib.rs"), &read("\nfn (")).map(|_| ());
    assert!(
        broken
            .unwrap_err()
            .to_string()
            .starts_with("lib.rs: line 2: ")
    );
}
