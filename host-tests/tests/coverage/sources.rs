//! The items of a crate, read from its source: what a path on the page may name.
//!
//! Macros are not expanded. What a macro call at the level of items says in names counts as declared there: function codes, objects and
//! validated numbers are made that way.

use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::{Attribute, Fields, ImplItem, Item, TraitItem, Visibility};

/// One declared name.
#[derive(Debug, Clone)]
pub(crate) struct Declared {
    modules: Vec<String>,
    /// `Type::member`, or one name.
    item: Vec<String>,
    is_public: bool,
}

/// The items of one crate.
#[derive(Debug, Default)]
pub(crate) struct Items {
    declared: Vec<Declared>,
}

/// What of the syntax of a crate other checks read; each with its module.
#[derive(Default)]
pub(crate) struct Syntax {
    pub(crate) structs: Vec<(Vec<String>, syn::ItemStruct)>,
    pub(crate) enums: Vec<(Vec<String>, syn::ItemEnum)>,
    pub(crate) macro_calls: Vec<(Vec<String>, TokenStream)>,
}

/// Reads a crate from its root file, modules for tests left out.
pub(crate) fn read(root: &Path) -> (Items, Syntax) {
    let mut reader = Reader::default();
    let folder = root.parent().expect("a root file has a folder");
    reader.file(root, folder, &[]);
    let Reader { items, syntax } = reader;
    assert!(!items.declared.is_empty(), "{} is empty", root.display());
    (items, syntax)
}

/// What became of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Found {
    Public,
    Private,
    Nothing,
}

impl Items {
    /// Modules that are not written are skipped: `Type::member` is found wherever in the crate it is.
    pub(crate) fn find(&self, path: &[&str]) -> Found {
        let matches = |declared: &&Declared| {
            let (mut modules, item) = match path.len().checked_sub(declared.item.len()) {
                Some(at) => path.split_at(at),
                None => return false,
            };
            for module in &declared.modules {
                if let Some((first, rest)) = modules.split_first()
                    && first == module
                {
                    modules = rest;
                }
            }
            modules.is_empty() && item == declared.item
        };
        let found: Vec<_> = self.declared.iter().filter(matches).collect();
        match (found.is_empty(), found.iter().any(|item| item.is_public)) {
            (true, _) => Found::Nothing,
            (false, true) => Found::Public,
            (false, false) => Found::Private,
        }
    }

    /// The items with the same last name, for a message.
    pub(crate) fn like(&self, path: &[&str]) -> Vec<String> {
        let last = path.last().copied().unwrap_or_default();
        let same = |declared: &&Declared| declared.item.last().is_some_and(|name| name == last);
        let mut like: Vec<String> = (self.declared.iter().filter(same))
            .map(|declared| declared.item.join("::"))
            .collect();
        like.sort();
        like.dedup();
        like
    }
}

#[derive(Default)]
struct Reader {
    items: Items,
    syntax: Syntax,
}

impl Reader {
    fn file(&mut self, file: &Path, folder: &Path, modules: &[String]) {
        let text = std::fs::read_to_string(file)
            .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let parsed =
            syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        self.list(parsed.items, folder, modules);
    }

    fn list(&mut self, items: Vec<Item>, folder: &Path, modules: &[String]) {
        for item in items {
            self.item(item, folder, modules);
        }
    }

    fn declare(&mut self, modules: &[String], item: &[String], is_public: bool) {
        self.items.declared.push(Declared {
            modules: modules.to_vec(),
            item: item.to_vec(),
            is_public,
        });
    }

    fn item(&mut self, item: Item, folder: &Path, modules: &[String]) {
        let declare = |reader: &mut Self, name: &syn::Ident, visibility: &Visibility| {
            reader.declare(modules, &[name.to_string()], is_public(visibility));
        };
        match item {
            Item::Mod(module) if !is_for_tests(&module.attrs) => {
                declare(self, &module.ident, &module.vis);
                self.module(module, folder, modules);
            }
            Item::Const(item) => declare(self, &item.ident, &item.vis),
            Item::Static(item) => declare(self, &item.ident, &item.vis),
            Item::Type(item) => declare(self, &item.ident, &item.vis),
            Item::Fn(item) if !is_for_tests(&item.attrs) => {
                declare(self, &item.sig.ident, &item.vis);
            }
            Item::Enum(item) => {
                declare(self, &item.ident, &item.vis);
                for variant in &item.variants {
                    let member = [item.ident.to_string(), variant.ident.to_string()];
                    self.declare(modules, &member, is_public(&item.vis));
                }
                self.syntax.enums.push((modules.to_vec(), item));
            }
            Item::Struct(item) => {
                declare(self, &item.ident, &item.vis);
                if let Fields::Named(fields) = &item.fields {
                    for field in &fields.named {
                        let name = field.ident.as_ref().expect("a named field");
                        let member = [item.ident.to_string(), name.to_string()];
                        let is_public = is_public(&item.vis) && is_public(&field.vis);
                        self.declare(modules, &member, is_public);
                    }
                }
                self.syntax.structs.push((modules.to_vec(), item));
            }
            Item::Trait(item) => {
                declare(self, &item.ident, &item.vis);
                for member in &item.items {
                    if let TraitItem::Fn(method) = member {
                        let member = [item.ident.to_string(), method.sig.ident.to_string()];
                        self.declare(modules, &member, is_public(&item.vis));
                    }
                }
            }
            Item::Impl(item) if !is_for_tests(&item.attrs) => self.block(&item, modules),
            Item::Macro(call) if call.ident.is_none() => {
                self.names(&call.mac.tokens, modules, &[]);
                self.syntax
                    .macro_calls
                    .push((modules.to_vec(), call.mac.tokens));
            }
            _ => {}
        }
    }

    fn module(&mut self, module: syn::ItemMod, folder: &Path, modules: &[String]) {
        let name = module.ident.to_string();
        let inside: Vec<String> = modules.iter().cloned().chain([name.clone()]).collect();
        let inner = folder.join(&name);
        match module.content {
            Some((_, items)) => self.list(items, &inner, &inside),
            None => {
                let candidates: [PathBuf; 2] =
                    [folder.join(format!("{name}.rs")), inner.join("mod.rs")];
                let file = candidates.iter().find(|file| file.is_file());
                // A module with another path is for another target.
                if let Some(file) = file {
                    self.file(file, &inner, &inside);
                }
            }
        }
    }

    fn block(&mut self, block: &syn::ItemImpl, modules: &[String]) {
        let syn::Type::Path(path) = &*block.self_ty else {
            return;
        };
        let Some(owner) = path.path.segments.last() else {
            return;
        };
        let of_trait = block.trait_.is_some();
        for member in &block.items {
            let (name, visibility) = match member {
                ImplItem::Fn(method) => (&method.sig.ident, &method.vis),
                ImplItem::Const(item) => (&item.ident, &item.vis),
                _ => continue,
            };
            let path = [owner.ident.to_string(), name.to_string()];
            self.declare(modules, &path, of_trait || is_public(visibility));
        }
    }

    /// Names in a macro call; inside braces behind a name they are its members.
    fn names(&mut self, tokens: &TokenStream, modules: &[String], owner: &[String]) {
        let mut last: Option<String> = None;
        for token in tokens.clone() {
            match token {
                TokenTree::Ident(name) => {
                    let name = name.to_string();
                    let item: Vec<String> = owner.iter().cloned().chain([name.clone()]).collect();
                    self.declare(modules, &item, true);
                    last = Some(name);
                }
                TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                    if let (Some(name), true) = (last.take(), owner.is_empty()) {
                        self.names(&group.stream(), modules, &[name]);
                    }
                }
                _ => {}
            }
        }
    }
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute
                    .parse_args::<syn::Path>()
                    .is_ok_and(|condition| condition.is_ident("test"))
    })
}
