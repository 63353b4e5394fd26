#!/usr/bin/env bash
# From a fresh Debian 12 to a picture: installs what is missing, builds, and renders a sample scene
# on four worker processes of this machine. May be run again at any time.
#   deploy/render-sample.sh [PICTURE]        default: sample.png in the repository's folder
picture=$(realpath -m "${1:-$(dirname "${BASH_SOURCE[0]}")/../sample.png}")
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

install_packages build
configure release
compile release
say "Rendering scenes/samples/mosaic.tessera on 4 worker processes"
build/release/bin/tessera render scenes/samples/mosaic.tessera --workers 4 -o "$picture"
printf 'The picture is %s\n' "$picture"
