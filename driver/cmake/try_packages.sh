#!/usr/bin/env bash
# Called by script/package --try: lintian finds no error in the packages; in a new root folder they can be installed,
# run and purged, and leave nothing. Debian packages come from this machine's sources.
# Usage: try_packages.sh FOLDER
set -euo pipefail
packages=$1

echo "try: 1 of 4: lintian"
lintian --allow-root --fail-on error "$packages"/*.deb

root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
echo "try: 2 of 4: a new Debian 12 in $root"
sources=() options=()
for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.{list,sources}; do [[ ! -s $file ]] || sources+=("$file"); done
for file in /etc/apt/apt.conf.d/*; do options+=(--aptopt="$file"); done
mmdebstrap --quiet --variant=apt "${options[@]}" bookworm "$root" "${sources[@]}" || {
  echo "try: no root folder could be made; the packages have been checked by lintian only" >&2
  exit 1
}
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"; }
cp /etc/resolv.conf "$root/etc/resolv.conf"  # where apt goes by name
cp "$packages"/*.deb "$root/root"
in_root apt-get update -qq
# The files that are present, except for records of apt and dpkg, logs, and files that programs keep about others'
# files.
files() { (cd "$root" && find etc usr opt run srv var -path var/lib/apt -prune -o -path var/lib/dpkg -prune -o -path var/cache -prune \
  -o -path var/log -prune -o -print | sort); }

echo "try: 3 of 4: packages are installed and run"
# First what they depend on, so that all that is new then is theirs.
# shellcheck disable=SC2016
in_root sh -c 'apt-get install -y -qq --no-install-recommends $(apt-get install -s ./root/gicube_*.deb ./root/python3-gicube_*.deb | sed -n "s/^Inst \([^ ]*\).*/\1/p" | grep -v "gicube")' >"$root/root/log" 2>&1 || { tail "$root/root/log"; exit 1; }
files >"$root/root/before"
in_root sh -c 'apt-get install -y -qq --no-install-recommends ./root/*gicube*.deb' >"$root/root/log" 2>&1 || { tail "$root/root/log"; exit 1; }
in_root gicube-render builtin:buckyball --volume-size 64 --size 64x64 -o /tmp/ball.png
in_root gicube-smi show /tmp/ball.png
test -e "$root/usr/lib/systemd/system/gicube-board.socket"
in_root python3 -c 'import gicube
setup = gicube.parse_scene("volume { builtin: \"buckyball\" size: 64 }").set_up()
with gicube.open() as board:
    board.render(gicube.load_scene(board, setup)).save("/tmp/python.png")'
in_root gicube-smi show /tmp/python.png
in_root gicube-sweep builtin:buckyball --fix volume-size=32 --fix size=16x16 --reference step=0.25 -o /tmp/sweep --quiet

echo "try: 4 of 4: packages are purged"
in_root apt-get purge -y -qq gicube gicube-dev gicube-doc python3-gicube >"$root/root/log" 2>&1 || { tail "$root/root/log"; exit 1; }
files >"$root/root/after"
diff "$root/root/before" "$root/root/after" || { echo "try: the files above are left, or lost" >&2; exit 1; }
echo "try: all is well"
