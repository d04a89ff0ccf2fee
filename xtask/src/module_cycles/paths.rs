//! The paths in the code of a module: those of its `use` declarations and those of everything else.

use std::collections::BTreeSet;

use proc_macro2::{Group, Ident, Spacing, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Item, ItemUse, UseTree, Visibility};

/// One name that a `use` declaration brings in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Alias {
    /// The name in this module; `None` for `*`.
    pub(super) name: Option<String>,
    /// Where it comes from, as it is written.
    pub(super) path: Vec<String>,
    /// Whether others may use it from here.
    pub(super) passed_on: bool,
    pub(super) line: usize,
}

/// A path somewhere in the code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mention {
    pub(super) path: Vec<String>,
    pub(super) line: usize,
}

/// Every name of a declaration.
pub(super) fn aliases_of(declaration: &ItemUse) -> Vec<Alias> {
    let mut aliases = Vec::new();
    if declaration.leading_colon.is_none() {
        let passed_on = !matches!(declaration.vis, Visibility::Inherited);
        collect(&declaration.tree, &mut Vec::new(), passed_on, &mut aliases);
    }
    aliases
}

fn collect(tree: &UseTree, path: &mut Vec<String>, passed_on: bool, aliases: &mut Vec<Alias>) {
    let mut alias = |name: Option<String>, last: Option<&Ident>, line| {
        let mut path = path.clone();
        path.extend(last.filter(|last| *last != "self").map(Ident::to_string));
        let name = match name {
            Some(this) if this == "self" => path.last().cloned(),
            name => name,
        };
        aliases.push(Alias {
            name,
            path,
            passed_on,
            line,
        });
    };
    match tree {
        UseTree::Path(step) => {
            path.push(step.ident.to_string());
            collect(&step.tree, path, passed_on, aliases);
            path.pop();
        }
        UseTree::Group(group) => {
            for tree in &group.items {
                collect(tree, path, passed_on, aliases);
            }
        }
        UseTree::Name(name) => alias(
            Some(name.ident.to_string()),
            Some(&name.ident),
            line_of(&name.ident),
        ),
        UseTree::Rename(rename) => alias(
            Some(rename.rename.to_string()),
            Some(&rename.ident),
            line_of(&rename.ident),
        ),
        UseTree::Glob(glob) => alias(None, None, glob.star_token.spans[0].start().line),
    }
}

/// The paths of at least two words in an item, and all its words but the names of fields and methods.
pub(super) fn mentions_of(item: &Item) -> (Vec<Mention>, BTreeSet<String>) {
    let mut scan = Scan::default();
    scan.tokens(item.to_token_stream());
    (scan.mentions, scan.names)
}

#[derive(Default)]
struct Scan {
    mentions: Vec<Mention>,
    names: BTreeSet<String>,
}

impl Scan {
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<Ident> = Vec::new();
        let mut colons = 0;
        let mut is_behind_dot = false;
        let mut tokens = tokens.into_iter().peekable();
        while let Some(token) = tokens.next() {
            let is_field = is_behind_dot || is_single_colon(tokens.peek());
            is_behind_dot = matches!(&token, TokenTree::Punct(punct) if punct.as_char() == '.');
            match token {
                TokenTree::Ident(word) => {
                    if colons != 2 {
                        self.end(&mut path);
                    }
                    if !is_field {
                        self.names.insert(word.to_string());
                    }
                    path.push(word);
                    colons = 0;
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                TokenTree::Group(group) => {
                    self.end(&mut path);
                    colons = 0;
                    if !is_visibility(&group) {
                        self.tokens(group.stream());
                    }
                }
                _ => {
                    self.end(&mut path);
                    colons = 0;
                }
            }
        }
        self.end(&mut path);
    }

    fn end(&mut self, path: &mut Vec<Ident>) {
        if let [first, _, ..] = path.as_slice() {
            self.mentions.push(Mention {
                line: line_of(first),
                path: path.iter().map(Ident::to_string).collect(),
            });
        }
        path.clear();
    }
}

/// Whether a token is the colon behind the name of a field.
fn is_single_colon(token: Option<&TokenTree>) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == ':' && punct.spacing() == Spacing::Alone)
}

/// Whether these are the brackets of `pub(in crate::somewhere)`, which names who may use an item and needs nothing.
fn is_visibility(group: &Group) -> bool {
    let first = group.stream().into_iter().next();
    matches!(first, Some(TokenTree::Ident(word)) if word == "in")
}

fn line_of(word: &Ident) -> usize {
    word.span().start().line
}
