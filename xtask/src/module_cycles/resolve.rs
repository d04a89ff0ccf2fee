//! From the paths in the code to the files that define what they name.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::need::Need;
use super::paths::Alias;
use super::source::Modules;

/// Longer chains of re-exports are circular.
const LONGEST_CHAIN: usize = 32;

/// The first need of each file for each other file.
pub(super) fn needs(modules: &Modules) -> Vec<Need> {
    let mut needs: BTreeMap<(PathBuf, PathBuf), Need> = BTreeMap::new();
    for index in 0..modules.all.len() {
        for need in needs_of(modules, index) {
            needs
                .entry((need.from.clone(), need.to.clone()))
                .or_insert(need);
        }
    }
    needs.into_values().collect()
}

fn needs_of(modules: &Modules, index: usize) -> Vec<Need> {
    let module = &modules.all[index];
    let imports = module.aliases.iter().map(|alias| {
        let needed = !is_facade(modules, index, alias);
        (&alias.path, alias.line, needed)
    });
    let mentions = module
        .mentions
        .iter()
        .map(|mention| (&mention.path, mention.line, true));
    let mut needs = Vec::new();
    for (path, line, needed) in imports.chain(mentions) {
        let Some(target) = resolve(modules, index, path, 0).filter(|_| needed) else {
            continue;
        };
        let to = &modules.all[target].file;
        if *to != module.file {
            needs.push(Need {
                from: module.file.clone(),
                line,
                path: path.join("::"),
                to: to.clone(),
            });
        }
    }
    needs
}

/// Whether a module only passes on what lies below it.
fn is_facade(modules: &Modules, index: usize, alias: &Alias) -> bool {
    let module = &modules.all[index];
    let used_here = alias
        .name
        .as_ref()
        .is_some_and(|name| module.names.contains(name));
    let Some(target) = resolve(modules, index, &alias.path, 0) else {
        return true;
    };
    alias.passed_on && !used_here && is_below(modules, target, index)
}

fn is_below(modules: &Modules, mut index: usize, ancestor: usize) -> bool {
    while let Some(parent) = modules.all[index].parent {
        if parent == ancestor {
            return true;
        }
        index = parent;
    }
    false
}

/// The module that defines what a path names, seen from a module; `None` when it is of another crate.
fn resolve(modules: &Modules, from: usize, path: &[String], depth: usize) -> Option<usize> {
    let (first, rest) = path.split_first()?;
    match first.as_str() {
        "crate" => member(modules, 0, rest, depth),
        "self" => member(modules, from, rest, depth),
        "super" => above(modules, modules.all[from].parent?, rest, depth),
        name => {
            let module = &modules.all[from];
            let known = module.children.contains_key(name)
                || module
                    .aliases
                    .iter()
                    .any(|alias| alias.name.as_deref() == Some(name));
            known.then(|| member(modules, from, path, depth)).flatten()
        }
    }
}

/// The same behind one `super`, which may be followed by more.
fn above(modules: &Modules, from: usize, path: &[String], depth: usize) -> Option<usize> {
    match path.split_first() {
        Some((first, rest)) if first == "super" => {
            above(modules, modules.all[from].parent?, rest, depth)
        }
        _ => member(modules, from, path, depth),
    }
}

/// The module that defines `path`, which begins with a name of the module `index`.
fn member(modules: &Modules, index: usize, path: &[String], depth: usize) -> Option<usize> {
    let module = &modules.all[index];
    let Some((name, rest)) = path.split_first() else {
        return Some(index);
    };
    if depth > LONGEST_CHAIN {
        return None;
    }
    if let Some(child) = module.children.get(name) {
        return member(modules, *child, rest, depth + 1);
    }
    if module.items.contains(name) {
        return Some(index);
    }
    let named = module
        .aliases
        .iter()
        .find(|alias| alias.name.as_ref() == Some(name));
    if let Some(alias) = named {
        let whole = [&alias.path[..], rest].concat();
        // A name of another crate that is only passed on needs no file of this one.
        return if alias.path.first() == Some(name) {
            None
        } else {
            resolve(modules, index, &whole, depth + 1)
        };
    }
    by_glob(modules, index, path, depth).or(Some(index))
}

/// The module behind a `*` of the module `index` that has the name.
fn by_glob(modules: &Modules, index: usize, path: &[String], depth: usize) -> Option<usize> {
    let globs = modules.all[index]
        .aliases
        .iter()
        .filter(|alias| alias.name.is_none());
    globs
        .filter_map(|glob| resolve(modules, index, &glob.path, depth + 1))
        .filter(|target| *target != index)
        .find(|target| has(modules, *target, &path[0]))
        .and_then(|target| member(modules, target, path, depth + 1))
}

fn has(modules: &Modules, index: usize, name: &str) -> bool {
    let module = &modules.all[index];
    module.items.contains(name)
        || module.children.contains_key(name)
        || module
            .aliases
            .iter()
            .any(|alias| alias.name.as_deref() == Some(name))
}
