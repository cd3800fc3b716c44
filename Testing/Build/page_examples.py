# SPDX-License-Identifier: BSD-3-Clause
"""Compiles the C++ examples on the pages of all filters: page_examples.py <sources> <build folder> <work folder>.

All are functions of one source, which is compiled without output, with the folders of headers that the build uses.
"""

import json
import pathlib
import re
import shlex
import subprocess
import sys


def source_of(examples):
    """One source with a function for each example."""
    includes, functions = set(), []
    for name, text in examples.items():
        lines = text.splitlines()
        includes.update(line for line in lines if line.startswith("#include"))
        body = "\n".join(line for line in lines if not line.startswith("#include"))
        functions.append(f"void Example{name}()\n{{\n{body.strip()}\n}}\n")
    return "\n".join([*sorted(includes), "", *functions])


def compiler_of(build):
    """The compiler, and the folders of headers of all sources of the filters."""
    entries = json.loads((build / "compile_commands.json").read_text())
    compiler, folders = None, {}
    for entry in entries:
        words = shlex.split(entry["command"])
        if "/Filters/" not in entry["file"] or "/Testing/" in entry["file"]:
            continue
        compiler = compiler or next(word for word in words if re.search(r"(\+\+|clang|gcc)[-\d.]*$", word))
        for place, word in enumerate(words):
            if word == "-isystem":
                folders[("-isystem", words[place + 1])] = None
            elif word.startswith("-I"):
                folders[(word,)] = None
    return compiler, [word for folder in folders for word in folder]


def main(sources, build, work):
    sources, build, work = map(pathlib.Path, (sources, build, work))
    sys.path.insert(0, str(sources / "Examples" / "Documentation"))
    import generate
    from filter_examples import FILTERS

    proxies = generate.proxies()
    headers = {path.stem for path in (sources / "Filters").rglob("vtk*.h")}
    examples = {name: generate.example_in_cxx(name, proxies[name], example) for name, example in FILTERS.items()}
    if not set(examples) <= headers or len(examples) < 20:
        sys.exit(f"Pages without a class: {sorted(set(examples) - headers)}")
    work.mkdir(parents=True, exist_ok=True)
    path = work / "PageExamples.cxx"
    path.write_text(source_of(examples))
    compiler, folders = compiler_of(build)
    command = [compiler, "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", *folders, str(path)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"An example does not compile:\n{done.stdout[-6000:]}")
    broken = path.with_name("Broken.cxx")
    broken.write_text(source_of(examples).replace("->Update()", "->Updated()", 1))
    done = subprocess.run([*command[:-1], str(broken)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode == 0 or "Updated" not in done.stdout:
        sys.exit("A wrong example compiles")
    print(f"{len(examples)} examples compile")


if __name__ == "__main__":
    main(*sys.argv[1:])
