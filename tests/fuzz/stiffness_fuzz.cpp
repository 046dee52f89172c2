// Stiffness as text, and as JSON bound to its mesh.
#include "core/io/project/stiffness_io.h"
#include "core/surfaces/mesh_binding.h"
#include "core/surfaces/shapes.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  static const Mesh mesh = MakeIcosphere(1);
  const std::string text(fuzz::Bytes(data, size));
  if (fuzz::IsOfAnotherMesh(text, GeometryHash(mesh))) return 0;
  if (text.starts_with("ply")) return 0;  // painted meshes are read by the mesh reader
  return fuzz::Expect([&] { StiffnessOn(mesh, text, {}, "stiffness", nullptr); });
}
