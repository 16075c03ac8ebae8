#!/usr/bin/env bash
# The shared libraries show names of their public API only, all with their version; libgicube.so needs neither Protobuf
# nor gRPC. Usage: shown_names.sh libgicube.so libgicube-scene.so [libgicube-mpi.so]
set -euo pipefail
library=$1
scene=$2
# .so.0.3: before 1.0 each minor version has libraries of its own name.
header=$(dirname "$0")/../../driver/include/gicube/version.h
so=so.$(awk '/VERSION_(MAJOR|MINOR) [0-9]/ {printf "%s%s", dot, $3; dot = "."}' "$header")

shown=$(nm -D --defined-only --with-symbol-versions "$library" | awk '{print $3}' | grep -v '^GICUBE_0$')
if strange=$(grep -vE '^(gicube_|_ZNK?6gicube|_ZT[ISV]N6gicube).*@@GICUBE_0$' <<<"$shown"); then
  echo "names that are not of the public API: $strange" >&2
  exit 1
fi
if inner=$(c++filt <<<"$shown" | grep -E 'Board::State::|gicube::wire|Link|Device::|Batches'); then
  echo "names of the driver's inside: $inner" >&2
  exit 1
fi
grep -q '^_ZN6gicube5Board4openE' <<<"$shown"
[[ $(objdump -p "$library" | awk '/SONAME/ {print $2}') == "libgicube.$so" ]]
if objdump -p "$library" | grep NEEDED | grep -E 'protobuf|grpc'; then exit 1; fi

shown=$(nm -D --defined-only --with-symbol-versions "$scene" | awk '{print $3}' | grep -v '^GICUBE_SCENE_0$')
if strange=$(grep -vE '^(_ZNK?6gicube5scene|_ZT[ISV]N6gicube5scene).*@@GICUBE_SCENE_0$' <<<"$shown"); then
  echo "names that are not of gicube-scene's API: $strange" >&2
  exit 1
fi
if inner=$(c++filt <<<"$shown" | grep -E 'Faults|MeshDistance|DataStream|read_nrrd|closed_surface|WholeFile'); then
  echo "names of gicube-scene's inside: $inner" >&2
  exit 1
fi
grep -q '^_ZN6gicube5scene11read_volumeE' <<<"$shown"
[[ $(objdump -p "$scene" | awk '/SONAME/ {print $2}') == "libgicube-scene.$so" ]]
objdump -p "$scene" | grep "NEEDED *libgicube.$so" >/dev/null

mpi=${3:-}
[[ $mpi ]] || exit 0
nm -D --defined-only "$mpi" | grep ' gicube_mpi_open' >/dev/null
if nm -D --defined-only --with-symbol-versions "$mpi" | awk '{print $3}' | grep -vE '^(GICUBE_0|(gicube_|_ZNK?6gicube|_ZT[ISV]N6gicube).*@@GICUBE_0)$'; then exit 1; fi
[[ $(objdump -p "$mpi" | awk '/SONAME/ {print $2}') == "libgicube-mpi.$so" ]]
