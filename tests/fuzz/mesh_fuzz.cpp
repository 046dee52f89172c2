// Meshes of all formats, recognised by content.
#include "core/io/meshes/mesh_io.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  return fuzz::Expect([&] {
    const Mesh mesh = ReadMesh(fuzz::Put("mesh", fuzz::Bytes(data, size)));
    RequireUsable(mesh, "mesh");
    CheckClosed(mesh);
  });
}
