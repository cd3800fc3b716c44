# SPDX-License-Identifier: BSD-3-Clause
"""Sphinx's configuration of the documentation site. The environment variable SURFACE_SYNTHESIS_DOXYGEN is the folder whose
subfolder cxx holds the pages of Doxygen."""

import os

project = "SurfaceSynthesis"
copyright = "2026, the SurfaceSynthesis developers"
extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = []
html_theme = "alabaster"
html_theme_options = {
    "description": "Generative filters on surfaces for VTK",
    "fixed_sidebar": True,
    "page_width": "1180px",
    "sidebar_width": "240px",
    "body_max_width": "940px",
    "font_family": "system-ui, sans-serif",
    "head_font_family": "system-ui, sans-serif",
}
html_sidebars = {"**": ["about.html", "navigation.html", "searchbox.html"]}
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = [folder for folder in [os.environ.get("SURFACE_SYNTHESIS_DOXYGEN")] if folder]
html_copy_source = False
html_show_sphinx = False
napoleon_numpy_docstring = True
napoleon_google_docstring = False
add_module_names = False
nitpicky = False
