// Regions of a timeline that are bound to a mesh.
#include "core/io/project/regions_io.h"
#include "core/surfaces/mesh_binding.h"
#include "core/surfaces/shapes.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  static const Mesh mesh = MakeIcosphere(1);
  if (fuzz::IsOfAnotherMesh(fuzz::Bytes(data, size), NumberingHash(mesh))) return 0;
  const auto path = fuzz::Put("regions.json", fuzz::Bytes(data, size));
  Timeline timeline;
  timeline.regions.resize(2);
  timeline.regions[0].name = "tip";
  timeline.regions[0].vertices = {0, 1, 2};
  timeline.regions[1].name = "ball";
  timeline.regions[1].radius = 0.5;
  return fuzz::Expect([&] { FollowRegions(path, mesh, timeline, nullptr); });
}
