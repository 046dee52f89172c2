// Picks (JSON, MeshLab) and pairs of landmarks (JSON, text).
#include "core/io/project/landmarks_io.h"
#include "core/surfaces/mesh_binding.h"
#include "core/surfaces/shapes.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  static const Mesh mesh = MakeIcosphere(1);
  if (fuzz::IsOfAnotherMesh(fuzz::Bytes(data, size), GeometryHash(mesh))) return 0;
  const auto path = fuzz::Put("landmarks", fuzz::Bytes(data, size));
  fuzz::Expect([&] { ReadPicks(path, mesh); });
  return fuzz::Expect([&] { ReadLandmarkPairs({path}, mesh, mesh); });
}
