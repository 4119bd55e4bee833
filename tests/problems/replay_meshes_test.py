"""Checks where meshes are found, how STL is read, and that clustering keeps the shape. Usage: this file FOLDER, the
folder of the package saltus."""

import base64
import os
import struct
import sys
import tempfile
import unittest

sys.path.insert(0, sys.argv.pop(1))
from saltus.walking import replay_meshes  # noqa: E402

try:
    import numpy
except ImportError:
    numpy = None

ROUNDING = 1e-5  # m: single precision, and 16 bits over a box of 0.2 m


def ball(radius=0.1, rows=80):
    """Triangles of a ball around (1, 2, 3)."""
    theta = numpy.linspace(0.0, numpy.pi, rows + 1)
    phi = numpy.linspace(0.0, 2.0 * numpy.pi, 2 * rows + 1)
    t, p = numpy.meshgrid(theta, phi, indexing="ij")
    points = radius * numpy.stack([numpy.sin(t) * numpy.cos(p), numpy.sin(t) * numpy.sin(p),
                                   numpy.cos(t)], axis=-1) + [1.0, 2.0, 3.0]
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return numpy.concatenate([numpy.stack([a, b, c], axis=2).reshape(-1, 3, 3),
                              numpy.stack([a, c, d], axis=2).reshape(-1, 3, 3)])


def volume(points, triangles):
    a, b, c = (points[triangles[:, i]] - points.mean(axis=0) for i in range(3))
    return numpy.einsum("ij,ij->", a, numpy.cross(b, c)) / 6.0


def binary_stl(corners):
    return b"solid is no sign of text".ljust(80) + struct.pack("<I", len(corners)) + b"".join(
        struct.pack("<12fH", 0.0, 0.0, 0.0, *map(float, c.reshape(-1)), 0) for c in corners)


def text_stl(corners):
    lines = ["solid ball"]
    for corner in corners:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex %.9e %.9e %.9e" % tuple(p) for p in corner]
        lines += ["endloop", "endfacet"]
    return "\n".join(lines + ["endsolid ball", ""]).encode()


class InFolder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = os.path.realpath(self.temporary.name)
        self.urdf = self.file("share/Robo/robots/one/model.urdf")

    def tearDown(self):
        self.temporary.cleanup()

    def file(self, path, content=b""):
        path = os.path.join(self.folder, path)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(content)
        return path


class Find(InFolder):
    def test_package_around_the_urdf(self):
        mesh = self.file("share/Robo/meshes/a.stl")
        for scheme in ("package", "model"):
            self.assertEqual(replay_meshes.find(scheme + "://Robo/meshes/a.stl", self.urdf, {}), mesh)

    def test_paths(self):
        beside = self.file("share/Robo/robots/one/b.stl")
        above = self.file("share/Robo/meshes/a.stl")
        for reference, path in (("b.stl", beside), ("meshes/a.stl", above),
                                ("../../meshes/a.stl", above), (beside, beside),
                                ("file://" + beside, beside)):
            self.assertTrue(os.path.samefile(replay_meshes.find(reference, self.urdf, {}), path))

    def test_searches_the_paths_of_ros_and_gazebo(self):
        mesh = self.file("elsewhere/share/Far/a.stl")
        around = os.path.join(self.folder, "elsewhere/share")
        for variable, folder in (("ROS_PACKAGE_PATH", around),
                                 ("ROS_PACKAGE_PATH", os.path.join(around, "Far")),
                                 ("GAZEBO_MODEL_PATH", "/nowhere" + os.pathsep + around),
                                 ("AMENT_PREFIX_PATH", os.path.join(self.folder, "elsewhere"))):
            found = replay_meshes.find("package://Far/a.stl", self.urdf, {variable: folder})
            self.assertEqual(found, mesh, variable)

    def test_outside_only_on_request(self):
        foreign = self.file("elsewhere/a.stl")
        for reference in (foreign, "file://" + foreign, "../../../../elsewhere/a.stl",
                          "package://Robo/../../elsewhere/a.stl", "package://../elsewhere/a.stl"):
            with self.assertRaisesRegex(replay_meshes.MeshError, "robot's folders", msg=reference):
                replay_meshes.find(reference, self.urdf, {})
        beside = self.file("share/Robo/robots/one/c.stl")
        for reference in ("package://etc/hostname", "package:/" + beside):  # path from the file system root
            with self.assertRaisesRegex(replay_meshes.MeshError, "robot's folders", msg=reference):
                replay_meshes.find(reference, self.urdf, {})
        asked = {"ROS_PACKAGE_PATH": os.path.dirname(foreign)}
        self.assertEqual(replay_meshes.find(foreign, self.urdf, asked), foreign)

    def test_missing(self):
        with self.assertRaisesRegex(replay_meshes.MeshError, "ROS_PACKAGE_PATH"):
            replay_meshes.find("package://Far/a.stl", self.urdf, {})


@unittest.skipIf(numpy is None, "numpy is not installed")
class Stl(InFolder):
    def test_binary_and_text_agree(self):
        corners = ball(rows=6)
        for content in (binary_stl(corners), text_stl(corners)):
            read = replay_meshes.read_stl(self.file("a.stl", content))
            self.assertLess(numpy.abs(read - corners).max(), ROUNDING)

    def test_other_files_than_stl_are_rejected(self):
        whole = binary_stl(ball(rows=6))
        for content in (b"", b"<COLLADA/>", whole[:-7], b"solid empty\nendsolid\n",
                        b"solid\nvertex 1 2 x\n", text_stl(ball(rows=2)).replace(b"e", b"", 1)[:60]):
            with self.assertRaises(replay_meshes.MeshError):
                replay_meshes.read_stl(self.file("a.stl", content))

    def test_clustering_keeps_the_shape(self):
        corners = ball()
        points, triangles = replay_meshes.cluster(corners, 0.01)
        self.assertLess(len(triangles), 0.25 * len(corners))
        # A mean of points on a ball is inside it by less than one cell.
        radius = numpy.linalg.norm(points - [1.0, 2.0, 3.0], axis=1)
        self.assertLess(abs(radius - 0.1).max(), 0.01)
        self.assertEqual(len(numpy.unique(numpy.sort(triangles, axis=1), axis=0)), len(triangles))
        self.assertAlmostEqual(volume(points, triangles) / (4.0 / 3.0 * numpy.pi * 0.1**3), 1.0,
                               delta=0.05)

    def test_simplifies_until_small_enough(self):
        most = replay_meshes.MOST_TRIANGLES
        replay_meshes.MOST_TRIANGLES = 2000
        try:
            small = replay_meshes.simplify([ball(), ball(rows=60)])
        finally:
            replay_meshes.MOST_TRIANGLES = most
        self.assertLessEqual(sum(len(t) for _, t in small), 2000)
        self.assertGreater(min(len(t) for _, t in small), 500)


@unittest.skipIf(numpy is None, "numpy is not installed")
class TakeIn(InFolder):
    def robot(self, *references, scale=(1.0, 1.0, 1.0)):
        looks = [{"link": r, "boxes": [], "visuals": [
            {"shape": "mesh", "mesh": r, "size": list(scale)}]} for r in references]
        return {"urdf": self.urdf, "bodies": [{"looks": looks}]}

    def test_packed_mesh_round_trips(self):
        self.file("share/Robo/a.stl", binary_stl(1e3 * ball(rows=6)))
        # Mirrored, and in mm: the triangle normals must still point outward.
        robot = self.robot("package://Robo/a.stl", "package://Robo/a.stl", scale=(1e-3, -1e-3, 1e-3))
        table, packed, warning = replay_meshes.take_in(robot, {})
        self.assertIsNone(warning)
        self.assertEqual(len(table), 1)
        self.assertEqual([look["visuals"][0]["index"] for look in robot["bodies"][0]["looks"]],
                         [0, 0])
        entry, data = table[0], base64.b64decode(packed)
        self.assertEqual(len(data), 6 * (entry["corners"] + entry["triangles"]))
        levels = numpy.frombuffer(data, "<u2", 3 * entry["corners"]).reshape(-1, 3)
        points = numpy.array(entry["low"]) + levels * numpy.array(entry["step"])
        triangles = numpy.frombuffer(data, "<u2", offset=6 * entry["corners"]).reshape(-1, 3)
        self.assertLess(abs(numpy.linalg.norm(points - [1, -2, 3], axis=1) - 0.1).max(), ROUNDING)
        self.assertGreater(volume(points, triangles), 0.0)

    def test_one_warning_counts_and_names_the_first(self):
        self.file("share/Robo/a.stl", binary_stl(ball(rows=6)))
        self.file("share/Robo/c.dae", b"<COLLADA/>")
        robot = self.robot("package://Robo/b.stl", "package://Robo/a.stl", "package://Robo/c.dae",
                           "package://Robo/b.stl")
        table, _, warning = replay_meshes.take_in(robot, {})
        self.assertEqual(len(table), 1)
        self.assertRegex(warning, "2 of 3 meshes .* package://Robo/b.stl, is not in the robot's folders; name")
        self.assertNotIn("\n", warning)
        looks = robot["bodies"][0]["looks"]
        self.assertEqual([len(look["visuals"]) for look in looks], [0, 1, 0, 0])

    def test_robot_without_meshes(self):
        table, packed, warning = replay_meshes.take_in({"urdf": "", "bodies": [{}]}, {})
        self.assertEqual((table, packed, warning), ([], "", None))


if __name__ == "__main__":
    unittest.main()
