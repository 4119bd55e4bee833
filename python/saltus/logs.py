"""Converts runs to MAT v7.3 (in robometry's layout) and MCAP (with JSON messages).

Usage: python3 -m saltus.logs FOLDER mat|mcap|FILE.mat|FILE.mcap...

`mat` is FOLDER/run.mat, `mcap` FOLDER/run.mcap.
"""

import json
import math
import os
import re
import sys

from .on_folder import NOT_WRITTEN, SAID

try:
    import numpy as np
except ModuleNotFoundError:
    print("no logs: this python3 has no numpy; install python3-numpy, or set SALTUS_PYTHON to another python3", file=sys.stderr)
    sys.exit(SAID)

from .results import load  # noqa: E402
from .whole_file import whole_file  # noqa: E402

ROOT = "robot_logger_device"  # the name that robot-log-visualizer expects


# ---- MAT v7.3 ------------------------------------------------------------------------------------

# HDF5 behind a MATLAB header of 512 bytes. The dimensions of arrays are reversed.


def _name(text):
    """Converts a name to a MATLAB field name: letters, digits and _."""
    name = re.sub(r"\W", "_", text, flags=re.ASCII)
    return name if name[:1].isalpha() else "x" + name


def _kind(item, kind):
    item.attrs["MATLAB_class"] = np.bytes_(kind)
    return item


class _MatFile:
    def __init__(self, file):
        self.file = file
        self.references = file.create_group("#refs#")

    def group(self, parent, name):
        return _kind(parent.create_group(name), "struct")

    def numbers(self, parent, name, values):
        return _kind(parent.create_dataset(name, data=np.asarray(values, dtype=float)), "double")

    def text(self, parent, name, text):
        codes = np.array([[ord(letter)] for letter in text or " "], dtype=np.uint16)
        item = _kind(parent.create_dataset(name, data=codes), "char")
        item.attrs["MATLAB_int_decode"] = np.int32(2)
        return item

    def texts(self, parent, name, texts):
        import h5py
        made = [self.text(self.references, f"r{len(self.references)}", text).ref for text in texts]
        return _kind(parent.create_dataset(name, data=np.array([made], dtype=h5py.ref_dtype)), "cell")

    def signal(self, parent, name, time, columns, names, units):
        """columns: rows x entries. MATLAB sees entries x 1 x rows."""
        group = self.group(parent, _name(name))
        values = np.asarray(columns, dtype=float)
        self.numbers(group, "data", values.reshape(len(time), 1, -1))
        self.numbers(group, "dimensions", [[values.shape[1]], [1]])
        self.texts(group, "elements_names", names)
        self.texts(group, "units_of_measure", units)
        self.text(group, "name", name)
        self.numbers(group, "timestamps", np.asarray(time, dtype=float).reshape(-1, 1))


def _joints(run):
    """Names of the robot's joints, and the table with their positions q_NAME."""
    body = run.tables.get("body", {})
    return [name[len("q_"):] for name in body if name.startswith("q_")], body


def write_mat(run, path):
    """Writes every numeric column of every table as robot_logger_device.TABLE.COLUMN, with its element names.

    The joints of a robot are also in joints_state, where robot-log-visualizer expects them. It cannot read
    tables of one row, so these are omitted.
    """
    import h5py

    with whole_file(path) as partial:
        with h5py.File(partial, "w", userblock_size=512) as file:
            mat = _MatFile(file)
            root = mat.group(file, ROOT)
            joints, body = _joints(run)
            mat.texts(root, "description_list", joints or [os.path.basename(run.folder)])
            mat.text(root, "yarp_robot_name", str(run.summary.get("robot", "saltus")))
            if len(joints) > 0 and len(body.time) > 1:
                group = mat.group(root, "joints_state")
                for what, prefix, unit in (("positions", "q_", "rad"), ("velocities", "dq_", "rad/s"), ("torques", "tau_", "Nm")):
                    if all(prefix + joint in body for joint in joints):
                        columns = np.stack([body[prefix + joint] for joint in joints], axis=1)
                        mat.signal(group, what, body.time, columns, joints, [unit] * len(joints))
            for table_name, table in run.timed_tables().items():
                if len(table.time) < 2:
                    continue
                group = mat.group(root, _name(table_name))
                for name in table.numbers():
                    mat.signal(group, name, table.time, table[name].reshape(-1, 1), [name],
                               [table.units[name]])
        head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, written by Saltus HDF5 schema 1.00 ."
        with open(partial, "r+b") as file:
            file.write(head.ljust(116) + bytes(8) + b"\x00\x02IM")


# ---- MCAP ----------------------------------------------------------------------------------------


def _schema(title, table):
    properties = {"timestamp": {"type": "number", "description": "t [s]"}}
    for name in table:
        if name != "t":
            kind = ["number", "null"] if table[name].dtype.kind == "f" else "string"
            properties[name] = {"type": kind, "description": table.units[name]}
    return {"title": title, "type": "object", "properties": properties}


def write_mcap(run, path):
    """Writes one channel per table and one message per row; missing numbers are null. Times are those of the run."""
    from mcap.writer import Writer

    with whole_file(path) as partial:
        with open(partial, "wb") as stream:
            writer = Writer(stream)
            writer.start(profile="", library="saltus")
            writer.add_metadata("run", {"folder": os.path.basename(run.folder),
                                        "summary": json.dumps(run.summary)})
            for table_name, table in run.timed_tables().items():
                schema = json.dumps(_schema(f"saltus.{table_name}", table)).encode()
                channel = writer.register_channel(
                    topic=f"/{table_name}", message_encoding="json",
                    schema_id=writer.register_schema(f"saltus.{table_name}", "jsonschema", schema))
                columns = {name: table[name].tolist() for name in table if name != "t"}
                for row, t in enumerate(table.time.tolist()):
                    message = {"timestamp": t}
                    for name, values in columns.items():
                        value = values[row]
                        is_none = isinstance(value, float) and not math.isfinite(value)
                        message[name] = None if is_none else value
                    nanoseconds = max(0, round(t * 1e9))
                    writer.add_message(channel, nanoseconds, json.dumps(message).encode(), nanoseconds)
            writer.finish()


# ---- the command line ----------------------------------------------------------------------------

WRITERS = {".mat": write_mat, ".mcap": write_mcap}
REMEDIES = {"h5py": "apt-get install python3-h5py, or pip install h5py",
            "mcap": "pip install mcap (and numpy) in an environment whose python3 SALTUS_PYTHON names"}


def main(folder, names):
    files = [os.path.join(folder, f"run.{name}") if f".{name}" in WRITERS else name for name in names]
    for file in files:
        if os.path.splitext(file)[1] not in WRITERS:
            print(f"{file}: the name must end with .mat or .mcap", file=sys.stderr)
            return SAID
    try:
        status, run = 0, load(folder)
    except ValueError as error:  # invalid text, rows of different lengths, truncated JSON
        print(f"{folder}: its tables are damaged: {error}", file=sys.stderr)
        return SAID
    for file in files:
        try:
            WRITERS[os.path.splitext(file)[1]](run, file)
        except ModuleNotFoundError as error:
            print(f"no {file}: this python3 has no package {error.name}; {REMEDIES.get(error.name, '')}", file=sys.stderr)
            status = SAID
        except OSError as error:
            print(f"{file}: {error.strerror or error}", file=sys.stderr)
            return NOT_WRITTEN
    return status


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    try:
        sys.exit(main(sys.argv[1], sys.argv[2:]))
    except FileNotFoundError as error:
        sys.exit(str(error))
