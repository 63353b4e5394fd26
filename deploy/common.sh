# Shared by the scripts of this folder and of .ci; to be sourced. Everything runs from the repository's root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# Written by the compilers of this script and of those that it calls.
if [[ -z ${CCACHE_STATSLOG:-} ]]; then
  export CCACHE_STATSLOG=$PWD/build/ccache_stats.log
  rm -f "$CCACHE_STATSLOG"
fi

phases=()  # "SECONDS NAME" of each phase that has begun, SECONDS being when it did
failure=
# say NAME: begins the next phase of a script.
say() {
  phases+=("$SECONDS $*")
  printf '\n==> %s\n' "$*"
}
fail() {
  failure=$*
  exit 1
}

# The end of every script: how long each phase took, what the compiler cache spared, and why it failed.
tell_end() {
  local code=$1 i until free
  printf '\nseconds  phase\n'
  for ((i = 0; i < ${#phases[@]}; ++i)); do
    until=$SECONDS
    if ((i + 1 < ${#phases[@]})); then until=${phases[i + 1]%% *}; fi
    printf '%7d  %.80s\n' $((until - ${phases[i]%% *})) "${phases[i]#* }"
  done
  printf '%7d  in all\n' "$SECONDS"
  if [[ -s $CCACHE_STATSLOG ]]; then
    printf 'compiler cache: %d hits, %d misses\n' \
      "$(grep -cE '(direct|preprocessed)_cache_hit' "$CCACHE_STATSLOG")" "$(grep -c '^cache_miss' "$CCACHE_STATSLOG")"
  fi
  if ((code == 0)); then return; fi
  # The output above may tell of a full disk in a hundred ways.
  free=$(df --output=avail -m . | tail -n 1)
  if ((free < 50)); then
    failure="the disk is full: $free MB are free in $PWD; make room, then run this again"
  fi
  printf '%s: %s\n' "$(basename "$0")" \
    "${failure:-failed${phases:+ in the phase \"${phases[-1]#* }\"}; the output above says why}" >&2
}
trap 'tell_end $?' EXIT

# install_packages USE...: installs what deploy/packages.txt lists for these uses and is missing.
install_packages() {
  local missing=() package use wanted
  while read -r package use; do
    for wanted in "$@"; do
      if [[ $use == "$wanted" ]] && ! installed "$package"; then missing+=("$package"); fi
    done
  done < <(grep -v '^#' deploy/packages.txt)
  if ((${#missing[@]} == 0)); then
    printf 'All Debian packages needed for %s are installed.\n' "$*"
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
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q --error-on=any ||
    printf 'apt-get could not read all of its lists; going on with those that it has.\n'
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends "${missing[@]}" ||
    fail "apt-get could not install them: is Debian's archive reached, and is there room? Run again when it is"
}

installed() {
  # Node.js as its makers package it has npm in it, and Debian's npm cannot stand beside that.
  if [[ $1 == npm ]] && command -v npm >/dev/null; then return 0; fi
  [[ $(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null) == installed ]]
}

# configure PRESET [CMAKE OPTION...]: makes the build folder build/PRESET.
configure() {
  local log=build/$1/configure.log
  say "Configuring preset $1 in build/$1"
  mkdir -p "build/$1"
  cmake --preset "$@" >"$log" || { cat "$log"; fail "CMake failed"; }
}

# compile PRESET [TARGET...]: builds all, or these targets, in build/PRESET.
compile() {
  local preset=$1
  shift
  local targets=()
  if (($#)); then targets=(--target "$@"); fi
  say "Building preset $preset${*:+: $*}"
  if cmake --build --preset "$preset" "${targets[@]}"; then return; fi
  if [[ -e build/$preset/npm_unfinished ]]; then
    fail "npm could not install the packages of the studio page: is its registry reached? Run again when it is"
  fi
  fail "the build failed; the output above says why"
}

# run_tests PRESET CTEST_OPTION...: runs tests and sums them up; fails where one did.
run_tests() {
  local preset=$1 code=0
  shift
  rm -f "build/$preset/tests.xml"
  ctest --preset "$preset" --parallel "$(($(nproc) + 2))" --output-junit tests.xml "$@" || code=$?
  deploy/report_tests.py "build/$preset/tests.xml" "$preset" || code=1
  if ((code)); then fail "tests failed; each is named above, with the command that runs it alone"; fi
}
