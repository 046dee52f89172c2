#!/usr/bin/env bash
# run.sh build | run.sh TARGET SECONDS: makes the fuzz programs, or lets one look for inputs that break its reader.
# What it finds stays in build/fuzz/found, named by TARGET; give such a file to build/fuzz/bin/fuzz_TARGET to see it again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
bin=build/fuzz/bin
# The image library leaks the text of an error, HEIC's encoder some of its memory; the readers own nothing by hand.
export ASAN_OPTIONS=detect_leaks=0
trap 'rm -rf "/dev/shm/keypose_fuzz_${!:-none}"' EXIT

if [ "$1" = build ]; then
  cmake --preset fuzz >/dev/null
  cmake --build build/fuzz --target fuzz
  rm -rf build/fuzz/seeds
  "$bin/fuzz_seeds" build/fuzz/seeds &
  wait $!
  exit
fi

target=$1 seconds=$2
mkdir -p "build/fuzz/corpus/$target" build/fuzz/found
data=${KEYPOSE_DATA:-../shared/data}
folders=("build/fuzz/corpus/$target" "build/fuzz/seeds/$target")
[ -d "$data/mutants" ] && folders+=("$data/mutants")
"$bin/fuzz_$target" -max_total_time="$seconds" -timeout=25 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 \
  -artifact_prefix="build/fuzz/found/${target}_" "${folders[@]}" &
wait $!
