#!/usr/bin/env bash
# tinyobjloader takes a texture's name for a number: `map_Kd -s 2 2 a.png` names no texture, without a warning.
#
# Seen with: Debian 12's libtinyobjloader-dev 2.0.0~rc10+dfsg-2.
# Input: an MTL whose `map_Kd` has the option -s or -o with fewer than three numbers; the format makes the second and
# third optional.
# Output: the material's diffuse_texname is empty, warning and error are empty. With three numbers the name is read.
# Why it matters: the mesh has lost its texture, and nobody is told.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install libtinyobjloader-dev=2.0.0~rc10+dfsg-2+b1 >apt.log 2>&1 ||
  { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
cat >read.cpp <<'CPP'
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <cstdio>
#include <sstream>

int main(int, char** options) {
  for (++options; *options; ++options) {
    std::istringstream in(std::string("newmtl m\nmap_Kd ") + *options + " a.png\n");
    std::map<std::string, int> index;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    tinyobj::LoadMtl(&index, &materials, &in, &warning, &error);
    std::printf("%s: '%s'%s%s\n", *options, materials[0].diffuse_texname.c_str(), warning.c_str(), error.c_str());
  }
}
CPP
g++ -w -I root/usr/include read.cpp -o read
./read "-s 2 2 1" "-s 2 2" "-o 0.5" | tee result
if [ "$(cat result)" = "-s 2 2 1: 'a.png'
-s 2 2: ''
-o 0.5: ''" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
