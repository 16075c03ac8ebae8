#!/usr/bin/env bash
# What an installed SDK has to read: every page that a header or a program cites, links that lead somewhere, messages
# that protoc takes, a manual page and a bash completion for each program with all of its options.
# Usage: installed_pages.sh BUILD_DIR SOURCE_DIR
set -euo pipefail
build=$1
source=$2

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
prefix=$scratch/prefix
cmake --install "$build" --prefix "$prefix" >"$scratch/install.log"
doc=$prefix/share/doc/gicube
faults=0
fault() { echo "$*" >&2; faults=$((faults + 1)); }

# ---- programs: options of "PROGRAM WORD...", its commands, all below it
help_of() {  # asked of the program once
  local words=$*
  local said=$scratch/help.${words// /.}
  [[ -e $said ]] || env -u GICUBE_MANAGEMENT "$prefix/bin/$1" "${@:2}" --help >"$said"
  cat "$said"
}
options_of() { help_of "$@" | sed -nE 's/^ +((-[A-Za-z],)?--[a-z][^ ]*).*/\1/p' | grep -oE -e '--[a-z][a-z-]*' | sort -u; }
commands_of() { help_of "$@" | sed -nE '/^Subcommands:/,/^$/s/^  ([a-z][a-z-]*).*/\1/p'; }
offered() {  # what bash offers behind "PROGRAM WORD..." for the beginning of a word, which stands first
  bash -c '. "$0/$2"; COMP_WORDS=("${@:2}" "$1"); COMP_CWORD=$(($# - 1)); "_${2//-/_}"; printf "%s\n" "${COMPREPLY[@]}"' \
    "$prefix/share/bash-completion/completions" "$@" | sort
}
all_options=0
check_program() {
  local command
  [[ $(offered -- "$@") == "$(options_of "$@")" ]] || fault "$*: bash offers other options than --help has"
  while read -r option; do
    grep -qFe "$option" "$scratch/$1.txt" || fault "man $1 lacks $option"
    all_options=$((all_options + 1))
  done < <(options_of "$@")
  while read -r command; do
    grep -qxe "$command" <<<"$(offered "" "$@")" || fault "$*: bash does not offer $command"
    grep -qE "^ +${*:2}${2:+ }$command\$" "$scratch/$1.txt" || fault "man $1 lacks $*: $command"
    check_program "$@" "$command"
  done < <(commands_of "$@")
}
for program in "$prefix"/bin/*; do
  program=$(basename "$program")
  page=$prefix/share/man/man1/$program.1
  groff -man -Tascii -ww -rLL=300n -rHY=0 -P-cbou "$page" >"$scratch/$program.txt" 2>"$scratch/groff.log"
  [[ ! -s $scratch/groff.log ]] || fault "$page: $(head -n 3 "$scratch/groff.log")"
  check_program "$program"
done
[[ $all_options -gt 200 ]] || fault "only $all_options options were found"
[[ $(offered no gicube-render --illumination) == none ]] || fault "bash offers no words of --illumination"

# ---- pages
check_cited() {  # TEXT FILE: what it names
  while read -r cited; do
    [[ -e $doc/$cited || -e $prefix/include/$cited || -e $prefix/include/${cited#proto/} ]] || fault "$1 cites $cited"
  done < <(grep -oE '(docs|proto|gicube/v1|samples)/[A-Za-z0-9_/-]+\.(md|proto|scene)' "$2" | sort -u)
}
for header in "$prefix"/include/gicube/{,scene/}*.h; do check_cited "$(basename "$header")" "$header"; done
for page in "$prefix"/share/man/man1/*; do check_cited "$(basename "$page")" <(sed 's/\\-/-/g' "$page"); done
grep -rhoqE 'docs/[a-z_/]+\.md' "$prefix/include/gicube" || fault "no header cites a document"
[[ -e $doc/LICENSE ]] || fault "README.md links to LICENSE"

# A link leads to a page of the prefix, or into the sources outside of docs.
links=0
while IFS=: read -r page link; do
  target=${link%%#*}
  links=$((links + 1))
  [[ -z $target || -e $(dirname "$page")/$target ]] && continue
  relative=$(realpath -ms --relative-to="$doc" "$(dirname "$page")/$target")
  [[ $relative != docs/* && -e $source/$relative ]] || fault "${page#"$doc/"} links to $link"
done < <(grep -roE '\]\([^) ]+\)' "$doc" --include='*.md' | grep -v '://' | sed -E 's/\]\((.*)\)$/\1/')
[[ $links -gt 100 ]] || fault "only $links links were found"

# ---- messages and presets
protoc -I "$prefix/include" --descriptor_set_out="$scratch/messages" "$prefix"/include/gicube/v1/*.proto
diff -r "$source/proto/gicube/v1" "$prefix/include/gicube/v1"
diff -r "$source/driver/scene/presets" "$prefix/share/gicube/presets"
diff -r "$source/board_emu/config/presets" "$prefix/share/gicube/boards"
"$prefix/bin/gicube-board" --config "$prefix/share/gicube/boards/paper.textproto" --print-config > /dev/null

[[ $faults -eq 0 ]]
echo "installed pages: $all_options options, $links links, all is well"
