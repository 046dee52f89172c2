#!/bin/sh
# A puppet made of wire, without wire: a generated theropod with 74 sensors is recorded on twos, posed
# live over a plate, and becomes an animation. docs/wire-puppet.md tells what each step does.
#     wire_puppet.sh FOLDER [FRAMES]
set -e
if [ -z "$1" ]; then echo "usage: $0 FOLDER [FRAMES]" >&2; exit 2; fi
out=$1
frames=${2:-24}
keypose=${KEYPOSE:-$(dirname "$0")/../build/release/bin/keypose}
files=$out/armature/example
take=$out/armature/take
set -- --description "$files/theropod.txt" --chains "$files/theropod_chains.txt" \
  --skeleton "$files/theropod.bvh" --mesh "$files/theropod.ply"

echo "== the puppet's files"
"$keypose" armature example --folder "$files"
"$keypose" armature check --description "$files/theropod.txt" \
  --chains "$files/theropod_chains.txt" --skeleton "$files/theropod.bvh" 2>&1 | tail -8

echo "== recorded on twos; at frame 5 the line drops bytes"
"$keypose" armature record --description "$files/theropod.txt" --port simulated \
  --session "$take" --step 2 --frames "$frames" --faults drop@5 </dev/null

echo "== live over the plate, the recorded frames behind it"
echo "plate 0" | "$keypose" armature live "$@" --port simulated --seconds 4 --quiet \
  --plate "$files/plate.png" --shot "$files/shot.json" --set "$files/set.ply" \
  --session "$take" --step 2 --onion 2 --pictures "$out/live" | tail -1

echo "== baked: hard stops on twos, and smooth between the same frames as keys"
"$keypose" armature bake "$@" --curves "$take/curves.json" --frames "$take/frames" \
  --motion "$take/motion.bvh" --rest "$take/rest.ply" --overwrite
"$keypose" armature bake "$@" --curves "$take/curves.json" --between smooth \
  --frames "$out/smooth" --overwrite

echo "== over the plate, lit by a lamp from the left"
"$keypose" composite --frames "$take/frames" --shot "$files/shot.json" --plate "$files/plate.png" \
  --set "$files/set.ply" --pictures "$out/over" --lamp 0.6 --lamp_from -60 --lamp_height 40 --overwrite

echo "== exported"
"$keypose" export --frames "$take/frames" --animation "$out/animation" --formats glb,video --overwrite
ls "$out/animation"
