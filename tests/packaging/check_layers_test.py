"""Checks that the check of the layers finds violations."""

import contextlib
import io
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_layers  # noqa: E402


def verdict(files):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            file = pathlib.Path(folder) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        words = io.StringIO()
        with contextlib.redirect_stdout(words):
            status = check_layers.main([folder])
        return status, words.getvalue()


ROBOT = {"robots/saltus/robots/model/foot.hpp": ""}
CASES = [
    # name, files, expected text of the verdict
    ("good", {"framework/saltus/ocp/a.hpp": '#include "saltus/core/b.hpp"\n', "framework/saltus/core/b.hpp": ""}, None),
    ("framework to robots", {"framework/saltus/ocp/a.hpp": '#include "saltus/robots/model/foot.hpp"\n', **ROBOT},
     "framework/ocp must not include robots/model"),
    ("robots to problems", {"robots/saltus/robots/model/a.cpp": '#include "problems/p/q.hpp"\n', "problems/p/q.hpp": ""},
     "robots/model must not include problems/p"),
    ("robots to app", {"robots/saltus/robots/model/a.cpp": '#include "saltus/app/settings.hpp"\n', "framework/saltus/app/settings.hpp": ""},
     "robots/model must not include framework/app"),
    ("robots link app", {"robots/saltus/robots/model/CMakeLists.txt": "saltus_layer(a SOURCES a.cpp DEPENDS saltus::app)\n"},
     "a library must not link saltus::app"),
    ("app to app", {"framework/saltus/app/a.hpp": '#include "saltus/app/settings.hpp"\n', "framework/saltus/app/settings.hpp": ""}, None),
    ("benchmarks to tests", {"benchmarks/a.cpp": '#include "tests/support/q.hpp"\n', "tests/support/q.hpp": ""},
     "benchmarks must not include tests/support"),
    ("problems to benchmarks", {"problems/p/a.cpp": "#include <benchmarks/q.hpp>\n", "benchmarks/q.hpp": ""},
     "problems/p must not include benchmarks"),
    ("tests/qp to problems", {"tests/qp/a.cpp": '#include "problems/p/q.hpp"\n', "problems/p/q.hpp": ""},
     "tests/qp must not include problems/p"),
    ("circle", {"framework/saltus/core/a.hpp": '#include "saltus/ocp/b.hpp"\n',
                "framework/saltus/ocp/b.hpp": '#include "saltus/core/a.hpp"\n'},
     "a cycle between folders: framework/core -> framework/ocp -> framework/core"),
    ("private", {"framework/saltus/core/a.hpp": '#include "saltus/core/b.hpp"\n', "framework/saltus/core/b.hpp": "",
                 "framework/cmake/public_headers.txt": "core core/a.hpp\n"}, "is public and includes saltus/core/b.hpp"),
    ("controller to engine", {"robots/saltus/robots/walking/balance_controller.cpp": '#include "saltus/robots/walking/a.hpp"\n',
                              "robots/saltus/robots/walking/a.hpp": '#include "saltus/robots/whole_body/plant.hpp"\n',
                              "robots/saltus/robots/whole_body/plant.hpp": ""},
     "the controller must not include robots/saltus/robots/whole_body/plant.hpp, not even through robots/saltus/robots/walking/a.hpp"),
    ("missing", {"framework/saltus/core/a.hpp": '#include "saltus/core/gone.hpp"\n'}, "which does not exist"),
]

for name, files, expected in CASES:
    status, words = verdict(files)
    assert (status == 0) == (expected is None), (name, words)
    assert expected is None or expected in words, (name, words)
print(f"{len(CASES)} cases")
