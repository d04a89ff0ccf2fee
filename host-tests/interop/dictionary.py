"""The object dictionary that `canopen_bridge dictionary` prints, as python-canopen knows it."""

import subprocess

from canopen import objectdictionary
from canopen.objectdictionary import datatypes

TYPES = {
    "I8": datatypes.INTEGER8,
    "I16": datatypes.INTEGER16,
    "I32": datatypes.INTEGER32,
    "U8": datatypes.UNSIGNED8,
    "U16": datatypes.UNSIGNED16,
    "U32": datatypes.UNSIGNED32,
}


def variable(columns, node):
    index, sub, data_type, access, mappable, default, name = columns
    entry = objectdictionary.ODVariable(name, int(index, 16), int(sub, 16))
    entry.data_type = TYPES[data_type]
    entry.access_type = access
    entry.pdo_mappable = mappable == "true"
    if default.startswith("node+"):
        entry.default = node + int(default.removeprefix("node+"))
    elif default:
        entry.default = int(default)
    return entry


def load(program, node):
    """A dictionary of its own for each node that is made."""
    text = subprocess.run([program, "dictionary"], check=True, capture_output=True, text=True).stdout
    rows = [line.split("\t") for line in text.splitlines()]
    subs = {}
    for columns in rows:
        subs.setdefault(int(columns[0], 16), []).append(variable(columns, node))
    dictionary = objectdictionary.ObjectDictionary()
    dictionary.node_id = node
    for index, entries in subs.items():
        if len(entries) == 1:
            dictionary.add_object(entries[0])
            continue
        record = objectdictionary.ODRecord(f"record {index:04X}", index)
        for entry in entries:
            record.add_member(entry)
        dictionary.add_object(record)
    return dictionary
