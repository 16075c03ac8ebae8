#!/usr/bin/env bash
# libgicube.so shows names of the public API only, all with its version, and needs neither Protobuf nor gRPC.
# Usage: shown_names.sh libgicube.so
set -euo pipefail
library=$1

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
[[ $(objdump -p "$library" | awk '/SONAME/ {print $2}') == libgicube.so.0 ]]
if objdump -p "$library" | grep NEEDED | grep -E 'protobuf|grpc'; then exit 1; fi
