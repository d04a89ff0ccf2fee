//! The commands and options of `motionctl`, read from the definition that clap makes them of.

use std::collections::BTreeMap;

use syn::{Attribute, Fields, ItemStruct, Type};

use crate::sources::Syntax;

/// The parameters of a drive that `motionctl write` takes.
const PARAMETERS: &str = "Parameter";

/// The command line of the tool.
#[derive(Debug)]
pub(crate) struct Tool {
    commands: BTreeMap<String, Vec<OptionOf>>,
    /// What `motionctl write` may set.
    parameters: Vec<String>,
}

/// An option with the values that it takes, where they are listed.
#[derive(Debug)]
struct OptionOf {
    name: String,
    values: Vec<String>,
}

impl Tool {
    /// From the source of the tool.
    pub(crate) fn of(syntax: &Syntax) -> Self {
        let (_, commands) = (syntax.enums.iter())
            .find(|(modules, item)| modules.is_empty() && item.ident == "Command")
            .expect("enum Command in crates/motionctl/src/main.rs");
        let command = |variant: &syn::Variant| {
            let arguments = variant.fields.iter().next().expect("arguments");
            let path = innermost(&arguments.ty);
            let module = path.first().expect("a module with arguments");
            (name_of(variant, "command"), options_of(syntax, module))
        };
        Self {
            commands: commands.variants.iter().map(command).collect(),
            parameters: values_of(syntax, PARAMETERS),
        }
    }

    /// Whether there is such a command.
    pub(crate) fn has(&self, command: &str) -> bool {
        self.commands.contains_key(command)
    }

    /// Whether a call like `motionctl scan --protocol canopen` or `motionctl write main-gain` can be made.
    ///
    /// # Errors
    /// Which word is wrong, and what could stand in its place.
    pub(crate) fn check_call(&self, call: &str) -> Result<(), String> {
        let mut words = call.split(' ').skip(1);
        let command = words.next().unwrap_or_default();
        let Some(options) = self.commands.get(command) else {
            let names: Vec<&str> = self.commands.keys().map(String::as_str).collect();
            let names = names.join(", ");
            return Err(format!(
                "expected a command of motionctl ({names}), found \"{command}\""
            ));
        };
        let mut last: Option<&OptionOf> = None;
        for word in words {
            if let Some(name) = word.strip_prefix("--") {
                last = Some(option(options, command, name)?);
                continue;
            }
            let values = match last.take() {
                Some(option) => &option.values[..],
                None if command == "write" => &self.parameters,
                None => &[],
            };
            if !values.iter().any(|value| value == word) {
                let values = values.join(", ");
                return Err(format!(
                    "expected one of [{values}] in motionctl {command}, found \"{word}\""
                ));
            }
        }
        Ok(())
    }
}

fn option<'a>(options: &'a [OptionOf], command: &str, name: &str) -> Result<&'a OptionOf, String> {
    let found = options.iter().find(|option| option.name == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = options.iter().map(|option| option.name.as_str()).collect();
        let names = names.join(", --");
        format!("expected an option of motionctl {command} (--{names}), found \"--{name}\"")
    })
}

fn options_of(syntax: &Syntax, module: &str) -> Vec<OptionOf> {
    let is_in = |modules: &[String]| modules.first().is_some_and(|first| first == module);
    let arguments = (syntax.structs.iter())
        .find(|(modules, item)| is_in(modules) && item.ident == "Arguments")
        .unwrap_or_else(|| panic!("struct Arguments in crates/motionctl/src/{module}"));
    let mut options = Vec::new();
    collect(syntax, arguments, &mut options);
    options
}

fn collect(
    syntax: &Syntax,
    (modules, item): &(Vec<String>, ItemStruct),
    options: &mut Vec<OptionOf>,
) {
    let Fields::Named(fields) = &item.fields else {
        return;
    };
    for field in &fields.named {
        let name = field.ident.as_ref().expect("a named field").to_string();
        let type_name = innermost(&field.ty).pop().unwrap_or_default();
        if word(&field.attrs, "command", "flatten").is_some() {
            let same = |(_, item): &&(Vec<String>, ItemStruct)| item.ident == type_name.as_str();
            let mut all = syntax.structs.iter().filter(same);
            let near = |(path, _): &&(Vec<String>, ItemStruct)| path.first() == modules.first();
            let mut near = syntax.structs.iter().filter(same).filter(near);
            if let Some(inner) = near.next().or_else(|| all.next()) {
                collect(syntax, inner, options);
            }
        } else if let Some(other) = word(&field.attrs, "arg", "long") {
            options.push(OptionOf {
                name: other.unwrap_or_else(|| name.replace('_', "-")),
                values: values_of(syntax, &type_name),
            });
        }
    }
}

/// The values of an option whose type is an enumeration of the tool; none for any other type.
fn values_of(syntax: &Syntax, type_name: &str) -> Vec<String> {
    let mut enums = syntax.enums.iter();
    let found = enums.find(|(_, item)| item.ident == type_name);
    let variants = found.into_iter().flat_map(|(_, item)| &item.variants);
    variants.map(|variant| name_of(variant, "value")).collect()
}

/// The name of a variant, which `#[command(name = "...")]` or `#[value(name = "...")]` may change.
fn name_of(variant: &syn::Variant, attribute: &str) -> String {
    word(&variant.attrs, attribute, "name")
        .flatten()
        .unwrap_or_else(|| kebab(&variant.ident.to_string()))
}

/// Whether `#[attribute(... wanted ...)]` is there, and the text of `wanted = "text"`.
fn word(attributes: &[Attribute], attribute: &str, wanted: &str) -> Option<Option<String>> {
    let lists = attributes
        .iter()
        .filter(|found| found.path().is_ident(attribute))
        .filter_map(|found| found.meta.require_list().ok());
    lists.into_iter().find_map(|list| {
        let mut tokens = list
            .tokens
            .clone()
            .into_iter()
            .map(|token| token.to_string());
        tokens.find(|token| token == wanted)?;
        let text = (tokens.next().as_deref() == Some("="))
            .then(|| tokens.next())
            .flatten();
        Some(text.map(|text| text.trim_matches('"').to_owned()))
    })
}

/// The path of a type, without the Box, Option or Vec around it.
fn innermost(of: &Type) -> Vec<String> {
    let Type::Path(path) = of else {
        return Vec::new();
    };
    let segments = &path.path.segments;
    if let Some(last) = segments.last()
        && let syn::PathArguments::AngleBracketed(arguments) = &last.arguments
        && let Some(syn::GenericArgument::Type(inner)) = arguments.args.first()
    {
        return innermost(inner);
    }
    let names = segments.iter().map(|segment| segment.ident.to_string());
    names.collect()
}

/// clap's name for a variant: `MainGain` is `main-gain`.
fn kebab(name: &str) -> String {
    let mut words = String::new();
    for (place, letter) in name.chars().enumerate() {
        if letter.is_ascii_uppercase() && place != 0 {
            words.push('-');
        }
        words.push(letter.to_ascii_lowercase());
    }
    words
}
