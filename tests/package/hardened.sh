#!/usr/bin/env bash
# Programs and shared libraries are built so that a fault of memory is harder to use: each can be loaded at any address,
# its tables of addresses are read-only and its stack can't be executed; returns are watched, and copies into buffers of
# known size. Usage: hardened.sh BUILD_FOLDER
set -euo pipefail
build=$1

expect() {  # FILE TEXT PATTERN WHAT
  grep -qE "$3" <<<"$2" || { echo "$1: expected $4" >&2; exit 1; }
}
count=0
for file in "$build"/bin/gicube-* "$build"/lib/*.so; do
  [[ $(head -c 4 "$file") == $'\x7fELF' ]] || continue  # a program of Python
  head=$(readelf --wide --file-header --program-headers --dynamic "$file")
  expect "$file" "$head" 'Type: +DYN' "code that can be loaded at any address"
  expect "$file" "$head" 'GNU_RELRO' "a part that is read-only once it is linked"
  expect "$file" "$head" 'BIND_NOW|Flags:.* NOW' "all names bound at the start"
  expect "$file" "$head" 'GNU_STACK.* RW ' "a stack that can't be executed"
  names=$(nm -D "$file")
  expect "$file" "$names" '__stack_chk_fail' "functions that watch their return address"
  ((++count))
done
((count >= 9)) || { echo "expected at least 9 programs and libraries, got $count" >&2; exit 1; }

# What handles the bytes of others. The C library's own checked functions stand for what was compiled so.
for file in "$build"/bin/gicube-board "$build"/lib/libgicube.so; do
  expect "$file" "$(nm -D "$file")" '__(memcpy|memmove|read|recv|snprintf|vsnprintf|fdelt|poll|strncpy|memset)_chk' \
    "calls that know the size of their buffer (_FORTIFY_SOURCE)"
  if [[ $(uname -m) == x86_64 ]]; then
    code=$(objdump --disassemble --no-show-raw-insn "$file" | grep -c endbr64)
    ((code > 100)) || { echo "$file: expected places that may be jumped to to be marked (endbr64), got $code" >&2; exit 1; }
  fi
done
