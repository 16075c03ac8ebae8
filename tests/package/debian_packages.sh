#!/usr/bin/env bash
# Makes the Debian packages and their bill of materials, unpacks them into a scratch root and builds and runs a program
# there. Usage: debian_packages.sh BUILD_DIR SOURCE_DIR
set -euo pipefail
build=$1
source=$2

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export XDG_RUNTIME_DIR=$scratch  # boards started here are not registered with the user's
cpack --config "$build/CPackConfig.cmake" -B "$scratch/packages" >"$scratch/cpack.log" || { cat "$scratch/cpack.log"; exit 1; }
runtime=$(echo "$scratch"/packages/gicube_*.deb)
python=$(echo "$scratch"/packages/python3-gicube_*.deb)
dev=$(echo "$scratch"/packages/gicube-dev_*.deb)
doc=$(echo "$scratch"/packages/gicube-doc_*_all.deb)

depends=$(dpkg-deb -f "$runtime" Depends)
for package in libc6 libgrpc++ libprotobuf; do
  [[ $depends == *$package* ]] || { echo "gicube does not depend on $package: $depends" >&2; exit 1; }
done
[[ $(dpkg-deb -f "$dev" Depends) == "gicube (= $(dpkg-deb -f "$runtime" Version))" ]]

mkdir "$scratch/root"
dpkg-deb -x "$runtime" "$scratch/root"
[[ ! -e $scratch/root/usr/include ]]
test -x "$scratch/root/usr/bin/gicube-board"
test -x "$scratch/root/usr/libexec/gicube/gicube-plug-in-host"
gzip -t "$scratch/root/usr/share/man/man1/gicube-board.1.gz" "$scratch/root/usr/share/doc/gicube/changelog.gz"
test -e "$scratch/root/usr/share/bash-completion/completions/gicube-board"
test -e "$scratch/root/usr/share/gicube/presets/ct-bone.tf"
test -e "$scratch/root/usr/lib/systemd/system/gicube-board.socket"
python3 -B "$source/driver/cmake/sbom.py" "$build" "$runtime" "$scratch/bill.json"
python3 -B "$(dirname "$0")/check_bill.py" "$scratch/bill.json" "$scratch/root" "$source"
dpkg-deb -x "$dev" "$scratch/root"
test -e "$scratch/root/usr/include/gicube/v1/board_config.proto"
[[ ! -e $scratch/root/usr/share/doc/gicube/docs ]]
dpkg-deb -x "$doc" "$scratch/root"
test -e "$scratch/root/usr/share/doc/gicube/docs/README.md"
for library in gicube gicube-scene; do [[ -L $scratch/root/usr/lib/lib$library.so && -e $scratch/root/usr/lib/lib$library.so ]]; done
! grep -rIl --exclude-dir=doc -e "$build" "$scratch/root"  # no text in it names the build's place

if [[ -e $build/lib/libgicube-mpi.so ]]; then
  mpi=$(echo "$scratch"/packages/gicube-mpi_*.deb)
  dpkg-deb -x "$mpi" "$scratch/root"
  [[ $(dpkg-deb -f "$mpi" Depends) == *"gicube (= $(dpkg-deb -f "$runtime" Version))"*mpi* ]]
  test -e "$scratch/root/usr/include/gicube/mpi.h"
  "$scratch/root/usr/bin/gicube-render" builtin:buckyball --volume-size 32 --size 8x8 --mpi=rays -o "$scratch/picture.png" | grep -q '^.*picture.png: frame '
fi
dpkg-deb -x "$python" "$scratch/root"
[[ $(dpkg-deb -f "$python" Depends) == *"gicube (= $(dpkg-deb -f "$runtime" Version))"* ]]
unset GICUBE_BOARD
"$scratch/root/usr/bin/gicube-sweep" builtin:buckyball --fix volume-size=16 --fix size=8x8 --reference step=1 -o "$scratch/sweep" >"$scratch/sweep.log"
grep -q 'of 1 runs' "$scratch/sweep.log"
gzip -t "$scratch/root/usr/share/man/man1/gicube-sweep.1.gz"
test -e "$scratch/root/usr/share/bash-completion/completions/gicube-sweep"
printf '%s\n' 'scenes = ["builtin:buckyball"]' '[fields]' '"asic.processors" = [1, 2]' '[fix]' 'volume-size = 16' \
  'size = "8x8"' 'fidelity = "cycle"' >"$scratch/space.toml"
"$scratch/root/usr/bin/gicube-explore" "$scratch/space.toml" --chart -o "$scratch/explore" >"$scratch/explore.log"
grep -q 'of 3 configurations' "$scratch/explore.log"
test -e "$scratch/explore/explore.svg"
gzip -t "$scratch/root/usr/share/man/man1/gicube-explore.1.gz"
test -e "$scratch/root/usr/share/bash-completion/completions/gicube-explore"
PYTHONPATH=$scratch/root/usr/lib/python3/dist-packages PATH=/usr/bin:/bin python3 -B -c 'import gicube
assert gicube.__file__.startswith("'"$scratch"'")
setup = gicube.parse_scene("volume { builtin: \"buckyball\" size: 32 } image { width: 32 height: 32 }").set_up()
with gicube.open() as board:
    assert board.render(gicube.load_scene(board, setup)).alpha.max() > 0'
export PATH=/usr/local/bin:/usr/bin:/bin PKG_CONFIG_PATH=$scratch/root/usr/lib/pkgconfig
# shellcheck disable=SC2046
c++ -std=c++20 "$source/samples/small/hello/main.cpp" $(pkg-config --cflags --libs gicube) -o "$scratch/hello"
LD_LIBRARY_PATH=$scratch/root/usr/lib "$scratch/hello" | grep -E '^centre [0-9]+ [0-9]+ [0-9]+, alpha 0\.9'

echo "Debian packages: all is well"
