# SPDX-License-Identifier: BSD-3-Clause
"""Builds the wheel: what CMake installs below surfacesynthesis/, without headers and CMake files.

The environment variable SKBUILD_CONFIGURE_OPTIONS holds further options of CMake, such as
-DSURFACE_SYNTHESIS_LEARNING=OFF.
"""

import pathlib
import re

from skbuild import setup

ROOT = pathlib.Path(__file__).resolve().parent
#: Extension modules lie in the package, libraries and models below it.
OPTIONS = [
    "-DSURFACE_SYNTHESIS_PETSC=OFF",
    "-DSURFACE_SYNTHESIS_TESTING=OFF",
    "-DSURFACE_SYNTHESIS_BENCHMARKS=OFF",
    "-DSURFACE_SYNTHESIS_EXAMPLES=OFF",
    "-DSURFACE_SYNTHESIS_PYTHON_DESTINATION=.",
    "-DCMAKE_INSTALL_BINDIR=surfacesynthesis/bin",
    "-DCMAKE_INSTALL_LIBDIR=surfacesynthesis/lib",
    "-DCMAKE_INSTALL_INCLUDEDIR=surfacesynthesis/include",
    "-DCMAKE_INSTALL_DATAROOTDIR=surfacesynthesis/share",
    "-DCMAKE_PLATFORM_NO_VERSIONED_SONAME=ON",  # a wheel has no symbolic links
]


def version():
    """The version of the project in CMakeLists.txt."""
    return re.search(r"project\(SurfaceSynthesis\s+VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


def wanted(files):
    """The installed files without those of development."""
    return [file for file in files if not re.search(r"surfacesynthesis/(include|lib/cmake|lib/vtk)/", file.replace("\\", "/"))]


setup(
    version=version(),
    packages=["surfacesynthesis"],
    package_dir={"": "Wrapping/Python"},
    cmake_install_dir="Wrapping/Python",
    cmake_args=OPTIONS,
    cmake_languages=("CXX",),
    cmake_process_manifest_hook=wanted,
    include_package_data=False,
    zip_safe=False,
)
