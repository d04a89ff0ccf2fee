"""The electronic data sheet of the hub motors in python-canopen and in Lely's dcf-tools, without a warning.

usage: eds.py CANOPEN_BRIDGE DATA_SHEET
"""

import logging
import pathlib
import subprocess
import sys
import tempfile
import warnings

import canopen

import dictionary

NODE = 4
OBJECTS = 194
# Where the number of entries in a record is U16 in the guide and UNSIGNED8 in a data sheet, as its comments say.
COUNTS = 0
NETWORK = """
master:
  node_id: 1
  baudrate: 500
left_wheel:
  dcf: "{sheet}"
  node_id: {node}
  heartbeat_producer: 100
  boot: false
"""


class Loud(logging.Handler):
    """Ends the check at the first warning."""

    def emit(self, record):
        sys.exit(f"python-canopen: {record.getMessage()}")


def variables(loaded):
    """Every entry by its address."""
    found = {}
    for index, entry in loaded.items():
        entries = entry.values() if hasattr(entry, "subindices") else [entry]
        found.update({(index, variable.subindex): variable for variable in entries})
    return found


def facts(variable):
    return variable.data_type, variable.access_type, variable.pdo_mappable, variable.default


def with_python_canopen(program, sheet):
    logging.getLogger().addHandler(Loud(logging.WARNING))
    warnings.simplefilter("error")
    loaded, expected = variables(canopen.import_od(sheet, NODE)), variables(dictionary.load(program, NODE))
    if len(loaded) != OBJECTS or loaded.keys() != expected.keys():
        sys.exit(f"expected {OBJECTS} objects, got {len(loaded)}; {sorted(loaded.keys() ^ expected.keys())} in one of the two only")
    for (index, sub), variable in loaded.items():
        want, got = facts(expected[index, sub]), facts(variable)
        is_count = sub == COUNTS and len(loaded.keys() & {(index, 1)})
        if want != got and not (is_count and want[1:3] == got[1:3]):
            sys.exit(f"{index:04X}h:{sub:02X}: expected type, access, mappable, default {want}, got {got}")
    print(f"python-canopen: {len(loaded)} objects as in the codec")


def silent(*command):
    """Runs a program that has nothing to say."""
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if run.returncode or run.stdout.strip() or run.stderr.strip():
        sys.exit(f"{command}: exit status {run.returncode}\n{run.stdout}{run.stderr}")


def with_dcf_tools(sheet):
    tools = pathlib.Path(sys.executable).parent
    silent(sys.executable, tools / "dcfchk", "-n", NODE, sheet)
    with tempfile.TemporaryDirectory() as folder:
        network = pathlib.Path(folder) / "network.yml"
        network.write_text(NETWORK.format(sheet=pathlib.Path(sheet).resolve(), node=NODE))
        silent(sys.executable, tools / "dcfgen", "-r", "-d", folder, network)
        if not (pathlib.Path(folder) / "master.dcf").is_file():
            sys.exit("dcfgen wrote no master.dcf")
    print("dcf-tools: dcfchk and dcfgen take it without a word")


def main(program, sheet):
    with_python_canopen(program, sheet)
    with_dcf_tools(sheet)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
