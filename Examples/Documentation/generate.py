# SPDX-License-Identifier: BSD-3-Clause
"""Writes the pages of the site for Sphinx, from headers, server-manager XML, the README.md of the folders, references.bib and
filter_examples.py: generate.py <folder>
"""

import inspect
import json
import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "Testing" / "ParaView"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import from_markdown  # noqa: E402
from filter_examples import FILTERS, LIMITS  # noqa: E402
from server_manager_xml import is_base, is_former, proxy_of  # noqa: E402

_NAMES = re.compile(r"`(?P<code>[^`]+)`|\[(?P<key>[A-Z][A-Za-z]+\d{4}[a-z]?)\]|\b(?P<filter>vtk[A-Z]\w+)\b"
                    r"|(?P<section>Reproducibility in README\.md)|(?P<file>\b(?:[A-Z]\w+/)*README\.md)|\b(?P<property>(?:[A-Z][a-z0-9]+){2,})\b(?!_)")  # fmt: skip


def escaped(text, properties=()):
    """Plain text of the sources for reStructuredText: links to papers, filters and pages of the site, names as code."""
    parts, place = [], 0
    for found in _NAMES.finditer(text):
        page = from_markdown.PAGES.get(found["file"])
        if found["key"]:
            mark = from_markdown.paper(found["key"])
        elif found["section"]:
            mark = ":ref:`Reproducibility <overview-reproducibility>`"
        elif page:
            mark = f":doc:`{page[1]} </{page[0]}>`"
        elif found["code"] or found["filter"] or found["property"] in properties:
            known = found["filter"] in FILTERS
            mark = f":doc:`{found['filter']} </filters/{found['filter']}>`" if known else f"``{found[0].strip('`')}``"
        else:
            continue
        parts += [from_markdown.plain(text[place:found.start()]), mark]
        place = found.end()
    return from_markdown.joined([*parts, from_markdown.plain(text[place:])])


def title(text, mark="="):
    return f"{text}\n{mark * (len(text) + 4)}\n\n"


def block(language, text):
    return f".. code-block:: {language}\n\n" + "".join(f"   {line}\n" if line else "\n" for line in text.split("\n")) + "\n"


# -- what the sources say ----------------------------------------------------------------------------------------------


def header_of(name):
    """The header file of a class."""
    return next(path for path in ROOT.glob(f"Filters/*/{name}.h"))


def sections_of(name):
    """Pairs (title, paragraphs) of the documentation of a class; the first title is empty."""
    text = re.search(r"/\*\*\n(.*?)\*/", header_of(name).read_text(encoding="utf-8"), re.DOTALL)[1]
    lines = [re.sub(r"^ \* ?", "", line) for line in text.split("\n")]
    sections = [("", [[]])]
    for line in lines:
        found = re.match(r"@par ?(.*)", line)
        if line.startswith(("@class", "@sa", "@ref")):
            continue
        if line.startswith("@brief"):
            line = ""
        if found and found[1]:
            sections.append((found[1], [[]]))
        elif found or not line.strip():
            sections[-1][1].append([])
        else:
            if line.lstrip().startswith("- "):
                sections[-1][1].append([])
            sections[-1][1][-1].append(line.strip())
    return [(name, [" ".join(lines) for lines in paragraphs if lines]) for name, paragraphs in sections]


def brief_of(name):
    text = header_of(name).read_text(encoding="utf-8")
    return " ".join(re.search(r"@brief (.*?)\n \*\n", text, re.DOTALL)[1].replace("\n *", " ").split())


def proxies():
    """The proxy of each class, by the class."""
    files = sorted((ROOT / "Wrapping" / "ParaView").glob("*.xml"))
    found = [proxy_of(path) for path in files if not is_base(path)]
    return {proxy.get("class"): proxy for proxy in found}


def properties_of(proxy):
    """The properties of a proxy that a user sets."""
    return [
        element for element in proxy
        if element.tag.endswith("VectorProperty") and not is_former(element) and element.get("information_only") != "1"
    ]  # fmt: skip


def names_of(proxy):
    """Names of properties, which are code in the text."""
    return {element.get("name") for element in proxy if element.tag.endswith("Property")}


def function_name(proxy):
    """The name of the function of paraview.simple."""
    return re.sub(r"[^A-Za-z0-9]", "", proxy.get("label"))


def rows_of_readme():
    """For each class the Python function and the command, of the tables in README.md."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    cell = r"(?:`([^`]*)`)?"
    return {found[1]: (found[2], found[3])
            for found in re.finditer(rf"^\| `(vtk\w+)` \| {cell} ?\| {cell} ?\|", text, re.MULTILINE)}  # fmt: skip


def groups_of_readme():
    """Pairs (title, classes) of the tables in README.md."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    parts = re.split(r"^### (.*)$", text.split("\n## Filters\n")[1].split("\n## ")[0], flags=re.MULTILINE)
    return [(name, re.findall(r"^\| `(vtk\w+)`", part, re.MULTILINE)) for name, part in zip(parts[1::2], parts[2::2])]


# -- examples ----------------------------------------------------------------------------------------------------------


#: Readers of VTK by the end of a file's name.
READERS = {".csv": "vtkDelimitedTextReader", ".mha": "vtkMetaImageReader", ".obj": "vtkOBJReader", ".ply": "vtkPLYReader",
           ".png": "vtkPNGReader", ".stl": "vtkSTLReader", ".vtm": "vtkXMLMultiBlockDataReader", ".vtp": "vtkXMLPolyDataReader"}  # fmt: skip


def _in_cxx(value):
    if isinstance(value, str):
        return f'"{value}"'
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def example_in_cxx(name, proxy, example):
    command = {element.get("name"): element.get("command") for element in proxy}
    ports = {element.get("name"): element.get("port_index") for element in proxy}
    files = [("reader", "0", example.file)] if example.file else []
    files += [(other[0].lower() + other[1:], ports[other], file) for other, file in example.inputs]
    readers = [(variable, port, file, READERS[pathlib.Path(file).suffix]) for variable, port, file in files]
    lines = [f"#include <{header}.h>" for header in sorted({name, "vtkNew", *(reader for *_, reader in readers)})] + [""]
    for variable, _, file, reader in readers:
        lines += [f"vtkNew<{reader}> {variable};", f'{variable}->SetFileName("{file}");']
        if file.endswith(".csv"):
            lines += [f"{variable}->SetHaveHeaders(true);", f"{variable}->DetectNumericColumnsOn();"]
    lines.append(f"vtkNew<{name}> filter;")
    for variable, port, *_ in readers:
        lines.append(f"filter->SetInputConnection({'' if port == '0' else port + ', '}{variable}->GetOutputPort());")
    lines += [f"filter->{command[key]}({_in_cxx(value)});" for key, value in example.properties.items()]
    return "\n".join([*lines, "filter->Update();"])


def example_in_paraview(name, proxy, example):
    """Arguments that ParaView's Python does not choose as one would: a number of minutes for trainers, the active source as input,
    GDAL as reader of images; it knows the arrays of a file that has been read only."""
    kind = {".mha": "volume", ".vtm": "ensemble"}
    variable = kind.get(pathlib.Path(example.file).suffix, "surface") if example.file else None
    files = [("Input", variable, example.file)] if example.file else []
    files += [(other, re.sub(r"(?<=[a-z])(?=[A-Z])", "_", other).lower(), file) for other, file in example.inputs]
    words = [f"{other}={variable}" for other, variable, _ in files] or ["Input=None"]
    words += [f"{key}={json.dumps(value)}" for key, value in example.properties.items()]
    if any(element.get("name") == "TimeBudget" for element in proxy):
        words.append("TimeBudget=0")
    lines = ["from paraview.simple import *", "", 'LoadDistributedPlugin("SurfaceSynthesis", ns=globals())']
    for _, variable, file in files:
        reader = f'PNGSeriesReader(FileNames=["{file}"])' if file.endswith(".png") else f'OpenDataFile("{file}")'
        lines += [f"{variable} = {reader}", *([f"{variable}.UpdatePipeline()"] if variable == "volume" else [])]
    call = f"result = {function_name(proxy)}("
    separator = ", " if len(call) + len(", ".join(words)) < 110 else ",\n" + " " * len(call)
    return "\n".join([*lines, f"{call}{separator.join(words)})", "result.UpdatePipeline()"])


# -- pages -------------------------------------------------------------------------------------------------------------


def table_of_properties(proxy):
    lines = [".. list-table::\n   :header-rows: 1\n   :widths: 25 15 60\n   :class: properties\n\n",
             "   * - property\n     - default\n     - meaning\n"]  # fmt: skip
    names = names_of(proxy)
    for element in properties_of(proxy):
        documentation = element.find("Documentation")
        text = " ".join((documentation.text or "").split()) if documentation is not None else ""
        default = element.get("default_values", "")
        entries = {entry.get("value"): entry.get("text") for entry in element.findall("EnumerationDomain/Entry")}
        if entries:
            text += " One of " + ", ".join(entries.values()) + "."
        limits = [f"{word} {domain.get(key)}" for domain in element.findall("IntRangeDomain") + element.findall("DoubleRangeDomain")
                  for key, word in (("min", "at least"), ("max", "at most")) if domain.get(key)]  # fmt: skip
        if limits:
            text += f" ({', '.join(limits)})"
        if element.find("BooleanDomain") is not None:
            default = "on" if default == "1" else "off"
        default = entries.get(default, "" if default == "none" else default)
        lines.append(f"   * - ``{element.get('name')}``\n     - {escaped(default)}\n     - {escaped(text, names)}\n")
    return "".join(lines) + "\n"


def page_of(name, proxy, folder):
    example, (function, command) = FILTERS[name], rows_of_readme()[name]
    picture = folder / "pictures" / pathlib.Path(example.picture).name
    picture.parent.mkdir(exist_ok=True)
    shutil.copyfile(ROOT / "Examples" / example.picture, picture)
    parts = [title(proxy.get("label")), escaped(brief_of(name)) + ".\n\n"]
    parts.append(f".. image:: ../pictures/{picture.name}\n   :alt: {escaped(brief_of(name))}\n   :class: filter\n\n")
    parts += [title("When to use it", "-"), escaped(example.when) + "\n\n"]
    parts += [title("Example", "-"), "Python:\n\n", block("python", "import surfacesynthesis as ss\n\n" + example.python)]
    if example.command:
        parts += ["Command line:\n\n", block("bash", f"python3 -m surfacesynthesis {example.command}")]
    parts += ["C++:\n\n", block("cpp", example_in_cxx(name, proxy, example))]
    parts += ["ParaView:\n\n", block("python", example_in_paraview(name, proxy, example))]
    names = names_of(proxy)
    for heading, paragraphs in sections_of(name):
        parts.append(title(heading or "Description", "-"))
        parts += [("* " + escaped(text[2:], names) if text.startswith("- ") else escaped(text, names)) + "\n\n"
                  for text in paragraphs]  # fmt: skip
    if name in LIMITS:
        parts += [title("Limits in numbers", "-"), *(f"* {escaped(text, names)}\n" for text in LIMITS[name]), "\n"]
    parts += [title("Properties", "-"), table_of_properties(proxy)]
    parts += [title("Names", "-"), f":C++: `{name} <../cxx/class{name}.html>`__\n"]
    parts.append(f":Python: :func:`surfacesynthesis.{function}`\n" if function else "")
    parts.append(f":Command: ``{command}``\n" if command else "")
    parts.append(f":ParaView: ``{function_name(proxy)}``, {escaped(proxy.get('label'))}\n")
    (folder / "filters" / f"{name}.rst").write_text("".join(parts), encoding="utf-8")


def bibliography(folder):
    """The page of the papers, with a target for each key."""
    text = (ROOT / "Examples" / "references.bib").read_text(encoding="utf-8")
    parts = [title("Papers")]
    for key, body in re.findall(r"^@\w+\{(\w+),\n(.*?)^\}", text, re.MULTILINE | re.DOTALL):
        fields = dict(re.findall(r"^\s*(\w+)\s*=\s*\{(.*?)\},?\s*$", body, re.MULTILINE | re.DOTALL))
        fields = {name: re.sub(r"\\.|[{}]|\s+", lambda match: " " if match[0].isspace() else "", value)
                  for name, value in fields.items()}  # fmt: skip
        where = fields.get("journal") or fields.get("booktitle") or fields.get("publisher") or fields.get("howpublished") or ""
        line = f"{fields.get('author', '')}: *{escaped(fields.get('title', ''))}*. {escaped(where)} {fields.get('year', '')}."
        note = f" {escaped(fields['note'])}." if "note" in fields else ""
        parts.append(f".. _{key.lower()}:\n\n[{key}]\n   {line}{note}\n\n")
    (folder / "papers.rst").write_text("".join(parts), encoding="utf-8")


def descriptions_of_readme():
    """For each class what the tables in README.md say of it."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return {found[1]: found[2] for found in re.finditer(r"^\| `(vtk\w+)` \|[^|]*\|[^|]*\| (.*) \|$", text, re.MULTILINE)}


def index_of_filters(folder):
    """The page with a picture, the names and a description of each filter."""
    parts, descriptions, labels = [title("Filters")], descriptions_of_readme(), proxies()
    parts.append("Each filter is a VTK class, a Python function, a command and an entry of ParaView's menus *Filters > Surface "
                 "Synthesis*.\n\n")  # fmt: skip
    for heading, classes in groups_of_readme():
        parts += [title(heading, "-"), ".. toctree::\n   :maxdepth: 1\n   :hidden:\n\n"]
        parts += [f"   {name}\n" for name in classes]
        parts.append("\n.. list-table::\n   :widths: 25 30 45\n   :class: plain\n\n")
        for name in classes:
            function, picture = rows_of_readme()[name][0], pathlib.Path(FILTERS[name].picture).name
            parts.append(f"   * - .. image:: ../pictures/{picture}\n          :alt: {labels[name].get('label')}\n          :width: 100%\n"
                         f"          :target: {name}.html\n\n"
                         f"     - :doc:`{labels[name].get('label')} <{name}>`\n\n       ``{name}``\n\n       ``{function}()``\n"
                         f"     - {from_markdown.inline(descriptions[name])}\n")  # fmt: skip
        parts.append("\n")
    (folder / "filters" / "index.rst").write_text("".join(parts), encoding="utf-8")


def reference_of_python(folder):
    """The page of the functions and classes of the package, but for VTK's."""
    import surfacesynthesis

    parts = [title("Python"), ".. module:: surfacesynthesis\n\n"]
    for name in sorted(surfacesynthesis.__all__, key=str.lower):
        value = getattr(surfacesynthesis, name)
        if inspect.isfunction(value):
            parts.append(f".. autofunction:: surfacesynthesis.{name}\n\n")
        elif inspect.isclass(value) and not name.startswith("vtk"):
            parts.append(f".. autoclass:: surfacesynthesis.{name}\n   :members:\n\n")
    (folder / "python.rst").write_text("".join(parts), encoding="utf-8")


def reference_of_cxx(folder):
    """The page of the classes in C++, and the first page of Doxygen's, which leads back."""
    parts = [title("C++"), "All classes and functions, those of the libraries without VTK included, are in the `reference of C++ "
             "<cxx/index.html>`__. The filters:\n\n"]  # fmt: skip
    back = ["# Reference of C++ {#mainpage}\n\n[Documentation of all filters, with examples](../index.html)\n\n"]
    for name in sorted(FILTERS):
        parts.append(f"* `{name} <cxx/class{name}.html>`__: {escaped(brief_of(name))}.\n")
        back.append(f"- {name}: {brief_of(name)}.\n")
    (folder / "cxx_reference.rst").write_text("".join(parts), encoding="utf-8")
    (folder / "mainpage.md").write_text("".join(back), encoding="utf-8")


def pages_of_readmes(folder):
    for file, (name, _) in from_markdown.PAGES.items():
        pictures = {}
        (folder / f"{name}.rst").write_text(from_markdown.page(file, pictures), encoding="utf-8")
        for path, picture in pictures.items():
            shutil.copyfile(path, folder / "pictures" / picture)


def copy_pages(folder):
    """The pages that are written by hand, and their pictures."""
    here = pathlib.Path(__file__).resolve().parent
    (folder / "pictures").mkdir(exist_ok=True)
    for page in [here / "conf.py", *here.glob("*.rst"), *here.glob("tasks/*.rst"), *here.glob("static/*")]:
        target = folder / page.relative_to(here)
        target.parent.mkdir(exist_ok=True)
        shutil.copyfile(page, target)
        for name in re.findall(r"^.. image:: (?:\.\./)?pictures/(.*)$", page.read_text(encoding="utf-8"), re.MULTILINE):
            shutil.copyfile(ROOT / "Examples" / "Gallery" / name, folder / "pictures" / name)


def main(folder):
    folder = pathlib.Path(folder)
    (folder / "filters").mkdir(parents=True, exist_ok=True)
    copy_pages(folder)
    for name, proxy in proxies().items():
        page_of(name, proxy, folder)
    index_of_filters(folder)
    bibliography(folder)
    reference_of_python(folder)
    reference_of_cxx(folder)
    pages_of_readmes(folder)


if __name__ == "__main__":
    main(sys.argv[1])
