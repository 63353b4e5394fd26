#!/usr/bin/env bash
# From a fresh Debian 12 to a tested build: installs what is missing, builds with warnings as errors
# and runs every test. May be run again at any time.
#   deploy/test.sh [CTEST OPTION...]         for example: deploy/test.sh -R accelerator
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

install_packages build test
build dev
say "Running the tests"
# One more at a time than there are cores: some wait more than they work.
ctest --preset dev --parallel "$(($(nproc) + 1))" "$@"
