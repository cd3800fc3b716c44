# SPDX-License-Identifier: BSD-3-Clause
"""Checks the names in the C++ files with clang-tidy, by the rules readability-identifier-naming of .clang-tidy.

    python3 naming.py <root of the repository> <build folder> <clang-tidy, version 14> [--sources]

Without --sources: all headers of Filters and IO, included in a few generated files; those named *Implementation.h, which
their sources include after setting macros, with one of these sources each. With --sources: all sources of Filters and IO
that the build compiles, one by one, which takes long.

Shows what is wrong, and fails, when a name breaks the rules; and when a badly named class would pass.
"""

import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys

import layering

CHECKS = "-checks=-*,readability-identifier-naming"
IMPLEMENTATION = "Implementation.h"
# The headers are divided by the libraries that they reach: each of the generated files compiles its library's headers.
GROUPS = (("Torch", layering.TORCH), ("CGAL", re.compile("CGAL/")), ("OpenVDB", re.compile("openvdb/")),
          ("VTK", re.compile("vtk[A-Z]")), ("Plain", re.compile("")))


def library_commands(root, build):
    """Source, file that is compiled for it, and arguments of the compilations of Filters and IO."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    for entry in entries:
        compiled = os.path.join(entry["directory"], entry["file"])
        sources = [compiled]
        if re.search(r"/Unity/unity_\d+_cxx\.cxx$", compiled) and os.path.exists(compiled):
            with open(compiled, encoding="utf-8") as file:  # one that includes all sources of a library
                sources = re.findall(r'#include "(.*)"', file.read())
        for source in sources:
            name = os.path.relpath(source, root)
            if name.startswith(("Filters/", "IO/")) and name.endswith(".cxx"):
                yield name, compiled, shlex.split(entry["command"])


def search_arguments(commands):
    """Folders of headers and macros that any of the compilations has."""
    found = {}
    for _, _, command in commands:
        for k, argument in enumerate(command):
            if argument == "-isystem":
                found[("-isystem", command[k + 1])] = None
            elif argument.startswith(("-I", "-D")):
                found[(argument,)] = None
    return [part for arguments in found for part in arguments]


def headers_by_group(sources, built_sources):
    """The headers by the group of the libraries that they reach, without those of what the build leaves out."""
    built = {layering.library_of(source) for source in built_sources}
    groups = {name: [] for name, pattern in GROUPS
              if name == "Plain" or any(sources.chain_to(source, pattern) for source in built_sources)}
    for header in sources.files:
        if header.endswith(".h") and not header.endswith(IMPLEMENTATION) and layering.library_of(header) in built:
            name = next(name for name, pattern in GROUPS if name == "Plain" or sources.chain_to(header, pattern))
            groups.get(name, []).append(header)
    return {name: headers for name, headers in groups.items() if headers}


def run(program, arguments):
    """What clang-tidy complains of."""
    result = subprocess.run([program, CHECKS, "-warnings-as-errors=*", "-quiet", *arguments],
                            capture_output=True, text=True, check=False)
    if result.returncode == 0:
        return ""
    return result.stdout + "\n".join(line for line in result.stderr.splitlines() if "generated" not in line)


def check_file(root, program, path, text, arguments):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    # Names as in the sources, whose headers the rules of clang-tidy are found from.
    return run(program, [f"-header-filter=^{re.escape(root)}/(Filters|IO)/", f"--config-file={root}/.clang-tidy", path,
                         "--", "-x", "c++", "-std=c++17", "-w", "-fsyntax-only", *arguments])


def check_source(build, program, header_filter, source):
    return run(program, ["-p", build, f"-header-filter={header_filter}", "--extra-arg=-w", source])


def sources_of_implementations(root, sources, built_sources):
    """For each header named *Implementation.h that the build compiles, a source that includes it."""
    found = {}
    for source in built_sources:
        for _, path in sources.includes.get(source, ()):
            if path and path.endswith(IMPLEMENTATION):
                found.setdefault(path, os.path.join(root, source))
    return found


def check_headers(root, build, program, folder):
    commands = list(library_commands(root, build))
    arguments = search_arguments(commands)
    sources = layering.Sources(root)
    built_sources = sorted(source for source, _, _ in commands if source in sources.known)
    implementations = sources_of_implementations(root, sources, built_sources)
    groups = headers_by_group(sources, built_sources)
    numbers = {**{name: len(headers) for name, headers in groups.items()}, "Implementation": len(implementations)}
    if sum(numbers.values()) < 50:
        sys.exit(f"Only {numbers} headers below {root}")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = []
        for name, headers in groups.items():
            text = "".join(f'#include "{os.path.join(root, header)}"\n' for header in headers)
            path = os.path.join(folder, f"{name}Headers.cxx")
            runs.append(pool.submit(check_file, root, program, path, text, arguments))
        for source in implementations.values():
            runs.append(pool.submit(check_source, build, program, f"{IMPLEMENTATION}$", source))
        found = "".join(job.result() for job in runs)
    return found, ", ".join(f"{number} {name}" for name, number in numbers.items()) + " headers"


def check_sources(root, build, program):
    commands = list(library_commands(root, build))
    compiled = sorted({file for _, file, _ in commands})
    own = f"^{re.escape(root)}/(Filters|IO)/.*\\.cxx$"
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = "".join(pool.map(lambda file: check_source(build, program, own, file), compiled))
    return found, f"{len({source for source, _, _ in commands})} sources"


def main():
    root, build, program = (os.path.abspath(path) for path in sys.argv[1:4])
    folder = os.path.join(build, "Testing", "Build", "Naming")
    os.makedirs(folder, exist_ok=True)
    bad = check_file(root, program, os.path.join(folder, "Bad.cxx"), "class bad_name\n{\n  int lower = 0;\n};\n", [])
    if "bad_name" not in bad or "lower" not in bad:
        sys.exit(f"{program} does not find a badly named class:\n{bad}")
    if "--sources" in sys.argv:
        found, summary = check_sources(root, build, program)
    else:
        found, summary = check_headers(root, build, program, folder)
    if found:
        sys.exit(found + "\nNames that break the rules of .clang-tidy")
    print(f"The names in {summary} follow .clang-tidy")


if __name__ == "__main__":
    main()
