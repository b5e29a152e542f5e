"""The rules of the house that a compiler does not enforce, checked on the sources.

  layering_test.py [ROOT]       checks the tree (default: the one this file is in)
  layering_test.py --self-test  plants one violation of each rule and checks that it is reported
"""

import pathlib
import re
import sys
import tempfile

# A layer may include itself and what stands left of it.
LAYERS = ["geometry", "solver", "service"]
# These two know neither JSON nor HTTP, files nor the command line.
PURE_LAYERS = ["geometry", "solver"]
IMPURE = re.compile(
    r"^(nlohmann/|CLI/|httplib\.h|vtk|openssl/|fstream$|filesystem$|iostream$)")
# Headers that are expensive, ill-behaved or to be replaced one day have one door each. None: any
# one file of the folder may be the door.
DOORS = [
    ("Embree", re.compile(r"^embree3/|^rtcore"), "geometry", "embree_scene.cpp"),
    ("Odeint", re.compile(r"^boost/numeric/odeint"), "solver", "predictor.cpp"),
    ("cpp-httplib", re.compile(r"^httplib\.h$"), "service/http", None),
    ("VTK", re.compile(r"^vtk"), "service/formats", None),
]
TOP_LEVEL_FILES = ["CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md", "dev"]
FOLDERS = LAYERS + ["tests", "web", "docker"]
CODE = {".h", ".cpp"}
TEXT = CODE | {".txt", ".cmake", ".json", ".md", ".py", ".sh", ".yaml", ".yml", ".ts", ""}
NOT_OURS = {"build", "node_modules", "__pycache__", ".git"}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^>"\n]+)[>"]', re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
MACHINE_PATH = re.compile(r"(?<![\w./$}~-])/(?:home|root|Users|work|tmp|mnt|media)/[\w.-]+")


def files_of(root):
    yield from (root / name for name in TOP_LEVEL_FILES if (root / name).is_file())
    for folder in FOLDERS + [".ci"]:
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and not NOT_OURS & set(path.relative_to(root).parts):
                yield path


def check_includes(name, text, doors_used):
    layer = name.split("/")[0]
    for include in INCLUDE.findall(text):
        target = include.split("/")[0]
        if ".." in include.split("/"):
            yield f"{name}: includes {include}; paths start at the top of the tree"
        if layer not in LAYERS:
            continue
        if target in FOLDERS and target not in LAYERS[: LAYERS.index(layer) + 1]:
            yield f"{name}: includes {include}, which is above {layer}"
        if layer in PURE_LAYERS and IMPURE.search(include):
            yield f"{name}: includes {include}; {layer} knows no JSON, HTTP, files or VTK"
        for door, header, folder, file in DOORS:
            if not header.search(include):
                continue
            doors_used.setdefault(door, set()).add(name)
            if not name.startswith(folder + "/") or (file and name != f"{folder}/{file}"):
                yield f"{name}: includes {include}; {door} belongs to {folder}/{file or '*.cpp'}"
            elif name.endswith(".h"):
                yield f"{name}: includes {include}, and so does everybody who includes this header"


def violations(root):
    doors_used = {}
    for path in files_of(root):
        if path.suffix not in TEXT:
            continue
        name = path.relative_to(root).as_posix()
        text = path.read_text(encoding="utf-8", errors="replace")
        if path.suffix in CODE:
            yield from check_includes(name, text, doors_used)
        if path.suffix == ".h" and not COMMENT.sub("", text).lstrip().startswith("#pragma once"):
            yield f"{name}: a header starts with #pragma once"
        if name != "tests/layering_test.py":  # which plants one
            for found in MACHINE_PATH.findall(text):
                yield f"{name}: {found} is a path of one machine"
    for door, users in sorted(doors_used.items()):
        if len(users) > 1:
            yield f"{door} is included by {', '.join(sorted(users))}; one file is its door"


# One violation each, with a part of the message it must cause.
PLANTED = [
    ({"geometry/a.h": '#pragma once\n#include "solver/light.h"\n'}, "above geometry"),
    ({"solver/a.cpp": '#include "service/api/scene_json.h"\n'}, "above solver"),
    ({"service/a.cpp": '  #  include "tests/support/x.h"\n'}, "above service"),
    ({"solver/a.cpp": '#include "../service/x.h"\n'}, "start at the top"),
    ({"solver/a.h": "#pragma once\n#include <nlohmann/json_fwd.hpp>\n"}, "no JSON"),
    ({"geometry/a.cpp": "#include <fstream>\n"}, "no JSON, HTTP, files"),
    ({"geometry/b.cpp": "#include <embree3/rtcore.h>\n"}, "Embree belongs to"),
    ({"solver/b.cpp": "#include <boost/numeric/odeint.hpp>\n"}, "Odeint belongs to"),
    ({"service/main.cpp": "#include <httplib.h>\n"}, "cpp-httplib belongs to"),
    ({"service/http/a.cpp": "#include <httplib.h>\n",
      "service/http/b.cpp": '#include "httplib.h"\n'}, "one file is its door"),
    ({"service/formats/a.cpp": "#include <vtkPolyData.h>\n",
      "service/formats/b.cpp": "#include <vtkPoints.h>\n"}, "one file is its door"),
    ({"service/formats/vtk.h": "#pragma once\n#include <vtkPoints.h>\n"}, "so does everybody"),
    ({"geometry/a.h": "// Says much.\nstruct A {};\n"}, "#pragma once"),
    ({"tests/a.cpp": 'auto f = open("/home/ada/scene.json");\n'}, "one machine"),
]
CLEAN = {
    "geometry/a.h": "// Says much.\n/* And more. */\n#pragma once\n#include <cmath>\n",
    "geometry/embree_scene.cpp": "#include <embree3/rtcore.h>\n",
    "solver/predictor.cpp":
        '#include <boost/numeric/odeint.hpp>\n#include "solver/predictor.h"\n#include "geometry/a.h"\n',
    "service/http/server.cpp": '#include <httplib.h>\n#include "solver/b.h"\n',
    "service/formats/vtk.cpp": "#include <vtkPoints.h>\n#include <vtkPolyData.h>\n",
    "tests/http/client.cpp": '#include <httplib.h>\n#include "service/http/server.h"\n',
    "README.md": "curl http://127.0.0.1:8080/tmp/x; see ~/.cache/isocaustic, $HOME/work/x\n",
    "build/release/x.h": "/home/ada/x.h\n",
}


def plant(root, files):
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def self_test():
    failures = []
    with tempfile.TemporaryDirectory() as clean:
        plant(pathlib.Path(clean), CLEAN)
        failures += [f"reported in a clean tree: {v}" for v in violations(pathlib.Path(clean))]
    for files, message in PLANTED:
        with tempfile.TemporaryDirectory() as root:
            plant(pathlib.Path(root), files)
            found = list(violations(pathlib.Path(root)))
            if not any(message in violation for violation in found):
                failures.append(f'nothing reported "{message}" for {files}; found {found}')
    return failures


def main(arguments):
    if arguments == ["--self-test"]:
        failures = self_test()
        print(f"{len(PLANTED)} planted violations, {len(failures)} failures")
    else:
        default = pathlib.Path(__file__).resolve().parent.parent
        root = pathlib.Path(arguments[0]) if arguments else default
        failures = list(violations(root))
        checked = sum(1 for path in files_of(root) if path.suffix in CODE)
        print(f"{checked} source files, {len(failures)} violations")
        if checked == 0:
            failures.append(f"no sources in {root}")
    for failure in failures:
        print(failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
