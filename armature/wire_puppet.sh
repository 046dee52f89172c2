#!/bin/sh
# A puppet made of wire, without wire: a generated theropod with 74 sensors is recorded on twos, posed
# live over a plate, and becomes an animation. docs/wire-puppet.md tells what each step does.
#     wire_puppet.sh FOLDER [FRAMES]
set -e
if [ -z "$1" ]; then echo "usage: $0 FOLDER [FRAMES]" >&2; exit 2; fi
out=$1
frames=${2:-24}
keypose=${KEYPOSE:-$(dirname "$0")/../build/release/bin/keypose}
puppet="--description $out/puppet/theropod.txt --chains $out/puppet/theropod_chains.txt
  --skeleton $out/puppet/theropod.bvh --mesh $out/puppet/theropod.ply"

echo "== the puppet's files"
"$keypose" armature example --folder "$out/puppet"
"$keypose" armature check --description "$out/puppet/theropod.txt" \
  --chains "$out/puppet/theropod_chains.txt" --skeleton "$out/puppet/theropod.bvh" 2>&1 | tail -8

echo "== recorded on twos; at frame 5 the line drops bytes"
"$keypose" armature record --description "$out/puppet/theropod.txt" --port simulated \
  --session "$out/take" --step 2 --frames "$frames" --faults drop@5 </dev/null

echo "== live over the plate, the recorded frames behind it"
# shellcheck disable=SC2086
echo "plate 0" | "$keypose" armature live $puppet --port simulated --seconds 4 --quiet \
  --plate "$out/puppet/plate.png" --shot "$out/puppet/shot.json" --set "$out/puppet/set.ply" \
  --session "$out/take" --step 2 --onion 2 --pictures "$out/live" | tail -1

echo "== baked: hard stops on twos, and smooth between the same frames as keys"
# shellcheck disable=SC2086
"$keypose" armature bake $puppet --curves "$out/take/curves.json" --frames "$out/frames" \
  --motion "$out/motion.bvh" --rest "$out/rest.ply" --overwrite
# shellcheck disable=SC2086
"$keypose" armature bake $puppet --curves "$out/take/curves.json" --between smooth \
  --frames "$out/smooth" --overwrite

echo "== exported"
"$keypose" export --frames "$out/frames" --animation "$out/animation" --formats glb,video --overwrite
ls "$out/animation"
