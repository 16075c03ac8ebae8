"""The Python package gicube and the emulated board that it opens, built by CMake: pip install --no-build-isolation .

With GICUBE_BUILD=FOLDER of a build tree that is whole nothing is built. The shared libraries and programs go to lib,
bin and libexec of the environment, where the module finds them as in an installed SDK.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

TREE = Path(os.environ.get("GICUBE_BUILD", "build/release"))
OWN = TREE / "pip"
OWN.mkdir(parents=True, exist_ok=True)


class Binary(Distribution):
    def has_ext_modules(self):
        return True


class Build(build_py):
    def run(self):
        super().run()
        if "GICUBE_BUILD" not in os.environ:
            subprocess.run(["cmake", "--preset", "release"], check=True)
            targets = ["gicube_python", "gicube-board", "gicube-plug-in-host"]
            subprocess.run(["cmake", "--build", str(TREE), "--target", *targets], check=True)
        stage = OWN / "stage"
        shutil.rmtree(stage, ignore_errors=True)
        subprocess.run(["cmake", "--install", str(TREE), "--prefix", str(stage), "--component", "pip"], check=True)
        (module,) = stage.glob("gicube/_core*.so")
        self.copy_file(str(module), f"{self.build_lib}/gicube")
        folders = {path.parent.relative_to(stage) for path in stage.glob("*/**/*") if path.is_file()} - {Path("gicube")}
        files = {folder: [str(path) for path in (stage / folder).iterdir() if path.is_file()] for folder in folders}
        self.distribution.data_files = [(str(folder), held) for folder, held in files.items()]


setup(
    name="gicube",
    version=".".join(re.findall(r"VERSION_(?:MAJOR|MINOR|PATCH) (\d+)",
                                Path("driver/include/gicube/version.h").read_text())),
    description="A volumetric ray tracing board, emulated, with numpy arrays",
    python_requires=">=3.11",
    install_requires=["numpy"],
    packages=["gicube"],
    package_dir={"gicube": "driver/python/gicube"},
    package_data={"gicube": ["py.typed", "*.pyi"]},
    distclass=Binary,
    cmdclass={"build_py": Build},
    options={"build": {"build_base": str(OWN)}, "egg_info": {"egg_base": str(OWN)},
             "bdist_wheel": {"bdist_dir": str(OWN / "wheel")}},
)
