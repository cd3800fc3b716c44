# SPDX-License-Identifier: BSD-3-Clause
"""Checks Debian packages: debian_packages.py <packages> <root> <sources> <work>.

Unpacks the packages into the folder <root> and runs their programs there. As root, with debootstrap and a Debian mirror
within reach, installs them in a minimal Debian below <work>, without LibTorch, and draws a picture there: in less than a
minute after the download.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

#: Seconds of installation and first picture together, after the download.
MINUTE = 60.0

#: What each package needs and holds: patterns of dependencies, and of files.
EXPECTED = {
    "surfacesynthesis-models": ((), (r"usr/share/SurfaceSynthesis/Models/coat\.safetensors$",)),
    "libsurfacesynthesis": (
        ("libc6", "libvtk9.1", "libopenblas0", "surfacesynthesis-models"),
        (r"usr/lib/[^/]+/libSurfaceSynthesisCore\.so\.\d+\.\d+$", r"usr/lib/[^/]+/libvtkSurfaceSynthesisNoise[^/]*\.so\.\d"),
    ),
    "libsurfacesynthesis-dev": (
        ("libsurfacesynthesis", "libvtk9-dev", "libeigen3-dev"),
        (
            r"usr/include/SurfaceSynthesis/vtkMaternNoiseFilter\.h$",
            r"usr/lib/[^/]+/cmake/SurfaceSynthesis/SurfaceSynthesisConfig\.cmake$",
            r"usr/lib/[^/]+/libSurfaceSynthesisCore\.so$",
        ),
    ),
    "python3-surfacesynthesis": (
        ("libsurfacesynthesis", "python3", "python3-vtk9", "python3-numpy", "libvtk9.1"),
        (
            r"usr/bin/surfacesynthesis$",
            r"usr/lib/python3/dist-packages/surfacesynthesis/__init__\.py$",
            r"usr/lib/python3/dist-packages/surfacesynthesis/vtkSurfaceSynthesisNoise[^/]*\.so$",
        ),
    ),
    "surfacesynthesis-training": (
        ("libsurfacesynthesis", "libtorch1.13"),
        (
            r"usr/bin/surfacesynthesis-train$",
            r"usr/lib/[^/]+/libSurfaceSynthesisLearning\.so\.",
            r"usr/lib/python3/dist-packages/surfacesynthesis/vtkSurfaceSynthesisTraining[^/]*\.so$",
        ),
    ),
}
PICTURE = """\
import surfacesynthesis as ss
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

ball = vtkSphereSource()
ball.SetThetaResolution(100)
ball.SetPhiResolution(100)
ball.Update()
noise = ss.matern_noise(ball.GetOutput(), range=0.3, seed=1)
noise.GetPointData().SetActiveScalars("MaternNoise")
mapper, actor, renderer, window = vtkPolyDataMapper(), vtkActor(), vtkRenderer(), vtkRenderWindow()
mapper.SetInputData(noise)
mapper.SetScalarRange(-2, 2)
actor.SetMapper(mapper)
renderer.AddActor(actor)
window.AddRenderer(renderer)
window.SetSize(600, 600)
window.Render()
image, writer = vtkWindowToImageFilter(), vtkPNGWriter()
image.SetInput(window)
writer.SetInputConnection(image.GetOutputPort())
writer.SetFileName("/tmp/picture.png")
writer.Write()
"""


def output_of(*command, **options):
    """The output of a command that must succeed."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {done.returncode} and printed\n{done.stdout[-8000:]}")
    return done.stdout


def fail_unless(condition, text):
    if not condition:
        sys.exit(text)


def field(package, name):
    return output_of("dpkg-deb", "-f", package, name).strip()


def check_contents(packages):
    """Names, dependencies and files of the packages; returns the files of each."""
    named = {re.sub(r"[0-9.]+$", "", field(package, "Package")): package for package in packages}
    fail_unless(set(named) == set(EXPECTED) or set(named) == set(EXPECTED) - {"surfacesynthesis-training"}, f"{sorted(named)}")
    owners = {}
    for name, package in named.items():
        needed, patterns = EXPECTED[name]
        depends = field(package, "Depends")
        files = re.findall(r"^[^d]\S+ .* \./(\S+)(?: -> \S+)?$", output_of("dpkg-deb", "-c", package), re.MULTILINE)
        for dependency in needed:
            fail_unless(re.search(rf"(^|, ){re.escape(dependency)}", depends), f"{name} does not depend on {dependency}: {depends}")
        for pattern in patterns:
            fail_unless(any(re.search(pattern, file) for file in files), f"{name} has no {pattern} among {files}")
        for file in files:
            fail_unless(file not in owners, f"{file} is in {name} and in {owners.get(file)}")
            owners[file] = name
        copyright_file = f"usr/share/doc/{field(package, 'Package')}/copyright"
        fail_unless(copyright_file in files, f"{name} has no {copyright_file}")
        torch = [line for line in depends.split(", ") if "torch" in line]
        fail_unless(bool(torch) == (name in ("surfacesynthesis-training", "libsurfacesynthesis-dev")) or name.endswith("-dev"),
                    f"{name} depends on {torch}")  # fmt: skip
        print(f"{os.path.basename(package)}: {os.path.getsize(package) / 2**20:.1f} MiB; Depends: {depends}")
    return owners


def check_unpacked(packages, root, files, source):
    """The files run where they are unpacked: no path of the build tree is in them."""
    for package in packages:
        output_of("dpkg", "-x", package, root)
    for file in files:
        path = root / file
        if not path.is_symlink() and file.endswith((".cmake", ".py", ".h")):
            fail_unless(str(source) not in path.read_text(errors="replace"), f"{file} names the folder of the sources")
        if ".so" in file and not path.is_symlink():
            dynamic = output_of("readelf", "-d", path)
            fail_unless("RUNPATH" not in dynamic and "RPATH" not in dynamic, f"{file} has a path of libraries")
    libraries = next(root.glob("usr/lib/*/libSurfaceSynthesisCore.so")).parent
    environment = {**os.environ, "LD_LIBRARY_PATH": str(libraries), "PYTHONPATH": "", "PYTHONDONTWRITEBYTECODE": "1"}
    program = root / "usr/bin/surfacesynthesis"
    text = output_of(program, "--help", env=environment, cwd=root)
    fail_unless("noise" in text and "tetrahedralize" in text, text)
    (root / "tetrahedron.off").write_text("OFF\n4 4 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
    text = output_of(program, "remesh", "tetrahedron.off", "even.vtp", "--points", "300", env=environment, cwd=root)
    text += output_of(program, "noise", "even.vtp", "noise.vtp", "--range", "3", env=environment, cwd=root)
    text += output_of(program, "tetrahedralize", "noise.vtp", "volume.vtu", env=environment, cwd=root)
    fail_unless("volume.vtu" in text and (root / "volume.vtu").is_file(), text)
    if (root / "usr/bin/surfacesynthesis-train").is_file():
        output_of(root / "usr/bin/surfacesynthesis-train", "--help", env=environment)
        code = "from surfacesynthesis import vtkFlowMatchingTrainer; vtkFlowMatchingTrainer()"
        output_of(sys.executable, "-c", code, env={**environment, "PYTHONPATH": str(root / "usr/lib/python3/dist-packages")})


def mirror_and_release():
    """The address and the name of the Debian that this machine installs from; None where there is none."""
    release = dict(re.findall(r'^(\w+)="?([^"\n]*)', pathlib.Path("/etc/os-release").read_text(), re.MULTILINE))
    name = release.get("VERSION_CODENAME", "")
    targets = subprocess.run(
        ["apt-get", "indextargets", "--format", "$(REPO_URI)", "Created-By: Packages", f"Codename: {name}", "Label: Debian"],
        stdout=subprocess.PIPE, text=True, check=False,
    ).stdout.split()  # fmt: skip
    return (targets[0], name) if targets else None


def make_minimal_debian(folder, mirror, release):
    """A minimal Debian in ``folder``, from an archive beside it that is made once."""
    archive = folder.with_suffix(".tar")
    if not archive.is_file():
        output_of("debootstrap", "--variant=minbase", release, folder, mirror)
        output_of("tar", "-C", folder, "-cf", archive.with_suffix(".unfinished"), ".")
        archive.with_suffix(".unfinished").rename(archive)
    else:
        folder.mkdir()
        output_of("tar", "-C", folder, "-xf", archive)
    # as in Debian's images for containers: nothing is to survive a loss of power
    (folder / "etc/dpkg/dpkg.cfg.d/unsafe-io").write_text("force-unsafe-io\n")
    for file in ("etc/resolv.conf", "etc/hosts"):
        shutil.copyfile(pathlib.Path("/", file), folder / file)


def check_installed(packages, work):
    """Installs the packages without those of development and training in a minimal Debian, and draws a picture there."""
    source = mirror_and_release()
    if os.geteuid() != 0 or not shutil.which("debootstrap") or source is None:
        print("Not installed: this needs root, debootstrap and a mirror of Debian")
        return
    folder = work / "Debian"
    shutil.rmtree(folder, ignore_errors=True)
    make_minimal_debian(folder, *source)
    names = []
    for package in packages:
        if not re.search("-dev_|training", package.name):
            shutil.copy(package, folder / "tmp")
            names.append(f"/tmp/{package.name}")
    (folder / "tmp/picture.py").write_text(PICTURE)
    inside = ["unshare", "--mount", "--pid", "--fork", "--kill-child", "chroot", folder, "env", "DEBIAN_FRONTEND=noninteractive",
              "LC_ALL=C.UTF-8", "PATH=/usr/sbin:/usr/bin:/sbin:/bin"]  # fmt: skip
    install = [*inside, "apt-get", "install", "-y", "-q", "--no-install-recommends", *names, "xvfb", "xauth"]
    output_of(*inside, "apt-get", "update", "-q")
    output_of(*install, "--download-only")
    started, before = time.monotonic(), os.times()
    text = output_of(*install)
    installed = time.monotonic()
    script = "mount -t proc proc /proc && xvfb-run -a -s '-screen 0 1024x768x24' python3 /tmp/picture.py"
    output_of(*inside, "sh", "-c", script)
    drawn = time.monotonic()
    picture = folder / "tmp/picture.png"
    fail_unless(picture.is_file() and picture.stat().st_size > 10000, "The picture is missing or empty")
    shutil.copy(picture, work / "picture.png")
    count = re.search(r"(\d+) newly installed", text)[1]
    print(f"{count} packages installed in {installed - started:.0f} s, first picture {drawn - installed:.1f} s later")
    shutil.rmtree(folder)
    after = os.times()
    worked = after.children_user + after.children_system - before.children_user - before.children_system
    print(f"{worked:.0f} s of processor time")
    busy = os.getloadavg()[1] > os.cpu_count() + 1  # with other work: the time on the clock says nothing
    taken = worked if busy else drawn - started
    fail_unless(taken < MINUTE, f"Installation and first picture took {taken:.0f} s{' of processor time' if busy else ''}")


def main(packages, root, source, work):
    packages = sorted(pathlib.Path(packages).resolve().glob("*.deb"))
    root, work = pathlib.Path(root), pathlib.Path(work)
    root.mkdir(parents=True)
    files = check_contents(packages)
    check_unpacked(packages, root, files, source)
    check_installed(packages, work)


if __name__ == "__main__":
    main(*sys.argv[1:])
