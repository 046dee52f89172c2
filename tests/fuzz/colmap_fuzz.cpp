// A COLMAP model, text or binary: cameras, images and points one after the other, with a separator
// line in between.
#include "core/io/project/colmap_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  constexpr std::string_view kApart = "\n=====\n";
  std::string_view rest = fuzz::Bytes(data, size);
  const bool text = !rest.empty() && rest.front() == '#';
  const auto next = [&] {
    const std::string_view part = rest.substr(0, rest.find(kApart));
    rest.remove_prefix(std::min(rest.size(), part.size() + kApart.size()));
    return part;
  };
  return fuzz::Expect([&] {
    for (const char* name : {"cameras", "images", "points3D"}) {
      std::filesystem::remove(fuzz::Folder() / (std::string(name) + (text ? ".bin" : ".txt")));
      fuzz::Put(std::string(name) + (text ? ".txt" : ".bin"), next());
    }
    ReadColmapModel(fuzz::Folder());
  });
}
