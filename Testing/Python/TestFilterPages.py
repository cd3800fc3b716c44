# SPDX-License-Identifier: BSD-3-Clause
"""Examples of the documentation's pages: each filter has one, in C++, Python, on the command line and in ParaView, and they
name what there is. Build.Documentation builds the pages."""

import ast
import inspect
import pathlib
import re
import shlex
import sys

import pytest
import surfacesynthesis
from surfacesynthesis.command_line import build_parser

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "Examples" / "Documentation"))
import from_markdown  # noqa: E402
import generate  # noqa: E402
from filter_examples import FILTERS, LIMITS  # noqa: E402

PROXIES = generate.proxies()
PAGES = sorted((ROOT / "Examples" / "Documentation" / "tasks").glob("*.rst"))


def blocks_of(path, language):
    """The code of a page in a language, without its indentation."""
    text = path.read_text(encoding="utf-8")
    found = re.findall(rf"^\.\. code-block:: {language}\n\n((?:   .*\n|\n)+)", text, re.MULTILINE)
    return [re.sub(r"^   ", "", block, flags=re.MULTILINE).strip() for block in found]


def check_command(words):
    assert words[:3] == ["python3", "-m", "surfacesynthesis"], words
    build_parser().parse_args(words[3:])


def check_calls(code):
    """Binds the arguments of each call of the package to the signature of the function."""
    calls = [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)]
    calls = [call for call in calls if isinstance(call.func.value, ast.Name) and call.func.value.id == "ss"]
    for call in calls:
        function = getattr(surfacesynthesis, call.func.attr)
        keywords = {keyword.arg: None for keyword in call.keywords}
        inspect.signature(function).bind(*[None] * len(call.args), **keywords)
    return calls


def test_each_filter_has_a_page_and_each_page_a_filter():
    assert set(FILTERS) == set(PROXIES) == set(generate.rows_of_readme())
    assert sorted(FILTERS) == sorted(name for _, names in generate.groups_of_readme() for name in names)


@pytest.mark.parametrize("name", sorted(FILTERS))
def test_examples_name_what_there_is(name):
    example, proxy = FILTERS[name], PROXIES[name]
    if not hasattr(surfacesynthesis, name):
        pytest.skip(f"built without {name}")
    assert (ROOT / "Examples" / example.picture).is_file()
    settable = {element.get("name") for element in generate.properties_of(proxy)}
    assert set(example.properties) <= settable
    inputs = {element.get("name") for element in proxy if element.tag == "InputProperty"}
    assert {other for other, _ in example.inputs} <= inputs
    assert example.file or "DatasetFileName" in example.properties
    files = [file for file in (example.file, *(file for _, file in example.inputs)) if file]
    assert all(file in example.python for file in files)
    instance = getattr(surfacesynthesis, name)()
    for setter in re.findall(r"filter->(\w+)\(", generate.example_in_cxx(name, proxy, example)):
        assert hasattr(instance, setter), setter
    calls = check_calls(example.python)
    assert generate.rows_of_readme()[name][0] in [call.func.attr for call in calls]
    if example.command:
        check_command(["python3", "-m", "surfacesynthesis", *shlex.split(example.command)])
        assert all(file in example.command for file in files if not file.endswith(".png"))
        assert shlex.split(example.command)[0] == (generate.rows_of_readme()[name][1] or "").split()[0]
    ast.parse(generate.example_in_paraview(name, proxy, example))


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_code_of_tasks_names_what_there_is(path):
    if "vtkTetrahedralizeFilter" not in surfacesynthesis.__all__ or "vtkLatentDiffusionTrainer" not in surfacesynthesis.__all__:
        pytest.skip("built without a filter of the tasks")
    for block in blocks_of(path, "bash"):
        for line in block.splitlines():
            if not re.match(r"\w+=", line):
                check_command(shlex.split(line))
    for block in blocks_of(path, "python"):
        assert check_calls(block)
    assert blocks_of(path, "bash")


def test_a_wrong_example_is_found():
    with pytest.raises(TypeError):
        check_calls("ss.matern_noise(mesh, rang=5)")
    with pytest.raises(Exception, match="unrecognized"):
        check_command(shlex.split("python3 -m surfacesynthesis noise in.stl out.vtp --rang3 5"))


def test_limits_are_of_filters_and_name_files_that_there_are():
    assert set(LIMITS) == set(FILTERS)
    assert all(any(re.search(r"[0-9]|O\(|copy", text) for text in texts) for texts in LIMITS.values())
    for text in [text for texts in LIMITS.values() for text in texts]:
        assert all((ROOT / name).is_file() for name in re.findall(r"[\w/]+\.md", text)), text


def test_text_of_sources_stays_text():
    assert generate.escaped("a*b `c` Name_ and Name_k [Kuai2026]") == (
        r"a\*b ``c`` Name\_ and Name_k :ref:`[Kuai2026] <kuai2026>`"
    )
    text = generate.escaped("SampleRate and vtkMaternNoiseFilter(vtkPolyData) in README.md", {"SampleRate"})
    assert text == (r"``SampleRate`` and :doc:`vtkMaternNoiseFilter </filters/vtkMaternNoiseFilter>`\ (\ ``vtkPolyData``\ ) in "
                    ":doc:`Overview </overview>`")  # fmt: skip
    brief = generate.brief_of("vtkMaternNoiseFilter")
    assert brief.startswith("Generates Gaussian random fields") and "\n" not in brief
    assert {"", "Input", "Output", "Cost"} <= {heading for heading, _ in generate.sections_of("vtkMaternNoiseFilter")}


def test_markdown_becomes_blocks():
    text = "# A\n\nText\ngoes on.\n- one\n  of two\n- two\n\n  ```bash\n  x | y\n\n    z\n  ```\n| a | b |\n|---|---|\n| c | |\n\n    code\n\nend"
    assert from_markdown.blocks(text) == [
        ("heading", ["# A"]), ("paragraph", ["Text", "goes on."]), ("list", ["- one", "  of two", "- two"]),
        ("code", ["bash", "x | y", "", "  z"]), ("table", ["| a | b |", "|---|---|", "| c | |"]), ("code", ["bash", "code", ""]),
        ("paragraph", ["end"]),
    ]  # fmt: skip


def test_markdown_becomes_inline_markup():
    folder = ROOT / "Examples"
    assert from_markdown.inline("**b** `c`s, *e* 2*3*4 [t](https://vtk.org) x_ [Kuai2026]", folder) == (
        r"**b** ``c``\ s, *e* 2\*3\*4 `t <https://vtk.org>`__ x\_ :ref:`[Kuai2026] <kuai2026>`"
    )
    assert from_markdown.inline("[a](Models/README.md) [b](#the-spectrum) [c](run.sh)", folder) == (
        ":doc:`a </models>` :ref:`b <gallery-the-spectrum>` c (``Examples/run.sh``)"
    )


def test_pages_of_the_folders_have_all_their_pictures():
    for file in from_markdown.PAGES:
        pictures = {}
        page = from_markdown.page(file, pictures)
        expected = re.findall(r"!\[[^\]]*\]\(([^)]*)\)", (ROOT / file).read_text(encoding="utf-8"))
        assert len(pictures) == len(set(expected)) and all(path.is_file() for path in pictures)
        assert all(f"pictures/{name}" in page for name in pictures.values()) and "![" not in page
