# SPDX-License-Identifier: BSD-3-Clause
"""Checks of the texts of the repository.

    python3 words.py <root of the repository>

 - A doc comment of C++ or Python and a line of README.md open with a noun or a verb, not with a relative clause
   ("Whether ...", "How many ...").
 - No file refers to a folder outside of the repository, or to one of a certain machine.

Prints every violation and fails when there is one; and when the patterns would not find one.
"""

import os
import re
import subprocess
import sys

RELATIVE = "(What|Whether|That|Where|How) [a-z]+ "
OPENINGS = {  # ends of file names: the openings that their texts must not have
    (".h",): re.compile(r"^\s*.*///?<? *(@brief )?" + RELATIVE),
    (".py", ".py.in"): re.compile(r'"""' + RELATIVE),
    ("README.md",): re.compile(r"^\s*([-*] )?" + RELATIVE),
}
ABSOLUTE = re.compile(r"(?<![\w.$}])/(home|root|work|workspace|mnt)/\w")
UPWARDS = re.compile(r"(?:^|[\s\"'`(=:])((?:\.\./)+)([\w.-]*)")
# The script that starts the tests there is told of the machine.
MAY_REFER_OUTSIDE = {".ci/run"}


def texts(root):
    """Name and text of each file that git tracks; of a tree without git, of all files."""
    if os.path.exists(os.path.join(root, ".git")):
        command = ["git", "-c", "safe.directory=*", "-C", root, "ls-files"]
        names = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    else:
        names = [
            os.path.relpath(os.path.join(place, name), root) for place, _, files in os.walk(root) for name in files
            if not os.path.relpath(place, root).startswith("build")
        ]
    for name in names:
        try:
            with open(os.path.join(root, name), encoding="utf-8") as file:
                yield name, file.read()
        except (UnicodeDecodeError, FileNotFoundError):
            pass  # binary, or deleted and not yet committed


def refers_outside(name, line):
    """The folder outside of the repository that a line of a file names, or None."""
    absolute = ABSOLUTE.search(line)
    if absolute:
        return absolute[0]
    for match in UPWARDS.finditer(line):
        steps = match[1].count("/")
        if steps > name.count("/") or match[2] == "shared":
            return match[0].strip()
    return None


def violations(name, text):
    opening = next((pattern for ends, pattern in OPENINGS.items() if name.endswith(ends)), None)
    for number, line in enumerate(text.splitlines(), start=1):
        if opening and opening.search(line):
            yield f"{name}:{number}: opens with a relative clause: {line.strip()}"
        outside = None if name in MAY_REFER_OUTSIDE else refers_outside(name, line)
        if outside:
            yield f"{name}:{number}: refers to a folder outside of the repository: {outside}"


EXAMPLES = [  # file, line, violation or not
    ("Filters/A.h", "  /// Whether edges are kept.", True),
    ("Filters/A.h", "  int Edges; ///< How many edges are kept.", True),
    ("Filters/A.h", "// What an iteration says of itself", True),
    ("Filters/A.h", "/// Number of edges: how many edges are kept.", False),
    ("Filters/A.h", "/// Whatever cannot be reached.", False),
    ("Wrapping/a.py", '    """' + "How many edges are kept.\"\"\"", True),
    ("README.md", "Where nothing is set, the default holds.", True),
    ("README.md", "# How to build", False),
    ("README.md", "from " + "../" + "shared/a.txt", True),
    ("Testing/run.sh", 'cat "' + "../" + '../a"', True),
    ("Testing/Build/A.cmake", "include(" + "../" + "Support/A.cmake)", False),
    ("Testing/run.sh", "cd /" + "work/main", True),
    ("Testing/run.sh", 'cd "$root/' + 'work/main"', False),
    (".ci/run", 'cat "' + "../" + '../shared/a"', False),
]


def main():
    for name, line, expected in EXAMPLES:
        if bool(list(violations(name, line))) != expected:
            sys.exit(f"{name}: \"{line}\" should {'' if expected else 'not '}be reported")
    found = []
    number_of_files = 0
    for name, text in texts(sys.argv[1]):
        number_of_files += 1
        if name != "Testing/Build/words.py":
            found += violations(name, text)
    if number_of_files < 100:
        sys.exit(f"Only {number_of_files} texts below {sys.argv[1]}")
    if found:
        sys.exit("\n".join(found) + f"\n{len(found)} violations")
    print(f"{number_of_files} texts have no such openings and references")


if __name__ == "__main__":
    main()
