# SPDX-License-Identifier: BSD-3-Clause
"""Checks that all C++ files are formatted as .clang-format says.

    python3 formatting.py <root of the repository> <clang-format, version 14>

Shows what is to change, and fails, when a file is not; and when a badly formatted file would pass. To mend them:
clang-format -i <file>...
"""

import concurrent.futures
import os
import subprocess
import sys
import tempfile

FILES_PER_PROCESS = 16


def cxx_files(root):
    """The C++ files that git tracks; of a tree without git, all in the folders of sources."""
    if os.path.exists(os.path.join(root, ".git")):
        command = ["git", "-c", "safe.directory=*", "-C", root, "ls-files", "*.h", "*.cxx"]
        names = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
        return [name for name in names if os.path.exists(os.path.join(root, name))]
    return [
        os.path.relpath(os.path.join(place, name), root)
        for folder in ("Filters", "IO", "Testing", "Examples", "Wrapping")
        for place, _, names in os.walk(os.path.join(root, folder)) for name in names if name.endswith((".h", ".cxx"))
    ]


def complaints(program, root, files):
    """The output of clang-format, empty when all files are formatted as they should be."""
    command = [program, "--dry-run", "-Werror", "--style=file", *files]
    run = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    return run.stderr if run.returncode == 0 else run.stderr or f"{program} ended with {run.returncode}\n"


def finds_bad_formatting(program, root):
    """True when a copy of .clang-format is followed, and a file that does not follow it is found."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(root, ".clang-format"), encoding="utf-8") as style:
            rules = style.read()
        for name, text in ((".clang-format", rules), ("Good.cxx", "int F() { return 1; }\n"),
                           ("Bad.cxx", "int  F( ) {\n    return 1; }\n")):
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)
        good, bad = (complaints(program, folder, [name]) for name in ("Good.cxx", "Bad.cxx"))
    return not good and "Bad.cxx" in bad


def main():
    root, program = sys.argv[1:]
    if not finds_bad_formatting(program, root):
        sys.exit(f"{program} does not find a badly formatted file, or complains of a good one")
    files = cxx_files(root)
    if len(files) < 100:
        sys.exit(f"Only {len(files)} C++ files below {root}")
    batches = [files[k:k + FILES_PER_PROCESS] for k in range(0, len(files), FILES_PER_PROCESS)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = "".join(pool.map(lambda batch: complaints(program, root, batch), batches))
    if found:
        sys.exit(found + "Not formatted as .clang-format says. To mend: clang-format -i <file>...")
    print(f"{len(files)} files are formatted as .clang-format says")


if __name__ == "__main__":
    main()
