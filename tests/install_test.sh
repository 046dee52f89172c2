#!/usr/bin/env bash
# Installs a build under a fresh prefix and uses it from there, as described in README.md.
# usage: install_test.sh BUILD_DIR
set -euo pipefail
build=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

fail() { echo "install_test: $*" >&2; exit 1; }

cmake --install "$build" --prefix "$folder/prefix" >/dev/null
export PATH="$folder/prefix/bin:$PATH"
[ "$(command -v keypose)" = "$folder/prefix/bin/keypose" ] || fail "keypose is not in PREFIX/bin"
keypose --version >/dev/null || fail "the installed keypose does not start"
# The stages and the default pipeline are found beside the program, wherever it is.
keypose cleanup --help | grep -q -- --faces || fail "keypose finds no stage programs under the prefix"
keypose graph -C /nonexistent 2>/dev/null && fail "a project that is not there must be an error"
mkdir -p "$folder/photos" "$folder/project"
printf 'poses: {rest: %s}\n' "$folder/photos" > "$folder/project/pipeline.yaml"
keypose graph -C "$folder/project" | grep -q 'dense/rest' || fail "the default pipeline is not found under the prefix"
# So are the libraries that programs load later.
[ "$(ls "$folder/prefix/lib/keypose")" = "$(ls "$build/lib/keypose")" ] || fail "a library of lib/keypose was not installed"
# No test programs are installed.
! ls "$folder/prefix/bin" | grep -q _test || fail "a test program was installed"
echo "1 passed, 0 failed"
