#!/usr/bin/env bash
# Has pip install the Python package from a build tree into an environment of its own, with no network, and renders a
# picture there. Usage: pip_install.sh BUILD_DIR SOURCE_DIR
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
unset PYTHONPATH GICUBE_BOARD
export XDG_RUNTIME_DIR=$scratch  # boards started here are not registered with the user's
/usr/bin/python3 -m pip --version >/dev/null 2>&1 || { echo "no pip: not tried"; exit 77; }
/usr/bin/python3 -m venv --without-pip --system-site-packages "$scratch/venv"
cd "$2"
GICUBE_BUILD=$1 "$scratch/venv/bin/python" -m pip install --quiet --no-index --no-build-isolation --root-user-action ignore .
cd "$scratch"
env -i PATH=/usr/bin:/bin XDG_RUNTIME_DIR="$scratch" "$scratch/venv/bin/python" -c 'import gicube, pathlib, sys
assert gicube.__file__.startswith(sys.prefix), gicube.__file__
assert (pathlib.Path(gicube.__file__).parent / "py.typed").exists()
assert f"{sys.prefix}/lib/libgicube.so" in pathlib.Path("/proc/self/maps").read_text()
setup = gicube.parse_scene("volume { builtin: \"buckyball\" size: 32 } image { width: 32 height: 32 }").set_up()
with gicube.open() as board:
    children = pathlib.Path("/proc/thread-self/children").read_text().split()
    assert [pathlib.Path(f"/proc/{child}/exe").resolve() for child in children] == [pathlib.Path(sys.prefix, "bin/gicube-board")]
    assert board.render(gicube.load_scene(board, setup)).alpha.max() > 0'
"$scratch/venv/bin/python" -m pip uninstall --quiet --yes --root-user-action ignore gicube
[[ ! -e $scratch/venv/bin/gicube-board && ! $(compgen -G "$scratch/venv/lib/libgicube.so*") ]]
echo "pip: all is well"
