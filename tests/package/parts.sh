#!/usr/bin/env bash
# The driver alone, and what script/demo builds, are configured where no package of the other parts is found.
# Usage: parts.sh SOURCE_DIR
set -euo pipefail
source=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# configured NAME "PACKAGES that are not found" "LIBRARIES that are not asked for" OPTION...
configured() {
  local name=$1 without=() package
  for package in $2; do without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
  local libraries=$3
  shift 3
  cmake -S "$source" -B "$scratch/$name" -G Ninja -DBUILD_TESTING=OFF "${without[@]}" "$@" >"$scratch/$name.log" 2>&1 || {
    cat "$scratch/$name.log"
    exit 1
  }
  for package in $libraries; do
    if grep -q "^${package}_FOUND" "$scratch/$name/CMakeCache.txt"; then
      echo "$name: asks for $package" && exit 1
    fi
  done
  # No target misses another one.
  ninja -C "$scratch/$name" -n >"$scratch/$name.log" || { cat "$scratch/$name.log" && exit 1; }
}

configured driver "Protobuf gRPC spdlog CLI11 nlohmann_json ZLIB PNG pugixml embree Python3 pybind11 MPI" \
  "Highway Seccomp OpenImageIO FFTW Nanoflann" -DGICUBE_BOARD=OFF -DGICUBE_SCENE=OFF
configured demo "embree Python3 pybind11 MPI" "OpenImageIO FFTW Nanoflann" \
  -DGICUBE_PICTURES=OFF -DGICUBE_SAMPLES=OFF -DGICUBE_PYTHON=OFF
configured scene "gRPC spdlog embree" "Highway Seccomp FFTW Nanoflann" -DGICUBE_BOARD=OFF
echo "parts: all is well"
