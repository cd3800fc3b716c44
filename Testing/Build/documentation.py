# SPDX-License-Identifier: BSD-3-Clause
"""Checks the documentation site: documentation.py <folder of the pages> <work> [<chromium>].

Links and pictures lead to files, and parts of pages to parts that there are, but for what Doxygen's scripts make. With
Chromium, some pages are drawn.
"""

import html.parser
import pathlib
import subprocess
import sys
import urllib.parse


class _Reader(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.links, self.names = [], set()

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.links += [values[key] for key in ("href", "src") if values.get(key)]
        self.names |= {values[key] for key in ("id", "name") if values.get(key)}


def read(path):
    reader = _Reader()
    reader.feed(path.read_text(encoding="utf-8", errors="replace"))
    return reader


def faults_of(folder):
    """The links of all pages that lead nowhere."""
    pages = {path.resolve(): read(path) for path in folder.rglob("*.html")}
    own = [path for path in pages if "cxx" not in path.relative_to(folder.resolve()).parts]
    faults = []
    for page in own:
        for link in pages[page].links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (page.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else page
            if not target.exists():
                faults.append(f"{page.name}: {link}")
            elif parts.fragment and target in pages and parts.fragment not in pages[target].names:
                faults.append(f"{page.name}: {link} has no such part")
    return faults, len(own)


def draw(chromium, page, picture):
    subprocess.run([chromium, "--headless=new", "--no-sandbox", "--hide-scrollbars", "--window-size=1250,1000",
                    f"--user-data-dir={picture.parent / 'profile'}", f"--screenshot={picture}", page.as_uri()],
                   check=True, capture_output=True, timeout=120)  # fmt: skip
    return picture.stat().st_size


def main(folder, work, chromium=""):
    folder, work = pathlib.Path(folder).resolve(), pathlib.Path(work)
    work.mkdir(parents=True, exist_ok=True)
    faults, count = faults_of(folder)
    if faults:
        sys.exit("Links that lead nowhere:\n" + "\n".join(faults))
    if count < 45 or not (folder / "cxx" / "classvtkMaternNoiseFilter.html").is_file():
        sys.exit(f"{count} pages are too few, or those of C++ are missing")
    for name in ("index", "filters/vtkMaternNoiseFilter", "tasks/scan", "gallery", "cxx/classvtkMaternNoiseFilter") if chromium else ():
        size = draw(chromium, folder / f"{name}.html", work / f"{name.replace('/', '-')}.png")
        if size < 40000:
            sys.exit(f"The picture of {name}.html has {size} bytes only")
    print(f"{count} pages")


if __name__ == "__main__":
    main(*sys.argv[1:])
