//! `motionctl schema`: the shape of what the commands print with `--json`, for programs that read it.
//!
//! The schemas are derived from the types that are printed, so they cannot say anything else.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use schemars::{JsonSchema, Schema, SchemaGenerator};

use crate::board;
use crate::hub;
use crate::output::{print, print_json, tell};
use crate::{
    assign_id, backup, bench, check, decode, disable, dry_run, home, jog, keyframes, limits,
    monitor, moves, origin, plan, probe, read, record, reset, restore, scan, sim, speed, tune,
    write,
};

const EXAMPLES: &str = "\
Examples:
  motionctl schema                         the names
  motionctl schema sim                     what `sim --json` prints
  motionctl schema zlac-sim                what `sim --drives zlac --json` prints
  motionctl schema board-run               what `board run --json` prints
  motionctl schema --folder docs/schemas   one file each

With --dry-run a command prints what `dry-run` says. A line of `decode --json` and of `monitor --json` is a document of its own.

Exit status: 0 printed or written, 2 there is no such schema, or a file cannot be written.";

/// The name of a file, and what it says.
pub(crate) type NamedSchema = (&'static str, fn() -> Schema);

/// What each command prints with `--json`, by the name of its file.
const SCHEMAS: &[NamedSchema] = &[
    ("assign-id", assign_id::schema),
    ("backup", backup::schema),
    ("bench", bench::schema),
    ("check", check::schema),
    ("decode", decode::schema),
    ("disable", disable::schema),
    ("dry-run", dry_run::schema),
    ("enable", disable::schema),
    ("home", home::schema),
    ("jog", jog::schema),
    ("keyframes", keyframes::schema),
    ("limits", limits::schema),
    ("monitor", monitor::schema),
    ("move", moves::schema),
    ("origin", origin::schema),
    ("plan", plan::schema),
    ("probe", probe::schema),
    ("read", read::schema),
    ("record", record::schema),
    ("reset", reset::schema),
    ("restore", restore::schema),
    ("run", crate::run::schema),
    ("scan", scan::schema),
    ("sim", sim::schema),
    ("speed", speed::schema),
    ("tune", tune::schema),
    ("write", write::schema),
];

/// Options of `motionctl schema`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// The command, with `zlac-` before it for hub motors. Default: the names.
    #[arg(value_name = "NAME", conflicts_with = "folder")]
    name: Option<String>,
    /// Write every schema into this folder, NAME.json each.
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// One shape or another.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its shape is used")]
pub(crate) enum Either<A, B> {
    One(A),
    Other(B),
}

/// The schema of a type, as it is written: fields that are left out at times are not required.
pub(crate) fn of<T: JsonSchema>() -> Schema {
    let settings = schemars::generate::SchemaSettings::draft2020_12().for_serialize();
    SchemaGenerator::new(settings).into_root_schema_for::<T>()
}

/// Every schema with its name.
fn all() -> impl Iterator<Item = (&'static str, Schema)> {
    SCHEMAS
        .iter()
        .chain(hub::SCHEMAS)
        .chain(board::SCHEMAS)
        .map(|(name, shape)| {
            let mut schema = shape();
            schema.insert("title".to_owned(), format!("motionctl {name}").into());
            (*name, schema)
        })
}

/// Prints a schema or the names, or writes all.
pub(crate) fn run(arguments: &Arguments) -> io::Result<ExitCode> {
    match (&arguments.name, &arguments.folder) {
        (_, Some(folder)) => write_all(folder)?,
        (Some(name), None) => {
            let (_, schema) = all().find(|(known, _)| known == name).ok_or_else(|| {
                io::Error::other(format!(
                    "there is no schema {name}: motionctl schema lists them"
                ))
            })?;
            print_json(schema.as_value())?;
        }
        (None, None) => {
            let names: Vec<&str> = all().map(|(name, _)| name).collect();
            print(names.join("\n"))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn write_all(folder: &Path) -> io::Result<()> {
    let write = |name: &str, schema: Schema| {
        let mut text = serde_json::to_string_pretty(schema.as_value())?;
        text.push('\n');
        std::fs::write(folder.join(name).with_extension("json"), text)
    };
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| all().try_for_each(|(name, schema)| write(name, schema)));
    written.map_err(|error| {
        io::Error::other(format!("cannot write to {}: {error}", folder.display()))
    })?;
    tell(format_args!("schemas: {}", folder.display()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_schema_has_a_name_of_its_own_and_describes_an_object_or_several() {
        let mut names: Vec<&str> = all().map(|(name, _)| name).collect();
        names.sort_unstable();
        names.dedup();
        let count = SCHEMAS.len() + hub::SCHEMAS.len() + board::SCHEMAS.len();
        assert_eq!(names.len(), count);
        for (name, schema) in all() {
            let shapes = ["properties", "anyOf", "oneOf"];
            assert!(
                shapes.iter().any(|shape| schema.get(*shape).is_some()),
                "{name}"
            );
        }
    }

    #[test]
    fn the_files_in_the_documents_are_those_that_would_be_written() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas");
        let fresh = tempfile::tempdir().unwrap();
        write_all(fresh.path()).unwrap();
        let read = |folder: &Path| {
            let mut files: Vec<(String, String)> = std::fs::read_dir(folder)
                .unwrap()
                .map(|entry| {
                    let entry = entry.unwrap();
                    let name = entry.file_name().into_string().unwrap();
                    (name, std::fs::read_to_string(entry.path()).unwrap())
                })
                .collect();
            files.sort();
            files
        };
        let again = "cargo run -p motionctl -- schema --folder docs/schemas";
        for (old, new) in read(&folder).iter().zip(read(fresh.path())) {
            assert_eq!(*old, new, "write them again: {again}");
        }
        assert_eq!(read(&folder).len(), read(fresh.path()).len(), "{again}");
    }

    #[test]
    fn an_unknown_name_is_refused() {
        let arguments = Arguments {
            name: Some("walk".to_owned()),
            folder: None,
        };
        let error = run(&arguments).unwrap_err().to_string();
        assert!(error.contains("no schema walk"), "{error}");
    }
}
