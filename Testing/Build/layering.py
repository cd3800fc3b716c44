# SPDX-License-Identifier: BSD-3-Clause
"""Checks the layers of the sources by reading their includes, and the layout of the tree.

    python3 layering.py <root of the repository>

Prints every violation and fails when there is one, or when there is nothing to check:

 - An include points down the layers, never up (LAYERS).
 - No folders include each other, directly or around a longer cycle.
 - Plain libraries include no VTK header.
 - LibTorch is reached from Filters/Learning and Filters/Training only, through whatever headers.
 - CGAL, OpenVDB and TetGen are included in Filters/MeshProcessing only.
 - Headers of VTK classes (vtk*.h) reach no header of the algorithms behind them.
 - The library includes no header of the tests and takes random numbers from explicit seeds only.
 - Every source names its license in its first two lines.
 - The top-level folder holds what it should and no more.
"""

import collections
import os
import re
import subprocess
import sys

CORE = "Filters/Core"
WEIGHTS = "IO/Weights"
DATASETS = "IO/Datasets"
INFERENCE = "Filters/Inference"
MESH_PROCESSING = "Filters/MeshProcessing"
DISTRIBUTED = "Filters/Distributed"
LEARNING = "Filters/Learning"
BRIDGE = "Filters/Bridge"
TRAINING = "Filters/Training"

# The folders that a library may include, besides itself. Every other folder of Filters is a VTK module.
LAYERS = {
    CORE: set(),
    WEIGHTS: {CORE},
    DATASETS: {CORE, WEIGHTS},
    INFERENCE: {CORE, WEIGHTS, DATASETS},
    MESH_PROCESSING: {CORE, WEIGHTS, DATASETS},
    DISTRIBUTED: {CORE},
    LEARNING: {CORE, WEIGHTS, DATASETS, INFERENCE, MESH_PROCESSING},
    BRIDGE: {CORE, WEIGHTS, DATASETS, INFERENCE, MESH_PROCESSING, DISTRIBUTED},
}
PLAIN = (CORE, WEIGHTS, DATASETS, INFERENCE, MESH_PROCESSING, DISTRIBUTED, LEARNING)
BELOW_MODULES = set(LAYERS) - {LEARNING}

TORCH = re.compile(r"(torch|ATen|c10)/")
MESHING = re.compile(r"(CGAL|openvdb)/|tetgen\.h$")
HEAVY = re.compile(
    r"(torch|ATen|c10|Eigen|unsupported/Eigen|CGAL|openvdb|Spectra|nlohmann|Random123)/|tetgen|cholmod|nanoflann")
RANDOM = re.compile(r"std::(random_device|[a-z_]+_distribution)|[^a-zA-Z_:]s?rand\(")
INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[ \t]*([<\"])([^>\"]+)[>\"]")

TOP_LEVEL = {
    "CMakeLists.txt", "Filters", "IO", "Wrapping", "Testing", "Examples", "vtk.module", "README.md", "LICENSE",
    "CMakePresets.json", "CITATION.cff", "CHANGELOG.md", "CONTRIBUTING.md", "pyproject.toml", "setup.py"
}
LICENSED = (".h", ".cxx", ".py", ".cmake", ".sh", ".module", ".in")


def files_below(root, folders, suffixes):
    """Paths relative to the root, sorted, of the files whose names end so."""
    found = []
    for folder in folders:
        for place, names, files in os.walk(os.path.join(root, folder)):
            names[:] = [name for name in names if name != "__pycache__"]
            found += [
                os.path.relpath(os.path.join(place, file), root) for file in files if file.endswith(tuple(suffixes))
            ]
    return sorted(found)


def read(root, path):
    with open(os.path.join(root, path), encoding="utf-8", errors="replace") as file:
        return file.read()


def library_of(path):
    """The library or VTK module that a file of Filters or IO is in: the first two folders of its path."""
    return "/".join(path.split("/")[:2])


def folder_of(path):
    """The folder of a library that a file is in; the library itself for files and modules without folders."""
    parts = path.split("/")
    return "/".join(parts[:3]) if len(parts) > 3 else library_of(path)


class Sources:
    """The includes of the headers and sources of Filters and IO."""

    def __init__(self, root):
        self.root = root
        self.files = files_below(root, ("Filters", "IO"), (".h", ".cxx"))
        self.known = set(self.files)
        self.modules = sorted({library_of(file) for file in self.files} - set(PLAIN))
        self.includes = {}  # file: [(text of the include, path in the repository or None)]
        for file in self.files:
            matches = (INCLUDE.match(line) for line in read(root, file).splitlines())
            self.includes[file] = [(match[2], self.resolve(file, match[2])) for match in matches if match]

    def resolve(self, file, text):
        """The file of the repository that an include names, whether it exists or not; None for foreign headers."""
        beside = os.path.normpath(os.path.join(os.path.dirname(file), text))
        candidates = [beside, os.path.normpath(os.path.join("Filters", text)), os.path.normpath(text)]
        candidates += [os.path.join(module, text) for module in self.modules if "/" not in text]
        for candidate in candidates:
            if candidate in self.known:
                return candidate
        if text.startswith(".."):
            return beside
        return next((path for path in candidates[1:3] if library_of(path) in LAYERS and "/" in text), None)

    def number_of_includes(self):
        return sum(len(includes) for includes in self.includes.values())

    def chain_to(self, start, pattern):
        """The shortest chain of includes from a file to a foreign header that matches, or None."""
        previous = {start: None}
        queue = collections.deque([start])
        while queue:
            file = queue.popleft()
            for text, path in self.includes[file]:
                if path is None and pattern.match(text):
                    chain = [text]
                    while file:
                        chain.append(file)
                        file = previous[file]
                    return chain[::-1]
                if path in self.known and path not in previous:
                    previous[path] = file
                    queue.append(path)
        return None


def check_layers(sources):
    for file, includes in sources.includes.items():
        library = library_of(file)
        allowed = LAYERS.get(library)
        if allowed is None:
            allowed = BELOW_MODULES | set(sources.modules) | ({LEARNING} if library == TRAINING else set())
        for text, path in includes:
            if re.match(r"(gtest|gmock|benchmark|Testing)/", text) or (path and path.startswith("Testing/")):
                yield f"{file}: {text}\n    tests in the library: the library does not know its tests"
            elif path and path.startswith(("Filters/", "IO/")) and library_of(path) not in allowed | {library}:
                yield f"{file}: {text}\n    include up the layers: {library} lies below or beside {library_of(path)}"
            if library in PLAIN and re.match("vtk[A-Z]", text):
                yield f"{file}: {text}\n    VTK in a plain library: it must build without VTK"
            if library != MESH_PROCESSING and MESHING.match(text):
                yield f"{file}: {text}\n    mesh processing outside of {MESH_PROCESSING}"


def check_reach(sources):
    for file in sources.files:
        if library_of(file) not in (LEARNING, TRAINING):
            chain = sources.chain_to(file, TORCH)
            if chain:
                yield f"{' -> '.join(chain)}\n    torch outside of Learning: applying a model needs no LibTorch"
        name = os.path.basename(file)
        if name.startswith("vtk") and name.endswith(".h"):
            chain = sources.chain_to(file, HEAVY)
            plain = next((text for text, path in sources.includes[file] if path and library_of(path) in PLAIN), None)
            if chain or plain:
                yield (f"{' -> '.join(chain or [file, plain])}\n"
                       "    algorithm in the header of a VTK class: it belongs behind std::unique_ptr<Internals>")


def shortest_cycle(graph, start):
    """The shortest cycle of folders through one of them, which is repeated at its end; or None."""
    previous = {}
    queue = collections.deque([start])
    while queue:
        folder = queue.popleft()
        for other in sorted(graph[folder]):
            if other == start:
                cycle = [start]
                while folder != start:
                    cycle.append(folder)
                    folder = previous[folder]
                return [start] + cycle[1:][::-1] + [start]
            if other not in previous:
                previous[other] = folder
                queue.append(other)
    return None


def check_cycles(sources):
    """Folders that include each other, with the includes that make them do so."""
    graph = collections.defaultdict(dict)  # folder: {folder: [include]}
    for file, includes in sources.includes.items():
        for text, path in includes:
            if path and folder_of(path) != folder_of(file):
                graph[folder_of(file)].setdefault(folder_of(path), []).append(f"{file}: {text}")
                graph[folder_of(path)] = graph[folder_of(path)]
    reported = set()
    for folder in sorted(graph):
        cycle = shortest_cycle(graph, folder)
        if cycle and frozenset(cycle) not in reported:
            reported.add(frozenset(cycle))
            steps = [include for a, b in zip(cycle, cycle[1:]) for include in graph[a][b]]
            yield "folders include each other: " + " -> ".join(cycle) + "".join(f"\n    {step}" for step in steps)


def check_randomness(sources):
    for file in sources.files:
        for line in read(sources.root, file).splitlines():
            if RANDOM.search(line) and not line.lstrip().startswith("//"):
                yield f"{file}: {line.strip()}\n    randomness must come from an explicit seed"


def check_licenses(root):
    for file in files_below(root, ("Filters", "IO", "Wrapping", "Testing", "Examples"), LICENSED + ("CMakeLists.txt",)):
        if "SPDX-License-Identifier: BSD-3-Clause" not in "\n".join(read(root, file).splitlines()[:2]):
            yield f"{file}: does not begin with the SPDX line"


def check_top_level(root):
    """In a clone only what git tracks counts; elsewhere there may be anything beside the sources."""
    if not os.path.exists(os.path.join(root, ".git")):
        return
    entries = subprocess.run(["git", "-c", "safe.directory=*", "-C", root, "ls-files"],
                             check=True, capture_output=True, text=True).stdout.splitlines()
    for entry in sorted({path.split("/")[0] for path in entries}):
        if entry not in TOP_LEVEL and not entry.startswith("."):
            yield f"{entry}: does not belong in the top-level folder"


def violations(root):
    """The sources and the list of all violations in a tree."""
    sources = Sources(root)
    found = []
    for check in (check_layers, check_reach, check_cycles, check_randomness):
        found += check(sources)
    return sources, found + list(check_licenses(root)) + list(check_top_level(root))


def main():
    sources, found = violations(sys.argv[1])
    summary = f"{sources.number_of_includes()} includes in {len(sources.files)} files"
    if len(sources.files) < 20 or sources.number_of_includes() < 50:
        sys.exit(f"Only {summary} below {sys.argv[1]}")
    if found:
        sys.exit("Violations of the layering:\n" + "\n".join(f"  {violation}" for violation in found))
    print(f"{summary} keep to the layers")


if __name__ == "__main__":
    main()
