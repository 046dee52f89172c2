// Description files of armatures, and files of anchors and chains: the first byte says which.
#include "armature/description/chain_file.h"
#include "armature/description/description_file.h"
#include "core/values/errors.h"
#include "tests/fuzz/fuzz_folder.h"

namespace {

/// A fault must name its place: "d.txt:LINE:COLUMN: ...".
bool NamesItsLine(const std::string& said) {
  std::size_t at = said.find("d.txt:") == 0 ? 6 : said.size();
  const std::size_t line = at;
  while (at < said.size() && said[at] >= '0' && said[at] <= '9') ++at;
  return at > line && at < said.size() && said[at] == ':';
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  static const armature::Armature figure =
      armature::DescriptionFile::Parse(
          "node { name a axis 1 0 0 sensor 0 node { name b length 1 node { name c length 1 } } "
          "node { name d length 1 } }",
          "figure")
          .armature();
  const std::string text(fuzz::Bytes(data, size).substr(size > 0));
  try {
    if (size > 0 && data[0] == 'c') {
      armature::ParseChains(text, "d.txt", figure);
    } else {
      const auto file = armature::DescriptionFile::Parse(text, "d.txt");
      if (file.Text() != text) __builtin_trap();
      armature::ForwardKinematics(file.armature(),
                                  std::vector<double>(file.armature().joints.size(), 0.3));
    }
  } catch (const InputError& error) {
    if (!NamesItsLine(error.what())) __builtin_trap();
  }
  return 0;
}
