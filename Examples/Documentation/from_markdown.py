# SPDX-License-Identifier: BSD-3-Clause
"""reStructuredText of the repository's Markdown: headings, paragraphs, lists, tables, code, pictures, links and papers."""

import os
import pathlib
import re

from filter_examples import FILTERS

ROOT = pathlib.Path(__file__).resolve().parents[2]

#: Files that are pages of the site: name of the page, and its title.
PAGES = {
    "README.md": ("overview", "Overview"),
    "Examples/README.md": ("gallery", "Gallery"),
    "Examples/ParaView/README.md": ("paraview", "In ParaView"),
    "Examples/Models/README.md": ("models", "Trained models"),
    "Examples/Training/README.md": ("trainings", "How the models were trained"),
    "Testing/Benchmarks/README.md": ("benchmarks", "Measurements"),
}

_KEY = r"\[(?P<key>[A-Z][A-Za-z]+\d{4}[a-z]?)\](?!\()"
_INLINE = re.compile(r"`(?P<code>[^`]+)`|\[(?P<text>[^\]]+)\]\((?P<target>[^)]+)\)|" + _KEY
                     + r"|\*\*(?P<strong>[^*]+)\*\*|(?<![\w*])\*(?P<emphasis>[^*\s][^*]*)\*(?!\w)", re.DOTALL)  # fmt: skip


def plain(text):
    """Text without a meaning for reStructuredText."""
    return re.sub(r"_(?=\W|$)", r"\\_", re.sub(r"([\\*`|])", r"\\\1", text))


def paper(key):
    return f":ref:`[{key}] <{key.lower()}>`"


def joined(parts):
    """Inline markup and text in turn; markup that touches a letter is set apart without a space."""
    text = ""
    for number, part in enumerate(parts):
        if number % 2 == 0:
            text += part if not part or part[0].isspace() or not text else "\\ " + part
        else:
            text += part if not text or text[-1].isspace() else "\\ " + part
    return text


def slug(heading):
    """The anchor of a heading, as web sites give it."""
    return re.sub(r"[^a-z0-9 _-]", "", heading.lower()).replace(" ", "-")


def link(text, target, folder):
    """A link to a page of the site or to another site; a file of the sources is named."""
    bare = text.replace("`", "").replace("*", "")
    if re.match(r"[a-z]+:", target):
        return f"`{plain(bare)} <{target}>`__"
    path, _, anchor = target.partition("#")
    path = os.path.normpath(folder / path) if path else None
    name = os.path.relpath(path, ROOT) if path else None
    name = name + "/README.md" if name and (ROOT / name).is_dir() and f"{name}/README.md" in PAGES else name
    page = PAGES.get(name, (None,))[0] if path else PAGES.get(os.path.relpath(folder / "README.md", ROOT), (None,))[0]
    if page and anchor:
        return f":ref:`{plain(bare)} <{page}-{anchor}>`"
    if page:
        return f":doc:`{plain(bare)} </{page}>`"
    return plain(bare) if bare == name or not name else f"{plain(bare)} (``{name}``)"


def inline(text, folder=ROOT):
    """Text of a paragraph, a list or a table."""
    parts, place = [], 0
    for found in _INLINE.finditer(text):
        parts.append(plain(text[place:found.start()]))
        place = found.end()
        if found["code"] in FILTERS:
            parts.append(f":doc:`{found['code']} </filters/{found['code']}>`")
        elif found["code"]:
            parts.append(f"``{found['code'].strip()}``")
        elif found["target"]:
            parts.append(link(found["text"], found["target"], folder))
        elif found["key"]:
            parts.append(paper(found["key"]))
        elif found["strong"]:
            parts.append(f"**{plain(found['strong'].replace('`', ''))}**")
        else:
            parts.append(f"*{plain(found['emphasis'].replace('`', ''))}*")
    return joined([*parts, plain(text[place:])])


def cell_of(text, folder, pictures):
    """A cell of a table, of one picture above its text or of text."""
    found = re.match(r"(!\[.*?\]\(.*?\))\s*(.*)", text)
    if not found:
        return inline(text, folder)
    lines = picture(found[1], folder, pictures).rstrip().split("\n")
    return ("\n" + 7 * " ").join([*lines, "   :width: 100%", ""]) + "\n" + 7 * " " + inline(found[2], folder)


def table(lines, folder, pictures):
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))] for line in lines]
    rows = [rows[0], *rows[2:]]
    header = any(rows[0])
    parts = [".. list-table::\n", "   :header-rows: 1\n" if header else "", "   :class: plain\n\n"]
    for row in rows if header else rows[1:]:
        row = (row + [""] * len(rows[0]))[: len(rows[0])]
        parts += [f"   {'* -' if number == 0 else '  -'} {cell_of(cell, folder, pictures)}".rstrip() + "\n" for number, cell in enumerate(row)]
    return "".join(parts) + "\n"


def picture(line, folder, pictures):
    """A picture; its file is added to ``pictures``, name by path."""
    found = re.match(r"!\[(.*?)\]\((.*?)\)$", line.strip(), re.DOTALL)
    path = pathlib.Path(os.path.normpath(folder / found[2]))
    pictures[path] = "_".join(path.relative_to(ROOT).parts[1:])
    return f".. image:: pictures/{pictures[path]}\n   :alt: {' '.join(found[1].split())}\n\n"


def code_of(line, lines):
    """The block of code that begins with a line, a fence or indented, without the indentation; its lines leave ``lines``."""
    fenced = line.strip().startswith("```")
    width = len(line) - len(line.lstrip())
    ends = (number for number, other in enumerate(lines) if (other.strip().startswith("```") if fenced
                                                             else other.strip() and not other.startswith("    ")))  # fmt: skip
    end = next(ends, len(lines))
    taken = lines[:end]
    del lines[: end + 1 if fenced else end]
    head = [line.strip()[3:].strip()] if fenced else ["bash", line[width:]]
    return head + [other[width:] for other in taken]


def blocks(text):
    """Pairs (kind, lines): code (with its language first), heading, table, list, picture, paragraph."""
    found, lines = [("space", [])], text.split("\n")
    kinds = ((r"#+ ", "heading"), (r" *\|", "table"), (r"- |\d+\. ", "list"), (r"!\[", "picture"))
    while lines:
        line = lines.pop(0)
        last = found[-1]
        if line.strip().startswith("```") or (line.startswith("    ") and last[0] == "space"):
            found.append(("code", code_of(line, lines)))
        elif not line.strip():
            found.append(("space", []))
        else:
            kind = next((name for pattern, name in kinds if re.match(pattern, line)), "paragraph")
            goes_on = {"list": kind == "list" or (kind == "paragraph" and line.startswith(" ")), "heading": False,
                       "picture": not last[1] or not last[1][-1].endswith(")")}  # fmt: skip
            if goes_on.get(last[0], last[0] == kind):
                last[1].append(line.strip() if kind == "paragraph" and last[0] != "list" else line)
            else:
                found.append((kind, [line.strip() if kind == "paragraph" else line]))
    return [block for block in found if block[0] != "space"]


def items(lines, folder):
    """A list; lines that begin with spaces go on with the item before."""
    entries = []
    for line in lines:
        if re.match(r"- |\d+\. ", line):
            entries.append(line)
        else:
            entries[-1] += " " + line.strip()
    mark = "#." if lines[0][0].isdigit() else "*"
    return "".join(f"{mark} {inline(re.sub(r'^(- |[0-9]+[.] )', '', entry), folder)}\n" for entry in entries) + "\n"


def page(file, pictures):
    """The page of a file."""
    folder, (name, title) = (ROOT / file).parent, PAGES[file]
    parts = [f"{title}\n{'=' * 60}\n\n"]
    for kind, lines in blocks((ROOT / file).read_text(encoding="utf-8")):
        if kind == "heading":
            marks, _, heading = lines[0].partition(" ")
            if len(marks) > 1:
                bare = re.sub(r"\[([^\]]*)\]\([^)]*\)|`", r"\1", heading)
                parts.append(f".. _{name}-{slug(heading)}:\n\n{plain(bare)}\n{'=-~^.'[len(marks) - 1] * (len(bare) + 4)}\n\n")
        elif kind == "code":
            language = lines[0] if lines[0] in ("bash", "python", "cpp", "cmake") else "text"
            parts.append(f".. code-block:: {language}\n\n" + "".join(f"   {line}\n" if line else "\n" for line in lines[1:]) + "\n")
        elif kind == "table":
            parts.append(table(lines, folder, pictures))
        elif kind == "picture":
            parts.append(picture("\n".join(lines), folder, pictures))
        elif kind == "list":
            parts.append(items(lines, folder))
        else:
            parts.append(inline("\n".join(lines), folder) + "\n\n")
    return "".join(parts)
