#!/usr/bin/env bash
# Installs the build into a scratch prefix and uses it as an outside project does: samples/installed and the installed
# samples/small by find_package, their tests, a program by pkg-config, the board found beside the library.
# Usage: installed_files.sh BUILD_DIR SOURCE_DIR
set -euo pipefail
build=$1
source=$2

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export XDG_RUNTIME_DIR=$scratch  # boards started here are not registered with the user's
prefix=$scratch/moved/prefix
unset GICUBE_BOARD
export PATH=/usr/local/bin:/usr/bin:/bin

# Moved after it was installed: nothing in it may name its place.
cmake --install "$build" --prefix "$scratch/prefix" >"$scratch/install.log"
mkdir "$scratch/moved"
mv "$scratch/prefix" "$prefix"

for program in board compose conformance cone-beam form-factors light render replay smi; do test -x "$prefix/bin/gicube-$program"; done

# OpenImageIO is loaded where a picture needs it, from beside the program's libraries; without it PNGs are still
# written.
if objdump -p "$prefix/bin/gicube-render" | grep OpenImageIO; then exit 1; fi
render() { "$prefix/bin/gicube-render" builtin:buckyball --volume-size 16 --size 8x8 --quiet -o "$scratch/$1" 2>&1; }
render picture.exr
pictures=$(find "$prefix" -name 'libgicube-pictures.so.*' -type l)
mv "$pictures" "$scratch/away"
render picture.png
if said=$(render other.exr); then exit 1; fi
[[ -e /usr/lib/$(gcc -print-multiarch)/${pictures##*/} ]] ||
  grep -q "other.exr: format: expected one that does not need libgicube-pictures.so, got ${pictures##*/}" <<<"$said"
mv "$scratch/away" "$pictures"

cmake -S "$source/samples/installed" -B "$scratch/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" -DCMAKE_C_FLAGS="-Wall -Wextra -Werror"
grep -q "^gicube_DIR:PATH=$prefix/" "$scratch/build/CMakeCache.txt"
cmake --build "$scratch/build"
ctest --test-dir "$scratch/build" --output-on-failure

# The small examples as they are installed.
cmake -S "$prefix/share/doc/gicube/samples/small" -B "$scratch/small" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" -DCMAKE_C_FLAGS="-Wall -Wextra -Werror"
cmake --build "$scratch/small"
"$scratch/small/hello" | grep -E '^centre [0-9]+ [0-9]+ [0-9]+, alpha 0\.9'
"$scratch/small/host_bsdf" >"$scratch/host_bsdf.txt"
"$prefix/bin/gicube-smi" doctor "emu:?bsdf=$scratch/small/brushed_metal.so"

# The short samples, with their tests.
cmake -S "$prefix/share/doc/gicube/samples/short" -B "$scratch/short" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror"
cmake --build "$scratch/short"
ctest --test-dir "$scratch/short" --output-on-failure

# What gicube_add_test() does not understand it says, instead of making a test of something else.
refuses() {
  printf 'cmake_minimum_required(VERSION 3.22)\nproject(x LANGUAGES NONE)\nfind_package(gicube REQUIRED %s)\n%s\n' \
    "${3:-}" "gicube_add_test($1)" >"$scratch/CMakeLists.txt"
  if cmake -S "$scratch" -B "$scratch/refused" -DCMAKE_PREFIX_PATH="$prefix" >"$scratch/refused.log" 2>&1; then
    echo "gicube_add_test($1) was taken" >&2
    return 1
  fi
  grep -q "$2" <<<"$(tr -s '\n ' ' ' <"$scratch/refused.log")" || { cat "$scratch/refused.log" >&2; return 1; }
}
refuses "COMMAND x" "NAME is missing"
refuses "NAME x" "either SOURCES or COMMAND"
refuses "NAME x COMMAND y BUS isa" "BUS: expected pci33, agp1x, agp2x or agp4x, got isa"
refuses "NAME x COMMAND y BOARD unix:/z BUS pci33" "BOARD is a board that there is"
refuses "SPEED 3 NAME x COMMAND y" "not understood: SPEED"
refuses "NAME x COMMAND y FIDELITY cycles" "FIDELITY: expected functional or cycle, got cycles"
refuses "NAME x COMMAND y FAULTS no/plan" "FAULTS: expected a file, got $scratch/no/plan"
refuses "NAME x COMMAND y CONFIG no.textproto" "CONFIG: expected a file, got $scratch/no.textproto"
refuses "NAME x COMMAND y" "COMPONENTS: expected scene or mpi, got scenes" "COMPONENTS scenes"

# Under an older standard each C++ header says first what it needs, and no more is said of it; the C interface and the
# version need none.
while read -r header; do
  printf '#include <%s>\nint main() {}\n' "$header" >"$scratch/old.cpp"
  case $header in
    *c_api.h | *c_types.h | *bsdf.h | *observer.h | *version.h) c++ -std=c++17 -fsyntax-only -I"$prefix/include" "$scratch/old.cpp" ;;
    *)
      if c++ -std=c++17 -fsyntax-only -I"$prefix/include" "$scratch/old.cpp" 2>"$scratch/old.log"; then
        echo "$header was compiled as C++17" >&2 && exit 1
      fi
      if [[ $(grep -c 'error:' "$scratch/old.log") != 2 ]] || ! grep -q '#error "gicube needs C++20' "$scratch/old.log"; then
        head -20 "$scratch/old.log" && exit 1
      fi
      ;;
  esac
done < <(cd "$prefix/include" && find gicube -name '*.h')

# emu: finds the installed program without any help.
"$scratch/build/depth_map" "$scratch/depth.pgm"
[[ $(head -c 11 "$scratch/depth.pgm" | tr '\n' ' ') == "P5 256 256 " ]]

# pkg-config: the README's program, by one command.
export PKG_CONFIG_PATH=$prefix/lib/pkgconfig:$prefix/lib64/pkgconfig:$prefix/lib/$(cc -dumpmachine)/pkgconfig
version=$(sed -nE 's/^#define GICUBE_VERSION_(MAJOR|MINOR|PATCH) //p' "$prefix/include/gicube/version.h" | paste -sd .)
[[ $(pkg-config --modversion gicube) == "$version" ]]
libraries=$(pkg-config --variable=libdir gicube)
# shellcheck disable=SC2046
c++ -std=c++20 "$source/samples/small/hello/main.cpp" "-Wl,-rpath,$libraries" $(pkg-config --cflags --libs gicube) -o "$scratch/hello"
"$scratch/hello" | grep -E '^centre [0-9]+ [0-9]+ [0-9]+, alpha 0\.9'

# gicube-scene, by pkg-config. Its headers name nothing of the libraries that it reads files with, and a fault has its
# parts.
if grep -E '#include [<"](teem|nifti|OpenImageIO|google|zlib|fmt)' "$prefix"/include/gicube/scene/*.h; then exit 1; fi
# shellcheck disable=SC2046
c++ -std=c++20 "$source"/samples/installed/turntable/{main,turntable}.cpp "-Wl,-rpath,$libraries" \
  $(pkg-config --cflags --libs gicube-scene) -o "$scratch/turntable"
if "$scratch/turntable" "$scratch/none.nrrd" "$scratch/none.png" 2>"$scratch/fault"; then exit 1; fi
grep -q 'node\[thing\]: .*none.nrrd: file: expected a file, got nothing there' "$scratch/fault"

# And the C program, by a C compiler that knows nothing of C++.
cc -std=c99 -Wall -Wextra -Wpedantic -Werror "$source/samples/installed/c_host/c_host.c" $(pkg-config --cflags --libs gicube) \
  -o "$scratch/c_host"
LD_LIBRARY_PATH=$libraries "$scratch/c_host" | grep -E '^rays: 50 of 100 met the cube'

echo "installed files: all is well"
