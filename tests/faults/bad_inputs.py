"""Gives each kind of bad input to the program, as a user would, and records its message and exit status. No run may
hang, end by a signal, report an internal error (status 1) or leave a partial file. The table is docs/bad_inputs.md.

  bad_inputs.py SALTUS PAGE            the test: prints outcomes that differ from the page; status 1 if any
  bad_inputs.py SALTUS PAGE --write    writes the page
  bad_inputs.py SALTUS --only TEXT     prints the kinds that contain the text
  bad_inputs.py ... --sanitized        for a program with the address sanitizer, which reserves terabytes of addresses
"""

import argparse
import concurrent.futures
import csv
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import stat
import struct
import subprocess
import sys
import tempfile
import time
import zipfile

LIMIT = 60  # s, on a loaded machine; a longer run counts as a hang
MEMORY = 4 << 30  # bytes of address space: 512 MB of memory and the reservations of libraries
LONGEST = 1200  # characters of all messages about one mistake

SMALL_URDF = """<robot name="r">
  <link name="base"><inertial><origin xyz="0 0 0.4"/><mass value="10"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  {}
</robot>
"""
LEG = """<joint name="{0}_hip" type="revolute"><parent link="base"/><child link="{0}_foot"/><origin xyz="0 {1} 0"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="10" velocity="5"/></joint>
  <link name="{0}_foot"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0 0 -0.5"/><geometry>{2}</geometry></collision></link>"""
BOX = '<box size="0.2 0.1 0.05"/>'


def biped(sole=BOX, left=None, right=None):
    return SMALL_URDF.format((left or LEG.format("l", "0.1", sole)) + (right or LEG.format("r", "-0.1", BOX)))


def write_npz(path, shapes):
    """Arrays of ones in the format of numpy."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, (rows, columns) in shapes.items():
            head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}".encode()
            head += b" " * (-(len(head) + 11) % 64) + b"\n"
            archive.writestr(name + ".npy", b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head + struct.pack("<d", 1.0) * (rows * columns))


class Case:
    """`files`: contents by name (a function of the path creates other files). `words` may contain {d}, the folder of
    the case."""

    def __init__(self, group, kind, words, files=None, env=None, status=(2,), **how):
        self.group, self.kind, self.words, self.files = group, kind, words, files or {}
        self.env, self.status, self.how = env or {}, status, how


def cases():
    """All cases by groups, in the order of the page."""
    everything = []

    def group(name):
        def add(kind, words, files=None, **rest):
            everything.append(Case(name, kind, words, files, **rest))
        return add

    push = ["run", "push_recovery", "--plant", "centroidal", "--pictures", "false", "--out", "{d}/out"]

    add = group("Command line")
    for kind, words in {
        "unknown verb": ["frobnicate"], "misspelt verb": ["rnu", "push_recovery"], "empty verb": [""], "blank verb": [" "],
        "verb in capitals": ["RUN", "push_recovery"], "verb of 100,000 letters": ["x" * 100000],
        "verb with terminal colour codes": ["\x1b[31mred"], "verb that is not UTF-8": [b"\xff\xfe"],
        "verb that is an option": ["--run"], "unknown short option": ["-q"],
        "run without a problem": ["run"], "unknown problem": ["run", "nothing_of_the_kind"],
        "misspelt problem": ["run", "push_recvery"],
        "problem that is a path": ["run", "../push_recovery"], "empty problem": ["run", ""],
        "problem with a new line": ["run", "push\nrecovery"], "two problems": ["run", "push_recovery", "sway"],
        "list with an argument": ["list", "all"], "version with an argument": ["--version", "1"],
        "unknown shell to complete for": ["completion", "powershell"], "completion without a shell": ["completion"],
        "rerun without a folder": ["rerun"], "plot without a folder": ["plot"], "logs without a folder": ["logs"], "movie without a folder": ["movie"],
        "robot without a command": ["robot"], "robot with an unknown command": ["robot", "mend"], "new without a name": ["new"],
        "check of an unknown problem": ["check", "NO_SUCH"], "suite without a matching case": ["suite", "--only", "no_such_case"],
        "suite by an unknown solver": ["suite", "--set", "solver=gurobi"],
        "check with no intervals": ["check", "--intervals", "0"], "check with half an interval": ["check", "--intervals", "2.5"],
        "unknown benchmark": ["bench", "speed"], "bench without a command": ["bench"],
    }.items():
        add(kind, words, status=(0, 2) if kind == "robot without a command" else (2,))
    for kind, words in {
        "unknown option": ["--frobnicate"], "unknown option with a value": ["--push.impluse", "3"],
        "option without its value": ["--config"], "folder without a name": ["--out"], "setting without a value": ["--push.impulse"],
        "set without an assignment": ["--set"], "set without =": ["--set", "push.impulse"], "set without a key": ["--set", "=1"],
        "set without a value": ["--set", "push.impulse="], "set without key and value": ["--set", "="], "option of dashes": ["--=1"],
        "three dashes": ["---push.impulse=1"], "an extra word": ["seven"], "an extra number": ["7"],
        "key that is a section": ["--push", "7"], "key with a dot at its end": ["--push.", "7"],
        "key with two dots": ["--push..impulse", "7"], "key with spaces": ["--set", "push impulse=7"],
        "key in capitals": ["--PUSH.IMPULSE", "7"], "key in another alphabet": ["--set", "имп=7"],
        "key of 100,000 letters": ["--set", "k" * 100000 + "=1"], "value of 100,000 digits": ["--push.impulse", "9" * 100000],
        "key given twice": ["--push.impulse", "7", "--push.impulse", "8"],
        "two files of settings": ["--config", "a.yaml", "--config", "b.yaml"],
        "two folders": ["--out", "{d}/other"], "quiet and JSON": ["--quiet", "--json", "--push.impulse", "x"],
        "flag with a value": ["--quiet=3"], "ten thousand words": ["--set", "push.impulse=1"] * 5000 + ["--nothing"],
    }.items():
        add(kind, push + words)

    add = group("Values of settings")
    for kind, key, value in [
        ("text instead of a number", "push.impulse", "seven"), ("empty number", "push.impulse", ""), ("blank number", "push.impulse", " "),
        ("an exponent without digits", "push.impulse", "1e"), ("decimal comma", "push.impulse", "7,5"), ("number out of range", "push.impulse", "1e400"),
        ("a minus sign alone", "push.impulse", "-"), ("two decimal points", "push.impulse", "1.2.3"), ("two signs", "push.impulse", "--7"),
        ("NaN", "push.impulse", "nan"), ("YAML's NaN", "push.impulse", ".nan"), ("infinity", "push.impulse", "inf"), ("YAML's infinity", "push.impulse", ".inf"),
        ("hexadecimal", "push.impulse", "0x10"), ("digits in groups", "push.impulse", "1_000"), ("digits in another script", "push.impulse", "٧"),
        ("number with a unit", "push.impulse", "7 N s"), ("percentage", "push.impulse", "7%"), ("fraction", "push.impulse", "7/2"),
        ("formula", "push.impulse", "2*3"), ("negative size", "push.impulse", "-7"), ("beyond the range", "push.impulse", "1e5"),
        ("list instead of a number", "push.impulse", "[7]"), ("map instead of a number", "push.impulse", "{{a: 7}}"), ("no duration", "push.duration", "0"),
        ("'none' for a required number", "push.impulse", "none"),
        ("two numbers on two lines", "push.impulse", "7\n8"), ("terminal colour codes", "push.impulse", "\x1b[31m7"), ("not UTF-8", "push.impulse", b"\xff7"),
        ("fraction instead of a whole number", "mpc.intervals", "1.5"), ("exponent instead of a whole number", "mpc.intervals", "1e1"),
        ("integer out of range", "mpc.intervals", "99999999999999999999"), ("2^31", "mpc.intervals", "2147483648"),
        ("no intervals", "mpc.intervals", "0"), ("negative intervals", "mpc.intervals", "-15"), ("text instead of a whole number", "mpc.intervals", "many"),
        ("'perhaps' instead of a Boolean", "stepping", "perhaps"), ("number instead of a Boolean", "stepping", "2"), ("empty Boolean", "stepping", ""),
        ("list instead of a Boolean", "stepping", "[true]"),
        ("unknown choice", "plant", "gazebo"), ("misspelt choice", "plant", "centroidl"), ("choice in capitals", "plant", "DART"),
        ("empty choice", "plant", ""), ("list instead of a choice", "solver", "[ipopt]"), ("number instead of a choice", "solver", "1"), ("unknown preset", "preset", "moon"),
        ("too few numbers", "push.direction", "[0, -1]"), ("too many numbers", "push.direction", "[0, -1, 0, 0]"), ("one number instead of a list", "push.direction", "1"),
        ("empty list", "push.direction", "[]"), ("list within a list", "push.direction", "[[0, -1, 0]]"), ("list without its end", "push.direction", "[0, -1, 0"),
        ("text within a list", "push.direction", "[0, left, 0]"), ("NaN within a list", "push.direction", "[0, nan, 0]"),
        ("missing entry in a list", "push.direction", "[0, , 0]"), ("no direction", "push.direction", "[0, 0, 0]"), ("a list of 50,000 numbers", "push.direction", "[" + "0," * 50000 + "0]"),
        ("lists 10,000 deep", "push.direction", "[" * 10000),
        ("pushes that cannot be read", "pushes", "soon 6 90"), ("push with two numbers", "pushes", "3 6"), ("push with five numbers", "pushes", "3 6 90 0.1 7"),
        ("push at NaN", "pushes", "nan 6 90"), ("pushes that overlap", "pushes", "2.45 6 90"), ("push of 100,000 letters", "pushes", "a" * 100000),
        ("push before the start", "pushes", "-1 6 90"),
        ("too many pushes for their time", "push.random.rate_hz", "50"), ("upper limit below the lower limit", "push.random.impulse", "[8, 3]"),
        ("lateral limits in the wrong order", "step.lateral_min", "0.4"), ("shortest step above the longest", "step.shortest_s", "2"),
        ("largest force below the smallest", "contact.fz_max", "5"), ("unsupported number of edges of a pyramid", "contact.edges", "5"), ("unknown log format", "log.formats", "csv,hdf5"),
        ("a folder as the robot file", "robot.config", "{d}"), ("a missing robot file", "robot.config", "{d}/none.yaml"),
        ("a missing URDF", "robot.urdf", "{d}/none.urdf"), ("a yaw rate that turns the feet too far", "walk.velocity", "[0.1, 0, 0.5]"),
        ("mass error of -100 %", "model.mass_error", "-1"), ("tolerance of 0", "solver_tolerance", "0"), ("tolerance of 2", "solver_tolerance", "2"),
        ("a period of 0", "mpc.step_s", "0"), ("weights that are negative", "weights.gamma", "[-1, 0, 0, 0, 0, 0, 0, 0, 0]"),
    ]:
        add(kind + f" ({key})", [word for word in push if key != "plant" or word not in ("--plant", "centroidal")] + [f"--{key}", value])
    add("control period that is not a multiple of the simulator's step (control.period)", ["run", "push_recovery", "--plant", "dart", "--control.period", "0.0015", "--pictures", "false", "--out", "{d}/out"])
    add("NaN for the control period (sway)", ["run", "sway", "--out", "{d}/out", "--set", "mpc.step_s=nan"])

    add = group("Files of settings")
    config = push + ["--config", "{d}/c.yaml"]
    for kind, content in {
        "empty": b"", "blank": b" \n\t\n", "binary data": bytes(range(256)) * 8, "not UTF-8": b"push:\n  impulse: \xff\xfe\n",
        "UTF-16": "push:\n  impulse: x7\n".encode("utf-16"), "a NUL in the middle": b"push:\n  imp\0ulse: 7\n", "tabs": b"push:\n\timpulse: 7\n",
        "unknown key": b"push:\n  impluse: 7\n", "unknown section": b"shove:\n  impulse: 7\n", "key given twice": b"push:\n  impulse: 7\n  impulse: 8\n",
        "section given twice": b"push:\n  impulse: 7\npush:\n  start: 1\n", "key both flat and in its section": b"push.impulse: 7\npush:\n  impulse: 8\n",
        "value instead of a section": b"push: 7\n", "section instead of a value": b"push:\n  impulse:\n    size: 7\n", "list instead of a value": b"push:\n  impulse: [7]\n",
        "list of sections": b"push:\n  - impulse: 7\n", "value missing": b"push:\n  impulse:\n", "null": b"push:\n  impulse: ~\n",
        "an alias": b"a: &a 7\npush:\n  impulse: *a\n", "an alias of itself": b"a: &a [*a]\n", "aliases that expand exponentially": b"a: &a [x,x]\nb: &b [*a,*a]\nc: [*b,*b]\n",
        "merged keys": b"a: &a {impulse: 7}\npush:\n  <<: *a\n", "two documents": b"push:\n  impulse: 7\n---\npush:\n  impulse: 8\n",
        "a Python tag": b"push: !!python/object/apply:os.system ['true']\n", "a binary tag": b"push:\n  impulse: !!binary aGk=\n",
        "an unsupported YAML version": b"%YAML 9.9\n---\npush: {impulse: x}\n", "a single list": b"- push\n- 7\n", "a single word": b"push\n",
        "truncated JSON": b'{"push": {"impulse": 7', "a quote without its end": b'push:\n  impulse: "7\n', "inconsistent indentation": b"push:\n    impulse: 7\n  start: 1\n",
        "an extra colon": b"push: impulse: 7\n", "a key that is a list": b"[a, b]: 7\n", "an empty key": b'"": 7\n', "brackets 100,000 deep": b"[" * 100000,
        "sections 100,000 deep": b"{a: " * 100000, "indentation 2000 levels deep": "".join(" " * i + "a:\n" for i in range(2000)).encode(),
        "a key of a million letters": b"k" * 1000000 + b": 7\n", "a hundred thousand keys": "".join(f"k{i}: 7\n" for i in range(100000)).encode(),
        "a value of a million digits": b"push:\n  impulse: " + b"7" * 1000000 + b"\n", "begins with a comma": b", 2]", "one quote": b"'", "one bracket": b"}",
        "an anchor without a value": b"push: &\n", "the text of an XML file": b"<push><impulse>7</impulse></push>\n", "TOML": b"[push]\nimpulse = 7\n", "INI": b"[push]\nimpulse=7\n",
        "a shell command": b"push:\n  impulse: $(reboot)\n", "an environment variable": b"push:\n  impulse: ${HOME}\n", "a comment in place of the value": b"push:\n  impulse: # 7\n",
        "a carriage return in a name": b"pl\rant: dart\r\n", "no space after the colon": b"push:\n  impulse:7\n",
    }.items():
        add(kind, config, {"c.yaml": content})
    add("a byte order mark and a mistake", config, {"c.yaml": b"\xef\xbb\xbfplant: moon\n"})
    add("a missing file", config)
    add("a folder", config, {"c.yaml": lambda path: path.mkdir()})
    add("a dangling link", config, {"c.yaml": lambda path: path.symlink_to("nowhere")})
    add("a link to itself", config, {"c.yaml": lambda path: path.symlink_to("c.yaml")})
    add("a socket", config, {"c.yaml": lambda path: os.mknod(path, stat.S_IFSOCK | 0o600)})
    add("/dev/null", push + ["--config", "/dev/null"])
    add("/dev/zero, which is endless", push + ["--config", "/dev/zero"])
    add("/dev/urandom, which is endless", push + ["--config", "/dev/urandom"])
    add("a file of 3 GB", config, {"c.yaml": lambda path: os.truncate(path, 3 << 30) if path.touch() is None else None})
    add("a name of 5000 letters", push + ["--config", "n" * 5000])
    add("an empty name", push + ["--config", ""])
    add("a name with a new line", push + ["--config", "{d}/a\nb.yaml"])
    add("standard input, closed", push + ["--config", "/dev/stdin"])
    add("memory of the process", push + ["--config", "/proc/self/mem"])

    add = group("Robots")
    check = ["robot", "check", "{d}/r.urdf"]
    deep = "<a>" * 200000 + "</a>" * 200000
    chain = "".join(f'<joint name="j{i}" type="fixed"><parent link="{f"c{i - 1}" if i else "base"}"/><child link="c{i}"/></joint><link name="c{i}"/>' for i in range(3000))
    for kind, text in {
        "empty URDF": "", "blank URDF": " \n", "text that is not XML": "hello", "HTML": "<html><body>404</body></html>", "truncated in the middle": biped()[:400],
        "another root element": "<model name='r'/>", "an empty root element": "<robot/>", "no links": '<robot name="r"></robot>', "no name": biped().replace(' name="r"', "", 1),
        "two roots of XML": biped() + biped(), "a link twice": biped().replace('"r_foot"', '"l_foot"'), "a joint twice": biped().replace('"r_hip"', '"l_hip"'),
        "an unknown parent link": biped().replace('parent link="base"', 'parent link="bsae"', 1), "an unknown child link": biped().replace('child link="l_foot"', 'child link="none"'),
        "a cycle of joints": biped().replace('parent link="base"', 'parent link="r_foot"', 1).replace('child link="r_foot"', 'child link="l_foot"'),
        "a link without a joint": biped().replace("</robot>", '<link name="loose"/></robot>'), "a joint from a link to itself": biped().replace('parent link="base"', 'parent link="l_foot"', 1),
        "a joint without a parent": biped().replace('<parent link="base"/>', "", 1), "a joint without a child": biped().replace('<child link="l_foot"/>', ""),
        "an unknown type of joint": biped().replace('type="revolute"', 'type="rubber"', 1), "a floating joint": biped().replace('type="revolute"', 'type="floating"', 1),
        "a negative mass": biped().replace('mass value="1"', 'mass value="-1"', 1), "no mass at all": re.sub(r'mass value="\d+"', 'mass value="0"', biped()),
        "a mass that is NaN": biped().replace('mass value="1"', 'mass value="nan"', 1), "a mass out of range": biped().replace('mass value="1"', 'mass value="1e999"', 1),
        "a mass in words": biped().replace('mass value="1"', 'mass value="heavy"', 1), "a mass with a decimal comma": biped().replace('mass value="10"', 'mass value="10,5"'),
        "an inertia that is not positive": biped().replace('ixx="1"', 'ixx="-1"', 1), "a physically impossible inertia": biped().replace('ixx="1"', 'ixx="9"', 1),
        "an inertia without an entry": biped().replace(' izz="1"', "", 1), "limits in the wrong order": biped().replace('lower="-1" upper="1"', 'lower="1" upper="-1"', 1),
        "limits that are NaN": biped().replace('lower="-1"', 'lower="nan"', 1), "no limits": re.sub(r"<limit[^>]*/>", "", biped(), count=1),
        "no effort": biped().replace('effort="10"', 'effort="0"'), "an axis of length 0": biped().replace('axis xyz="1 0 0"', 'axis xyz="0 0 0"', 1),
        "an axis of two numbers": biped().replace('axis xyz="1 0 0"', 'axis xyz="1 0"', 1), "an origin of NaN": biped().replace('origin xyz="0 0.1 0"', 'origin xyz="0 nan 0"'),
        "an origin 1e300 m away": biped().replace('origin xyz="0 0.1 0"', 'origin xyz="0 1e300 0"'), "no feet": SMALL_URDF.format(""), "one foot": SMALL_URDF.format(LEG.format("l", "0.1", BOX)),
        "a sole of size 0": biped('<box size="0 0 0"/>'), "a sole of negative size": biped('<box size="-0.2 0.1 0.05"/>'), "a sole that is a point": biped('<sphere radius="0.05"/>'),
        "geometry without a shape": biped(""), "an unknown shape": biped('<torus radius="1"/>'), "a missing mesh": biped('<mesh filename="none.stl"/>'),
        "a mesh without a name": biped("<mesh/>"), "a mesh above the robot's folders": biped('<mesh filename="../../../../../../etc/passwd"/>'),
        "a mesh with an absolute path": biped('<mesh filename="/etc/passwd"/>'), "a mesh in a missing package": biped('<mesh filename="package://nobody/m.stl"/>'),
        "a mesh outside its package": biped('<mesh filename="package://../m.stl"/>'), "a mesh with a network address": biped('<mesh filename="http://example.org/m.stl"/>'),
        "a mesh of a package at the top of the file system": biped('<mesh filename="package://etc/hostname"/>'), "a mesh of a model at the top": biped('<mesh filename="model://etc/passwd"/>'),
        "a mesh that is a device": biped('<mesh filename="/dev/zero"/>'), "a mesh whose name has 100,000 letters": biped(f'<mesh filename="{"m" * 100000}.stl"/>'),
        "entities that expand exponentially": '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>' + biped().replace('"r"', '"&b;"', 1),
        "an entity from a file": '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]>' + biped().replace('"r"', '"&a;"', 1), "a name of a million letters": biped().replace('"base"', '"' + "b" * 1000000 + '"'),
        "tags 200,000 deep": f'<robot name="r">{deep}</robot>', "a chain of 3000 links": SMALL_URDF.format(chain), "tags 60,000 deep after end tags in CDATA": f'<robot name="r"><![CDATA[{"</" * 60000}]]>{"<a>" * 60000}{"</a>" * 60000}</robot>',
        "tags 60,000 deep that appear to be self-closing": '<robot name="r">' + '<a b="/>">' * 60000, "a declaration inside an element": biped().replace("<link", "<?a?><link", 1),
        "a comment without its end": biped().replace("<link", "<!-- <link", 1),
        "bytes that are not text": biped().replace("base", "b\udcffse"), "an attribute twice": biped().replace('name="base"', 'name="base" name="other"', 1), "xacro that was not expanded": biped().replace('"10"', '"${mass}"', 1),
        "SDF": '<sdf version="1.7"><model name="r"><link name="a"/></model></sdf>', "MJCF": '<mujoco model="r"><worldbody/></mujoco>',
    }.items():
        add(kind, check, {"r.urdf": text})
    for kind, content in {
        "an empty mesh": b"", "a mesh of plain text": b"this is no mesh", "a truncated STL": b"\0" * 80 + (5).to_bytes(4, "little") + b"\0" * 20, "an STL of 4 billion triangles": b"\0" * 80 + b"\xff" * 4 + b"\0" * 50,
        "an STL without triangles": b"\0" * 84, "an STL of NaN": b"\0" * 80 + (1).to_bytes(4, "little") + b"\xff" * 50, "an ASCII STL without its end": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0",
        "an OBJ named STL": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    }.items():
        add(kind, check, {"r.urdf": biped('<mesh filename="m.stl"/>'), "m.stl": content})
    deep = b"<COLLADA>" + b"<node>" * 100000 + b"</node>" * 100000 + b"</COLLADA>"
    for kind, name, content in (("Collada 100,000 deep", "m.dae", deep), ("XML that is not Collada", "m.dae", b"<a/>"), ("Collada in an archive", "m.zae", b"PK\3\4"),
                                ("an OBJ without faces", "m.obj", b"mtllib ../../x.mtl\nv 0 0 0\n"), ("a mesh in an unsupported format", "m.blend", b"BLENDER"), ("a mesh without a format", "m", b"")):
        add(kind, check, {"r.urdf": biped(f'<mesh filename="{name}"/>'), name: content})
    add("a mesh that is a folder", check, {"r.urdf": biped('<mesh filename="m.stl"/>'), "m.stl": lambda path: path.mkdir()})
    add("a mesh of 3 GB", check, {"r.urdf": biped('<mesh filename="m.stl"/>'), "m.stl": lambda path: os.truncate(path, 3 << 30) if path.touch() is None else None})
    add("no file", check)
    add("a folder", check, {"r.urdf": lambda path: path.mkdir()})
    add("no name of a file", ["robot", "check"])
    add("two files", ["robot", "check", "a.urdf", "b.urdf"])
    robot = check + ["--config", "{d}/robot.yaml"]
    for kind, text in {
        "its description: empty": "", "its description: required key missing": "name: r\n", "its description: unknown key": "nmae: r\n", "its description: sole missing from the URDF": "name: r\nleft_foot: {sole: none}\nright_foot: {sole: r_foot}\n",
        "its description: mass in words": "name: r\nmass: heavy\n", "its description: one link for both feet": "name: r\nleft_foot: {sole: l_foot}\nright_foot: {sole: l_foot}\n", "its description: lists instead of maps": "name: r\npostures: [1, 2]\n",
        "its description: a name that is a list": "name: [a]\n",
    }.items():
        add(kind, robot, {"r.urdf": biped(), "robot.yaml": text})
    add("its description: no file", robot, {"r.urdf": biped()})
    add("made from a URDF without feet", ["robot", "new", "{d}/r.urdf", "--out", "{d}/out"], {"r.urdf": SMALL_URDF.format("")})
    for kind, name in (("leads elsewhere", "../../elsewhere/x"), ("is a path", "/tmp/x"), ("is hidden", ".x"), ("has a new line", "r&#10;capsules: 1"), ("is missing", "")):
        add(f"made from a URDF whose name {kind}", ["robot", "new", "{d}/r.urdf"], {"r.urdf": biped().replace('name="r"', f'name="{name}"', 1)})
    add("made into a folder that is a file", ["robot", "new", "{d}/r.urdf", "--out", "{d}/out"], {"r.urdf": biped(), "out": b""})

    add = group("Folders for results")
    def into(out):
        return push[:-1] + [out]
    add("a file", into("{d}/file"), {"file": b"mine"})
    add("below a file", into("{d}/file/out"), {"file": b"mine"})
    add("a device", into("/dev/null"))
    add("below /proc", into("/proc/saltus"))
    add("a name of 300 letters", into("{d}/" + "o" * 300))
    add("a path of 5000 letters", into("{d}/" + "o/" * 2500))
    add("an empty name", into(""))
    add("a link to itself", into("{d}/loop"), {"loop": lambda path: path.symlink_to("loop")})
    add("a folder with other files", into("{d}/theirs"), {"theirs": lambda path: (path.mkdir(), (path / "thesis.tex").write_text("years of work"))[0]}, status=(0, 2))
    for verb in ("plot", "movie", "rerun"):
        add(f"{verb}: a missing file", [verb, "{d}/none"])
        add(f"{verb}: empty", [verb, "{d}/e"], {"e": lambda path: path.mkdir()}, status=(2, 4))
        add(f"{verb}: a file", [verb, "{d}/f"], {"f": b"x"})
        add(f"{verb}: two folders", [verb, "{d}", "{d}"])
    add("logs: a missing file", ["logs", "{d}/none"])
    add("logs: empty", ["logs", "{d}/e"], {"e": lambda path: path.mkdir()})
    add("logs: an unknown format", ["logs", "{d}", "--formats", "hdf5"])
    def results(**files):
        def make(path):
            path.mkdir()
            for name, content in files.items():
                (path / name.replace("__", ".")).write_bytes(content)
        return {"r": make}
    run_json = b'{"problem": "push_recovery", "folder": "/", "saltus": {}}'
    for kind, files in {
        "truncated run.json": {"run__json": run_json[:20]}, "run.json of another kind": {"run__json": b"[1, 2]"}, "run.json of bytes": {"run__json": b"\xff\xfe\0"},
        "run.json of an unknown problem": {"run__json": b'{"problem": "none", "folder": "/"}'}, "run.json with a number as the problem": {"run__json": b'{"problem": 7, "folder": "/"}'},
        "run.json 100,000 deep": {"run__json": b"[" * 100000 + b"]" * 100000},
        "run.json with a problem of 100,000 letters": {"run__json": b'{"problem": "' + b"p" * 100000 + b'", "folder": "/"}'},
        "settings of another version": {"run__json": run_json, "config__yaml": b"push:\n  strength: 7\n"}, "truncated settings": {"run__json": run_json, "config__yaml": b"push: {"},
    }.items():
        add(f"rerun: {kind}", ["rerun", "{d}/r", "--out", "{d}/out"], results(config__yaml=files.pop("config__yaml", b"plant: centroidal\n"), **files))
    for name in ("zero", "urandom"):
        add(f"rerun: run.json is /dev/{name}", ["rerun", "{d}/r", "--out", "{d}/out"], {"r": lambda path, name=name: (path.mkdir(), (path / "config.yaml").write_text(""), (path / "run.json").symlink_to(f"/dev/{name}"))[0]})
    add("rerun: into a folder that is not empty", ["rerun", "{d}/r", "--out", "{d}/r"], results(run__json=run_json, config__yaml=b"plant: centroidal\n"))
    for kind, content in {
        "a binary table": b"\xff\xfe\0" * 50, "an empty table": b"", "a table with a header only": b"t [s],x\n", "a truncated table": b"t [s],com_x [m]\n0,0.1\n0.01,", "a table of text": b"t [s],com_x [m]\nnow,there\n",
        "a table of NaN": b"t [s],com_x [m]\nnan,nan\n", "rows of different lengths": b"t [s],com_x [m]\n0\n0,1,2\n", "other columns": b"a,b\n1,2\n",
    }.items():
        add(f"plot: {kind}", ["plot", "{d}/r"], status=(0, 4), files=results(trajectory__csv=content, summary__json=b"{}", config__yaml=b"plant: centroidal\n", run__json=run_json))
    add("logs: a binary table", ["logs", "{d}/r", "--formats", "mat"], results(trajectory__csv=b"\xff\xfe\0" * 50), status=(4,))
    add("plot: a summary that is not JSON", ["plot", "{d}/r"], results(trajectory__csv=b"t [s],com_x [m]\n0,0\n", summary__json=b"{", config__yaml=b"plant: centroidal\n", run__json=run_json), status=(4,))
    add("plot: a binary map", ["plot", "{d}/r"], results(map__csv=b"\xff\0" * 40, config__yaml=b"plant: centroidal\n"), status=(4,))

    add = group("Maps")
    survey = ["map", "--plant", "centroidal", "--set", "pictures=false", "--jobs", "1", "--out", "{d}/out"]
    for kind, words in {
        "no directions": ["--directions", "0"], "negative directions": ["--directions", "-4"], "a billion directions": ["--directions", "1000000000"], "directions in words": ["--directions", "all"],
        "impulses in words": ["--impulses", "a,b"], "no impulses": ["--impulses", ""], "a range with step zero": ["--impulses", "1:0:5"], "a range with a step in the wrong direction": ["--impulses", "1:-1:5"],
        "a range with its ends in the wrong order": ["--impulses", "5:1:1"], "a range of a billion numbers": ["--impulses", "1:1e-9:2"], "half a range": ["--impulses", "1:2"], "four numbers in a range": ["--impulses", "1:1:5:9"],
        "a negative impulse": ["--impulses", "-3"], "a NaN impulse": ["--impulses", "nan"], "an infinite range": ["--impulses", "1:1:inf"], "a comma at the end": ["--impulses", "1,"],
        "an impulse twice": ["--impulses", "3,3,3"], "negative times": ["--step-times", "-0.6"], "an unknown controller": ["--controllers", "pid"], "a controller twice": ["--controllers", "mpc,mpc,x"],
        "no jobs": ["--jobs", "0"], "negative jobs": ["--jobs", "-2"], "a million jobs": ["--jobs", "1000000"], "jobs in words": ["--jobs", "many"], "an unknown plant": ["--plant", "gazebo"],
        "a setting that the map varies": ["--set", "push.impulse=7"], "an unknown setting": ["--set", "push.impluse=7"], "an extra word": ["north"], "--all with a value": ["--all=3"],
    }.items():
        few = [] if words[0] in ("--directions",) else ["--directions", "1"]
        few += [] if words[0] == "--impulses" else ["--impulses", "3"]
        kept = survey[:1] + survey[3:] if words[0] == "--plant" else survey
        if words[0] == "--jobs":
            kept = [w for w in kept if w not in ("--jobs", "1")]
        add(kind, kept + few + words, status=(0, 2) if kind == "an impulse twice" else (2,))
    def begun(table, settings=b"plant: centroidal\n"):
        def make(path):
            path.mkdir()
            (path / "map.csv").write_bytes(table)
            if settings is not None:
                (path / "config.yaml").write_bytes(settings)
        return {"out": make}
    head = b"controller,step_time_s,direction_deg,impulse_ns,outcome,bound_ns,reason,angular_momentum_max_nms,com_height_min_m,com_height_max_m,icp_settling_s,icp_furthest_m,touchdown_after_push_s,final_com_error_m,stepped,failed_solves,seconds,known_from\n"
    few = ["--directions", "1", "--impulses", "3"]
    add("continued with other settings", survey + few, begun(head + b"mpc,0.6,270,7,recovered,5.2,,0.99,0.52,0.54,1.5,0.1,0.6,0.001,1,0,3.2,\n"))
    add("continued without its settings", survey + few, begun(head + b"mpc,0.6,270,7,recovered,5.2,,0.99,0.52,0.54,1.5,0.1,0.6,0.001,1,0,3.2,\n", None))
    add("continued from a table of another version", survey + few, begun(b"a,b\n1,2\n" * 90))
    add("continued in the folder of a run", survey + few, {"out": lambda path: (path.mkdir(), (path / "config.yaml").write_text("x: 1\n"))[0]})

    add = group("New projects")
    for kind, name in {
        "empty name": "", "a blank": " ", "two dots": "..", "a dot": ".", "a path to an existing file": "../file", "begins with a dash": "-x", "begins with a digit": "7up", 
        "spaces": "my project", "quotes": 'a"b', "a semicolon": "a;b", "another alphabet": "имя", "terminal colour codes": "\x1b[31mx", "a name of 300 letters": "x" * 300, "not UTF-8": b"\xffx", "a name reserved by CMake": "test",
        "a CMake variable": "${HOME}",
    }.items():
        add(kind, ["new", name], {"file": b""}, status=(0, 2) if kind in ("a name reserved by CMake",) else (2,))
    add("a folder that is not empty", ["new", "{d}/full"], {"full": lambda path: (path.mkdir(), (path / "a").touch())[0]})
    add("a file", ["new", "{d}/full"], {"full": b"x"})
    add("an unknown kind", ["new", "{d}/x", "--kind", "game"])
    add("a folder that is not writable", ["new", "/proc/x"])

    add = group("Benchmarks")
    for kind, words in {
        "latency without a matching case": ["latency", "--only", "no_such"], "latency against an unknown solver": ["latency", "--against", "cplex"], "latency against a missing library": ["latency", "--against", "hpipm", "--library", "{d}/none.so"],
        "results into a missing folder": ["latency", "--only", "no_such", "--json", "{d}/no/f.json"], "run of an unknown problem": ["run", "--problems", "no_such"], "run by an unknown solver": ["run", "--solvers", "no_such"],
        "run with an unknown start": ["run", "--start", "tepid"], "a tolerance in words": ["run", "--tolerance", "tight"], "a negative tolerance": ["run", "--tolerance", "-1", "--quick"], "no instances": ["run", "--instances", "0"], "no repetitions": ["run", "--repetitions", "0"],
        "a shard beyond the last": ["run", "--shard", "5/4"], "a shard in words": ["run", "--shard", "first"], "zero shards": ["run", "--shard", "0/0"], "a result file in a missing folder": ["run", "--quick", "--out", "{d}/no/r.json"],
        "an unknown scheduler": ["run", "--quick", "--scheduler", "nonsense", "--out", "{d}/r.json"], "a report without a file": ["report"], "a report of a missing file": ["report", "{d}/none.json"], "a comparison of only one file": ["compare", "{d}/a.json"],
        "a merge without a name": ["merge", "{d}/a.json"], "zero runs of pushes": ["pushes", "--runs", "0"], "pushes with limits in the wrong order": ["pushes", "--runs", "1", "--impulse", "9:3"], "pushes in words": ["pushes", "--runs", "few"],
        "reproduce an unknown table": ["reproduce", "no_such"], "an unknown option": ["run", "--fast"],
    }.items():
        add(kind, ["bench"] + words)
    for kind, content in {"a report of binary data": b"\xff\xfe\0", "a report of another kind": b"[1, 2]", "a report of a truncated file": b'{"format": "saltus-be', "a report of an empty file": b"", "a report of JSON 100,000 deep": b"[" * 100000}.items():
        add(kind, ["bench", "report", "{d}/r.json"], {"r.json": content})
    add("a report of a device", ["bench", "report", "/dev/zero"])
    add("a merge of two different kinds", ["bench", "merge", "--out", "{d}/m.json", "{d}/a.json", "{d}/b.json"], {"a.json": b"{}", "b.json": b"[]"})

    add = group("Quadratic programs from files")
    line = b"a.npz,2,1,0,0,1,0,1,1\n"
    good = {"P": (2, 2), "q": (2, 1), "G": (1, 2), "h": (1, 1)}
    for kind, listed, arrays in (
            ("no list", None, good), ("a list of words", b"a.npz,2,1,0,0,few,0,1,1\n", good), ("a truncated line", b"a.npz,2,1\n", good), ("more values than variables", line.replace(b"1,1\n", b"1,1,1\n"), good),
            ("a program in another folder", b"../" + line, good), ("a missing program", b"b" + line, good), ("P that is not square", line, {**good, "P": (5, 1)}), ("G too wide", line, {**good, "G": (2, 5)}),
            ("h too long", line, {**good, "h": (9, 1)}), ("bounds too long", line, {**good, "lb": (9, 1)}), ("no P", line, {"q": (2, 1)}), ("an empty archive", line, {})):
        def make(path, listed=listed, arrays=arrays):
            path.mkdir()
            if listed is not None:
                (path / "expected.csv").write_bytes(b"# name\n" + listed)
            write_npz(path / "a.npz", arrays)
        add(kind, ["suite", "--only", "C01", "--set", "solver=sparse"], {"mpc_qp": make}, env={"SALTUS_REFERENCE_DATA": "{d}"}, status=(3,), line="FAILED:|MISSED")

    add = group("Environment")
    bad = push + ["--push.impulse", "x"]
    add("HOME is not set", bad, env={"HOME": None})
    add("HOME is empty", bad, env={"HOME": ""})
    add("SALTUS_ICUB_URDF names a missing file", ["run", "push_recovery", "--plant", "dart", "--out", "{d}/out"], env={"SALTUS_ICUB_URDF": "/nowhere/model.urdf"})
    add("SALTUS_ICUB_URDF names a folder", ["run", "push_recovery", "--plant", "dart", "--out", "{d}/out"], env={"SALTUS_ICUB_URDF": "/tmp"})
    add("SALTUS_ICUB_URDF names a file that is not a URDF", ["run", "push_recovery", "--plant", "dart", "--out", "{d}/out"], env={"SALTUS_ICUB_URDF": "/etc/hostname"})
    add("the cache is a file", ["run", "push_recovery", "--plant", "dart", "--out", "{d}/out"], {"cache": b""}, env={"SALTUS_ICUB_URDF": None, "XDG_CACHE_HOME": "{d}/cache", "PIP_NO_INDEX": "1"})
    for name in ("C", "tr_TR.UTF-8", "xx_YY"):
        add(f"the language is {name}", bad, env={"LC_ALL": name, "LANG": name})
    add("number of threads in words", bad, env={"OMP_NUM_THREADS": "many"})
    add("no PATH", bad, env={"PATH": ""})
    add("standard input is closed", bad, closed=(0,))
    add("standard output is closed", bad, closed=(1,))
    add("the error stream is closed", bad, closed=(2,))
    add("all three are closed", bad, closed=(0, 1, 2))
    add("standard output is full", ["list"], stdout="/dev/full", status=(1, 2))
    add("the current folder was deleted", ["run", "push_recovery", "--push.impulse", "x"], gone=True)
    add("the current folder was deleted, and results are written to it", ["run", "push_recovery", "--plant", "centroidal", "--pictures", "false"], gone=True)
    add("files limited to 4 kB", push, limits={resource.RLIMIT_FSIZE: 4096})
    add("open files limited to eight", push, limits={resource.RLIMIT_NOFILE: 8}, status=(0, 2))
    add("no further process allowed", push, limits={resource.RLIMIT_NPROC: 0}, status=(0, 2))
    return everything


def half_written(folder):
    """Files that a stopped program may leave."""
    found = []
    for path in sorted(pathlib.Path(folder).rglob("*")) if os.path.isdir(folder) else []:
        if path.is_symlink() or not path.is_file():
            continue
        if path.name.endswith(".part"):
            found.append(path.name)
        elif path.suffix == ".json":
            try:
                json.loads(path.read_text(encoding="utf-8", errors="replace"))
            except ValueError:
                found.append(path.name)
        elif path.suffix == ".csv":
            rows = list(csv.reader(path.read_text(encoding="utf-8", errors="replace").splitlines()))
            if not rows or {len(row) for row in rows} != {len(rows[0])}:
                found.append(path.name)
    return found


def shown(text, folder):
    """The message in the form of the page, the same on every machine."""
    text = text.replace(folder, "DIR").replace(os.path.realpath(folder), "DIR")
    text = re.sub(r"x{20,}|(.)\1{40,}", lambda m: m.group(0)[:3] + "...", text)
    lines = [line for line in text.strip().splitlines() if line.strip()]
    return " / ".join(lines[:3]) + (" / ..." if len(lines) > 3 else "")


class Outcome:
    def __init__(self, case, status, text, faults, seconds):
        self.case, self.status, self.text, self.faults, self.seconds = case, status, text, faults, seconds


def outcome_of(program, case, addresses):
    folder = tempfile.mkdtemp(prefix="saltus-bad-")
    try:
        for name, content in case.files.items():
            path = pathlib.Path(folder, name)
            if callable(content):
                content(path)
            else:
                path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogateescape"))
        fill = lambda word: word if isinstance(word, bytes) else word.replace("{d}", folder).replace("{{", "{").replace("}}", "}")
        env = dict(os.environ, SALTUS_BENCH_TIMEOUT="30")
        for key, value in case.env.items():
            env.pop(key, None)
            if value is not None:
                env[key] = fill(value)
        cwd = os.path.join(folder, "started")
        os.mkdir(cwd)

        def before():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_AS, (addresses, addresses))
            for what, limit in case.how.get("limits", {}).items():
                resource.setrlimit(what, (limit, limit))
            for number in case.how.get("closed", ()):
                os.close(number)
            if case.how.get("gone"):
                os.rmdir(cwd)

        begin = time.monotonic()
        with open(case.how.get("stdout", os.devnull), "wb") as nowhere, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as error:
            process = subprocess.Popen([os.fsencode(program)] + [w if isinstance(w, bytes) else os.fsencode(fill(w)) for w in case.words],
                                       stdin=subprocess.DEVNULL, stdout=nowhere if "stdout" in case.how else out, stderr=error, env=env, cwd=cwd,
                                       preexec_fn=before, start_new_session=True)
            hangs = False
            try:
                status = process.wait(LIMIT)
            except subprocess.TimeoutExpired:
                hangs, status = True, None
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
            error.seek(0)
            text = error.read().decode("utf-8", "replace")
            out.seek(0)
            said = out.read().decode("utf-8", "replace")
        seconds = time.monotonic() - begin
        faults = []
        if hangs:
            faults.append(f"hangs for {LIMIT} s")
        elif status < 0:
            faults.append(f"ended by {signal.Signals(-status).name}")
        elif status not in case.status:
            faults.append(f"status {status}")
        sentence = text if text.strip() or status == 0 else said
        if status not in (0, None) and 2 not in case.how.get("closed", ()):
            if not sentence.strip():
                faults.append("says nothing")
            if "Traceback" in sentence or "internal error" in sentence:
                faults.append("blames itself")
            if any(ord(c) < 32 and c not in "\n\t" for c in sentence):
                faults.append("sends control characters")
            if len(sentence.replace(folder, "")) > LONGEST:
                faults.append(f"says {len(sentence)} characters")
        for where in ("out", "started"):
            faults += [f"leaves {name}" for name in half_written(os.path.join(folder, where)) if "out" not in case.files]
        if "line" in case.how:  # a message about a table
            sentence = "\n".join(line for line in sentence.splitlines() if re.search(case.how["line"], line))
        return Outcome(case, status, shown(sentence, folder) if status != 0 else "", faults, seconds)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def cell(text):
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;").replace("\t", " ")


def page(outcomes):
    lines = ["# Bad input", "",
             f"This page lists {len(outcomes)} kinds of user mistakes with the exit status and message of the program. For each kind, a test",
             "checks that the program does not hang, does not end by a signal, reports no internal error, and leaves no partial file.",
             "Status 2 means bad input. DIR is the folder of the case, and long text is truncated. `tests/faults/bad_inputs.py` makes",
             "the tables.", ""]
    seen = None
    for outcome in outcomes:
        if outcome.case.group != seen:
            seen = outcome.case.group
            lines += ["", f"## {seen}", "", "| kind | status | message |", "| --- | --- | --- |"]
        lines.append(f"| {cell(outcome.case.kind)} | {outcome.status} | {cell(outcome.text)[:300]} |")
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("page", nargs="?")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sanitized", action="store_true")
    args = parser.parse_args()
    addresses = resource.RLIM_INFINITY if args.sanitized else MEMORY
    program = os.path.abspath(args.program)
    wanted = [case for case in cases() if args.only in f"{case.group}: {case.kind}"]
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        outcomes = list(pool.map(lambda case: outcome_of(program, case, addresses), wanted))
    wrong = [o for o in outcomes if o.faults]
    for o in outcomes if args.only else wrong:
        print(f"{o.case.group}: {o.case.kind}: {', '.join(o.faults) or 'as it should'} [{o.status}, {o.seconds:.1f} s]: {o.text[:300]}")
    print(f"{len(outcomes)} kinds, {len(wrong)} not as they should be; the slowest took {max(o.seconds for o in outcomes):.1f} s")
    if args.write:
        pathlib.Path(args.page).write_text(page(outcomes), encoding="utf-8")
    elif args.page:
        stated = pathlib.Path(args.page).read_text(encoding="utf-8")
        for line in page(outcomes).splitlines():
            if line.startswith("| ") and line not in stated:
                kind = line[: line.index(" | ", line.index(" | ") + 3)]
                if kind + " | " not in stated:  # compare the status only; messages may depend on the machine
                    print(f"not as {args.page} has it: {line}")
                    wrong.append(line)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
