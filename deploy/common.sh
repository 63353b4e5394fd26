# Shared by the scripts of this folder; to be sourced. Everything runs from the repository's root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '\n==> %s\n' "$*"; }
fail() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }
trap 'fail "failed in line $LINENO; the output above says why"' ERR

# install_packages USE...: installs what deploy/packages.txt lists for these uses and is missing.
install_packages() {
  local missing=() package use wanted
  while read -r package use; do
    for wanted in "$@"; do
      if [[ $use == "$wanted" ]] && ! installed "$package"; then missing+=("$package"); fi
    done
  done < <(grep -v '^#' deploy/packages.txt)
  if ((${#missing[@]} == 0)); then
    say "All Debian packages needed for: $* are installed"
    return
  fi
  command -v apt-get >/dev/null ||
    fail "apt-get was not found; on other systems install the like of: ${missing[*]}"
  local as_root=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null || fail "run as root, or install sudo; missing are: ${missing[*]}"
    as_root=(sudo)
  fi
  say "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends "${missing[@]}"
}

installed() {
  # Node.js as its makers package it has npm in it, and Debian's npm cannot stand beside that.
  if [[ $1 == npm ]] && command -v npm >/dev/null; then return 0; fi
  [[ $(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null) == installed ]]
}

# build PRESET [TARGET...]: configures and builds into build/PRESET.
build() {
  local preset=$1
  shift
  say "Configuring and building preset $preset in build/$preset"
  cmake --preset "$preset" >"$(log_of "$preset")" || { cat "$(log_of "$preset")"; fail "CMake failed"; }
  local targets=()
  if (($#)); then targets=(--target "$@"); fi
  cmake --build --preset "$preset" "${targets[@]}"
}

log_of() {
  mkdir -p "build/$1"
  printf 'build/%s/configure.log' "$1"
}
