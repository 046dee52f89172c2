#!/usr/bin/env bash
# run.sh build: builds the fuzz programs.
# run.sh TARGET SECONDS: runs one of them, which searches for inputs that break its reader. Findings are kept in
# build/fuzz/found, with TARGET in their names. To reproduce one, pass it to build/fuzz/bin/fuzz_TARGET.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
bin=build/fuzz/bin
# The image library leaks the text of an error, and the HEIC encoder leaks memory. The readers own no raw memory.
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
