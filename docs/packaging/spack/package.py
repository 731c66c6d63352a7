# A package of Spack, for a repository of your site's: NAME/packages/py-granwave/package.py
# (packages/py_granwave from Spack 1 on). What of this was tried: the page "Install".
# It asks for what the core needs. Packages of single features are installed as they are wanted:
# py-scikit-fem, py-numba, py-clarabel, py-scikit-learn, py-imageio-ffmpeg, py-k3d, vtk,
# py-h5netcdf, py-plutoprint.
from spack.package import *


class PyGranwave(PythonPackage):
    """Impact and waves in ordered granular packings, on LAMMPS."""

    license("GPL-2.0-only")
    # a checkout:  spack develop --path . py-granwave@1.1.0
    version("1.1.0")

    # the plugin has no binary interface to other releases: built again with each
    depends_on("lammps@20250722 +lib +mpi +python +granular +plugin", type=("build", "link", "run"))

    depends_on("cxx", type="build")
    depends_on("cmake@3.20:", type="build")
    depends_on("ninja", type="build")
    depends_on("py-scikit-build-core@0.11:", type="build")
    depends_on("py-pybind11@2.13:", type=("build", "link"))

    depends_on("python@3.11:", type=("build", "run"))
    with default_args(type="run"):
        depends_on("py-mpi4py@4:")
        depends_on("py-ase@3.23:")
        depends_on("py-numpy@2:")
        depends_on("py-scipy@1.13:")
        depends_on("py-h5py@3.11:")
        depends_on("py-mdanalysis@2.8:")
        depends_on("py-matplotlib@3.11:")
        depends_on("py-pandas@2.2.2:")
        depends_on("py-xarray@2024.7:")
        depends_on("py-pillow@10:")
        depends_on("py-jinja2@3.1:")
        depends_on("py-markupsafe@2:")
        depends_on("py-tomli-w@1:")
        depends_on("py-tqdm@4.66:")
        depends_on("py-pysqa@1.1:1")
        depends_on("py-defusedxml@0.7:")
        depends_on("py-argcomplete@3.5:")

    def setup_build_environment(self, env):
        # lib or lib64, by the site
        config = find(self.spec["lammps"].prefix, "LAMMPSConfig.cmake")
        env.set("LAMMPS_DIR", ancestor(config[0]))

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_install(self):
        Executable(self.prefix.bin.granwave)("selftest")
