"""Finds and reads the meshes of a URDF and reduces them to the size of a page.

STL, binary or text. All corners in one cell of a cubic grid are replaced by their mean, and degenerate triangles are
removed (vertex clustering, Rossignac and Borrel 1993). The cells grow until the whole robot has few enough triangles.
Corners are quantised to 16 bits within their box.
"""

import base64
import os
import re

FINEST_CELL = 0.002  # m
MOST_TRIANGLES = 120000  # total of all meshes: at most 1.5 MB in the page
MOST_CORNERS = 65535  # per mesh: indices have 16 bits
LEVELS = 65535
LONGEST = 1 << 26  # bytes per mesh, as in robots/saltus/robots/model/mesh.cpp
REMEDY = "add the folder that contains it to ROS_PACKAGE_PATH"


class MeshError(Exception):
    """The reason why a mesh cannot be drawn, with the remedy."""


def parents(folder):
    """The folder and all its parents."""
    folder = os.path.abspath(folder)
    while True:
        yield folder
        if os.path.dirname(folder) == folder:
            return
        folder = os.path.dirname(folder)


def named_folders(environment):
    """The search paths of ROS and Gazebo for packages."""
    for variable in ("ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH", "AMENT_PREFIX_PATH"):
        for folder in filter(None, environment.get(variable, "").split(os.pathsep)):
            yield os.path.abspath(folder)


def lies_in(folder, path):
    """Compares paths by name and does not resolve links in the file system."""
    folder, path = os.path.normpath(folder), os.path.normpath(path)
    return os.path.commonpath([folder, path]) == folder


def folders_around(urdf):
    """The folder of the URDF and its parents, except those at the top of the file system."""
    own, *above = parents(os.path.dirname(urdf))
    return [own] + [folder for folder in above
                    if os.path.dirname(os.path.dirname(folder)) != os.path.dirname(folder)]


def folders_of_robot(urdf):
    """The folder of the URDF and its two parents, because packages have robots/NAME/ next to meshes/."""
    return folders_around(urdf)[:3]


def find(reference, urdf, environment=os.environ):
    """The file of package://NAME/REST, model://NAME/REST, file://PATH or a path.

    Names must stay inside their package, and paths inside the folders of the robot or named folders: a URDF from
    elsewhere cannot open other files (as in robots/saltus/robots/model/mesh.cpp).
    """
    if reference.startswith("file://"):
        reference = reference[len("file://"):]
    parts = re.match(r"(?:package|model)://(?!\.\.?/)([^/]+)/(.+)", reference)
    tries = []  # files, with the folders of which one must contain them
    if parts:
        name, rest = parts.groups()
        for folder in [*folders_around(urdf), *named_folders(environment)]:
            packages = [os.path.join(folder, name), os.path.join(folder, "share", name)]
            if os.path.basename(os.path.normpath(folder)) == name:
                packages.append(folder)
            tries += [(os.path.join(package, rest), [package]) for package in packages]
    else:
        around = folders_of_robot(urdf)
        allowed = [*around, *named_folders(environment)]
        tries = [(os.path.join(folder, reference), allowed) for folder in around]
    for path, allowed in tries:
        if os.path.isfile(path) and any(lies_in(folder, path) for folder in allowed):
            return path
    raise MeshError("is not in the robot's folders; " + REMEDY)


def read_stl(path):
    """Corners of the triangles, n x 3 x 3."""
    try:
        import numpy
    except ImportError:
        raise MeshError("cannot be read without numpy; "
                        "install python3-numpy and use /usr/bin/python3") from None
    try:
        with open(path, "rb") as file:
            data = file.read(LONGEST + 1)
    except OSError as error:
        raise MeshError(f"cannot be read ({error.strerror}); check {path}") from None
    if len(data) > LONGEST:
        raise MeshError(f"has more than {LONGEST >> 20} MB; export it with fewer triangles")
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + 50 * count:
        record = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("byte", "<u2")])
        corners = numpy.frombuffer(data, record, offset=84)["corners"].astype(float)
    elif data.lstrip()[:5].lower() == b"solid":
        words = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data)
        try:
            corners = numpy.array(words, dtype=float).reshape(-1, 3, 3)
        except ValueError:
            raise MeshError("has corners that do not form triangles; export it again") from None
    else:
        raise MeshError("is not a complete STL file; export it again as STL")
    if len(corners) == 0 or not numpy.isfinite(corners).all():
        raise MeshError("has no triangles, or corners that are not finite; export it again")
    return corners


def cluster(corners, cell):
    """Corners (k x 3) and triangles (m x 3 indices) after clustering with this cell size."""
    import numpy
    points = corners.reshape(-1, 3)
    cells = numpy.floor((points - points.min(axis=0)) / cell).astype(numpy.int64)
    extent = cells.max(axis=0) + 1
    keys = (cells[:, 0] * extent[1] + cells[:, 1]) * extent[2] + cells[:, 2]
    _, of_point, sizes = numpy.unique(keys, return_inverse=True, return_counts=True)
    of_point = of_point.reshape(-1)
    means = numpy.stack([numpy.bincount(of_point, weights=points[:, i]) for i in range(3)], axis=1)
    means /= sizes[:, None]
    triangles = of_point.reshape(-1, 3)
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    _, first = numpy.unique(numpy.sort(triangles, axis=1), axis=0, return_index=True)
    triangles = triangles[numpy.sort(first)]
    used, triangles = numpy.unique(triangles, return_inverse=True)
    return means[used], triangles.reshape(-1, 3)


def simplify(meshes):
    """All meshes, clustered with the smallest cell that meets the limits."""
    cell = FINEST_CELL
    while True:
        small = [cluster(corners, cell) for corners in meshes]
        if (sum(len(triangles) for _, triangles in small) <= MOST_TRIANGLES
                and all(len(points) <= MOST_CORNERS for points, _ in small)):
            return small
        cell *= 1.2


def pack(meshes):
    """A table for the page, and all corners and indices as little-endian uint16 in base64."""
    table, data = [], b""
    for points, triangles in meshes:
        entry = {"offset": len(data), "corners": len(points), "triangles": len(triangles)}
        if len(points) > 0:
            low = points.min(axis=0)
            step = (points.max(axis=0) - low) / LEVELS
            levels = ((points - low) / (step + (step == 0.0))).round()
            entry.update(low=low.tolist(), step=step.tolist())
            data += levels.astype("<u2").tobytes() + triangles.astype("<u2").tobytes()
        table.append(entry)
    return table, base64.b64encode(data).decode("ascii")


def take_in(robot, environment=os.environ):
    """Assigns every mesh of robot.json its index in the table of packed meshes.

    Returns table, packed meshes, and a warning or None. Links without a drawable visual keep only their boxes.
    """
    index, meshes, refused = {}, [], {}
    visuals = [(visual, look) for body in robot["bodies"] for look in body.get("looks", [])
               for visual in look["visuals"] if visual["shape"] == "mesh"]
    for visual, _ in visuals:
        key = (visual["mesh"], tuple(visual["size"]))
        if key in index or visual["mesh"] in refused:
            continue
        try:
            corners = read_stl(find(visual["mesh"], robot["urdf"], environment))
            # An odd number of negative scales mirrors the mesh and reverses its triangles.
            scale = visual["size"]
            corners = corners * scale
            if scale[0] * scale[1] * scale[2] < 0.0:
                corners = corners[:, ::-1]
        except MeshError as error:
            refused[visual["mesh"]] = error
            continue
        index[key] = len(meshes)
        meshes.append(corners)
    for visual, look in visuals:
        if visual["mesh"] in refused:
            look["visuals"] = [v for v in look["visuals"] if v is not visual]
        else:
            visual["index"] = index[(visual["mesh"], tuple(visual["size"]))]
    table, data = pack(simplify(meshes))
    warning = None
    if refused:
        first = next(iter(refused))
        warning = (f"warning: {len(refused)} of {len(refused) + len(meshes)} meshes are drawn as "
                   f"boxes in the replay; the first, {first}, {refused[first]}")
    return table, data, warning
