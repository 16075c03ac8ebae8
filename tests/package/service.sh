#!/usr/bin/env bash
# The units of systemd: systemd takes them, they keep the service from what it does not need, and the service's command
# line serves a board at a socket that was there first.
# Usage: service.sh UNIT_FOLDER PROGRAM_FOLDER
set -euo pipefail
units=$1
programs=$2

for tool in systemd-analyze systemd-socket-activate; do
  command -v "$tool" >/dev/null || { echo "no $tool on this machine: skipped"; exit 77; }
done
scratch=$(mktemp -d)
board=
trap '[[ -z $board ]] || kill "$board" 2>/dev/null || true; rm -rf "$scratch"' EXIT
export XDG_RUNTIME_DIR=$scratch  # boards started here are not registered with the user's
cp "$units"/gicube-board.* "$scratch"
sed -i "s|^ExecStart=gicube-board|ExecStart=$programs/gicube-board|" "$scratch/gicube-board.service"

systemd-analyze verify --man=no "$scratch"/gicube-board.{service,socket} >"$scratch/verify.log" 2>&1 || { cat "$scratch/verify.log"; exit 1; }
# A setting that systemd does not know is only a line there.
if grep "$scratch" "$scratch/verify.log"; then exit 1; fi
# 0.7 of 10 with systemd 252; each setting that is left out adds 0.1 or 0.2.
systemd-analyze security --offline=true --threshold=10 "$scratch/gicube-board.service" >"$scratch/security.log" || { cat "$scratch/security.log"; exit 1; }
for line in DynamicUser=yes ProtectSystem=strict PrivateNetwork=yes NoNewPrivileges=yes MemoryMax=3G SystemCallFilter=@system-service; do
  grep -qxF "$line" "$scratch/gicube-board.service" || { echo "gicube-board.service: expected $line, got none" >&2; exit 1; }
done

# As systemd starts it: only when a client comes, with the socket as file 3.
read -r -a words < <(sed -n 's/^ExecStart=//p' "$scratch/gicube-board.service")
systemd-socket-activate --listen="$scratch/board" "${words[@]}" >"$scratch/board.log" 2>&1 &
board=$!
until [[ -S $scratch/board ]]; do kill -0 "$board"; sleep 0.05; done
"$programs/gicube-smi" doctor "unix:$scratch/board"
grep -q "board 0 ready on unix:$scratch/board" "$scratch/board.log"
kill "$board"
wait "$board"
board=
[[ -S $scratch/board ]]

echo "service: all is well"
