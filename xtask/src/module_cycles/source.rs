//! The modules of a crate as their files declare them, without what is only for tests.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

use syn::{Attribute, Expr, ExprLit, Item, ItemMod, Lit, Meta};

use super::paths::{Alias, Mention, aliases_of, mentions_of};
use crate::error::Error;

/// Gives the text of a file.
pub(super) type Read<'a> = dyn Fn(&Path) -> io::Result<String> + 'a;

/// The modules of one crate; the first is its root.
#[derive(Default)]
pub(super) struct Modules {
    pub(super) all: Vec<Module>,
}

/// One module, in a file of its own or inside another's.
pub(super) struct Module {
    pub(super) file: PathBuf,
    pub(super) parent: Option<usize>,
    pub(super) children: BTreeMap<String, usize>,
    /// What it defines itself.
    pub(super) items: BTreeSet<String>,
    /// What its `use` declarations bring in.
    pub(super) aliases: Vec<Alias>,
    /// What the rest of its code mentions.
    pub(super) mentions: Vec<Mention>,
    /// Every name in the rest of its code.
    pub(super) names: BTreeSet<String>,
}

impl Modules {
    /// The files, each once.
    pub(super) fn files(&self) -> BTreeSet<&Path> {
        self.all
            .iter()
            .map(|module| module.file.as_path())
            .collect()
    }
}

/// Reads a crate from its root file.
///
/// # Errors
/// When a file is missing or does not parse.
pub(super) fn read_crate(root: &Path, read: &Read) -> Result<Modules, Error> {
    let mut reader = Reader {
        read,
        modules: Modules::default(),
    };
    let folder = root.parent().unwrap_or(Path::new("")).to_path_buf();
    reader.file(root.to_path_buf(), folder, None)?;
    Ok(reader.modules)
}

struct Reader<'a> {
    read: &'a Read<'a>,
    modules: Modules,
}

impl Reader<'_> {
    /// Reads a module that has a file; `folder` is where the files of its children are.
    fn file(
        &mut self,
        file: PathBuf,
        folder: PathBuf,
        parent: Option<usize>,
    ) -> Result<usize, Error> {
        let broken = |reason: String| Error::Source {
            path: file.clone(),
            reason,
        };
        let text = (self.read)(&file).map_err(|error| broken(error.to_string()))?;
        let parsed = syn::parse_file(&text)
            .map_err(|error| broken(format!("line {}: {error}", error.span().start().line)))?;
        self.module(file, folder, parent, parsed.items)
    }

    fn module(
        &mut self,
        file: PathBuf,
        folder: PathBuf,
        parent: Option<usize>,
        items: Vec<Item>,
    ) -> Result<usize, Error> {
        let index = self.modules.all.len();
        self.modules.all.push(Module {
            file: file.clone(),
            parent,
            children: BTreeMap::new(),
            items: BTreeSet::new(),
            aliases: Vec::new(),
            mentions: Vec::new(),
            names: BTreeSet::new(),
        });
        for item in items {
            if is_for_tests(attributes(&item)) {
                continue;
            }
            match item {
                Item::Mod(declaration) => self.child(index, &file, &folder, declaration)?,
                Item::Use(declaration) => {
                    self.modules.all[index]
                        .aliases
                        .extend(aliases_of(&declaration));
                }
                other => self.code(index, &other),
            }
        }
        Ok(index)
    }

    fn child(
        &mut self,
        parent: usize,
        file: &Path,
        folder: &Path,
        declaration: ItemMod,
    ) -> Result<(), Error> {
        let name = declaration.ident.to_string();
        let below = folder.join(&name);
        let child = match declaration.content {
            Some((_, items)) => self.module(file.to_path_buf(), below, Some(parent), items)?,
            None => {
                let (found, below) = match path_of(&declaration.attrs) {
                    // The files of its children are beside it, as for every `mod.rs`.
                    Some(path) => {
                        let found = file.parent().unwrap_or(Path::new("")).join(path);
                        let beside = found.parent().unwrap_or(Path::new("")).to_path_buf();
                        (found, beside)
                    }
                    None => (self.file_of(folder, &name), below),
                };
                self.file(found, below, Some(parent))?
            }
        };
        self.modules.all[parent].children.insert(name, child);
        Ok(())
    }

    fn file_of(&self, folder: &Path, name: &str) -> PathBuf {
        let beside = folder.join(format!("{name}.rs"));
        if (self.read)(&beside).is_ok() {
            beside
        } else {
            folder.join(name).join("mod.rs")
        }
    }

    fn code(&mut self, index: usize, item: &Item) {
        let module = &mut self.modules.all[index];
        module.items.extend(name_of(item));
        let (mentions, names) = mentions_of(item);
        module.mentions.extend(mentions);
        module.names.extend(names);
    }
}

/// Whether an item exists in tests only.
fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let Meta::List(list) = &attribute.meta else {
            return attribute.path().is_ident("test");
        };
        let condition = list.tokens.to_string();
        list.path.is_ident("cfg")
            && (condition == "test" || (condition.starts_with("all") && condition.contains("test")))
    })
}

/// The path in `#[path = "..."]`.
fn path_of(attributes: &[Attribute]) -> Option<String> {
    attributes
        .iter()
        .find_map(|attribute| match &attribute.meta {
            Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
                Expr::Lit(ExprLit {
                    lit: Lit::Str(text),
                    ..
                }) => Some(text.value()),
                _ => None,
            },
            _ => None,
        })
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

fn name_of(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(ident.to_string())
}
