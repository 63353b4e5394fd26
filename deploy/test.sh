#!/usr/bin/env bash
# From a fresh Debian 12 to a tested build: installs what is missing, builds with warnings as errors and
# runs the tests that tell a user that the program works. May be run again at any time.
#   deploy/test.sh [CTEST OPTION...]     with options: the tests that they name, for example -R Sphere
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

install_packages build test
configure release -DTESSERA_TESTS=ON
compile release
say "Running the tests"
if (($# == 0)); then set -- --label-exclude nightly; fi
run_tests release "$@"
