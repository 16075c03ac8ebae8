#!/usr/bin/env bash
# Installs the build into a scratch prefix and uses it as an outside project does: examples/ by find_package, their tests,
# a program by pkg-config, the board found beside the library.
# Usage: installed_files.sh BUILD_DIR SOURCE_DIR
set -euo pipefail
build=$1
source=$2

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
prefix=$scratch/moved/prefix
unset GICUBE_BOARD
export PATH=/usr/local/bin:/usr/bin:/bin

# Moved after it was installed: nothing in it may name its place.
cmake --install "$build" --prefix "$scratch/prefix" >"$scratch/install.log"
mkdir "$scratch/moved"
mv "$scratch/prefix" "$prefix"

cmake -S "$source/examples" -B "$scratch/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" -DCMAKE_C_FLAGS="-Wall -Wextra -Werror"
grep -q "^gicube_DIR:PATH=$prefix/" "$scratch/build/CMakeCache.txt"
cmake --build "$scratch/build"
ctest --test-dir "$scratch/build" --output-on-failure

# emu: finds the installed program without any help.
"$scratch/build/depth_map" "$scratch/depth.pgm"
head -c 15 "$scratch/depth.pgm" | head -n 2 | tr '\n' ' ' | grep -q '^P5 256 256'

# pkg-config: the README's program, by one command.
export PKG_CONFIG_PATH=$prefix/lib/pkgconfig:$prefix/lib64/pkgconfig:$prefix/lib/$(cc -dumpmachine)/pkgconfig
[[ $(pkg-config --modversion gicube) == "$(sed -nE 's/^project\(gicube VERSION ([0-9.]+).*/\1/p' "$source/CMakeLists.txt")" ]]
libraries=$(pkg-config --variable=libdir gicube)
# shellcheck disable=SC2046
c++ -std=c++20 "$source/samples/hello/main.cpp" $(pkg-config --cflags --libs gicube) -o "$scratch/hello"
LD_LIBRARY_PATH=$libraries "$scratch/hello" | grep -E '^centre [0-9]+ [0-9]+ [0-9]+, alpha 0\.9'

# And the C program, by a C compiler that knows nothing of C++.
cc -std=c99 -Wall -Wextra -Wpedantic -Werror "$source/examples/c_host/c_host.c" $(pkg-config --cflags --libs gicube) \
  -o "$scratch/c_host"
LD_LIBRARY_PATH=$libraries "$scratch/c_host" | grep -E '^rays: 50 of 100 met the cube'

echo "installed files: all is well"
