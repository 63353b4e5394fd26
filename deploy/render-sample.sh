#!/usr/bin/env bash
# From a fresh Debian 12 to a picture: installs what is missing, builds, and renders a sample scene
# on four worker processes of this machine. May be run again at any time.
#   deploy/render-sample.sh [PICTURE]        default: sample.png in the repository's folder
picture=$(realpath -m "${1:-$(dirname "${BASH_SOURCE[0]}")/../sample.png}")
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

install_packages build
build release
say "Rendering scenes/samples/mosaic.tessera on 4 worker processes"
build/release/bin/tessera render scenes/samples/mosaic.tessera --workers 4 -o "$picture" \
  --stats build/release/sample.json
python=$(command -v python3 || true)
if [[ -n $python ]]; then
  "$python" - build/release/sample.json <<'PY'
import json, sys
s = json.load(open(sys.argv[1]))
print(f"{s['workers']['seen']} workers traced {s['tiles']['done']} tiles, {s['rays']['total']:,} rays, "
      f"in {s['seconds']['total']:.2f} s; pixels {s['pixels_sha256'][:16]}...")
PY
fi
say "The picture is $picture"
