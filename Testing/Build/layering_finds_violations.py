# SPDX-License-Identifier: BSD-3-Clause
"""layering.py must find each kind of violation: it reads trees of harmless files with a few bad ones at a time.

    python3 layering_finds_violations.py
"""

import os
import subprocess
import sys
import tempfile

import layering

SPDX = "// SPDX-License-Identifier: BSD-3-Clause\n"
HARMLESS = {
    "Filters/Core/Mesh/TriangleMesh.h": "#include <Eigen/Core>\n",
    "Filters/Core/Common/Errors.h": "#include <stdexcept>\n// #include <vtkPolyData.h> in a comment\n",
    "IO/Weights/SafetensorsFile.h": '#include "Core/Common/Errors.h"\n',
    "IO/Datasets/SignalDataset.h": '#include "IO/Weights/SafetensorsFile.h"\n',
    "Filters/Inference/PoissonNet/Model.h": '#include "IO/Weights/SafetensorsFile.h"\n#include "Core/Mesh/TriangleMesh.h"\n',
    "Filters/MeshProcessing/Cgal/CgalMesh.h": '#include "Core/Mesh/TriangleMesh.h"\n#include <CGAL/Surface_mesh.h>\n',
    "Filters/Learning/Layers/Layer.h": '#include "Inference/PoissonNet/Model.h"\n#include <torch/torch.h>\n',
    "Filters/Bridge/SurfaceBridge.h": '#include "Inference/PoissonNet/Model.h"\n#include <vtkPolyData.h>\n',
    "Filters/Noise/vtkNoise.h": "#include <vtkPolyDataAlgorithm.h>\n",
    "Filters/Noise/vtkNoise.cxx": '#include "vtkNoise.h"\n#include "SurfaceBridge.h"\n#include "MeshProcessing/Cgal/CgalMesh.h"\n',
    "Filters/Training/vtkTrainer.cxx": '#include "Learning/Layers/Layer.h"\n',
}

# Files, and a part of the message about them.
VIOLATIONS = [
    # up the layers
    ({"Filters/Core/A.cxx": '#include "IO/Weights/SafetensorsFile.h"\n'}, "include up the layers: Filters/Core"),
    ({"Filters/Core/A.cxx": '#include "Bridge/Absent.h"\n'}, "include up the layers: Filters/Core"),
    ({"Filters/Core/A.cxx": '#include "SurfaceBridge.h"\n'}, "include up the layers: Filters/Core"),
    ({"IO/Weights/A.cxx": '#include "IO/Datasets/SignalDataset.h"\n'}, "include up the layers: IO/Weights"),
    ({"IO/Datasets/A.cxx": '#include "Inference/PoissonNet/Model.h"\n'}, "include up the layers: IO/Datasets"),
    ({"Filters/Inference/A.cxx": '#include "Learning/Layers/Absent.h"\n'}, "include up the layers: Filters/Inference"),
    ({"Filters/Inference/A.cxx": '#include "MeshProcessing/Cgal/Absent.h"\n'},
     "Filters/Inference lies below or beside Filters/MeshProcessing"),
    ({"Filters/MeshProcessing/A.cxx": '#include "Inference/PoissonNet/Model.h"\n'},
     "Filters/MeshProcessing lies below or beside Filters/Inference"),
    ({"Filters/Learning/A.cxx": '#include "SurfaceBridge.h"\n'}, "Filters/Learning lies below or beside Filters/Bridge"),
    ({"Filters/Bridge/A.cxx": '#include "Learning/Layers/Absent.h"\n'}, "Filters/Bridge lies below or beside Filters/Learning"),
    ({"Filters/Bridge/A.cxx": '#include "../Noise/vtkNoise.h"\n'}, "Filters/Bridge lies below or beside Filters/Noise"),
    ({"Filters/Bridge/A.cxx": '#include "vtkNoise.h"\n'}, "Filters/Bridge lies below or beside Filters/Noise"),
    ({"Filters/Noise/A.cxx": '#include "Learning/Layers/Absent.h"\n'}, "Filters/Noise lies below or beside Filters/Learning"),
    # folders that include each other
    ({"Filters/Core/Mesh/A.h": '#include "Core/Common/Errors.h"\n',
      "Filters/Core/Common/A.h": '#include "Core/Mesh/TriangleMesh.h"\n'},
     "Filters/Core/Common -> Filters/Core/Mesh -> Filters/Core/Common\n    Filters/Core/Common/A.h: Core/Mesh/TriangleMesh.h"),
    ({"Filters/Inference/A/A.h": '#include "../B/B.h"\n',
      "Filters/Inference/B/Deep/B.cxx": '#include "../../A/A.h"\n',
      "Filters/Inference/B/B.h": ""}, "Filters/Inference/A -> Filters/Inference/B -> Filters/Inference/A"),
    ({"Filters/Learning/A/A.h": '#include "Learning/B/B.h"\n',
      "Filters/Learning/B/B.h": '#include "Learning/C/C.h"\n',
      "Filters/Learning/C/C.h": '#include "Learning/A/A.h"\n'},
     "Filters/Learning/A -> Filters/Learning/B -> Filters/Learning/C -> Filters/Learning/A"),
    ({"Filters/Noise/vtkA.cxx": '#include "vtkOther.h"\n',
      "Filters/Other/vtkOther.h": "", "Filters/Other/vtkOther.cxx": '#include "vtkNoise.h"\n'},
     "folders include each other: Filters/Noise -> Filters/Other -> Filters/Noise"),
    # VTK
    ({"Filters/Core/Deep/A.cxx": "#  include <vtkPolyData.h>\n"}, "VTK in a plain library"),
    ({"Filters/Inference/A.h": "#include <vtkPolyData.h>\n"}, "VTK in a plain library"),
    ({"Filters/MeshProcessing/A.h": "#include <vtkPolyData.h>\n"}, "VTK in a plain library"),
    ({"Filters/Learning/A.h": '#include "vtkPolyData.h"\n'}, "VTK in a plain library"),
    ({"IO/Weights/A.cxx": "#include <vtkPolyData.h>\n"}, "VTK in a plain library"),
    ({"IO/Datasets/A.cxx": "#include <vtkPolyData.h>\n"}, "VTK in a plain library"),
    # LibTorch, directly and through other headers
    ({"Filters/Core/A.h": "#include <torch/torch.h>\n"}, "torch outside of Learning"),
    ({"Filters/Inference/A.cxx": "#include <c10/util/Half.h>\n"}, "torch outside of Learning"),
    ({"Filters/Bridge/A.h": "#include <ATen/ATen.h>\n"}, "torch outside of Learning"),
    ({"Filters/Noise/vtkA.cxx": '#include "Learning/Layers/Layer.h"\n'},
     "Filters/Noise/vtkA.cxx -> Filters/Learning/Layers/Layer.h -> torch/torch.h\n    torch outside of Learning"),
    # mesh processing
    ({"Filters/Noise/A.cxx": "#include <CGAL/Surface_mesh.h>\n"}, "mesh processing outside of"),
    ({"Filters/Core/Mesh/A.cxx": "#include <openvdb/Grid.h>\n"}, "mesh processing outside of"),
    # headers of VTK classes
    ({"Filters/Noise/vtkA.h": "#include <Eigen/Core>\n"}, "algorithm in the header of a VTK class"),
    ({"Filters/Noise/vtkA.h": "#include <Random123/philox.h>\n"}, "algorithm in the header of a VTK class"),
    ({"Filters/Noise/vtkA.h": '#include "Core/Common/Errors.h"\n'}, "algorithm in the header of a VTK class"),
    ({"Filters/Noise/vtkA.h": '#include "SurfaceBridge.h"\n'},
     "Filters/Core/Mesh/TriangleMesh.h -> Eigen/Core\n    algorithm in the header of a VTK class"),
    # the rest
    ({"Filters/Core/A.cxx": "#include <gtest/gtest.h>\n"}, "tests in the library"),
    ({"Filters/Core/A.cxx": '#include "../../Testing/Support/A.h"\n'}, "tests in the library"),
    ({"Filters/Core/A.cxx": "std::normal_distribution<double> d;\n"}, "explicit seed"),
    ({"Filters/Core/A.cxx": "std::random_device device;\n"}, "explicit seed"),
    ({"Filters/Core/A.cxx": "int x = rand();\n"}, "explicit seed"),
]


def write(root, files, first_line=SPDX):
    for name, text in files.items():
        path = os.path.join(root, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(first_line + text)


def found_with(files, first_line=SPDX):
    """The violations in a tree of the harmless files and these, as one text."""
    with tempfile.TemporaryDirectory() as root:
        write(root, HARMLESS)
        write(root, files, first_line)
        return "\n".join(layering.violations(root)[1])


def check_top_level():
    with tempfile.TemporaryDirectory() as root:
        write(root, {**HARMLESS, "CHANGELOG.md": "", ".clang-format": "", "Scripts/a.py": ""})
        for command in ("init", "add -A"):
            subprocess.run(["git", "-C", root] + command.split(), check=True, capture_output=True)
        found = layering.violations(root)[1]
    return found == ["Scripts: does not belong in the top-level folder"] or found


def main():
    failures = []
    harmless = found_with({})
    if harmless:
        failures.append(f"the harmless files were reported:\n{harmless}")
    for files, expected in VIOLATIONS:
        found = found_with(files)
        if expected not in found:
            failures.append(f'{files} should have been reported as "{expected}", but: {found or "nothing"}')
    if "Testing/A.cxx: does not begin with the SPDX line" not in found_with({"Testing/A.cxx": "int a;\n"}, ""):
        failures.append("a missing license was not reported")
    if check_top_level() is not True:
        failures.append(f"a strange folder at the top gave {check_top_level()}")
    with tempfile.TemporaryDirectory() as root:
        script = layering.__file__
        if subprocess.run([sys.executable, script, root], capture_output=True, check=False).returncode == 0:
            failures.append("an empty tree passes")
    if failures:
        sys.exit("\n".join(failures))
    print(f"{len(VIOLATIONS)} violations were found")


if __name__ == "__main__":
    main()
